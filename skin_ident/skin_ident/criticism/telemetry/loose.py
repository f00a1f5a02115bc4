"""A loose contact: a channel jumps from following the load to a constant reading, and back, while the load does not jump.

Such a jump is as large as the reading itself within a sample, and the silent reading is the same each time. A drop-out of a few samples is
an outlier (see `excursions`); a frozen reading begins without a jump. Skin that a plunger left behind and meets again jumps, too, but
always up and while the depth grows: where only the depth is known of the load, such jumps do not count.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from skin_ident.criticism.telemetry.tails import reach, smallest_step
from skin_ident.stretches import runs

IDLE = 0.05  # share of the greatest load up to which a channel reads its zero
LOADED = 0.2  # share of the greatest load below which an open contact loses nothing
FALLS = 0.6  # share of the expected reading by which it must jump
CALM = 0.2  # share of the load by which it may itself change near the jump
NEAR = 3  # samples to either side of the jump
LASTS_S, LASTS = 0.1, 12  # s and samples for which the reading must stay
OFF = 0.3  # share of the expected reading by which the silent one must differ from it: a kick of noise comes back to the expected reading
SAME = 0.1  # share of the expected reading within which the silent one must stay
WIDE = 5.0  # standard deviations of the silent reading that still count as it
FEWEST = 4  # jumps that make a loose contact
WAYS = 2  # least number of them down, and up


@dataclass(frozen=True)
class Contact:
    """Where the channel is silent, masks (N,) of each session; its reading then, N; and the number of jumps that show it."""

    lost: list[np.ndarray]
    level: float
    jumps: int


def contact_of(rows: list[np.ndarray], loads: list[np.ndarray], dt: float, by_depth: bool = False, step: float = 0.0) -> Contact | None:
    """The loose contact of a channel with these readings (N,) under these loads (N,), one each for every session; None where it has none.

    `by_depth`: the loads are depths, which say nothing about skin that the plunger has left behind. The converter's `step` is estimated
    from the readings where it is 0.
    """
    zero = _zero(rows, loads)
    rows = [y - zero for y in rows]
    slope, least = _slope(rows, loads), LOADED * max(float(load.max()) for load in loads)
    if slope * least < reach(np.concatenate([np.diff(y) for y in rows]), step or smallest_step(np.concatenate(rows))):
        return None
    size = max(LASTS, round(LASTS_S / dt))
    jumps = [_jumps(y, load, slope, least, by_depth) for y, load in zip(rows, loads, strict=True)]
    silent = [_silent_side(y, at, size) for y, at in zip(rows, jumps, strict=True)]
    readings = [float(np.median(y[a:b])) for y, sides in zip(rows, silent, strict=True) for a, b, _ in sides]
    if len(readings) < FEWEST:
        return None
    level = float(np.median(readings))
    wide = SAME * slope * least

    def silent_at(y: np.ndarray, load: np.ndarray, a: int, b: int) -> bool:
        ought = slope * float(np.median(load[a:b]))
        return bool(np.all(np.abs(y[a:b] - level) < wide) and abs(level - ought) > OFF * ought)

    near_it = [[s for s in sides if silent_at(y, load, *s[:2])] for y, load, sides in zip(rows, loads, silent, strict=True)]
    kept = [[(a, b) for a, b, _ in sides] for sides in near_it]
    ways = [down for sides in near_it for _, _, down in sides]
    if len(ways) < FEWEST or min(sum(ways), len(ways) - sum(ways)) < WAYS:
        return None
    seen = np.concatenate([y[a:b] for y, sides in zip(rows, kept, strict=True) for a, b in sides])
    near = min(WIDE * float(np.std(seen)) + 1e-9, wide)
    lost = [
        _lost(y, slope * load, level, near, size) | _grown(y, sides, level, wide) for y, load, sides in zip(rows, loads, kept, strict=True)
    ]
    return Contact(lost, level + zero, len(ways))


def _zero(rows: list[np.ndarray], loads: list[np.ndarray]) -> float:
    """What the channel reads without a load, N; 0 where it is always loaded."""
    y, load = np.concatenate(rows), np.concatenate(loads)
    idle = load < IDLE * load.max()
    return float(np.median(y[idle])) if idle.any() else 0.0


def _slope(rows: list[np.ndarray], loads: list[np.ndarray]) -> float:
    """Reading per load while the channel follows: the upper quartile of their ratio under load, as the channel may be silent most of the
    time."""
    y, load = np.concatenate(rows), np.concatenate(loads)
    pressed = load > 0.5 * load.max()
    return float(np.percentile(y[pressed] / load[pressed], 75.0)) if pressed.any() else 0.0


def _jumps(y: np.ndarray, load: np.ndarray, slope: float, least: float, by_depth: bool) -> np.ndarray:
    """Samples (the first after the jump) where the reading jumps by about the expected reading while the load stays."""
    calm = maximum_filter1d(load, 2 * NEAR + 1) - minimum_filter1d(load, 2 * NEAR + 1) < CALM * load
    d = np.diff(y, prepend=y[0])
    k = np.arange(y.size)
    rises = load[np.minimum(k + NEAR, y.size - 1)] > load[np.maximum(k - NEAR, 0)]
    met = (d > 0.0) & rises & by_depth
    return np.flatnonzero((load > least) & calm & (np.abs(d) > FALLS * slope * load) & ~met)


def _silent_side(y: np.ndarray, jumps: np.ndarray, size: int) -> list[tuple[int, int, bool]]:
    """Begin and end of the `size` samples after each jump down and before each jump up, and whether it is down."""
    sides = [(int(k), int(k) + size, True) if y[k] < y[k - 1] else (int(k) - size, int(k), False) for k in jumps]
    return [side for side in sides if side[0] >= 0 and side[1] <= y.size]


def _grown(y: np.ndarray, sides: list[tuple[int, int]], level: float, wide: float) -> np.ndarray:
    """Mask of the stretches at the level that contain one of these sides."""
    at = np.abs(y - level) < wide
    out = np.zeros(y.size, bool)
    for a, b in sides:
        before, after = np.flatnonzero(~at[:a]), np.flatnonzero(~at[b:])
        out[before[-1] + 1 if before.size else 0 : b + after[0] if after.size else y.size] = True
    return out


def _lost(y: np.ndarray, ought: np.ndarray, level: float, near: float, size: int) -> np.ndarray:
    """Mask of the other stretches within `near` of the level that last `size` samples, and are either constant or ought to read more."""
    out = np.zeros(y.size, bool)
    for a, b in zip(*runs(np.abs(y - level) <= near), strict=True):
        out[a:b] = b - a >= size and bool(np.ptp(y[a:b]) == 0.0 or np.max(ought[a:b]) > abs(level) + 3.0 * near)
    return out
