"""The parameters of the driver node, and what they make: limits and zero settings. Those of the rigs are in `rig_settings`."""

from dataclasses import dataclass, fields

from skin_models.errors import SkinError
from skin_models.ros.parameters import setting
from skin_testbed_driver.ros.rig_settings import RigSettings
from skin_testbed_driver.safety import Limits
from skin_testbed_driver.zeroing import ZeroSettings


@dataclass(frozen=True)
class DriverSettings(RigSettings):
    """Every parameter. Those that the running loop cannot change are fixed."""

    autostart: bool = setting(True, "configure and activate at start, without a lifecycle manager", fixed=True)
    realtime_priority: int = setting(
        0, "1 to 90: real-time priority of sampling (SCHED_FIFO), where this user may have one; 0: none", lower=0, upper=90, fixed=True
    )
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
    zero_extrapolate: bool = setting(True, "whether the surface is where the force begins to rise, or where it has risen by zero_threshold")
    zero_travel: float = setting(0.01, "m, how far to look for the surface", lower=1e-4, upper=0.15)
    tare_duration: float = setting(1.0, "s, how long the service tare averages", lower=0.01, upper=600.0)

    def __post_init__(self) -> None:
        """Refuse combinations that make no sense."""
        self.limits()
        if self.zero_slow > self.zero_fast:
            raise SkinError(f"zero_slow ({self.zero_slow} m/s) must not exceed zero_fast ({self.zero_fast} m/s)")

    def limits(self) -> Limits:
        """The parameters that are limits. Raises `SkinError` if they contradict each other."""
        return Limits(**{f.name: getattr(self, f.name) for f in fields(Limits)})

    def zeroing(self) -> ZeroSettings:
        """How to find the surface."""
        return ZeroSettings(
            threshold=self.zero_threshold, samples=self.zero_samples, fast=self.zero_fast, slow=self.zero_slow,
            travel=self.zero_travel, retracted_depth=self.retracted_depth, extrapolate=self.zero_extrapolate,
        )  # fmt: skip
