"""How well the driver keeps its time, beside what a user would write instead.

    bench_sampling.py [--seconds 10] [--rounds 1] [--rates 100 500 1000] [--taxels 4 64]        (./skin bench sampling: as it stands)

Same machine, same minute, same messages (JointState, WrenchStamped, TaxelArray):
    driver       the installed driver with its simulated rig
    real-time    the same with a real-time priority, where this user may have one
    replay       the first with a recording for its rig: nothing is simulated, so that this is what sampling and publishing cost
    rclpy timer  a node whose timer publishes, on SingleThreadedExecutor: what a tutorial shows

Every publisher is a process of its own; period and latency are those of the force messages as they reach this process. Jitter is the
deviation of the period between publications (source timestamps) from the wanted one. CPU is that of the publisher: of its busiest thread,
which publishes, and of the whole process. The driver's also simulates the rig, checks limits and watches sensors.

What the machine can do is told by a bare loop, time.sleep to absolute deadlines and nothing else, in a process of its own: `beside` every
publisher, in the same seconds and so under the same load, and `alone`, for half as long before each. On a machine that others use,
several rounds of all publishers in turn are pooled into one table.
"""

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import TaxelArray

from skin_models.ros.processes import Domain, Process, executable


@dataclass(frozen=True)
class Row:
    """One line of the table: s, and CPU in shares of one core."""

    name: str
    periods: np.ndarray
    latencies: np.ndarray
    thread: float
    cpu: float
    beside: np.ndarray  # periods of the bare loop meanwhile, s
    alone: np.ndarray  # and before


class Timer(Node):
    """What a tutorial shows."""

    def __init__(self, rate: float, taxels: int) -> None:
        super().__init__("timer")
        self.force = self.create_publisher(WrenchStamped, "force", 10)
        self.encoder = self.create_publisher(JointState, "encoder", 10)
        self.taxels, self.count = self.create_publisher(TaxelArray, "taxels", 10), taxels
        self.create_timer(1.0 / rate, self.tick)

    def tick(self) -> None:
        force, encoder = WrenchStamped(), JointState(name=["indentation"], position=[0.0], velocity=[0.0])
        taxels = TaxelArray(force=[0.0] * self.count, voltage=[0.0] * self.count, status=[0] * self.count)
        force.header.stamp = encoder.header.stamp = taxels.header.stamp = self.get_clock().now().to_msg()
        self.encoder.publish(encoder)
        self.force.publish(force)
        self.taxels.publish(taxels)


def bare_loop(rate: float, seconds: float) -> np.ndarray:
    """Periods of a loop that only sleeps, s."""
    times = np.empty(int(rate * seconds))
    deadline = time.monotonic()
    for i in range(times.size):
        deadline += 1.0 / rate
        time.sleep(max(deadline - time.monotonic(), 0.0))
        times[i] = time.monotonic()
    return np.diff(times)


def cpu_seconds(pid: int) -> dict[str, float]:
    """CPU time (s) that every thread of a process has used. The scheduler's own count: finer than the ticks of `stat`."""
    return {task.name: 1e-9 * int((task / "schedstat").read_text().split()[0]) for task in Path(f"/proc/{pid}/task").iterdir()}


def listen(domain: Domain, process: Process, rate: float, seconds: float) -> tuple[tuple, subprocess.Popen]:
    """Periods, latencies and CPU shares (busiest thread, process) of a publisher while it runs steadily; and the bare loop beside it."""
    context = rclpy.context.Context()
    rclpy.init(context=context, domain_id=domain.id)
    node = rclpy.create_node("bench", context=context)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(node)
    sent, latency = [], []

    def on_force(_: WrenchStamped, info: dict) -> None:
        sent.append(info["source_timestamp"])
        latency.append(info["received_timestamp"] - info["source_timestamp"])

    node.create_subscription(WrenchStamped, "force", on_force, QoSProfile(depth=5000))
    while len(sent) < rate:  # the first second is for settling
        executor.spin_once(timeout_sec=0.1)
    loop = start_loop(rate, seconds)
    skipped, cpu, start = len(sent), cpu_seconds(process.pid), time.monotonic()
    while time.monotonic() - start < seconds:
        executor.spin_once(timeout_sec=0.1)
    passed = time.monotonic() - start
    shares = [(used - cpu.get(thread, 0.0)) / passed for thread, used in cpu_seconds(process.pid).items()]
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)
    return (1e-9 * np.diff(sent[skipped:]), 1e-9 * np.array(latency[skipped:]), max(shares), sum(shares)), loop


def recording(taxels: int) -> Path:
    """A table of two seconds at 1 kHz."""
    with tempfile.NamedTemporaryFile("w", suffix=".tsv", delete=False) as file:
        print("t_s", "x_mm", "force_n", *(f"taxel_{i}_n" for i in range(taxels)), sep="\t", file=file)
        for i in range(2000):
            print(1e-3 * i, *(math.sin(1e-3 * i + j) for j in range(taxels + 2)), sep="\t", file=file)
    return Path(file.name)


