"""The skin under the plunger, integrated in small steps on a physical state: the place of its surface."""

from dataclasses import dataclass, field
from math import exp

import numpy as np

MOST_KEPT = 12  # bare pressings, a few MB each
_KEPT: dict = {}


@dataclass
class Laws:
    """What is added to the two plain branches.

    elements: objects with `step(u, du, dt) -> N`, memory or shape, on the depth of the surface.
    rate: function (u, w) -> N of depth and speed, rising with w.
    pull: function (w) -> N >= 0 that the surface holds on to a leaving plunger.
    mount_stiffness: function (stretch m) -> N/m of a spring between encoder and tip.
    """

    elements: list = field(default_factory=list)
    rate: object = None
    pull: object = None
    mount_stiffness: object = None


@dataclass(frozen=True)
class Pressed:
    """Arrays over the fine grid: surface depth u (m), its speed w (m/s), plunger force (N, >= 0 without adhesion), added force (N)."""

    u: np.ndarray
    w: np.ndarray
    force: np.ndarray
    added: np.ndarray
    touching: np.ndarray


def press(x, v, a, dt, skin, laws=None) -> Pressed:
    """Push a plunger along x(t), with speed v and acceleration a, into `skin`.

    In contact the surface goes with the plunger: F = m a + (k1 + k2) u + (b1 + b2) u' + added. Contact ends when F would pull more
    than the surface holds, then the surface comes back by itself, force free, until the plunger meets it again.
    """
    if laws is None or laws == Laws():
        return _press_bare(x, v, a, dt, skin)
    return _press(x, v, a, dt, skin, laws)


def _press_bare(x, v, a, dt, skin):
    """The same without laws, kept: cases of one seed share their path, and the loop over samples is what costs."""
    key = (hash(x.tobytes()), dt, skin.k1, skin.b1, skin.k2, skin.b2, skin.mass)
    if key not in _KEPT:
        while len(_KEPT) >= MOST_KEPT:
            del _KEPT[next(iter(_KEPT))]
        _KEPT[key] = _press(x, v, a, dt, skin, Laws())
        for row in vars(_KEPT[key]).values():
            row.setflags(write=False)
    return _KEPT[key]


def _press(x, v, a, dt, skin, laws):
    run = _press_mounted if laws.mount_stiffness else _press_rigid
    u, w, force, added, touching = (np.asarray(c, float) for c in run(x.tolist(), v.tolist(), dt, skin, laws))
    force = np.where(touching > 0, force + skin.mass * a, 0.0)
    return Pressed(u, w, force, added, touching > 0)


class _Memory:
    """The elements' common force; they are told the surface's place, and hear of every move exactly once."""

    def __init__(self, elements):
        self.steps, self.place, self.force = [e.step for e in elements], 0.0, 0.0

    def tell(self, u, dt):
        if self.steps:
            du, self.place = u - self.place, u
            self.force = sum([s(u, du, dt) for s in self.steps])
        return self.force


def _press_rigid(x, v, dt, skin, laws):
    k, b = skin.stiffness, skin.damping
    memory, rate, pull = _Memory(laws.elements), laws.rate, laws.pull
    touching, u = False, 0.0
    rows = []
    for xi, vi in zip(x, v, strict=True):
        if not touching:
            u, w, added = _recover(u, memory, k, b, dt, rate)
            if xi < u:
                rows.append((u, w, 0.0, added, 0.0))
                continue
        added = memory.tell(xi, dt)
        if rate:
            added += rate(xi, vi)
        force = k * xi + b * vi + added
        if force >= (-pull(vi) if pull and touching else 0.0):
            touching, u = True, xi
            rows.append((xi, vi, force, added, 1.0))
            continue
        if touching:
            u, w, added = _recover(u, memory, k, b, dt, rate)
        touching, u = False, max(u, xi)
        rows.append((u, w, 0.0, added, 0.0))
    return zip(*rows, strict=True)


def _recover(u, memory, k, b, dt, rate):
    """One step of the free surface, b w = -(k u + memory + rate): exact for the plain branches. Gives u, w and the added force."""
    pressing = k * u + memory.force
    if rate:
        w = _free_speed(u, pressing, b, rate)
        new = u + w * dt
    else:
        new = u - pressing / k * (1 - exp(-k * dt / b))
    memory.tell(new, dt)
    w = -(k * new + memory.force) / b if not rate else w
    return new, w, memory.force + (rate(new, w) if rate else 0.0)


def _free_speed(u, pressing, b, rate):
    """w with b w + rate(u, w) + pressing = 0, by bisection: both terms rise with w."""
    low, high = sorted((0.0, -2 * pressing / b))
    for _ in range(30):
        middle = 0.5 * (low + high)
        if b * middle + rate(u, middle) + pressing > 0:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


def _press_mounted(x, v, dt, skin, laws):
    """As above with a spring between encoder and tip: the tip is the state, driven by the spring; exact for a straight path."""
    k, b = skin.stiffness, skin.damping
    memory, rate, spring = _Memory(laws.elements), laws.rate, laws.mount_stiffness
    u, w, last, stretch = 0.0, 0.0, x[0], 0.0
    rows = []
    for xi in x:
        added = memory.force + (rate(u, w) if rate else 0.0)
        stiff = spring(stretch)
        new = _driven(u, last, xi, stiff, added, k, b, dt)
        stretch = xi - new
        if stretch <= 0:  # the spring would pull: the surface goes by itself
            new, stretch = _driven(u, last, xi, 0.0, added, k, b, dt), 0.0
        force = stiff * stretch
        w = (force - k * new - added) / b
        memory.tell(new, dt)
        u, last = new, xi
        rows.append((u, w, force, added, float(force > 0)))
    return zip(*rows, strict=True)


def _driven(u, last, xi, stiff, added, k, b, dt):
    """Surface after one step of b u' = stiff (x - u) - k u - added with x straight from `last` to `xi`."""
    pole = (k + stiff) / b
    gone = 1 - exp(-pole * dt)
    path = last * gone + (xi - last) * (1 - gone / (pole * dt))
    return u + (stiff * path - added * gone) / (b * pole) - u * gone
