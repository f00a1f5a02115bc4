"""What presses on the skin, from messages: our ContactArray, a WrenchStamped, and Contacts of ros_gz_interfaces where that is installed.

Rule for silence: a message holds until `timeout` after it came. Then its contacts are stale: force and depth fall to zero with the time
constant `decay`, and below a thousandth they are gone. An empty ContactArray says that nothing touches, at once. Where the clock is set
back, as by a simulator's reset, what came before counts as having come then.

Rule for force and depth: NaN is what is not given. Where both are given the force presses, also a force of zero, and the depth only tells a
spread that depends on it how wide to be.
"""

import math
from collections import Counter
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from geometry_msgs.msg import WrenchStamped
from skin_testbed_msgs.msg import ContactArray

from skin_models.signals import DEEPEST
from skin_models.simulated_skin import HARDEST, Presses

_GONE = 1e-3
GAZEBO = "gz"  # the source that is Gazebo

# What may be wrong with a contact.
NO_PLACE = "without a finite place"
BAD_RADIUS = "with a radius that is negative or not finite"
NOTHING = "with neither force nor depth"
TOO_HARD = f"with a force beyond {1e-6 * HARDEST:g} MN, the greatest that is accepted"
TOO_DEEP = f"with a depth beyond {1e3 * DEEPEST:g} mm, the greatest that is accepted: depths are in m, are these in mm?"
NO_FORCE = "with a depth and a force of exactly 0, which is what counts: force is NaN where only the depth is known"

Press = tuple[str, tuple[float, float, float], float, float, float]  # key, position m, force N, depth m, radius m


@dataclass(frozen=True)
class _Message:
    """The usable contacts of one message and when it came (s)."""

    presses: Presses
    came: float


class ContactInput:
    """The last message of every source. `unusable` counts the contacts left out, by what is wrong, and `doubtful` those that are kept."""

    def __init__(self) -> None:
        """Nothing was heard yet."""
        self._messages: dict[str, _Message] = {}
        self.unusable: Counter[str] = Counter()
        self.doubtful: Counter[str] = Counter()

    def take(self, source: str, contacts: list[Press], now: float) -> None:
        """Replace what `source` said last."""
        faults = [_fault(c) for c in contacts]
        usable = [c for c, fault in zip(contacts, faults, strict=True) if not fault]
        self.unusable.update(filter(None, faults))
        if source != GAZEBO:  # which has no way to leave a force out
            self.doubtful[NO_FORCE] += sum(force == 0.0 and depth > 0.0 for _, _, force, depth, _ in usable)
        self._messages = {**self._messages, source: _Message(_presses(source, usable), now)}

    def at(self, now: float, timeout: float, decay: float) -> tuple[Presses, bool]:
        """Everything that presses at time `now` (s), and whether some of it is stale."""
        held, stale = [], False
        if any(message.came > now for message in self._messages.values()):
            self._messages = {source: replace(m, came=min(m.came, now)) for source, m in self._messages.items()}
        for message in self._messages.values():
            late = now - message.came - timeout
            factor = math.exp(-late / decay) if late > 0.0 else 1.0
            if message.presses.key and factor > _GONE:
                held.append(message.presses if factor == 1.0 else message.presses.faded(factor))
                stale |= factor < 1.0
        return _joined(held), stale


def _fault(c: Press) -> str:
    """Why a contact cannot be used; empty where it can."""
    _, position, force, depth, radius = c
    faults = (
        (not math.isfinite(sum(position)), NO_PLACE),
        (not math.isfinite(radius) or radius < 0.0, BAD_RADIUS),
        (math.isnan(force) and math.isnan(depth), NOTHING),
        (abs(force) > HARDEST, TOO_HARD),
        (abs(depth) > DEEPEST, TOO_DEEP),
    )
    return next((words for bad, words in faults if bad), "")


def _presses(source: str, contacts: list[Press]) -> Presses:
    """Negative forces and depths do not press: they count as zero."""
    keys = tuple(f"{source}/{name or i}" for i, (name, *_) in enumerate(contacts))
    if len(set(keys)) != len(keys):  # two contacts of one name: tell them apart by their place in the message
        keys = tuple(f"{key}#{i}" for i, key in enumerate(keys))
    table = np.array([(*position, force, depth, radius) for _, position, force, depth, radius in contacts]).reshape(-1, 6)
    return Presses(keys, table[:, :3], np.maximum(table[:, 3], 0.0), np.maximum(table[:, 4], 0.0), table[:, 5])


def _joined(parts: list[Presses]) -> Presses:
    if len(parts) < 2:
        return parts[0] if parts else Presses()
    fields = ([getattr(p, name) for p in parts] for name in ("position", "force", "depth", "radius"))
    return Presses(tuple(key for p in parts for key in p.key), *map(np.concatenate, fields))


def from_contacts(message: ContactArray) -> list[Press]:
    """The contacts of our own message."""
    return [(c.name, (c.position.x, c.position.y, c.position.z), c.force, c.depth, c.radius) for c in message.contacts]


def from_wrench(message: WrenchStamped, radius: float) -> list[Press]:
    """One contact of `radius` (m) from a wrench in the skin's frame: force.z is minus the compression, and the torque tells where.

    A normal force F_z at (x, y, 0) has the torque (y F_z, -x F_z): the contact sits at the centre of pressure. Below 1 mN it sits
    at the origin.
    """
    force, torque = message.wrench.force, message.wrench.torque
    if abs(force.z) < 1e-3:
        return [("", (0.0, 0.0, 0.0), max(-force.z, 0.0), math.nan, radius)]
    return [("", (-torque.y / force.z, torque.x / force.z, 0.0), -force.z, math.nan, radius)]


def from_gazebo(message: Any) -> list[Press]:
    """One contact per contact point of ros_gz_interfaces/Contacts, taken in the frame in which Gazebo gives them.

    The force is the component of the first body's wrench along the point's normal; where no wrench is given the depth counts.
    """
    return [point for contact in message.contacts for point in _gazebo_points(contact)]


def _gazebo_points(contact: Any) -> list[Press]:
    points = []
    name = f"{contact.collision1.name}|{contact.collision2.name}"
    for i, p in enumerate(contact.positions):
        depth = float(contact.depths[i]) if i < len(contact.depths) else math.nan
        force = math.nan
        if i < len(contact.wrenches) and i < len(contact.normals):
            f, n = contact.wrenches[i].body_1_wrench.force, contact.normals[i]
            force = abs(f.x * n.x + f.y * n.y + f.z * n.z)
        points.append((f"{name}|{i}", (p.x, p.y, p.z), force, depth, 0.0))
    return points
