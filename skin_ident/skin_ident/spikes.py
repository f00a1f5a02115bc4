"""Spikes: up to three samples that jump away and back in one channel, unlike what the plunger and the other channels do.

A fast touch looks the same in a row by itself: at 100 Hz, 10 mm/s for 40 ms are four samples of b x' = 16 N between zeros. But it is in
every channel that feels the skin, in proportion, and in the depth. So what stands off in a row is held against both:

    by another channel o     its own excess there, times how much the row moves with o elsewhere
    by the depth x           the excess of max(0, k x + b x') of a plain skin, k and b by a robust fit to the row (N/m, N s/m)

It is a spike where neither tells at least a third of it, nor is told by a third of that. Channels that agree while the plunger rests (a
discharge hits all cables) are no skin, and a row beside which none can tell is a skin's only where the plunger moves: what depth and speed
vary by about a place bounds what a skin can do there. A lone row without a depth has nothing beside it, and its jumps are spikes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.scale import normal_scale, white_noise
from skin_ident.recordings.recording import Recording
from skin_ident.stretches import without

SPIKE = 12.0  # times the usual second difference (robust) and
SPIKE_RANGE = 0.03  # of the channel's range
WIDEST = 4  # samples of one spike: three, and one more where it was resampled
FASTER = 5.0  # times the greatest speed beside jumps, which no stage reaches in one
OFTEN = 0.2  # of the samples: a channel that bends more often jumps all the time
MOST = 0.02  # of the samples that spikes may hold: a channel of more is not what it would be without
WAY = 4  # samples to either side that must keep to the line from which a spike stands off
LATE = 2  # samples by which channels may come after each other, or after the depth
AGREE = 1 / 3  # of an excess, that another channel or the depth must tell: static and dynamic shares of skins differ by up to 1.8
CLEAR = 4.0  # noise widths by which a witness must see what it is asked for
RELATED = 0.5  # of what a row varies by, that may be left by another that can deny a touch
AT_REST = 2.0  # noise widths of what depth and speed vary by while the plunger rests: ten samples range over three
WITNESSES = 4  # taxels that are asked about another channel
FELT = 0.02  # of the largest force: below, plunger and skin do not touch
FEWEST = 20  # samples in contact for the depth to say what force goes with it
ROUNDS = 20  # of reweighting
HUBER = 1.345  # noise widths, from which a residual counts by its size alone


def spikes_of(r: Recording) -> dict[str, np.ndarray]:
    """Which samples (N,) of `depth`, `force`, `taxel_0`, … belong to a spike.

    The depth comes first: bridged, it is what the channels are held against.
    """
    rows = r.channels
    found = {name: jumps(y) for name, y in rows.items()}
    asked = witnesses(rows)
    depth = {} if r.depth is None else {"depth": _of_depth(r, found, asked)}
    x = None if r.depth is None else bridged(r.t, r.depth, depth["depth"])

    def alone(name: str) -> np.ndarray:
        if not found[name].any():
            return found[name]
        others = [_Other.of(rows[name], rows[o]) for o in asked if o != name]
        skin = None if x is None else Skin.of(r.t, x, rows[name])
        left = without(found[name], lambda a, b: _is_skin(rows[name], a, b, others, skin))
        return left if np.count_nonzero(left) <= MOST * left.size else np.zeros_like(left)

    return depth | {name: alone(name) for name in rows}


def bridged(t: np.ndarray, y: np.ndarray, spike: np.ndarray) -> np.ndarray:
    """The row (N,) with straight lines over its spikes."""
    return np.interp(t, t[~spike], y[~spike]) if spike.any() else y


def _of_depth(r: Recording, found: Mapping[str, np.ndarray], asked: Sequence[str]) -> np.ndarray:
    """Spikes of the encoder: jumps beside which no channel jumps (`found`, (N,) each), nor follows as a skin would. What hits all cables
    hits the encoder's, too: faster than the stage ever moves else, a jump is motion only where every channel has as much of it as of depth.
    """
    own = jumps(r.depth)
    if not own.any():
        return own
    rows = [r.channels[name] for name in asked]
    skins = [(y, skin) for y in rows if (skin := Skin.of(r.t, r.depth, y)) is not None]
    steady = ~(own[1:] | own[:-1])
    fastest = float(np.max(np.abs(np.diff(r.depth))[steady], initial=0.0))  # m per sample
    by_depth = [(y, _Other.of(y, r.depth)) for y in rows]

    def followed(a: int, b: int) -> bool:
        if abs(_excess(r.depth, a, b)) > FASTER * fastest * min(b - a, WIDEST):
            return all(_tells(y, a, b, r.depth, o.slope, o.noise) for y, o in by_depth)
        beside = any(found[name][max(0, a - LATE) : b + LATE].any() for name in asked)
        return beside or any(_tells(skin.force, a, b, y, 1.0, white_noise(y)) for y, skin in skins)

    left = without(own, followed)
    return left if np.count_nonzero(left) <= MOST * left.size else np.zeros_like(left)


def _is_skin(y: np.ndarray, a: int, b: int, others: "list[_Other]", skin: "Skin | None") -> bool:
    """Whether the samples a..b of y (b exclusive) are what the plunger does to the skin."""
    if skin is not None and _tells(y, a, b, skin.force, 1.0, skin.noise):
        return True
    excess = abs(_excess(y, a, b))
    if skin is not None and skin.reach(a, b) < AGREE * excess:
        return False
    agreed = any(_tells(y, a, b, o.row, o.slope, o.noise) for o in others)
    return agreed or (skin is not None and not any(o.can_deny(excess) for o in others))


def _tells(y: np.ndarray, a: int, b: int, other: np.ndarray, slope: float, noise: float) -> bool:
    """Whether `other` times `slope` has the excess of y at a..b, to a factor of 1 / AGREE, some samples earlier or later.

    `noise` is the standard deviation of `other`; what hides in it tells nothing.
    """
    excess = _excess(y, a, b)
    if excess == 0.0 or not _clear(excess, slope, noise):
        return False
    shifts = [d for d in range(-LATE, LATE + 1) if a + d >= 1 and b + d < y.size]
    return any(AGREE <= slope * _excess(other, a + d, b + d) / excess <= 1.0 / AGREE for d in shifts)


def _clear(excess: float, slope: float, noise: float) -> bool:
    """Whether a third of an excess would be seen by a channel of this noise, of which the row is `slope` times."""
    return AGREE * abs(excess) > CLEAR * abs(slope) * noise


def _excess(y: np.ndarray, a: int, b: int) -> float:
    """Mean by which the samples a..b stand off the straight line through their neighbours a - 1 and b."""
    along = (np.arange(a, b) - (a - 1)) / (b - a + 1)
    return float(np.mean(y[a:b] - y[a - 1] - (y[b] - y[a - 1]) * along))


@dataclass(frozen=True)
class _Other:
    """Another channel (N,), its noise, how much the row in question moves with it, and whether the row does so throughout."""

    row: np.ndarray
    noise: float
    slope: float = 0.0
    related: bool = False

    @classmethod
    def of(cls, y: np.ndarray, row: np.ndarray) -> "_Other":
        """`slope` is the median ratio of what y and row are off their medians, weighted by the latter: spikes of neither move it."""
        noise = white_noise(row)
        by, off = row - np.median(row), y - np.median(y)
        clear = np.abs(by) > CLEAR * noise
        if not clear.any():
            return cls(row, noise)
        by, off = by[clear], off[clear]
        size, ratios = np.abs(by), off / by
        order = np.argsort(ratios)
        weight = np.cumsum(np.minimum(size, np.percentile(size, 99))[order])
        slope = float(ratios[order][np.searchsorted(weight, 0.5 * weight[-1])])
        return cls(row, noise, slope, bool(np.median(np.abs(off - slope * by)) < RELATED * np.median(np.abs(off))))

    def can_deny(self, excess: float) -> bool:
        """Whether it would show an excess of the row, were that the skin's."""
        return self.related and _clear(excess, self.slope, self.noise)


