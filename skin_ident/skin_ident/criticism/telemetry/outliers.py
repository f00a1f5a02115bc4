"""Outliers in what was measured: spikes, bursts, drop-outs, and samples frozen while the load goes on.

A force also stands still whenever the plunger does: at a reversal with backlash in the drive, or within a coarse step of a converter. The
simulation may then run ahead of it, because its depth is smoothed. A real frozen run misses a movement from its beginning on, and in one
channel alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.stats import binom, poisson

from skin_ident.criticism.telemetry.as_read import AsRead, as_read
from skin_ident.criticism.telemetry.excursions import OWN_SHARE, excursions, fill_clusters, held
from skin_ident.criticism.telemetry.one_sided import one_sided
from skin_ident.criticism.telemetry.pushed import not_pushed, not_shared
from skin_ident.criticism.telemetry.swallowed import is_swallowed
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.telemetry.tails import HEAVIEST_TAIL, LEAST_LIMIT, TAIL_CHANCE, reach, smallest_step, stands_apart
from skin_ident.criticism.telemetry.unlikely import unlikely_runs
from skin_ident.criticism.telemetry.wrong_samples import Marks, told
from skin_ident.recordings.recording import Recording
from skin_ident.stretches import runs, without

LOWEST = 0.7  # share of the noise's reach, down to which excursions are looked for where there are none beyond it
NEAREST = 0.35  # share of it below which excursions run into each other and cannot be counted for comparison
FEWEST = 2  # frozen runs that make a finding by themselves
DROPPED = 3  # excursions that must end at one reading
BESIDE = 20  # samples to either side of a run that show where it should be
STANDS = 3  # samples at one value, far off: noise of single samples does not do that
UNLIKELY = 1e-3  # chance that so many excursions stand still
FROZEN = 5  # samples at one value, the shortest frozen run
MISSED = 10.0  # converter steps by which a frozen run must be behind when it comes back
SURE = 1 / 3  # share of the frozen runs that must be so beyond doubt
EARLY = 0.25  # share of the whole change that the first half of the run must have missed
SEEN = 0.4  # share of its expected change that another channel must show by the end of the run, if it can
CLEAR = 3.0  # noise widths that its expected change must exceed for it to show
BOUNCING = 0.05  # chance below which it is no coincidence that excursions are at landings


@dataclass(frozen=True)
class Said:
    """What was measured in a session, at full rate: `raw` (C, N), N, and its `residual` (C, N), measured less simulated. `jumps` (N,) marks
    samples where a force may really jump, `path` (N,) m is the encoder's depth. Channels with readings of their own in the `recording` are
    examined at those."""

    name: str
    residual: np.ndarray
    raw: np.ndarray
    jumps: np.ndarray
    path: np.ndarray | None = None
    recording: Recording | None = None


def find_outliers(
    channels: tuple[str, ...], sessions: Sequence[Said], dt: float, steps: Sequence[float] = (), reads: float = 0.0
) -> list[Symptom]:
    """Excursions and frozen runs, one symptom per channel. Sessions without a recording are sampled every `dt` s. `steps` of the
    converters are estimated where they are not given. A run that stands still misses nothing if the encoder, whose resolution `reads` m,
    stands still as well."""
    steps = steps or [0.0] * len(channels)
    residuals, jumps = [s.residual for s in sessions], [s.jumps for s in sessions]
    paths, dts = [s.path for s in sessions if s.path is not None], [s.recording.dt if s.recording else dt for s in sessions]
    n_taxels = sum(channel != "force" for channel in channels)
    lines = [[_line(channel, c, s) for s in sessions] for c, channel in enumerate(channels)]
    read = [_of_channel(own, step) for own, step in zip(lines, steps, strict=True)]
    marks = [m.on_grid(own) for m, own in zip(read, lines, strict=True)]
    bounced = _bounced([m.away for m in marks], jumps)
    found = []
    for c, channel in enumerate(channels):
        away = [a & ~b for a, b in zip(marks[c].away, bounced, strict=True)]
        if is_swallowed([s.raw[c] for s in sessions], [e[c] for e in residuals], away):
            away = [np.zeros_like(a) for a in away]
        away = not_shared(not_pushed(away, [e[c] for e in residuals], paths, dts, reads), c, residuals, paths, dts, reads)
        still = _stands_still(marks, c, sessions, paths, reads)
        found.append(told([s.name for s in sessions], channel, lines[c], read[c], away, still, n_taxels, dts))
    return [s for s in found if s is not None]


def _stands_still(marks: list[Marks], c: int, sessions: Sequence[Said], paths: list[np.ndarray], reads: float) -> list[np.ndarray]:
    """Masks (N,) for every session where channel `c` alone stands still while the plunger moves: frozen runs, if enough of them are so
    beyond doubt, and runs that noise would not make, if there are several."""
    others = [[_startled(s.residual[o]) | m.still[k] for o, m in enumerate(marks) if o != c] for k, s in enumerate(sessions)]
    alone = ([_alone(m, o) for m, o in zip(masks, others, strict=True)] for masks in (marks[c].still, marks[c].unlikely))
    own, lost = (_under_way(masks, paths, reads) for masks in alone)
    sure = sum(_sure(masked, s, c) for masked, s in zip(own, sessions, strict=True))
    if sure < max(FEWEST, SURE * sum(runs(s)[0].size for s in own)):
        own = [np.zeros_like(s) for s in own]
    if sum(runs(m)[0].size for m in lost) >= FEWEST:
        own = [s | m for s, m in zip(own, lost, strict=True)]
    return own


def _line(channel: str, c: int, s: Said) -> AsRead:
    """Row `c` of a session at the channel's own readings."""
    read = () if s.recording is None else (s.recording.t, s.recording.own(channel))
    return as_read(s.residual[c], s.raw[c], s.jumps, *read)


