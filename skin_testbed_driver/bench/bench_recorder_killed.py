"""What a recording loses when its recorder is killed (SIGKILL): seconds before the kill that cannot be read back.

    bench_recorder_killed.py [--trials 20]        (./skin bench recorder: as it stands)

The driver samples at 100 Hz and 1 kHz in real time; the recorder is killed at a random moment, three to five seconds after the last
topic has come. *Lost* is the time from the stamp of the last sample in the file to the kill: what the recorder held back, what it had not
yet taken from the network, and how late the driver was. The file is read as it was left, without its end. Every trial has a driver and a
domain of its own: who starts where another participant was killed hears nothing for seconds, because Fast DDS goes on to write into the
shared memory of the dead one, and then everything.
"""

import argparse
import random
import struct
import tempfile
import time
from pathlib import Path

import numpy as np
from mcap.exceptions import McapError
from mcap.stream_reader import StreamReader

from skin_models.ros.processes import Domain, Processes


def stamps(directory: Path) -> np.ndarray:
    """The stamps of `encoder` in a file without an end, s since 1970."""
    found, topics = [], {}
    with next(directory.glob("*.mcap")).open("rb") as file:
        try:
            for record in StreamReader(file).records:
                kind = type(record).__name__
                if kind == "Channel":
                    topics[record.id] = record.topic
                elif kind == "Message" and topics[record.channel_id] == "/encoder":
                    found.append(struct.unpack_from("<iI", record.data, 4))  # behind the four bytes that open CDR
        except McapError:
            pass  # the end is missing
    return np.array([s + 1e-9 * ns for s, ns in found])


def trial(rate: float) -> tuple[float, int, int]:
    """Seconds lost, samples that read back, and samples missing between the first and the last of them."""
    with Domain() as domain, Processes(domain.environment()) as processes, tempfile.TemporaryDirectory() as folder:
        driver = processes.start("skin_testbed_driver", "driver_node", parameters={"sample_rate": rate})
        driver.wait_for_output("sampling at", 60.0)
        return killed(rate, processes, Path(folder) / "s")


def killed(rate: float, processes: Processes, directory: Path) -> tuple[float, int, int]:
    """As `trial`, beside a running driver."""
    topics = ["encoder", "force", "taxels"]
    recorder = processes.start("skin_testbed_driver", "recorder", parameters={"directory": str(directory), "topics": topics})
    recorder.wait_for_output("every topic asked for", 60.0)
    time.sleep(random.uniform(3.0, 5.0))
    now = time.time()
    recorder.kill()
    t = stamps(directory)
    return now - float(t[-1]), t.size, round((t[-1] - t[0]) * rate) + 1 - t.size


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=20)
    trials = parser.parse_args().trials
    for rate in (100.0, 1000.0):
        lost, read, missing = zip(*(trial(rate) for _ in range(trials)), strict=True)
        print(
            f"{rate:g} Hz: {trials} kills, {sum(read)} samples read back, {sum(missing)} missing among them, "
            f"last {np.median(lost):.2f} s lost (median), {max(lost):.2f} s at most",
            flush=True,
        )


if __name__ == "__main__":
    main()
