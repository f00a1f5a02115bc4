"""Worked example: a MuJoCo scene presses a finger on a patch and publishes the contacts, for the skin node to feel.

    pip install mujoco          (.venv/bin/pip, where `./skin` made a .venv)
    ./skin run skin_models skin_node --ros-args -p layout:=grid -p columns:=9 -p rows:=9 -p pitch:=0.005
    ./skin run skin_models mujoco_finger

MuJoCo knows bodies and contact forces, not skin: it publishes `contacts` with the force of every contact point and its place in the
frame of the patch, and the skin node makes taxels of it. Any simulator that can tell contact forces plugs in the same way.
"""

import math
import sys
from dataclasses import dataclass

import numpy as np
from geometry_msgs.msg import Point
from rclpy.node import Node
from skin_testbed_msgs.msg import Contact, ContactArray

from skin_models.errors import SkinError
from skin_models.ros.node import run
from skin_models.ros.parameters import Parameters, setting
from skin_models.ros.qos import overridable, stream
from skin_models.ros.ticking import Ticking

STEP = 1e-3  # s

SCENE = f"""
<mujoco model="finger on skin">
  <option timestep="{STEP}"/>
  <worldbody>
    <light pos="0 0 0.5"/>
    <body name="patch"><geom name="skin" type="box" size="0.03 0.03 0.002" pos="0 0 -0.002" rgba="0.9 0.7 0.6 1" solref="0.02 1"/></body>
    <body name="finger" pos="0 0 0.02">
      <joint name="x" type="slide" axis="1 0 0" damping="2"/>
      <joint name="y" type="slide" axis="0 1 0" damping="2"/>
      <joint name="z" type="slide" axis="0 0 1" damping="2"/>
      <geom name="tip" type="sphere" size="0.008" mass="0.05"/>
      <geom type="capsule" fromto="0 0 0.008 0 0 0.05" size="0.007" mass="0.05" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <actuator>
    <position joint="x" kp="300" dampratio="1"/>
    <position joint="y" kp="300" dampratio="1"/>
    <motor joint="z"/>
  </actuator>
</mujoco>
"""


@dataclass(frozen=True)
class FingerSettings:
    """Parameters of the example."""

    rate: float = setting(100.0, "Hz of `contacts`", lower=1.0, upper=500.0, fixed=True)
    force: float = setting(4.0, "N, with which the finger presses on average", lower=0.0, upper=50.0)
    circle: float = setting(0.012, "m, radius of the circle that the finger draws", lower=0.0, upper=0.025)
    period: float = setting(4.0, "s per circle", lower=0.5, upper=60.0)
    skin_frame: str = setting("skin", "frame_id of the contacts", fixed=True)


class MujocoFinger(Node):
    """Steps the scene in real time and publishes what touches."""

    def __init__(self) -> None:
        """Raises `SkinError` where MuJoCo is not installed."""
        super().__init__("mujoco_finger")
        self._settings = Parameters(self, FingerSettings)
        self._mujoco = _mujoco()
        self._model = self._mujoco.MjModel.from_xml_string(SCENE)
        self._data = self._mujoco.MjData(self._model)
        rate = self._settings.now.rate
        self._steps = max(round(1.0 / (rate * STEP)), 1)
        self._contacts = self.create_publisher(ContactArray, "contacts", stream(rate), qos_overriding_options=overridable())
        self._ticking = Ticking(self._tick, rate, self.get_clock())
        self._ticking.start()
        self.get_logger().info("ready: a finger draws circles on the skin")

    def _tick(self) -> None:
        for _ in range(self._steps):
            self._aim()
            self._mujoco.mj_step(self._model, self._data)
        message = ContactArray(contacts=self._touching())
        message.header.frame_id = self._settings.now.skin_frame
        message.header.stamp = self.get_clock().now().to_msg()
        self._contacts.publish(message)

    def _aim(self) -> None:
        """Where the finger should be, and how hard it presses: half the force more and less, three times per circle."""
        s, angle = self._settings.now, 2.0 * math.pi * self._data.time / self._settings.now.period
        press = s.force * (1.0 + 0.5 * math.sin(3.0 * angle)) if self._data.time > 0.2 else 0.0
        self._data.ctrl[:] = s.circle * math.cos(angle), s.circle * math.sin(angle), -press

    def _touching(self) -> list[Contact]:
        """The contacts of the skin: place on its surface and normal force."""
        touching, wrench = [], np.zeros(6)
        skin = self._model.geom("skin").id
        for i in range(self._data.ncon):
            contact = self._data.contact[i]
            if skin in (contact.geom1, contact.geom2):
                self._mujoco.mj_contactForce(self._model, self._data, i, wrench)
                x, y, _ = contact.pos.tolist()
                touching.append(Contact(name=f"tip {i}", position=Point(x=x, y=y), force=float(wrench[0]), depth=math.nan))
        return touching

    def destroy_node(self) -> None:
        """End the stepping thread first."""
        if hasattr(self, "_ticking"):
            self._ticking.end()
        super().destroy_node()


def _mujoco():
    try:
        import mujoco
    except ImportError as error:
        raise SkinError(f"this example needs MuJoCo: {sys.executable} -m pip install mujoco") from error
    return mujoco


def main() -> None:
    """Run the example."""
    run(MujocoFinger, settings=FingerSettings)
