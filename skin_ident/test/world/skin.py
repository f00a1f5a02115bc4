"""The skin under the plunger, integrated in small steps on a physical state: the place of its surface."""

from dataclasses import dataclass, field
from math import exp

import numpy as np


@dataclass
class Laws:
    """What is added to the two plain branches.

    elements: objects with `step(u, du, dt) -> N`, memory or shape, on the depth of the surface.
    rate: function (u, w) -> N of depth and speed, rising with w.
    pull: function (w) -> N >= 0 that the surface holds on to a leaving plunger.
    mount: function (stretch m) -> N of a spring between encoder and tip, with its inverse stiffness in `mount_stiffness`.
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
    laws = laws or Laws()
    run = _press_mounted if laws.mount_stiffness else _press_rigid
    u, w, force, added, touching = (np.asarray(c, float) for c in run(x.tolist(), v.tolist(), dt, skin, laws))
    force = np.where(touching > 0, force + skin.mass * a, 0.0)
    return Pressed(u, w, force, added, touching > 0)


def _press_rigid(x, v, dt, skin, laws):
    k, b = skin.stiffness, skin.damping
    steps, rate, pull = [e.step for e in laws.elements], laws.rate, laws.pull
    touching, u, memory = False, 0.0, 0.0
    rows = []
    for xi, vi in zip(x, v, strict=True):
        if touching or xi >= u:
            before, w = u, vi
            added = memory = sum([s(xi, xi - before, dt) for s in steps]) if steps else 0.0
            if rate:
                added += rate(xi, w)
            force = k * xi + b * w + added
            if force >= (-pull(w) if pull and touching else 0.0):
                touching, u = True, xi
                rows.append((u, w, force, added, 1.0))
                continue
            touching = False
        u, w, memory, added = _recover(u, memory, k, b, dt, steps, rate)
        u = max(u, xi) if touching else u
        rows.append((u, w, 0.0, added, 0.0))
    return zip(*rows, strict=True)


def _recover(u, memory, k, b, dt, steps, rate):
    """One step of the free surface: exponential Euler on b w = -(k u + memory), exact for the plain branches."""
    target = -memory / k
    decay = exp(-k * dt / b)
    new = target + (u - target) * decay
    w = -(k * u + memory) / b
    added = memory
    if rate:
        w = _free_speed(u, k * u + memory, b, rate)
        new = u + w * dt
        added += rate(u, w)
    if steps:
        memory = sum([s(new, new - u, dt) for s in steps])
    return new, w, memory, added


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
    steps, rate, spring = [e.step for e in laws.elements], laws.rate, laws.mount_stiffness
    u, w, memory, last = 0.0, 0.0, 0.0, x[0]
    rows = []
    for xi in x:
        stiff = spring(xi - u) if xi > u else 0.0
        added = memory + (rate(u, w) if rate else 0.0)
        pole = (k + stiff) / b
        gone = 1 - exp(-pole * dt)
        path = last * gone + (xi - last) * (1 - gone / (pole * dt))
        new = u + (stiff * path - added * gone) / (b * pole) - u * gone
        w = (stiff * max(xi - new, 0.0) - k * new - added) / b
        memory = sum([s(new, new - u, dt) for s in steps]) if steps else 0.0
        u, last = new, xi
        rows.append((u, w, stiff * max(xi - u, 0.0), added, float(xi > u)))
    return zip(*rows, strict=True)
