"""Spikes: up to three samples that jump away and back in one channel, unlike what the plunger and the other channels do.

In a single channel (row) a fast touch looks the same: at 100 Hz, 10 mm/s for 40 ms are four samples of b x' = 16 N between zeros. But a
touch is in every channel that feels the skin, in proportion, and in the depth. The excess of a jump is its mean deviation from the straight
line through the samples around it. It is compared with two predictions:

    from another channel o   the excess of o there, times the row's slope over o elsewhere
    from the depth x         the excess of max(0, k x + b x') of a plain skin, k and b by a robust fit to the row (N/m, N s/m)

The jump is a spike unless one of them agrees with its excess to a factor of three. Two more rules:

-   Depth and speed about a jump bound what a skin can do there. A jump of more than three times that is a spike even if channels agree, as
    for a discharge that hits all cables while the plunger rests.
-   Otherwise, a jump is the skin's where no other channel is related and precise enough to deny it.

A single channel without a depth has nothing to be compared with: all its jumps are spikes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.scale import normal_scale, white_noise
from skin_ident.recordings.recording import Recording
from skin_ident.stretches import without

SPIKE = 12.0  # a jump's second difference exceeds this many robust standard deviations (or converter steps), and
SPIKE_RANGE = 0.03  # this share of the channel's range
WIDEST = 4  # most samples of one spike: three, and one more where it was resampled
FASTER = 5.0  # a jump of depth faster than this many times the greatest speed elsewhere cannot be motion of the stage
OFTEN = 0.2  # share of suspect samples above which a channel is taken to jump all the time, and has no spikes
MOST = 0.02  # share of samples in spikes above which they are no spikes but part of the signal
WAY = 4  # samples to either side that must stay close to the line from which a spike deviates
LATE = 2  # samples by which channels may lag behind each other, or behind the depth
AGREE = 1 / 3  # least ratio of two excesses that agree; not nearer to 1, as static and dynamic shares of skins differ by up to 1.8
CLEAR = 4.0  # standard deviations of its noise by which another channel must be able to see a third of the excess
RELATED = 0.5  # a channel can deny a touch only if it predicts the row to this share of the row's own deviation
AT_REST = 2.0  # standard deviations of depth's and speed's noise taken off what they vary by: ten samples at rest range over three
WITNESSES = 4  # most taxels that are compared with a channel
FELT = 0.02  # of the largest force; below, plunger and skin are not in contact
FEWEST = 20  # samples in contact that are needed to predict the force from the depth
ROUNDS = 20  # of iterative reweighting
HUBER = 1.345  # standard deviations beyond which a residual is downweighted (Huber)


def spikes_of(r: Recording) -> dict[str, np.ndarray]:
    """Masks (N,) of the samples that belong to a spike, for `depth`, `force`, `taxel_0`, …

    The depth comes first, because channels are compared with the depth after its spikes are bridged.
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
    """The row (N,) with straight lines across its spikes."""
    return np.interp(t, t[~spike], y[~spike]) if spike.any() else y


