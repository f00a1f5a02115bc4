"""The parameters of the driver node, and what they make: limits, zero settings, calibration and the rig."""

from dataclasses import dataclass, fields

from skin_models.dispersion import Dispersion
from skin_models.errors import SkinError
from skin_models.model import Model
from skin_models.model_file import load_model
from skin_models.ros.parameters import setting

from skin_testbed_driver.calibration import Calibration, load_calibration, thesis_calibration
from skin_testbed_driver.rig import Rig
from skin_testbed_driver.rigs.simulated import Imperfections, SimulatedRig
from skin_testbed_driver.safety import Limits
from skin_testbed_driver.zeroing import ZeroSettings

# 4 mm silicone over one taxel with the skin's mass weighed (thesis, Table 4-5).
THESIS_SILICONE = Model(Dispersion(m=0.000432, b1=939.5, k1=9619.0, b2=629.2, k2=2766.0), name="silicone 4 mm")


@dataclass(frozen=True)
class DriverSettings:
    """Every parameter. Those that the running loop cannot change are fixed."""

    rig: str = setting("simulated", "which rig to drive", choices=("simulated",), fixed=True)
    sample_rate: float = setting(100.0, "Hz, synchronous samples per second", lower=1.0, upper=1000.0, fixed=True)
    autostart: bool = setting(True, "configure and activate at start, without a lifecycle manager", fixed=True)
    calibration_file: str = setting("", "YAML with the slope of every taxel; empty: the thesis's slopes", fixed=True)
    start_depth: float = setting(
        -0.002, "m, depth at which the plunger is taken to be at start, until the service zero finds the surface",
        lower=-0.15, upper=0.15, fixed=True,
    )  # fmt: skip
    speed_samples: int = setting(
        2, "samples in the least-squares line whose slope is the published speed; 2: finite difference", lower=2, upper=100, fixed=True
    )
    force_frame: str = setting("load_cell", "frame_id of force", fixed=True)
    skin_frame: str = setting("skin", "frame_id of taxels and of taxel_layout", fixed=True)

    min_depth: float = setting(-0.01, "m, travel limit in the air", lower=-0.15, upper=0.0, fixed=True)
    max_depth: float = setting(0.004, "m, deepest indentation", lower=0.0, upper=0.15, fixed=True)
    max_speed: float = setting(0.02, "m/s, greatest speed", lower=1e-6, upper=1.0, fixed=True)
    max_acceleration: float = setting(1.0, "m/s^2, greatest acceleration, also that of every stop", lower=1e-4, upper=100.0, fixed=True)
    max_force: float = setting(Limits.max_force, "N, more than this stops and retracts", lower=0.01, upper=10000.0, fixed=True)
    max_following_error: float = setting(2e-4, "m, by how much the stage may miss where it should be", lower=1e-6, upper=0.01, fixed=True)
    retracted_depth: float = setting(-0.002, "m, where an over-force retracts to", lower=-0.15, upper=0.0, fixed=True)

    zero_threshold: float = setting(0.01, "V, rise of the rolling mean that is the surface (thesis, section 3.2.2)", lower=1e-4, upper=1.0)
    zero_samples: int = setting(100, "samples in that rolling mean", lower=1, upper=10000)
    zero_fast: float = setting(5e-4, "m/s, first approach to the surface", lower=1e-6, upper=0.02)
    zero_slow: float = setting(2e-5, "m/s, second approach", lower=1e-6, upper=0.02)
    zero_travel: float = setting(0.01, "m, how far to look for the surface", lower=1e-4, upper=0.15)
    tare_duration: float = setting(1.0, "s, how long the service tare averages", lower=0.01, upper=600.0)

    time_scale: float = setting(
        1.0, "simulated seconds per second; other than 1 publishes /clock, for nodes with use_sim_time", lower=0.01, upper=1000.0, fixed=True
    )
    model: str = setting("", "simulated rig: YAML of the specimen and its hidden effects; empty: 4 mm silicone", fixed=True)
    seed: int = setting(0, "simulated rig: seed of noise, rest errors and random effects", lower=0, upper=2**31 - 1, fixed=True)
    surface_offset: float = setting(
        0.0, "m, simulated rig: by how much the surface lies deeper than start_depth says", lower=-0.02, upper=0.02, fixed=True
    )
    load_cell_noise: float = setting(3e-3, "V, simulated rig: standard deviation", lower=0.0, upper=1.0, fixed=True)
    taxel_noise: float = setting(3e-3, "V, simulated rig: standard deviation", lower=0.0, upper=1.0, fixed=True)
    rest_error: float = setting(5e-6, "m, simulated rig: greatest error of the stage at rest", lower=0.0, upper=1e-3, fixed=True)
    screw_error: float = setting(2.5e-6, "m, simulated rig: amplitude of the screw's error", lower=0.0, upper=1e-3, fixed=True)
    quantised: bool = setting(True, "simulated rig: encoder of 1 um and converter of 4.88 mV; false: exact values", fixed=True)

    def __post_init__(self) -> None:
        """Refuse combinations that make no sense."""
        self.limits()
        if self.zero_slow > self.zero_fast:
            raise SkinError(f"zero_slow ({self.zero_slow} m/s) must not exceed zero_fast ({self.zero_fast} m/s)")

    def limits(self) -> Limits:
        """The parameters that are limits. Raises `SkinError` if they contradict each other."""
        return Limits(**{f.name: getattr(self, f.name) for f in fields(Limits)})

    def zeroing(self, threshold: float = 0.0, samples: int = 0) -> ZeroSettings:
        """How to find the surface; 0 takes the parameter."""
        return ZeroSettings(
            threshold=threshold or self.zero_threshold, samples=samples or self.zero_samples, fast=self.zero_fast, slow=self.zero_slow,
            travel=self.zero_travel, retracted_depth=self.retracted_depth,
        )  # fmt: skip

    def make_rig(self) -> tuple[Rig, Calibration]:
        """The rig, closed, and the calibration that the driver believes in. Raises `SkinError` for files that cannot be used."""
        model = load_model(self.model) if self.model else THESIS_SILICONE
        true = thesis_calibration(len(model.shares))
        real = Imperfections(self.load_cell_noise, self.taxel_noise, self.rest_error, self.screw_error, self.quantised)
        surface = 0.075
        start = surface - self.surface_offset + self.start_depth
        rig = SimulatedRig(model, true, surface=surface, start=start, seed=self.seed, imperfections=real)
        return rig, load_calibration(self.calibration_file, rig.layout.names) if self.calibration_file else true
