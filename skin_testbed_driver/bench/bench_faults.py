"""What happens when something dies: a table of faults, each caused many times by ending or cutting real processes.

    bench_faults.py [--trials 10]        (./skin bench faults: as it stands)

Times are from the fault to the first sample from which on the plunger rests (moves less than 5 um in 100 ms), by the driver's stamps.
"""

import argparse
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import rclpy
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import WrenchStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import DriverState, TaxelArray
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from skin_models.ros.processes import Domain, Process, Processes

HARDWARE = Path(__file__).parents[1] / "test" / "hardware.py"
REMAP = {"axis_state": "joint_states", "axis_command": "axis_trajectory", "force_in": "wrench", "taxels_in": "tactile"}
TOPICS = {
    "rig": "topics",
    "joint": "z_axis",
    "axis_sign": -1.0,
    "taxels_type": "Float64MultiArray",
    "taxels": 2,
    "max_following_error": 3e-3,
    "stale_after": 0.5,
}
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Bench:
    """A node that watches a driver in a domain of its own."""

    def __init__(self, parameters: dict, hardware: bool = False) -> None:
        self.domain = Domain()
        self.processes = Processes(self.domain.environment())
        self.context = rclpy.context.Context()
        rclpy.init(context=self.context, domain_id=self.domain.id)
        self.node = rclpy.create_node("faults", context=self.context)
        self.executor = rclpy.executors.SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.samples, self.forces, self.state, self.taxels, self.axis = [], [], None, [], []
        self.node.create_subscription(JointState, "encoder", self._on_encoder, 1000)
        self.node.create_subscription(WrenchStamped, "force", self._on_force, 1000)
        self.node.create_subscription(DriverState, "driver_state", self._on_state, LATCHED)
        self.node.create_subscription(TaxelArray, "taxels", self._on_taxels, 1000)
        self.node.create_subscription(JointState, "joint_states", lambda m: self.axis.append((stamp(m), m.position[1])), 1000)
        self.changing = self.node.create_client(ChangeState, "testbed_driver/change_state")
        self.commands = self.node.create_publisher(JointTrajectory, "command", 10)
        self.resetting = self.node.create_client(Trigger, "testbed_driver/reset")
        if hardware:
            self.parts = {name: self.run([str(HARDWARE), name, kind]) for name, kind in hardware_parts()}
        remap = REMAP if hardware else None
        self.driver = self.processes.start("skin_testbed_driver", "driver_node", parameters=parameters, remap=remap)
        self.wait(lambda: self.state and self.state.state == DriverState.READY and self.samples)
        self.wait(self.commands.get_subscription_count)

    def run(self, command: list[str]) -> Process:
        """Start a Python script."""
        self.processes.running.append(Process([sys.executable, *command], self.domain.environment(), command[0]))
        return self.processes.running[-1]

    def wait(self, condition: Callable[[], object], timeout: float = 120.0) -> None:
        """Spin until it is true."""
        deadline = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > deadline:
                said = f"the driver's last word: {self.state.reason}" if self.state else "no driver was heard"
                raise SystemExit(f"bench_faults: waited in vain; the machine is too busy, or the driver has an error ({said})")
            self.executor.spin_once(timeout_sec=0.05)

    def go(self, depth: float, seconds: float) -> None:
        """Command one straight move."""
        when = Duration(sec=int(seconds), nanosec=int(1e9 * (seconds % 1)))
        point = JointTrajectoryPoint(positions=[depth], velocities=[0.0], time_from_start=when)
        self.commands.publish(JointTrajectory(joint_names=["indentation"], points=[point]))

    def back(self) -> None:
        """Reset, and go into the air."""
        self.wait(lambda: self.resting(time.time() - 0.5) is not None or self.state.state == DriverState.READY)
        while self.state.state == DriverState.STOPPED:
            future = self.resetting.call_async(Trigger.Request())
            self.wait(future.done)
            self.wait_for(0.3)
        self.go(-5e-4, 2.0)
        self.wait(lambda: abs(self.samples[-1][1] + 5e-4) < 1e-5 and self.state.state == DriverState.READY)

    def press(self) -> None:
        """From the air on the way to 1 mm, and already in the skin."""
        self.back()
        self.go(1e-3, 4.0)
        self.wait(lambda: self.samples[-1][1] > 2e-4)

    def call(self, transition: int) -> None:
        """Lead the node to another state."""
        future = self.changing.call_async(ChangeState.Request(transition=Transition(id=transition)))
        self.wait(future.done)

    def wait_for(self, seconds: float) -> None:
        """Let time pass."""
        end = time.monotonic() + seconds
        self.wait(lambda: time.monotonic() > end)

    def resting(self, since: float) -> float | None:
        """When, after `since`, the plunger came to rest (s); None while it moves."""
        recent = [(t, x) for t, x in self.samples[-1000:] if t >= since and not math.isnan(x)]
        for i, (t, x) in enumerate(recent):
            later = [y for s, y in recent[i:] if s <= t + 0.1]
            if recent[-1][0] >= t + 0.1 and max(abs(y - x) for y in later) < 5e-6:
                return t
        return None

    def __enter__(self) -> "Bench":
        return self

    def __exit__(self, *_: object) -> None:
        self.processes.end()
        rclpy.shutdown(context=self.context)
        self.domain.__exit__()

    def _on_encoder(self, m: JointState) -> None:
        self.samples.append((stamp(m), m.position[0]))

    def _on_force(self, m: WrenchStamped) -> None:
        self.forces.append((stamp(m), -m.wrench.force.z))

    def _on_taxels(self, m: TaxelArray) -> None:
        self.taxels.append((stamp(m), m.force[0]))

    def _on_state(self, m: DriverState) -> None:
        self.state = m