def _of_depth(r: Recording, found: Mapping[str, np.ndarray], asked: Sequence[str]) -> np.ndarray:
    """A mask (N,) of the encoder's spikes: jumps at which no channel jumps (`found`, (N,) each) or follows as a skin would.

    A discharge hits the encoder's cable together with all others. So a jump that is faster than the stage moves elsewhere is motion only
    where every channel follows it in proportion to the depth.
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
    """Whether the jump in samples a..b of y (b exclusive) is a touch of the skin and no spike."""
    if skin is not None and _tells(y, a, b, skin.force, 1.0, skin.noise):
        return True
    excess = abs(_excess(y, a, b))
    if skin is not None and skin.reach(a, b) < AGREE * excess:
        return False
    agreed = any(_tells(y, a, b, o.row, o.slope, o.noise) for o in others)
    return agreed or (skin is not None and not any(o.can_deny(excess) for o in others))


def _tells(y: np.ndarray, a: int, b: int, other: np.ndarray, slope: float, noise: float) -> bool:
    """Whether `other` times `slope` has the excess of y at a..b, to a factor of 1 / AGREE, at most LATE samples earlier or later.

    `noise` is the standard deviation of `other`; False where it would hide the excess.
    """
    excess = _excess(y, a, b)
    if excess == 0.0 or not _clear(excess, slope, noise):
        return False
    shifts = [d for d in range(-LATE, LATE + 1) if a + d >= 1 and b + d < y.size]
    return any(AGREE <= slope * _excess(other, a + d, b + d) / excess <= 1.0 / AGREE for d in shifts)


def _clear(excess: float, slope: float, noise: float) -> bool:
    """Whether a third of an excess of the row would stand out of the noise of another channel, if the row is `slope` times that channel."""
    return AGREE * abs(excess) > CLEAR * abs(slope) * noise


def _excess(y: np.ndarray, a: int, b: int) -> float:
    """Mean deviation of the samples a..b from the straight line through their neighbours a - 1 and b."""
    along = (np.arange(a, b) - (a - 1)) / (b - a + 1)
    return float(np.mean(y[a:b] - y[a - 1] - (y[b] - y[a - 1]) * along))


@dataclass(frozen=True)
class _Other:
    """Another channel (N,), its noise, the slope of the row in question over it, and whether the row follows it throughout."""

    row: np.ndarray
    noise: float
    slope: float = 0.0
    related: bool = False

    @classmethod
    def of(cls, y: np.ndarray, row: np.ndarray) -> "_Other":
        """Compares y with another channel `row`. The slope is the median ratio of their deviations from their medians, weighted by that of
        `row`, so that spikes in either do not change it."""
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
        """Whether this channel would show an excess of the row if the skin had caused it."""
        return self.related and _clear(excess, self.slope, self.noise)


@dataclass(frozen=True)
class Skin:
    """The force of a plain skin under the recorded depth: `force` (N,) = max(0, k x + b x') in contact, and its noise.

    `bounds` (2, N) are |k| x and |b| dx / dt (between samples), by whose variation a force can vary; `rest` is what noise adds to that.
    """

    force: np.ndarray
    noise: float
    bounds: np.ndarray
    rest: float

    @classmethod
    def of(cls, t: np.ndarray, depth: np.ndarray, y: np.ndarray) -> "Skin | None":
        """Fits k and b robustly to y over the samples in contact; None where these are too few, or the depth is constant there."""
        speed = np.gradient(depth, t)
        felt = (depth > 0.0) & (y > FELT * np.percentile(y, 99.5))
        if np.count_nonzero(felt) < FEWEST or np.ptp(depth[felt]) == 0.0:
            return None
        k, b = _robust(np.array([depth, speed])[:, felt].T, y[felt])
        pull, bounds = k * depth + b * speed, np.abs([[k], [b]]) * [depth, np.append(np.diff(depth) / np.diff(t), 0.0)]
        return cls(np.maximum(pull, 0.0) * (depth > 0.0), white_noise(pull), bounds, AT_REST * sum(map(white_noise, bounds)))

    def reach(self, a: int, b: int) -> float:
        """The most, N, by which a skin's force can vary about a..b: by the range of depth there, and by the whole speed, since contact may
        begin or end; less what noise adds."""
        depth, speed = self.bounds[:, max(0, a - WAY) : b + WAY]
        return max(float(np.ptp(depth) + max(0.0, speed.max()) - min(0.0, speed.min())) - self.rest, 0.0)


def _robust(columns: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Coefficients (p,) of y over columns (n, p), fitted with a constant and Huber's weights (Ann. Math. Stat. 35, 1964)."""
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
    """Channels with which others are compared: the force, and the taxels of the widest range (spikes not counted)."""
    ranges = {name: float(np.subtract(*np.percentile(y, [99.5, 0.5]))) for name, y in rows.items() if name != "force"}
    return [name for name in rows if name == "force"] + sorted(ranges, key=lambda name: -ranges[name])[:WITNESSES]


def jumps(y: np.ndarray) -> np.ndarray:
    """A mask (N,) of samples that jump away from the straight line between the samples around them, as spikes and fast touches do."""
    bend = np.abs(np.diff(y, 2))
    usual = normal_scale(bend)
    limit = max(SPIKE * max(usual, step_between(y)), SPIKE_RANGE * float(np.subtract(*np.percentile(y, [99.5, 0.5]))))
    out = np.zeros(y.size, bool)
    suspects = np.flatnonzero(bend > limit) + 1
    for i in suspects if suspects.size <= OFTEN * y.size else ():
        _mark(y, int(i), limit / 2, out)
    return out


def _mark(y: np.ndarray, i: int, limit: float, out: np.ndarray) -> None:
    """Mark in `out` the shortest run that contains i and deviates from the line through its neighbours, while samples around it do not.

    The second condition tells a spike from a corner, such as the loss of contact makes.
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
    """The smallest usual step between neighbouring samples (5th percentile), which is the converter's step where there is one."""
    steps = np.abs(np.diff(y))
    steps = steps[steps > 0.0]
    return float(np.percentile(steps, 5)) if steps.size else 0.0