def _of_channel(lines: list[AsRead], step: float) -> Marks:
    """What looks wrong in one channel, at its own readings in every session."""
    e, y, jumps = ([getattr(line, what) for line in lines] for what in ("e", "y", "jumps"))
    step = step or smallest_step(np.concatenate(y))
    limit = reach(np.concatenate([np.diff(row) for row in e]), step)

    def beyond(level: float) -> int:
        return sum(runs(excursions(a, b, level))[0].size for a, b in zip(e, y, strict=True))

    nearest = NEAREST * limit
    level = stands_apart(limit, beyond, step, nearest) or stands_apart(LOWEST * limit, beyond, step, nearest)
    far = [excursions(a, b, level or limit) for a, b in zip(e, y, strict=True)]
    less_far = None if level else _standing(e, y, LOWEST * limit) or one_sided(e, y, limit)
    away = [fill_clusters(f) for f in far] if level else less_far or _to_one_reading(far, y, limit, step)
    values, counts = np.unique(np.concatenate(y), return_counts=True)
    idle = float(values[np.argmax(counts)])
    resting = [j | (np.abs(b - idle) < limit) for b, j in zip(y, jumps, strict=True)]
    still = [_frozen(b, a, limit, step, rest) for a, b, rest in zip(e, y, resting, strict=True)]
    unlikely = [unlikely_runs(b, a, step, rest) for a, b, rest in zip(e, y, resting, strict=True)]
    return Marks(_between_landings(away, jumps), still, unlikely)


def _between_landings(away: list[np.ndarray], jumps: list[np.ndarray]) -> list[np.ndarray]:
    """The excursions, without those at landings if there are more of them than chance would put there: a plunger that lands may bounce."""
    share = float(np.concatenate(jumps).mean())
    at = np.concatenate([j[runs(a)[0]] for a, j in zip(away, jumps, strict=True)])
    if binom.sf(at.sum() - 1, at.size, share) > BOUNCING:
        return away
    return [without(a, lambda b, _, j=j: j[b]) for a, j in zip(away, jumps, strict=True)]


def _bounced(away: list[list[np.ndarray]], jumps: list[np.ndarray]) -> list[np.ndarray]:
    """Masks (N,) of each session where excursions of several channels begin at the same landing: all feel the plunger bounce."""
    together = [np.sum(masks, axis=0) > 1 for masks in zip(*away, strict=True)]
    return [t & ~without(t, lambda a, _, j=j: j[a]) for t, j in zip(together, jumps, strict=True)]


def _standing(e: list[np.ndarray], y: list[np.ndarray], limit: float) -> list[np.ndarray] | None:
    """The excursions beyond `limit` in which the reading stands still; None where these are too few and too short, or may be chance. White
    noise, whatever its tail, is elsewhere at the next sample. Noise that wanders in jumps sometimes comes back by one, and meanwhile
    repeats a reading as often as elsewhere."""
    out, lengths, by_chance = [], [], 0.0
    for rest, row in zip(e, y, strict=True):
        away = [(a, b) for a, b in zip(*runs(excursions(rest, row, limit)), strict=True) if b - a >= STANDS]
        stands = [(a, b) for a, b in away if np.ptp(row[a:b]) == 0.0 and _far_off(rest, a, b, limit)]
        lengths += [b - a for a, b in stands]
        again = _repeats(rest, row) if away else 0.0
        by_chance += sum(again ** (b - a - 1) for a, b in away)
        out.append(np.isin(np.arange(row.size), [i for a, b in stands for i in range(a, b)]))
    enough = len(lengths) >= FEWEST or max(lengths, default=0) > STANDS
    return out if enough and poisson.sf(len(lengths) - 1, by_chance) < UNLIKELY else None


def _repeats(e: np.ndarray, y: np.ndarray) -> float:
    """Chance that a reading that is far off stays so and repeats: zero in white noise."""
    return max(float(np.corrcoef(e[1:], e[:-1])[0, 1]), 0.0) * float(np.mean(np.diff(y) == 0.0))


