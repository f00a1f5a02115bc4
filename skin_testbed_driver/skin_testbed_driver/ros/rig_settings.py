"""The parameters that choose and describe the rig, and the rig they make."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rclpy.node import Node

from skin_models.errors import SkinError
from skin_models.layout import Layout, flat, row_from_origin
from skin_models.layout_file import load_layout
from skin_models.live import under_plunger
from skin_models.materials import material, names
from skin_models.model import Model
from skin_models.model_file import load_model
from skin_models.ros.parameters import setting
from skin_models.spread.noted import kernel_of
from skin_models.tables.text import SUFFIXES
from skin_models.words import counted
from skin_testbed_driver.calibration import Calibration, load_calibration, thesis_calibration
from skin_testbed_driver.rig import Rig
from skin_testbed_driver.rigs.own import is_own_rig, own_rig
from skin_testbed_driver.rigs.replay import ReplayRig
from skin_testbed_driver.rigs.simulated import TRAVEL, Imperfections, SimulatedRig
from skin_testbed_driver.rigs.table import read_table
from skin_testbed_driver.ros.replayed_bag import read_bag
from skin_testbed_driver.ros.topics_rig import TopicsRig, TopicsSettings

_RIGS = ("simulated", "replay", "topics")
_SURFACE = 0.075  # m, stage position of the simulated skin: the middle of the travel


@dataclass(frozen=True)
class RigSettings:
    """Every parameter of every rig; a rig looks at its own."""

    rig: str = setting(
        "simulated", f"which rig to drive: {', '.join(_RIGS)}, or your own, as a Python file or an installed module", fixed=True
    )
    rig_options: str = setting("", "own rig: YAML of what its class takes besides layout, such as {port: /dev/ttyUSB0}", fixed=True)
    sample_rate: float = setting(100.0, "Hz, synchronous samples per second", lower=1.0, upper=1000.0, fixed=True)
    calibration_file: str = setting("", "YAML with the slope of every taxel; empty: the thesis's slopes", fixed=True)
    start_depth: float = setting(
        -0.002, "m, depth at which the plunger is taken to be at start, until the service zero finds the surface",
        lower=-0.15, upper=0.15, fixed=True,
    )  # fmt: skip

    time_scale: float = setting(
        1.0,
        "simulated seconds per second; other than 1 publishes /clock, for nodes with use_sim_time",
        lower=0.01,
        upper=1000.0,
        fixed=True,
    )
    model: str = setting("silicone_4mm", "simulated rig: a shipped material, or YAML of the specimen and its hidden effects", fixed=True)
    layout_file: str = setting("", "table of taxels (name, x_mm, y_mm, …); empty: a row, 14 mm apart", fixed=True)
    taxels: int = setting(0, "taxels in that row; 0: as many as model or recording have", lower=0, upper=1000, fixed=True)
    seed: int = setting(0, "simulated rig: seed of noise, rest errors and random effects", lower=0, upper=2**31 - 1, fixed=True)
    surface_offset: float = setting(
        0.0, "m, simulated rig: by how much the surface lies deeper than start_depth says", lower=-0.02, upper=0.02, fixed=True
    )
    load_cell_noise: float = setting(3e-3, "V, simulated rig: standard deviation", lower=0.0, upper=1.0, fixed=True)
    taxel_noise: float = setting(3e-3, "V, simulated rig: standard deviation", lower=0.0, upper=1.0, fixed=True)
    rest_error: float = setting(5e-6, "m, simulated rig: greatest error of the stage at rest", lower=0.0, upper=1e-3, fixed=True)
    screw_error: float = setting(2.5e-6, "m, simulated rig: amplitude of the screw's error", lower=0.0, upper=1e-3, fixed=True)
    mount_compliance: float = setting(
        0.0, "m/N, simulated rig: of mounting plate and load cell; 0 for specimens whose parameters contain it, as the thesis's do",
        lower=0.0, upper=1e-3, fixed=True,
    )  # fmt: skip
    quantised: bool = setting(True, "simulated rig: encoder of 1 um and converter of 4.88 mV; false: exact values", fixed=True)

    recording: str = setting(
        "", "replay rig: a rosbag2 directory, an .mcap file, or a table (t_s, x_mm, force_n, taxel_0_n, …)", fixed=True
    )
    recording_namespace: str = setting("", "replay rig: namespace of the recorded topics, where a bag holds several rigs", fixed=True)
    loop: bool = setting(False, "replay rig: begin again at the end", fixed=True)

    joint: str = setting("indentation", "topics rig: name of the axis in axis_state and axis_command", fixed=True)
    axis_sign: float = setting(
        1.0, "topics rig: 1 if the joint grows towards the skin, -1 if away from it", lower=-1.0, upper=1.0, fixed=True
    )
    force_sign: float = setting(
        -1.0, "topics rig: what makes force.z of force_in positive in compression", lower=-1.0, upper=1.0, fixed=True
    )
    stale_after: float = setting(0.1, "s, topics rig: silence after which a signal is lost", lower=0.001, upper=10.0, fixed=True)
    command_type: str = setting(
        "JointTrajectory", "topics rig: type of axis_command", choices=("JointTrajectory", "Float64MultiArray"), fixed=True
    )
    axis_speeds: bool = setting(
        False, "topics rig: say in axis_command with what speed to arrive; controllers that allow no speed at the end refuse it", fixed=True
    )
    taxels_type: str = setting("TaxelArray", "topics rig: type of taxels_in", choices=("TaxelArray", "Float64MultiArray"), fixed=True)

    def make_rig(self, node: Node) -> tuple[Rig, Calibration]:
        """The rig, closed, and the calibration that the driver believes in. Raises `SkinError` for files that cannot be used."""
        rig = self._own() if is_own_rig(self.rig) else self._shipped()(node)
        path, names = self.calibration_file, rig.layout.names
        return rig, load_calibration(path, names) if path else thesis_calibration(len(names))

    def _shipped(self) -> Callable[[Node], Rig]:
        makers = dict(zip(_RIGS, (self._simulated, self._replay, self._topics), strict=True))
        if self.rig not in makers:
            raise SkinError(f"parameter rig must be one of {', '.join(_RIGS)}, or a Python file or module with a rig, not {self.rig!r}")
        return makers[self.rig]

    def _own(self) -> Rig:
        rig = own_rig(self.rig, self._layout(1), self.rig_options)
        if self.time_scale != 1.0 and not rig.owns_time:
            raise SkinError("hardware runs in real time: leave time_scale at 1.0")
        return rig

    def _simulated(self, node: Node) -> Rig:
        model = self._model()
        known = model.positions and not self.layout_file and not self.taxels
        layout = flat(model.positions) if known else self._layout(len(model.shares))
        if len(model.shares) not in (1, len(layout)):
            raise SkinError(f"the model has shares for {counted(len(model.shares), 'taxel')}, but the layout has {len(layout)}")
        real = Imperfections(
            self.load_cell_noise, self.taxel_noise, self.rest_error, self.screw_error, self.quantised, self.mount_compliance
        )
        start = _SURFACE - self.surface_offset + self.start_depth
        if not TRAVEL[0] <= start <= TRAVEL[1]:
            raise SkinError(f"start_depth ({self.start_depth} m) puts the stage at {start:g} m, outside its travel of {TRAVEL[1]:g} m")
        return SimulatedRig(
            under_plunger(model, layout, kernel_of(model.notes)), thesis_calibration(len(layout)), layout, _SURFACE, start, self.seed, real
        )

    def _model(self) -> Model:
        if self.model in names():
            return material(self.model).model
        if not Path(self.model).suffix and not Path(self.model).exists():
            raise SkinError(f"there is no material {self.model!r}, only {', '.join(names())}; a model of your own is a YAML file")
        return load_model(self.model)

    def _replay(self, node: Node) -> Rig:
        if not self.recording:
            raise SkinError("rig:=replay needs the parameter recording")
        if Path(self.recording).suffix.lower() in SUFFIXES:
            recorded, layout = read_table(self.recording), None
        else:
            recorded, layout = read_bag(self.recording, self.recording_namespace)
        for warning in recorded.warnings:
            node.get_logger().warning(f"{self.recording}: {warning}")
        return ReplayRig(recorded, layout or self._layout(max(recorded.taxels.values.shape[1], 1)), loop=self.loop)

    def _topics(self, node: Node) -> Rig:
        if self.time_scale != 1.0:
            raise SkinError("rig:=topics runs in the time of its drivers: leave time_scale at 1.0")
        settings = TopicsSettings(
            self.joint, math.copysign(1.0, self.axis_sign), math.copysign(1.0, self.force_sign), self.stale_after,
            self.command_type, self.taxels_type, self.axis_speeds,
        )  # fmt: skip
        return TopicsRig(node, settings, self._layout(1))

    def _layout(self, count: int) -> Layout:
        return load_layout(self.layout_file) if self.layout_file else row_from_origin(self.taxels or count)