def stamp(message: object) -> float:
    """s."""
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec


def hardware_parts() -> tuple[tuple[str, str], ...]:
    """Name and argument of each."""
    return ("axis", "JointTrajectory"), ("load_cell", "10000"), ("taxels", "")


def stopped(bench: Bench, fault: float) -> tuple[float, str]:
    """Seconds from the fault to rest, and the driver's sentence."""
    bench.wait(lambda: bench.state.state == DriverState.STOPPED)
    bench.wait(lambda: bench.resting(fault) is not None)
    return bench.resting(fault) - fault, bench.state.reason


def killed_commander(trials: int) -> list[tuple[float, str]]:
    """A process streams a sine with half a second of lookahead, and is killed."""
    results = []
    with Bench({}) as bench:
        bench.back()
        for _ in range(trials):
            commander = bench.run([__file__, "--commander"])
            bench.wait(lambda: bench.samples[-1][1] > 2e-4)
            commander.kill()
            results.append(stopped(bench, time.time()))
            bench.back()
    return results


def over_force(trials: int) -> list[tuple[float, str]]:
    """From the first sample above 5 N to the first that is lower in depth."""
    results = []
    with Bench({"max_force": 5.0}) as bench:
        for _ in range(trials):
            start = len(bench.forces)
            bench.go(3e-3, 3.0)
            bench.wait(lambda: bench.state.state == DriverState.STOPPED)
            bench.wait(lambda: bench.samples[-1][1] < -1.99e-3)
            seen = next(t for t, f in bench.forces[start:] if f > 5.0)
            x = dict(bench.samples)
            results.append((next(t for t in sorted(x) if t > seen and x[t] < x[seen]) - seen, bench.state.reason))
            bench.back()
    return results


def killed_part(name: str, trials: int) -> list[tuple[float, str]]:
    """A foreign driver's process is killed while the plunger presses."""
    results = []
    for _ in range(trials):
        with Bench(TOPICS, hardware=True) as bench:
            bench.go(3e-3, 10.0)
            bench.wait(lambda b=bench: b.samples[-1][1] > 2e-4 or b.state.state == DriverState.STOPPED)
            if bench.state.state == DriverState.STOPPED:
                raise SystemExit(f"bench_faults: stopped before the fault, {bench.state.reason}")
            bench.parts[name].kill()
            results.append(to_the_stop(bench, time.time()) if name == "axis" else stopped(bench, time.time()))
    return results


def killed_server(trials: int) -> list[tuple[float, str]]:
    """The profile server is killed in the middle of a sine."""
    sine, results = "{type: sine, amplitude_mm: 0.4, frequency_hz: 0.5, offset_mm: 0.5, periods: 30}", []
    with Bench({}) as bench:
        for _ in range(trials):
            bench.back()
            server = bench.processes.start("skin_motion_profiles", "profile_server")
            client = bench.processes.start("skin_motion_profiles", "execute", [sine])
            bench.wait(lambda: bench.samples[-1][1] > 3e-4)
            server.kill()
            results.append(stopped(bench, time.time()))
            client.kill()
    return results


def refused(trials: int) -> list[tuple[float, str]]:
    """While the plunger moves a command comes that no limit allows: 3 mm in 10 ms."""
    results = []
    with Bench({}) as bench:
        for _ in range(trials):
            bench.press()
            bench.go(3e-3, 0.01)
            results.append(stopped(bench, time.time()))
    return results


