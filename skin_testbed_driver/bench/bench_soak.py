"""A long session, counted: what the driver sampled, what a subscriber in another process got, and what the recorder's bag holds.

    bench_soak.py [--rate 100] [--taxels 4] [--seconds 20] [--motion]        (./skin bench soak: as it stands)

The driver (simulated rig), the recorder and, with --motion, the profile server with a sine that lasts as long, are processes of their own;
this process subscribes to encoder, force and taxels. A sample is known by its stamp: what is missing between the first and the last stamp
was dropped on the way. Overruns and latencies are also told without the first five seconds, in which processes start.
"""

import argparse
import struct
import tempfile
import time
from array import array
from pathlib import Path

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from mcap.reader import make_reader
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import TaxelArray

from skin_models.ros.processes import Domain, Processes

TOPICS = {"encoder": JointState, "force": WrenchStamped, "taxels": TaxelArray}
STAMP = struct.Struct("<iI")  # behind the four bytes that open every CDR message
SETTLING = 5.0  # s
SINE = "{{type: sine, amplitude_mm: 0.3, offset_mm: 0.5, frequency_hz: 0.5, periods: {}}}"


def stamp(data: bytes) -> int:
    """The stamp (ns) of a serialised message that begins with a header."""
    sec, nanosec = STAMP.unpack_from(data, 4)
    return sec * 10**9 + nanosec


class Listener:
    """A process's view of the streams: stamps, and how long every force message was on its way."""

    def __init__(self, domain: Domain, rate: float) -> None:
        self.context = rclpy.context.Context()
        rclpy.init(context=self.context, domain_id=domain.id)
        self.node = rclpy.create_node("soak", context=self.context)
        self.executor = rclpy.executors.SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.stamps = {name: array("q") for name in TOPICS}
        self.latencies, self.loop = array("q"), {}
        depth = QoSProfile(depth=max(int(5.0 * rate), 100))  # as the driver's
        for name, kind in TOPICS.items():
            callback = self._on_force if name == "force" else lambda data, name=name: self.stamps[name].append(stamp(data))
            self.node.create_subscription(kind, name, callback, depth, raw=True)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)

    def _on_force(self, data: bytes, info: dict) -> None:
        self.stamps["force"].append(stamp(data))
        self.latencies.append(info["received_timestamp"] - info["source_timestamp"])

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.endswith("sampling"):
                self.loop = {pair.key: pair.value for pair in status.values}

    def listen(self, seconds: float) -> None:
        """Take what comes."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.1)

    def close(self) -> None:
        """Leave the graph."""
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


def bag_stamps(directory: Path) -> dict[str, array]:
    """The stamps (ns) of every stream in a recording."""
    found = {name: array("q") for name in TOPICS}
    with next(directory.glob("*.mcap")).open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages(topics=[f"/{name}" for name in TOPICS]):
            found[channel.topic[1:]].append(stamp(message.data))
    return found


def dropped(stamps: array, rate: float) -> tuple[int, int, int]:
    """Samples received, missing between the first and the last, and received twice or out of order."""
    t = np.frombuffer(stamps, np.int64)
    if t.size < 2:
        return t.size, 0, 0
    expected = round((t.max() - t.min()) * 1e-9 * rate) + 1
    return t.size, expected - np.unique(t).size, int((np.diff(t) <= 0).sum())


def show(rate: float, listener: Listener, recorded: dict[str, array], before: int, ended: str) -> None:
    """The table. `before`: overruns while settling."""
    print(f"{'stream':10}{'seen by':>12}{'samples':>10}{'dropped':>9}{'disordered':>12}")
    for who, streams in (("subscriber", listener.stamps), ("bag", recorded)):
        for name, stamps in streams.items():
            samples, lost, disordered = dropped(stamps, rate)
            print(f"{name:10}{who:>12}{samples:10d}{lost:9d}{disordered:12d}")
    loop = listener.loop
    counts = ", ".join(f"{loop.get(key, '?')} {key}" for key in ("samples", "overruns", "skipped"))
    print(f"driver: {counts} ({before} of the overruns while settling)")
    print(f"last ten seconds: p99 jitter {loop.get('jitter_p99_us', '?')} us, {loop.get('achieved_rate_hz', '?')} Hz")
    p50, p99, p999 = 1e-3 * np.percentile(np.frombuffer(listener.latencies, np.int64), (50, 99, 99.9))
    print(f"latency of force: p50 {p50:.0f}, p99 {p99:.0f}, p99.9 {p999:.0f}, most {1e-3 * max(listener.latencies):.0f} us")
    print(f"motion: {ended}", flush=True)


def soak(rate: float, taxels: int, seconds: float, motion: bool, priority: int) -> None:
    """One session."""
    load = Path("/proc/loadavg").read_text().split()[1]
    print(f"\n{time.strftime('%H:%M:%S')} {rate:g} Hz, {taxels} taxels, {seconds:g} s, load of the machine {load}", flush=True)
    with Domain() as domain, Processes(domain.environment()) as processes, tempfile.TemporaryDirectory() as folder:
        parameters = {"sample_rate": float(rate), "taxels": taxels, "realtime_priority": priority}
        driver = processes.start("skin_testbed_driver", "driver_node", parameters=parameters)
        driver.wait_for_output("sampling at", 60.0)
        bag = Path(folder) / "bag"
        topics = [*TOPICS, "driver_state"]
        recorder = processes.start("skin_testbed_driver", "recorder", parameters={"directory": str(bag), "topics": topics})
        recorder.wait_for_output("every topic asked for", 60.0)
        listener, mover = Listener(domain, rate), None
        if motion:
            processes.start("skin_motion_profiles", "profile_server")
            mover = processes.start("skin_motion_profiles", "execute", [SINE.format(int((seconds - SETTLING) / 2.0))])
        listener.listen(SETTLING)
        before = int(listener.loop.get("overruns", 0))
        del listener.latencies[:]
        listener.listen(seconds)
        recorder.end(30.0)
        ended = "none" if mover is None else ("still moving" if mover.status is None else mover.output().strip().splitlines()[-1])
        show(rate, listener, bag_stamps(bag), before, ended)
        load = Path("/proc/loadavg").read_text().split()[1]
        print(f"{time.strftime('%H:%M:%S')} end, load of the machine {load}", flush=True)
        listener.close()


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rate", type=float, default=100.0, help="Hz")
    parser.add_argument("--taxels", type=int, default=4)
    parser.add_argument("--seconds", type=float, default=20.0, help="after settling")
    parser.add_argument("--motion", action="store_true", help="press all the time")
    parser.add_argument("--priority", type=int, default=0, help="real-time priority of sampling, 1 to 90")
    chosen = parser.parse_args()
    soak(chosen.rate, chosen.taxels, chosen.seconds, chosen.motion, chosen.priority)


if __name__ == "__main__":
    main()
