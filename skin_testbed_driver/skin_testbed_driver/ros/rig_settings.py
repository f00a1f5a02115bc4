"""The parameters that choose and describe the rig, and the rig they make."""

from dataclasses import dataclass, replace

import numpy as np

from skin_models.errors import SkinError
from skin_models.layout import Layout
from skin_models.layout_file import load_layout
from skin_models.materials import material, names
from skin_models.model import Model
from skin_models.model_file import load_model
from skin_models.ros.parameters import setting
from skin_models.simulated_skin import spread_width
from skin_testbed_driver.calibration import Calibration, load_calibration, thesis_calibration
from skin_testbed_driver.rig import Rig
from skin_testbed_driver.rigs.simulated import Imperfections, SimulatedRig, row_from_origin

_SURFACE = 0.075  # m, stage position of the simulated skin: the middle of the travel


@dataclass(frozen=True)
class RigSettings:
    """Every parameter of every rig; a rig looks at its own."""

    rig: str = setting("simulated", "which rig to drive", choices=("simulated",), fixed=True)
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
    layout_file: str = setting("", "simulated rig: table of taxels (name, x_mm, y_mm, …); empty: a row, 14 mm apart", fixed=True)
    taxels: int = setting(0, "simulated rig: taxels in that row; 0: as many as the model has", lower=0, upper=1000, fixed=True)
    seed: int = setting(0, "simulated rig: seed of noise, rest errors and random effects", lower=0, upper=2**31 - 1, fixed=True)
    surface_offset: float = setting(
        0.0, "m, simulated rig: by how much the surface lies deeper than start_depth says", lower=-0.02, upper=0.02, fixed=True
    )
    load_cell_noise: float = setting(3e-3, "V, simulated rig: standard deviation", lower=0.0, upper=1.0, fixed=True)
    taxel_noise: float = setting(3e-3, "V, simulated rig: standard deviation", lower=0.0, upper=1.0, fixed=True)
    rest_error: float = setting(5e-6, "m, simulated rig: greatest error of the stage at rest", lower=0.0, upper=1e-3, fixed=True)
    screw_error: float = setting(2.5e-6, "m, simulated rig: amplitude of the screw's error", lower=0.0, upper=1e-3, fixed=True)
    quantised: bool = setting(True, "simulated rig: encoder of 1 um and converter of 4.88 mV; false: exact values", fixed=True)

    def make_rig(self) -> tuple[Rig, Calibration]:
        """The rig, closed, and the calibration that the driver believes in. Raises `SkinError` for files that cannot be used."""
        rig, true = self._simulated()
        return rig, load_calibration(self.calibration_file, rig.layout.names) if self.calibration_file else true

    def _simulated(self) -> tuple[Rig, Calibration]:
        model = material(self.model).model if self.model in names() else load_model(self.model)
        layout = self._layout(model)
        calibration = thesis_calibration(len(layout))
        real = Imperfections(self.load_cell_noise, self.taxel_noise, self.rest_error, self.screw_error, self.quantised)
        start = _SURFACE - self.surface_offset + self.start_depth
        rig = SimulatedRig(_spread(model, layout), calibration, layout, _SURFACE, start, self.seed, real)
        return rig, calibration

    def _layout(self, model: Model) -> Layout:
        count = self.taxels or len(model.shares)
        layout = load_layout(self.layout_file) if self.layout_file else row_from_origin(count)
        if len(model.shares) not in (1, len(layout)):
            raise SkinError(f"the model has shares for {len(model.shares)} taxels, but the layout has {len(layout)}")
        return layout


def _spread(model: Model, layout: Layout) -> Model:
    """The model of one taxel, with more of them beside it: each has the share of a Gaussian at its distance from the origin."""
    if len(model.shares) == len(layout):
        return model
    squared = np.sum(layout.positions[:, :2] ** 2, axis=1)
    shares = model.shares[0] * np.exp(-squared / spread_width(model) ** 2)
    return replace(model, shares=tuple(shares.tolist()))
