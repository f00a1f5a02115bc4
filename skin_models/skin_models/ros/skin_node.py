"""The simulated skin: contacts in, taxels out.

drive:=contacts   `contacts` (ContactArray), `wrench` (WrenchStamped) and, where ros_gz_interfaces is installed, `gz_contacts` press on the
                  skin; `rate` times per second it publishes `taxels` and `taxels_truth`.
drive:=encoder    every sample of `encoder` (JointState) moves a plunger at the origin; `taxels`, `taxels_truth` and `force`, as the model
                  predicts them, bear its stamp. So the simulation runs beside a measurement, live or replayed.

A contact has a force (N), a depth (m), or both. NaN is what is not given: a `Contact` with `depth` alone needs `force` set to NaN, because
its default is 0. Where both are given the force presses, and the depth only tells a spread that depends on it how wide to be.

`taxel_layout` is latched; `markers`, `heat_map` and `points` are there to look at. The service `~/load_model` reads the model file again,
and setting the parameter `model` loads another one; the skin is then at rest. Silence: see `contact_input`. Contacts are taken as given in
`skin_frame`; a message that names another frame is reported on /diagnostics.
"""

import math
import threading

from geometry_msgs.msg import WrenchStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import ContactArray
from std_srvs.srv import Trigger

from skin_models.errors import SkinError
from skin_models.live import LiveModel, under_plunger
from skin_models.ros.contact_input import GAZEBO, ContactInput, from_contacts, from_gazebo, from_wrench
from skin_models.ros.node import run
from skin_models.ros.parameters import Parameters
from skin_models.ros.qos import LISTENING, overridable, stream
from skin_models.ros.skin_diagnostics import SkinDiagnostics
from skin_models.ros.skin_settings import SkinSettings
from skin_models.ros.taxel_output import TaxelOutput
from skin_models.ros.ticking import Ticking
from skin_models.ros.viewing import Viewing
from skin_models.simulated_skin import SimulatedSkin
from skin_models.spread.noted import THESIS_WIDTH
from skin_models.words import counted

try:
    from ros_gz_interfaces.msg import Contacts as GazeboContacts
except ImportError:
    GazeboContacts = None


JOINT = "indentation"


