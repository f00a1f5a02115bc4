"""What a recording loses when its recorder is killed (SIGKILL): seconds before the kill that cannot be read back.

    bench_recorder_killed.py [--trials 10]        (./skin bench recorder: as it stands)

The driver samples at 100 Hz and 1 kHz; the recorder is killed at a random moment after three seconds. The bag is read as `export_table`
and rig:=replay read it.
"""

import argparse
import random
import tempfile
import time
from pathlib import Path

import numpy as np

from skin_models.ros.processes import Domain, Processes
from skin_testbed_driver.ros.replayed_bag import read_bag


def trial(rate: float, processes: Processes, directory: Path) -> tuple[float, int, int]:
    """Seconds lost, samples that read back, and samples missing between the first and the last of them."""
    topics = ["encoder", "force", "taxels"]
    recorder = processes.start("skin_testbed_driver", "recorder", parameters={"directory": str(directory), "topics": topics})
    recorder.wait_for_output("every topic asked for", 60.0)
    begin = time.time()
    time.sleep(3.0 + random.random())
    recorder.kill()
    killed = time.time()
    recorded, _ = read_bag(str(directory))
    t = recorded.depth.t
    # Samples began to be recorded at about `begin`: what is lost lies between the last one and the kill.
    return (killed - begin) - float(t[-1]), t.size, round((t[-1] - t[0]) * rate) + 1 - np.unique(t).size


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=10)
    trials = parser.parse_args().trials
    for rate in (100.0, 1000.0):
        with Domain() as domain, Processes(domain.environment()) as processes, tempfile.TemporaryDirectory() as folder:
            driver = processes.start("skin_testbed_driver", "driver_node", parameters={"sample_rate": rate})
            driver.wait_for_output("sampling at", 60.0)
            lost, read, missing = zip(*(trial(rate, processes, Path(folder) / f"s{i}") for i in range(trials)), strict=True)
        print(
            f"{rate:g} Hz: {trials} kills, {sum(read)} samples read back, {sum(missing)} missing among them, "
            f"last {np.median(lost):.2f} s lost (median), {max(lost):.2f} s at most",
            flush=True,
        )


if __name__ == "__main__":
    main()
