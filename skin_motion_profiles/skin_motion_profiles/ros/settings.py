"""Parameters of the profile server."""

from dataclasses import dataclass

from skin_models.ros.parameters import setting


@dataclass(frozen=True)
class Settings:
    """All SI."""

    max_force: float = setting(100.0, "N, end a goal above this force unless the goal says otherwise", lower=0.0, upper=1e4)
    approach_speed: float = setting(0.002, "m/s, speed from the present depth to where a profile begins", lower=1e-6, upper=1.0)
    approach_acceleration: float = setting(0.05, "m/s^2, acceleration of that approach", lower=1e-4, upper=100.0)
    retract_speed: float = setting(0.01, "m/s, speed of a retreat after cancel, over-force or a fault", lower=1e-6, upper=1.0)
    feedback_timeout: float = setting(1.0, "s, longest silence of encoder or load cell", lower=0.02, upper=60.0)
    depth_tolerance: float = setting(0.0003, "m, largest distance between planned and measured depth", lower=1e-6, upper=0.1)
    depth_patience: float = setting(0.25, "s, how long that distance may be larger", lower=0.0, upper=60.0)
    settle_time: float = setting(1.0, "s, how long the stage may take to come to rest at the end", lower=0.0, upper=60.0)
    action_timeout: float = setting(600.0, "s, longest wait for zero, tare, or somebody at the x-y stage", lower=1.0, upper=1e5)
    stage_tolerance: float = setting(5e-5, "m, how near stage_position must come to stage_target", lower=1e-6, upper=0.01)
    driver_name: str = setting("testbed_driver", "name of the driver node, whose services zero and tare are called", fixed=True)
    skin_frame: str = setting("skin", "frame of stage_target", fixed=True)
