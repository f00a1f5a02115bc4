"""The ident node: live estimates of the dispersion model on `estimates`, and the action `identify` over recordings.

Subscribes to encoder, force and taxels; publishes `estimates` (ParameterEstimates) and `/diagnostics` (rate, jitter, losses, excitation).
`~/reset` forgets what was learnt, `~/save` writes it as a model file that the skin node loads (parameter `model_path`).
"""

import threading
import time
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.task import Future
from rclpy.time import Time
from sensor_msgs.msg import JointState
from skin_testbed_msgs.action import Identify
from skin_testbed_msgs.msg import ParameterEstimates, TaxelArray
from std_srvs.srv import Trigger

from skin_ident.estimators.live import LiveFit
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.decode import JOINT
from skin_ident.recordings.mass import USUAL_MM, known_mass
from skin_ident.ros import live_messages
from skin_ident.ros.identify import Run
from skin_models.errors import SkinError
from skin_models.model_file import save_model
from skin_models.ros.node import run
from skin_models.ros.parameters import Parameters, setting

Result = Identify.Result
_FAREWELL = 3.0  # s, for running goals to notice that the node ends
_LAST_WORD = 0.2  # s, for their results to leave


@dataclass(frozen=True)
class Settings:
    """Parameters of the node."""

    window: float = setting(30.0, "s, memory of the live estimate: older samples count for less than 1/e", lower=0.1, upper=1e5)
    cutoff: float = setting(5.0, "Hz, common low-pass of depth and forces before estimation", lower=0.05, upper=1e3)
    mass: float = setting(
        known_mass(Declared()).kg,
        f"kg, moving mass, held fixed in the live estimate; the default is that of `fit`: silicone {USUAL_MM:g} mm thick (thesis 4.3.1). "
        "rig.yaml is not read here: what it declares goes into this parameter",
        lower=0.0,
        upper=100.0,
    )
    publish_period: float = setting(0.5, "s, between two estimates", lower=0.02, upper=60.0, fixed=True)
    joint: str = setting(JOINT, "name of the joint in `encoder` that is the indentation depth")
    model_path: str = setting("identified_model.yaml", "file that `~/save` writes")


learning = attrgetter("window", "cutoff", "mass", "joint")  # the settings whose change starts the estimate anew


class IdentNode(Node):
    """Callbacks stay short; identification over recordings runs in a thread of its own, one goal after the other."""

    def __init__(self) -> None:
        super().__init__("ident_node")
        self.settings = Parameters(self, Settings)
        self._start_anew()
        self.add_post_set_parameters_callback(lambda parameters: self._on_change())  # after, for others may refuse a change
        self._subscribe()
        self.estimates = self.create_publisher(ParameterEstimates, "estimates", QoSProfile(depth=10))
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", QoSProfile(depth=10))
        self.create_timer(self.settings.now.publish_period, self._report)
        self.create_service(Trigger, "~/reset", self._on_reset)
        self.create_service(Trigger, "~/save", self._on_save)
        self.leaving = threading.Event()
        self.working = threading.Lock()
        self.workers: list[threading.Thread] = []
        self.goals = 0  # that have no result yet
        self.action = ActionServer(self, Identify, "identify", self._identify, cancel_callback=lambda handle: CancelResponse.ACCEPT)
        self.get_logger().info("ready: estimating live, and waiting for goals on identify")

    def _start_anew(self) -> None:
        now = self.settings.now
        self.learnt_under = learning(now)
        self.fit = LiveFit(now.window, now.cutoff, now.mass)

    def _on_change(self) -> None:
        """Forget what was learnt where it was learnt under other settings."""
        if learning(self.settings.now) != self.learnt_under:
            self._start_anew()

    def _subscribe(self) -> None:
        policies = QoSOverridingOptions.with_default_policies()
        pairs = (
            (JointState, "encoder", self._on_encoder),
            (WrenchStamped, "force", self._on_force),
            (TaxelArray, "taxels", self._on_taxels),
        )
        for kind, topic, callback in pairs:
            self.create_subscription(kind, topic, callback, qos_profile_sensor_data, qos_overriding_options=policies)

    def _on_encoder(self, message: JointState) -> None:
        position = dict(zip(message.name, message.position, strict=False)).get(self.settings.now.joint)
        if position is not None:  # a message may name joints and hold no positions
            self.fit.offer("encoder", _ns(message), np.array([position]))

    def _on_force(self, message: WrenchStamped) -> None:
        self.fit.offer("force", _ns(message), np.array([-message.wrench.force.z]))

    def _on_taxels(self, message: TaxelArray) -> None:
        self.fit.offer("taxels", _ns(message), np.array(message.force))

    def _report(self) -> None:
        self.fit.update()
        stamp = Time(nanoseconds=self.fit.newest).to_msg()
        self.estimates.publish(live_messages.estimates(self.fit, stamp))
        self.diagnostics.publish(live_messages.diagnostics(self.fit, self.get_clock().now().to_msg(), self.get_fully_qualified_name()))

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._start_anew()
        response.success, response.message = True, "what was learnt is forgotten"
        return response

    def _on_save(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        path = self.settings.now.model_path
        try:
            save_model(live_messages.model(self.fit), path, live_messages.std(self.fit))
            response.success, response.message = True, f"wrote {path}"
        except (SkinError, OSError) as error:
            response.success, response.message = False, f"nothing was written: {error}"
        return response

    async def _identify(self, handle: ServerGoalHandle) -> Result:
        self.goals += 1
        result = await self._in_thread(handle)
        if result.error_code == Result.SUCCESS:
            handle.succeed()
        elif handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        self.get_logger().info(f"identify ended: {result.error_string or 'success'}")
        self.goals -= 1
        return result

    def _in_thread(self, handle: ServerGoalHandle) -> Future:
        job, future = Run(handle.request, lambda: handle.is_cancel_requested or self.leaving.is_set(), handle.publish_feedback), Future()

        def work() -> None:
            try:
                future.set_result(job.after(self.working))
            except BaseException as error:  # a goal must end whatever happens
                future.set_exception(error)
            if self.executor is not None:
                self.executor.wake()  # nothing else resumes the waiting coroutine while the topics are silent

        worker = threading.Thread(target=work, name="identify", daemon=True)
        self.workers = [w for w in self.workers if w.is_alive()] + [worker]
        worker.start()
        return future

    def destroy_node(self) -> None:
        """Cancel all goals before the node goes, and let their clients hear of it, though the loop of the node has ended."""
        self.leaving.set()
        end = time.monotonic() + _FAREWELL
        told = end if self.goals else time.monotonic()
        while time.monotonic() < told and self.executor is not None:
            self.executor.spin_once(timeout_sec=0.02)
            if not self.goals:
                told = min(told, time.monotonic() + _LAST_WORD)
        for worker in self.workers:
            worker.join(0.1)
        super().destroy_node()


def _ns(message: JointState | WrenchStamped | TaxelArray) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def main() -> None:
    """Entry point."""
    run(IdentNode, settings=Settings)


if __name__ == "__main__":
    main()