class SkinNode(Node):
    """One patch of simulated skin."""

    def __init__(self) -> None:
        """Load the model, start to publish. Raises `SkinError` for parameters or files that cannot be used."""
        super().__init__("skin_node")
        self._loaded = threading.Lock()  # a model is exchanged between two samples, never within one
        self._input = ContactInput()
        self._settings = Parameters(self, SkinSettings, on_change=self._change)
        settings = self._settings.now
        self._encoder = settings.drive == "encoder"
        force_frame = settings.force_frame if self._encoder else ""
        self._output = TaxelOutput(self, settings.rate, settings.skin_frame, force_frame)
        self._viewing: Viewing | None = None
        self._build(settings)
        self._diagnostics = SkinDiagnostics(self)
        self._listen()
        self._ticking = None if self._encoder else Ticking(self._tick, settings.rate, self.get_clock())
        self.create_timer(1.0, self._diagnose, clock=Clock(clock_type=ClockType.STEADY_TIME))  # also while /clock stands still
        if settings.view_rate:
            self._viewing = Viewing(self, self._layout, settings.skin_frame)
            self.create_timer(1.0 / settings.view_rate, self._view)
        self.create_service(Trigger, "~/load_model", self._reload)
        if self._ticking:
            self._ticking.start()
        self.get_logger().info(f"ready: {self._about}")

    # ---- model ----------------------------------------------------------------------------------------------

    def _build(self, settings: SkinSettings) -> None:
        """Make everything that depends on the model, then exchange it at once."""
        model = settings.make_model()
        layout = settings.make_layout(model)
        kernel = settings.make_kernel(model)
        if self._encoder:
            skin, state = LiveModel(under_plunger(model, layout, kernel, settings.plunger_radius), settings.random_seed), None
        else:
            skin = SimulatedSkin(model, layout, 1.0 / settings.rate, kernel, fast=True)
            state = skin.initial(settings.random_seed)
        with self._loaded:
            self._skin, self._state, self._layout, self._reading = skin, state, layout, None
        effects = ", ".join(f"{e.cause} in {e.where}" for e in model.effects) or "no effects"
        if "spread_width" not in model.notes and not settings.spread_width and len(layout) > 1:
            said = f"{model.name} does not say how wide it spreads a force"
            self.get_logger().warning(f"{said}: taken as {1e3 * THESIS_WIDTH:g} mm, that of 4 mm silicone (parameter spread_width)")
        if model.dispersion.k2 < 0.0 and not self._encoder:
            self.get_logger().warning(f"{model.name} disperses a negative force (k2 < 0): taxels feel no more than presses all the same")
        self._about = f"{model.name} ({effects}), {counted(len(layout), 'taxel')}, driven by {settings.drive}"
        self._output.layout(layout, self.get_clock().now().to_msg())
        if self._viewing:
            self._viewing.show(layout)

    def _change(self, settings: SkinSettings) -> None:
        if settings.model != self._settings.now.model:
            self._build(settings)

    def _reload(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            self._build(self._settings.now)
            response.success, response.message = True, f"loaded {self._about}"
        except SkinError as error:
            response.success, response.message = False, f"kept the model that was loaded before: {error}"
        return response

    # ---- contacts -------------------------------------------------------------------------------------------

    def _listen(self) -> None:
        def subscribe(kind: type, topic: str, callback, qos: QoSProfile = LISTENING) -> None:
            self.create_subscription(kind, topic, callback, qos, qos_overriding_options=overridable())

        if self._encoder:  # reliable: a sample that is lost would be missing from the comparison with the measurement
            subscribe(JointState, "encoder", self._sample, stream(1000.0))
            return
        subscribe(ContactArray, "contacts", self._contacts)
        subscribe(WrenchStamped, "wrench", self._wrench)
        if GazeboContacts is not None:
            subscribe(GazeboContacts, "gz_contacts", lambda m: self._input.take(GAZEBO, from_gazebo(m), self._now()))

    def _contacts(self, message: ContactArray) -> None:
        self._diagnostics.frame(message.header.frame_id, self._settings.now.skin_frame)
        self._input.take("contacts", from_contacts(message), self._now())

    def _wrench(self, message: WrenchStamped) -> None:
        self._diagnostics.frame(message.header.frame_id, self._settings.now.skin_frame)
        self._input.take("wrench", from_wrench(message, self._settings.now.plunger_radius), self._now())

    def _now(self) -> float:
        return self.get_clock().now().nanoseconds * 1e-9

    # ---- samples --------------------------------------------------------------------------------------------

    def _tick(self) -> None:
        """One sample of a skin that contacts press on."""
        settings, now = self._settings.now, self.get_clock().now()
        presses, stale = self._input.at(now.nanoseconds * 1e-9, settings.contact_timeout, settings.contact_decay)
        with self._loaded:
            self._state, self._reading = self._skin.step(self._state, presses)
            reading = self._reading
        self._output.sample(now.to_msg(), reading.taxels, reading.truth, stale)
        self._diagnostics.sample(reading.outside, stale)

    def _sample(self, message: JointState) -> None:
        """One sample of a skin that a plunger presses on."""
        stamp, (depth, speed) = message.header.stamp, indentation(message)
        with self._loaded:
            reading = self._skin.step(stamp.sec + 1e-9 * stamp.nanosec, depth, speed)
            self._reading = reading or self._reading
        if reading is not None:
            self._output.force(stamp, reading.force)
            self._output.sample(stamp, reading.taxels, reading.taxels_truth)

    # ---- the rest -------------------------------------------------------------------------------------------

    def _view(self) -> None:
        with self._loaded:
            reading, layout = self._reading, self._layout
        if reading is not None and len(reading.taxels) == len(layout):
            self._viewing.publish(self.get_clock().now().to_msg(), reading.taxels, self._settings.now.view_force)

    def _diagnose(self) -> None:
        skin = self._skin
        if self._encoder:
            self._diagnostics.encoder(self._about, skin.refused, skin.restarts)
        else:
            self._diagnostics.contacts(self._about, self._ticking.report(), self._settings.now.rate, self._input)

    def destroy_node(self) -> None:
        """End the sampling thread first."""
        if getattr(self, "_ticking", None):
            self._ticking.end()
        super().destroy_node()


def indentation(message: JointState) -> tuple[float, float]:
    """Depth (m) and speed (m/s) of the joint `indentation`, or of the only joint; NaN for what is not there."""
    if JOINT not in message.name and len(message.position) > 1:
        return math.nan, math.nan
    i = message.name.index(JOINT) if JOINT in message.name else 0
    return tuple(values[i] if i < len(values) else math.nan for values in (message.position, message.velocity))


def main() -> None:
    """Run the node."""
    run(SkinNode, settings=SkinSettings)