@dataclass(frozen=True)
class Skin:
    """What a plain skin does to a row under a depth (N,): `force` (N,) = max(0, k x + b x') in contact, and its noise.

    `bounds` are k |x| and b |dx / dt| (2, N) by which a force can vary, the speeds between samples, and `rest` what noise adds to them.
    """

    force: np.ndarray
    noise: float
    bounds: np.ndarray
    rest: float

    @classmethod
    def of(cls, t: np.ndarray, depth: np.ndarray, y: np.ndarray) -> "Skin | None":
        """k and b by least squares that weigh far residuals down, over samples in contact; None where these are too few."""
        speed = np.gradient(depth, t)
        felt = (depth > 0.0) & (y > FELT * np.percentile(y, 99.5))
        if np.count_nonzero(felt) < FEWEST or np.ptp(depth[felt]) == 0.0:
            return None
        k, b = _robust(np.array([depth, speed])[:, felt].T, y[felt])
        pull, bounds = k * depth + b * speed, np.abs([[k], [b]]) * [depth, np.append(np.diff(depth) / np.diff(t), 0.0)]
        return cls(np.maximum(pull, 0.0) * (depth > 0.0), white_noise(pull), bounds, AT_REST * sum(map(white_noise, bounds)))

    def reach(self, a: int, b: int) -> float:
        """N by which a force can vary about a..b: what depth and speed do there, and the whole speed, for contact may begin or end."""
        depth, speed = self.bounds[:, max(0, a - WAY) : b + WAY]
        return max(float(np.ptp(depth) + max(0.0, speed.max()) - min(0.0, speed.min())) - self.rest, 0.0)