def _far_off(e: np.ndarray, a: int, b: int, limit: float) -> bool:
    """Whether the samples a..b lie apart from those around them. If not, they are right, and the two samples beside them are spikes."""
    around = np.concatenate([e[max(a - BESIDE, 0) : a], e[b : b + BESIDE]])
    return abs(float(np.median(e[a:b]) - np.median(around))) > 0.5 * limit


def _to_one_reading(far: list[np.ndarray], y: list[np.ndarray], limit: float, step: float) -> list[np.ndarray]:
    """The excursions that end at one and the same reading, as where a line drops out. Beyond `limit` L, in a tail as heavy as noise may
    have to either side, the density at a distance d is at most n / (2 L) (L / d)^(n + 1) per newton, n = `HEAVIEST_TAIL`. So only few of
    many fall into the same step of a converter by chance."""
    begin = [runs(f)[0] for f in far]
    ends, origins = (np.concatenate([b[np.maximum(a - k, 0)] for b, a in zip(y, begin, strict=True)]) for k in (0, 1))
    if ends.size < DROPPED:
        return [np.zeros_like(f) for f in far]
    readings, counts = np.unique(np.round(ends / max(step, 1e-12)), return_counts=True)
    one = readings[np.argmax(counts)] * step
    away = np.abs(one - origins)
    able = away >= OWN_SHARE * limit  # excursions jump at least that far
    at_one = 0.5 * HEAVIEST_TAIL * step / limit * (limit / np.maximum(away[able], limit)) ** (HEAVIEST_TAIL + 1.0)
    by_chance = ends.size * poisson.sf(counts.max() - 1, np.sum(np.minimum(at_one, 1.0)))
    if counts.max() < DROPPED or by_chance > TAIL_CHANCE:
        return [np.zeros_like(f) for f in far]
    return [f & (np.abs(b - one) <= 0.5 * step) for b, f in zip(y, far, strict=True)]


def _startled(e: np.ndarray) -> np.ndarray:
    """Mask (N,) of samples where a residual jumps beyond its noise."""
    d = np.diff(e, prepend=e[0])
    return np.abs(d) > reach(d)


def _alone(still: np.ndarray, others: list[np.ndarray]) -> np.ndarray:
    """The frozen runs that no other channel shares: if several channels stand still, or jump at the end, the plunger or the skin did."""
    return without(still, lambda a, b: any(o[a : b + 2].any() for o in others))


def _sure(still: np.ndarray, s: Said, c: int) -> int:
    """Number of runs of `still`, a mask of channel `c`, that miss a movement from its beginning on and that no other channel
    contradicts."""
    e, y = s.residual, s.raw
    noise = [reach(np.diff(row)) / LEAST_LIMIT for row in e]
    return sum(_from_the_start((y - e)[c, a : b + 1]) and not _denied(e, y, noise, c, a, b) for a, b in zip(*runs(still), strict=True))


def _under_way(masks: list[np.ndarray], paths: Sequence[np.ndarray], reads: float) -> list[np.ndarray]:
    """The runs of each session in which the plunger moves, as far as an encoder shows."""
    return [without(m, partial(_rests, path, reads)) for m, path in zip(masks, paths, strict=True)] if paths else masks


def _rests(path: np.ndarray, reads: float, a: int, b: int) -> bool:
    """Whether the path is the same in both halves of the samples a..b, to within the encoder's resolution `reads`, m."""
    middle = (a + b) // 2
    return abs(float(np.median(path[middle:b]) - np.median(path[a:middle]))) <= reads


def _from_the_start(should: np.ndarray) -> bool:
    """Whether the first half of a run contains its part of the change that the simulation makes over the whole run."""
    middle = 0.5 * (should[(should.size - 1) // 2] + should[should.size // 2])
    return (middle - should[0]) * np.sign(should[-1] - should[0]) >= EARLY * abs(should[-1] - should[0])


def _denied(e: np.ndarray, y: np.ndarray, noise: list[float], c: int, a: int, b: int) -> bool:
    """Whether another channel that ought to have moved within the run a..b stood still as well."""
    expected = np.diff((y - e)[:, [a, b]])[:, 0]
    able = np.abs(expected) > CLEAR * np.array(noise)
    able[c] = False
    return bool(np.any(able & ((y[:, b - 1] - y[:, a]) * np.sign(expected) < SEEN * np.abs(expected))))


def _frozen(y: np.ndarray, e: np.ndarray, limit: float, step: float, resting: np.ndarray) -> np.ndarray:
    """Mask of runs of one value, with no `resting` sample in them, during which the residual runs away, and after which it comes back in
    one jump."""
    mask = np.zeros(y.size, bool)
    least = max(limit, MISSED * step)
    for a, b in zip(*held(y, FROZEN), strict=True):
        jump = abs(y[b] - y[b - 1])
        should = (y[b - 1] - e[b - 1]) - (y[a] - e[a])
        missed = np.ptp(e[a:b]) > 0.5 * jump and should * (y[b] - y[b - 1]) > 0.5 * jump**2
        if jump > least and missed and not resting[a : b + 1].any() and abs(e[b] - e[a]) < 0.5 * jump:
            mask[a:b] = True
    return mask
