"""A driver of a spring, written from the contract alone and run as a process of its own: the profile server is tried against it.

    python fake_driver.py --scale 10 --retracted -0.002

It publishes encoder, force and driver_state, follows command, and breaks in the ways that the topic `break` asks for:
mute_encoder, mute_force, nan_force, stick (the stage no longer follows), block (force rises to 500 N), stop (a safety stop),
no_surface (zero fails), pause_after_zero (no sample for a while after the answer), mend.
"""

import argparse
import contextlib
import signal
import threading
import time

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import WrenchStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import DriverState
from skin_testbed_msgs.srv import Tare, Zero
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectory

STIFFNESS = 12000.0  # N/m
PERIOD = 0.01  # s


class Path:
    """Knots (t, x, v) with cubics between them; a new piece replaces what lies after its first knot."""

    def __init__(self, x: float) -> None:
        self.t, self.x, self.v = np.array([0.0]), np.array([x]), np.array([0.0])

    def replace(self, t, x, v) -> None:
        keep = self.t < t[0] - 1e-9
        self.t, self.x, self.v = (np.concatenate([old[keep], new]) for old, new in zip((self.t, self.x, self.v), (t, x, v), strict=True))

    def at(self, t: float) -> float:
        i = int(np.searchsorted(self.t, t, side="right")) - 1
        if i < 0:
            return float(self.x[0])
        if i + 1 >= self.t.size:
            return float(self.x[-1])
        h = self.t[i + 1] - self.t[i]
        u = (t - self.t[i]) / h
        return float(
            (2 * u**3 - 3 * u**2 + 1) * self.x[i] + (u**3 - 2 * u**2 + u) * h * self.v[i]
            + (3 * u**2 - 2 * u**3) * self.x[i + 1] + (u**3 - u**2) * h * self.v[i + 1]
        )  # fmt: skip

    def runs_dry(self, t: float) -> bool:
        return t > self.t[-1] and abs(self.v[-1]) > 1e-6


class FakeDriver(Node):
    def __init__(self, options: argparse.Namespace) -> None:
        super().__init__("testbed_driver")
        self.silent_until = 0.0
        self.options, self.lock, self.broken = options, threading.Lock(), set()
        self.depth = options.retracted
        self.path = Path(self.depth)
        self.encoder = self.create_publisher(JointState, "encoder", qos_profile_sensor_data)
        self.force = self.create_publisher(WrenchStamped, "force", qos_profile_sensor_data)
        self.clock = self.create_publisher(Clock, "/clock", qos_profile_sensor_data) if options.scale != 1.0 else None
        self.state = self.create_publisher(DriverState, "driver_state", QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
        self.create_subscription(JointTrajectory, "command", self.on_command, 50)
        self.create_subscription(String, "break", self.on_break, 10)
        self.create_service(Zero, "~/zero", self.on_zero)
        self.create_service(Tare, "~/tare", self.on_tare)
        self.begin, self.origin = time.monotonic(), time.time()
        self.announce(DriverState.READY)
        threading.Thread(target=self.tick_forever, daemon=True).start()

    def now(self) -> float:
        return self.origin + (time.monotonic() - self.begin) * self.options.scale

    def announce(self, state: int, reason: str = "") -> None:
        self.stopped = state == DriverState.STOPPED
        self.state.publish(
            DriverState(
                state=state, reason=reason, zeroed=True, sample_rate=1.0 / PERIOD, min_depth=-0.005, max_depth=0.003, max_speed=0.02,
                max_acceleration=0.5, max_force=110.0, retracted_depth=self.options.retracted,
            )
        )  # fmt: skip

    def on_command(self, message: JointTrajectory) -> None:
        base = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
        t = np.array([base + p.time_from_start.sec + p.time_from_start.nanosec * 1e-9 for p in message.points])
        with self.lock:
            self.path.replace(t, np.array([p.positions[0] for p in message.points]), np.array([p.velocities[0] for p in message.points]))

    def on_break(self, message: String) -> None:
        if message.data == "mend":
            self.broken.clear()
            self.path = Path(self.depth)
            self.announce(DriverState.READY)
        elif message.data == "stop":
            self.announce(DriverState.STOPPED, "somebody pressed the button")
        else:
            self.broken.add(message.data)

    def on_zero(self, request: Zero.Request, response: Zero.Response) -> Zero.Response:
        self.depth = 0.0  # the plunger is set down on the surface at once
        self.path = Path(0.0)
        if "pause_after_zero" in self.broken:
            self.silent_until = time.monotonic() + 0.4
        response.success, response.message = "no_surface" not in self.broken, "no contact within 10 mm"
        return response

    def on_tare(self, request: Tare.Request, response: Tare.Response) -> Tare.Response:
        response.success, response.message = self.depth < 0.0, "retract it, then tare"
        return response

    def tick_forever(self) -> None:
        i = 0
        while rclpy.ok():
            i += 1
            time.sleep(max(self.begin + i * PERIOD / self.options.scale - time.monotonic(), 0.0))
            self.tick(self.origin + i * PERIOD)

    def tick(self, now: float) -> None:
        with self.lock:
            if not self.stopped and "stick" not in self.broken:
                self.depth = self.path.at(now)
                if self.path.runs_dry(now):
                    self.announce(DriverState.STOPPED, "the commander fell silent")
        stamp = Time(sec=int(now), nanosec=int((now % 1.0) * 1e9))
        if self.clock is not None:
            self.clock.publish(Clock(clock=stamp))
        if time.monotonic() < self.silent_until:
            return
        if "mute_encoder" not in self.broken:
            message = JointState(name=["indentation"], position=[self.depth], velocity=[0.0])
            message.header.stamp = stamp
            self.encoder.publish(message)
        if "mute_force" not in self.broken:
            message = WrenchStamped()
            message.header.stamp, message.header.frame_id = stamp, "load_cell"
            message.wrench.force.z = -self.spring()
            self.force.publish(message)

    def spring(self) -> float:
        if "nan_force" in self.broken:
            return float("nan")
        return 500.0 if "block" in self.broken else STIFFNESS * max(self.depth, 0.0)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--scale", type=float, default=1.0)
    parser.add_argument("--retracted", type=float, default=-0.002)
    options = parser.parse_args()
    rclpy.init()
    signal.signal(signal.SIGTERM, lambda *_: rclpy.try_shutdown())
    executor, node = SingleThreadedExecutor(), FakeDriver(options)
    executor.add_node(node)
    print("fake driver ready", flush=True)
    while rclpy.ok():
        executor.spin_once(timeout_sec=0.5)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        main()