def start_loop(rate: float, seconds: float) -> subprocess.Popen:
    """The bare loop, in a process of its own."""
    command = [sys.executable, __file__, "--loop", "--rates", str(rate), "--seconds", str(seconds)]
    return subprocess.Popen(command, stdout=subprocess.PIPE)


def periods_of(loop: subprocess.Popen) -> np.ndarray:
    """What it measured, once it has ended."""
    return np.frombuffer(loop.communicate()[0])


def measure(rate: float, taxels: int, seconds: float) -> list[Row]:
    """All publishers, one after the other."""
    rows = []
    here = [sys.executable, __file__, "--rates", str(rate), "--taxels", str(taxels)]
    driver = [str(executable("skin_testbed_driver", "driver_node")), "--ros-args", "-p", f"sample_rate:={rate}", "-p", f"taxels:={taxels}"]
    table = recording(taxels)
    replay = [*driver, "-p", "rig:=replay", "-p", f"recording:={table}", "-p", "loop:=true"]
    urgent = [*driver, "-p", "realtime_priority:=40"]
    for name, command in (("driver", driver), ("real-time", urgent), ("replay", replay), ("rclpy timer", [*here, "--timer"])):
        alone = periods_of(start_loop(rate, 0.5 * seconds))
        with Domain() as domain:
            os.environ.update(domain.environment())
            process = Process(command, domain.environment(), name)
            heard, loop = listen(domain, process, rate, seconds)
            rows.append(Row(name, *heard, periods_of(loop), alone))
            process.end()
    table.unlink()
    return rows


def percentiles(periods: np.ndarray, rate: float) -> np.ndarray:
    """Jitter, us: p50, p99 and p99.9."""
    return 1e6 * np.percentile(np.abs(periods - 1.0 / rate), (50, 99, 99.9))


def pooled(rounds: list[list[Row]]) -> list[Row]:
    """The same publishers' rows of several rounds as one."""

    def one(rows: tuple[Row, ...]) -> Row:
        arrays = {name: np.concatenate([getattr(row, name) for row in rows]) for name in ("periods", "latencies", "beside", "alone")}
        shares = {name: float(np.mean([getattr(row, name) for row in rows])) for name in ("thread", "cpu")}
        return Row(rows[0].name, **arrays, **shares)

    return [one(rows) for rows in zip(*rounds, strict=True)]


def show(rate: float, taxels: int, rows: list[Row]) -> None:
    """One block of the table."""
    print(f"\n{rate:g} Hz, {taxels} taxels")
    words = f"{'samples':>8}{'missed':>8}{'p50':>8}{'p99':>8}{'p99.9':>8}   {'latency p50':>12}{'p99':>8}{'thread':>8}{'CPU':>7}"
    print(f"{'':14}{words}   µs, % of a core; p99 of the bare loop beside")
    for row in rows:
        missed = max(round(row.periods.sum() * rate) - row.periods.size, 0)
        half, most = 1e6 * np.percentile(row.latencies, (50, 99))
        line = f"{row.name:14}{row.periods.size + 1:8d}{missed:8d}" + "".join(f"{x:8.0f}" for x in percentiles(row.periods, rate))
        line += f"   {half:12.0f}{most:8.0f}{100.0 * row.thread:8.1f}{100.0 * row.cpu:7.1f}"
        print(f"{line}{percentiles(row.beside, rate)[1]:8.0f}")
    alone = percentiles(np.concatenate([row.alone for row in rows]), rate)
    print(f"{'bare, alone':14}{'':16}" + "".join(f"{x:8.0f}" for x in alone))
    cost = [np.array([row.thread, row.cpu]) * row.periods.sum() / row.periods.size for row in rows]
    for row, mine in zip(rows[:3], cost, strict=False):
        p99 = percentiles(row.periods, rate)[1]
        thread, process = mine / cost[3]
        ratio = f"CPU per sample x {thread:.2f} (thread), x {process:.2f} (process) of the timer"
        beside = percentiles(row.beside, rate)[1]
        print(
            f"{row.name}: p99 jitter x {p99 / beside:.2f} of the bare loop beside, x {p99 / alone[1]:.2f} of it alone; {ratio}", flush=True
        )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--rates", type=float, nargs="+", default=[100.0, 500.0, 1000.0])
    parser.add_argument("--taxels", type=int, nargs="+", default=[4, 64])
    parser.add_argument("--timer", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--loop", action="store_true", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.loop:
        sys.stdout.buffer.write(bare_loop(chosen.rates[0], chosen.seconds).tobytes())
    elif chosen.timer:
        rclpy.init()
        rclpy.spin(Timer(chosen.rates[0], chosen.taxels[0]))
    else:
        for rate in chosen.rates:
            for taxels in chosen.taxels:
                show(rate, taxels, pooled([measure(rate, taxels, chosen.seconds) for _ in range(chosen.rounds)]))


if __name__ == "__main__":
    main()