def deactivated(trials: int) -> list[tuple[float, str]]:
    """The node is deactivated while the plunger moves. Its samples end when it rests: the time is that of the last one."""
    results = []
    with Bench({}) as bench:
        for _ in range(trials):
            bench.press()
            fault = time.time()
            bench.call(Transition.TRANSITION_DEACTIVATE)
            bench.wait(lambda: bench.state.state == DriverState.INACTIVE)
            (_, x1), (t2, x2) = bench.samples[-2:]
            if abs(x2 - x1) > 2e-6:
                raise SystemExit("bench_faults: the plunger still moved when the driver became inactive")
            bench.call(Transition.TRANSITION_ACTIVATE)
            bench.wait(lambda: bench.state.state == DriverState.STOPPED)
            results.append((t2 - fault, bench.state.reason))
    return results


def killed_taxels(trials: int) -> list[tuple[float, str]]:
    """The taxels' driver is killed while the plunger presses: to the first NaN. The motion goes on."""
    results = []
    for _ in range(trials):
        with Bench(TOPICS, hardware=True) as bench:
            bench.go(3e-3, 20.0)
            bench.wait(lambda b=bench: b.samples[-1][1] > 2e-4 and b.taxels[-1][1] > 0.0)
            bench.parts["taxels"].kill()
            fault = time.time()
            bench.wait(lambda b=bench: math.isnan(b.taxels[-1][1]))
            first = next(t for t, f in bench.taxels if t > fault and math.isnan(f))
            depth = bench.samples[-1][1]
            bench.wait(lambda b=bench, x=depth: b.samples[-1][1] > x + 1e-4)
            results.append((first - fault, "NaN with the status STALE; the plunger went on"))
    return results


def killed_driver(trials: int) -> list[tuple[float, str]]:
    """The driver itself is killed while a foreign axis moves: to the axis's rest, by its own words."""
    results = []
    for _ in range(trials):
        with Bench(TOPICS, hardware=True) as bench:
            bench.go(3e-3, 20.0)
            bench.wait(lambda b=bench: b.samples[-1][1] > 2e-4)
            bench.driver.kill()
            fault = time.time()
            bench.wait_for(1.0)
            moved = [t for (t, x), (_, before) in zip(bench.axis[1:], bench.axis, strict=False) if x != before]
            results.append((max(moved[-1] - fault, 0.0), "the axis stays at the last point it was given"))
    return results


def to_the_stop(bench: Bench, fault: float) -> tuple[float, str]:
    """Seconds from the fault to the driver's stop: nobody tells where the plunger is."""
    bench.wait(lambda: bench.state.state == DriverState.STOPPED)
    return stamp(bench.state) - fault, bench.state.reason


def commander() -> None:
    """Streams x = 0.4 mm (1 - cos), 0.5 Hz, from where the plunger is, until it is killed."""
    rclpy.init()
    node = rclpy.create_node("commander")
    publisher, state = node.create_publisher(JointTrajectory, "command", 10), []
    node.create_subscription(JointState, "encoder", state.append, 10)
    while not state or not publisher.get_subscription_count():
        rclpy.spin_once(node, timeout_sec=0.1)
    base, x0, w = node.get_clock().now(), state[-1].position[0], math.pi
    while True:
        now = (node.get_clock().now() - base).nanoseconds * 1e-9
        message = JointTrajectory(joint_names=["indentation"])
        message.header.stamp = base.to_msg()
        for t in np.arange(max(now - 0.1, 0.0), now + 0.5, 0.02):
            when = Duration(sec=int(t), nanosec=int(1e9 * (t % 1.0)))
            x, v = x0 + 4e-4 * (1.0 - math.cos(w * t)), 4e-4 * w * math.sin(w * t)
            message.points.append(JointTrajectoryPoint(positions=[x], velocities=[v], time_from_start=when))
        publisher.publish(message)
        time.sleep(0.1)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--commander", action="store_true", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.commander:
        return commander()
    n = chosen.trials
    faults = (
        ("commander killed (lookahead 0.5 s)", lambda: killed_commander(n)),
        ("profile server killed in a sine", lambda: killed_server(n)),
        ("over-force, to the first sample back", lambda: over_force(n)),
        ("a command beyond the limits", lambda: refused(n)),
        ("driver deactivated", lambda: deactivated(n)),
        ("load cell's driver killed (stale after 0.5 s)", lambda: killed_part("load_cell", n)),
        ("axis's driver killed, to the stop (0.5 s)", lambda: killed_part("axis", n)),
        ("taxels' driver killed, to NaN (0.5 s)", lambda: killed_taxels(n)),
        ("driver killed, to the foreign axis's rest", lambda: killed_driver(n)),
    )
    print(f"{'fault':46}{'trials':>7}{'stopped':>8}{'median':>9}{'slowest':>9}   ms")
    for name, cause in faults:
        results = cause()
        times = 1e3 * np.array([t for t, _ in results])
        print(f"{name:46}{n:7d}{len(results):8d}{np.median(times):9.0f}{times.max():9.0f}   {results[-1][1]}", flush=True)


if __name__ == "__main__":
    main()