def _robust(columns: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Coefficients of y over columns (n, p) and a constant, by Huber's weights (Ann. Math. Stat. 35, 1964); without the constant."""
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0.0] = 1.0
    all_of_it = np.column_stack([columns / scale, np.full(y.size, y.size**-0.5)])
    weight = np.ones(y.size)
    for _ in range(ROUNDS):
        found = np.linalg.lstsq(all_of_it * weight[:, None], y * weight, rcond=None)[0]
        left = np.abs(y - all_of_it @ found)
        weight = np.sqrt(np.minimum(1.0, HUBER * normal_scale(left) / np.maximum(left, 1e-300)))
    return found[:-1] / scale


def witnesses(rows: Mapping[str, np.ndarray]) -> list[str]:
    """Channels that have a say about others: the force, and the taxels of the widest range, spikes left aside."""
    ranges = {name: float(np.subtract(*np.percentile(y, [99.5, 0.5]))) for name, y in rows.items() if name != "force"}
    return [name for name in rows if name == "force"] + sorted(ranges, key=lambda name: -ranges[name])[:WITNESSES]


def jumps(y: np.ndarray) -> np.ndarray:
    """Which samples (N,) jump from the straight line between the good samples around them, as spikes and fast touches do."""
    bend = np.abs(np.diff(y, 2))
    usual = normal_scale(bend)
    limit = max(SPIKE * max(usual, step_between(y)), SPIKE_RANGE * float(np.subtract(*np.percentile(y, [99.5, 0.5]))))
    out = np.zeros(y.size, bool)
    suspects = np.flatnonzero(bend > limit) + 1
    for i in suspects if suspects.size <= OFTEN * y.size else ():
        _mark(y, int(i), limit / 2, out)
    return out


def _mark(y: np.ndarray, i: int, limit: float, out: np.ndarray) -> None:
    """Mark the shortest run that contains i and stands off the line through its neighbours, which themselves keep to it.

    The second half tells a spike from a corner, such as the loss of contact makes.
    """
    for width in range(1, WIDEST + 1):
        for start in range(i - width + 1, i + 1):
            before, after = start - 1, start + width
            if before < 1 or after > y.size - 2:
                continue
            near = np.arange(max(0, before - WAY), min(y.size, after + WAY + 1))
            off = np.abs(y[near] - y[before] - (y[after] - y[before]) * (near - before) / (after - before))
            inside = (near >= start) & (near < after)
            if off[inside].min() > max(limit, 2.0 * off[~inside].max()):
                out[start:after] = True
                return


def step_between(y: np.ndarray) -> float:
    """The smallest step between neighbours: that of the converter, where there is one."""
    steps = np.abs(np.diff(y))
    steps = steps[steps > 0.0]
    return float(np.percentile(steps, 5)) if steps.size else 0.0
