"""A testbed of real processes: driver, profile server and recorder, started, used for sessions, and ended by their own ids.

Nothing is imported from those packages: they are found where they are installed and spoken to over DDS, as a user's own graph would be.
"""

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skin_models.errors import SkinError
from skin_models.ros.processes import Domain, Processes

# Without a search for the surface, which the simulated rig knows and a search would find within some 3 um. The tare takes 10 s: a mean over
# one second is 5 mN off in one of three cases, and the diagnosis would name that.
TARE = "{type: battery, profiles: [{type: free_air, clearance_mm: 1.0, duration_s: 0.5}, {type: tare, duration_s: 10}]}"
READY = "ready|sampling at|being recorded"  # what a node says when a session may begin
PATIENCE = 30.0  # s until a node is ready: a busy machine needs a while to import


class TestbedError(SkinError):
    """The testbed did not do what it was asked."""


class Testbed:
    """The simulated rig with its profile server, `time_scale` times faster than real. Use it as a context manager."""

    def __init__(self, model: Path | None, seed: int, time_scale: float) -> None:
        self.domain = Domain()
        self.processes = Processes(self.domain.environment())
        self.unfinished: set[Path] = set()  # recordings that would pass for whole ones
        self.simulated_time = {"use_sim_time": True} if time_scale != 1.0 else {}
        driver = {"seed": seed, "time_scale": time_scale, **({"model": str(model)} if model else {})}
        self._ready("skin_testbed_driver", "driver_node", driver)
        self._ready("skin_motion_profiles", "profile_server", {"feedback_timeout": 10.0, **self.simulated_time})

    def simulate_beside(self, model: Path, namespace: str) -> None:
        """Start a simulated skin that follows the encoder; it publishes `<namespace>/force` and `<namespace>/taxels`."""
        names = ("force", "taxels", "taxels_truth", "taxel_layout", "markers", "heat_map", "points")
        remap = {name: f"{namespace}/{name}" for name in names} | {"__node": f"{namespace}_skin"}
        parameters = {"model": str(model), "drive": "encoder", "seed": -1, "view_rate": 0.0, **self.simulated_time}
        self._ready("skin_models", "skin_node", parameters, remap)

    def execute(self, *words: str, timeout: float = 300.0) -> None:
        """Run one profile or battery through the action. Raises `TestbedError` with the server's sentence if it fails."""
        client = self.processes.start("skin_motion_profiles", "execute", words)
        if client.wait(timeout) != 0:
            raise TestbedError(f"the profile {words[0]} failed: {client.output().strip().splitlines()[-1]}")

    def session(self, directory: Path, *words: str) -> Path:
        """Run a battery while everything is recorded into `directory`, which must not exist; returns the bag.

        Where the battery or the recording does not come to its end, the directory is removed when the testbed is left.
        """
        if not directory.exists():
            self.unfinished.add(directory)
        recorder = self._ready("skin_testbed_driver", "recorder", {"directory": str(directory)})
        self.execute(*words)
        if recorder.end(PATIENCE) != 0:
            raise TestbedError(f"the recorder failed: {recorder.output().strip().splitlines()[-1]}")
        self.unfinished.discard(directory)
        return directory

    def _ready(self, package: str, name: str, parameters: Mapping[str, Any], remap: Mapping[str, str] | None = None):
        process = self.processes.start(package, name, parameters=parameters, remap=remap)
        process.wait_for_output(READY, PATIENCE)
        return process

    def __enter__(self) -> "Testbed":
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.processes.end()
            self.domain.__exit__()
        finally:
            for directory in self.unfinished:
                shutil.rmtree(directory, ignore_errors=True)
