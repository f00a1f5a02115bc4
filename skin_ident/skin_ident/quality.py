"""Telemetry before any model: what the channels of a session look like, and which of their samples cannot be believed.

Spikes (up to three samples that jump away and back) are bridged. A channel that holds one value while the others say it should move is
frozen or saturated, and those samples are ruled out. Sizes that only a wrong unit gives, and a plunger that hardly moves, are said.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.estimators.scale import normal_scale
from skin_ident.recordings.recording import Recording
from skin_models.words import counted

SPIKE = 12.0  # times the usual second difference (robust) and
SPIKE_RANGE = 0.03  # of the channel's range
WIDEST = 4  # samples of one spike: three, and one more where it was resampled
FROZEN = 8  # samples at one value before it is asked whether the channel should have moved
MOVED = 0.05  # of a channel's range: what it should have moved by
WITNESSES = 4  # taxels that are asked whether another channel should have moved
WAY = 4  # samples to either side that must keep to the line from which a spike stands off
JUMP = 2.0  # times the largest usual step: how a frozen encoder catches up
SOFT, HARD = 30.0, 1e6  # N/m, stiffness of a skin under a plunger: outside, a unit is suspected
FAR_TOO_MUCH = 30.0  # times the applied force: no taxel feels that
MOST, LEAST = 1.5, 0.01  # of the applied force, felt by all taxels together and by the strongest
FAR_TOO_LITTLE = 0.002  # of the applied force: so little the strongest feels only in another unit
SHALLOW = 20e-6  # m: depth that varies by less says little


@dataclass(frozen=True)
class Quality:
    """rate (Hz), depth range (m), speed (m/s rms), time in contact (share), spikes and frozen samples by channel, apparent delays (s).

    `delays` are those of each taxel behind the load cell: a skin's own relaxation is part of them.
    """

    rate: float
    depth_range: float
    speed: float
    contact: float
    spikes: dict[str, int]
    frozen: dict[str, int]
    delays: dict[str, float]
    warnings: tuple[str, ...]
    impossible: str = ""  # what no skin can do: a unit must be wrong

    def as_dict(self) -> dict[str, object]:
        """What was found, with units in the names."""
        return {
            "rate_hz": self.rate,
            "depth_range_mm": 1e3 * self.depth_range,
            "speed_rms_mm_per_s": 1e3 * self.speed,
            "in_contact": self.contact,
            "spikes": {name: n for name, n in self.spikes.items() if n},
            "frozen": {name: n for name, n in self.frozen.items() if n},
            "apparent_delay_ms": {name: 1e3 * delay for name, delay in self.delays.items()},
        }


def inspected(r: Recording) -> tuple[Recording, np.ndarray, Quality]:
    """The recording with its spikes bridged, which samples (N,) may be believed, and what was found."""
    mended, spikes = _without_spikes(r)
    good, frozen = _believable(mended)
    depth = mended.depth
    q = Quality(
        rate=1.0 / r.dt,
        depth_range=0.0 if depth is None else float(np.ptp(depth)),
        speed=0.0 if depth is None else float(np.sqrt(np.mean(np.square(np.gradient(depth, r.dt))))),
        contact=float("nan") if depth is None else float(np.mean(depth > 0.0)),
        spikes=spikes,
        frozen=frozen,
        delays={f"taxel_{i}": apparent_delay(mended.force, y, r.dt) for i, y in enumerate(mended.taxels)} if r.force is not None else {},
        warnings=(*_counts(spikes, frozen), *_sizes(mended)),
        impossible=impossible(mended) or far_too_little(mended),
    )
    return mended, good, q


def _rows(r: Recording) -> dict[str, np.ndarray]:
    return ({} if r.depth is None else {"depth": r.depth}) | r.channels


def _counts(spikes: dict[str, int], frozen: dict[str, int]) -> list[str]:
    return [f"{name}: {counted(n, 'spike')} bridged" for name, n in spikes.items() if n] + [
        f"{name}: {counted(n, 'sample')} frozen or saturated, left out" for name, n in frozen.items() if n
    ]


def _without_spikes(r: Recording) -> tuple[Recording, dict[str, int]]:
    found = {name: spikes(y) for name, y in _rows(r).items()}
    hit = {name: flags for name, flags in found.items() if flags.any()}
    if not hit:
        return r, dict.fromkeys(found, 0)

    def mended(name: str, y: np.ndarray | None) -> np.ndarray | None:
        return y if name not in hit else np.interp(r.t, r.t[~hit[name]], y[~hit[name]])

    taxels = np.array([mended(f"taxel_{i}", y) for i, y in enumerate(r.taxels)])
    clean = replace(r, depth=mended("depth", r.depth), force=mended("force", r.force), taxels=taxels)
    return clean, {name: int(flags.sum()) for name, flags in found.items()}


def spikes(y: np.ndarray) -> np.ndarray:
    """Which samples (N,) belong to a spike: they jump from the straight line between the good samples around them."""
    bend = np.abs(np.diff(y, 2))
    usual = normal_scale(bend)
    step = _step(y)
    limit = max(SPIKE * max(usual, step), SPIKE_RANGE * float(np.subtract(*np.percentile(y, [99.5, 0.5]))))
    out = np.zeros(y.size, bool)
    suspects = np.flatnonzero(bend > limit) + 1
    for i in suspects if suspects.size <= 0.05 * y.size else ():  # a channel that jumps all the time has no spikes
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


def _step(y: np.ndarray) -> float:
    """The smallest step between neighbours: that of the converter, where there is one."""
    steps = np.abs(np.diff(y))
    steps = steps[steps > 0.0]
    return float(np.percentile(steps, 5)) if steps.size else 0.0


def _believable(r: Recording) -> tuple[np.ndarray, dict[str, int]]:
    rows = _rows(r)
    asked = _asked(r)
    good, counts = np.ones(len(r), bool), {}
    for name, y in rows.items():
        others = [rows[n] for n in asked if n != name]
        frozen = _frozen(y, others, holds=name == "depth")
        counts[name] = int(frozen.sum())
        good &= ~frozen
    return good, counts


def _asked(r: Recording) -> list[str]:
    """Channels that have a say about others: depth, force, and of the taxels those with the widest range."""
    strongest = np.argsort(-np.ptp(r.taxels, axis=1))[:WITNESSES] if len(r.taxels) else []
    names = [*(["depth"] if r.depth is not None else []), *(["force"] if r.force is not None else [])]
    return names + [f"taxel_{i}" for i in sorted(int(i) for i in strongest)]


def _frozen(y: np.ndarray, others: list[np.ndarray], holds: bool) -> np.ndarray:
    """Samples in runs of one value during which every other channel that moves says that this one should have moved.

    A depth may be held while forces relax (`holds`): it counts as frozen only where it jumps afterwards.
    """
    out = np.zeros(y.size, bool)
    steps = np.abs(np.diff(y))
    edges = np.flatnonzero(steps)
    starts, stops = np.concatenate([[0], edges + 1]), np.concatenate([edges + 1, [y.size]])
    long = stops - starts >= FROZEN
    spread = float(np.ptp(y))
    related = [(o, s) for o in others if (s := _slope(y, o)) is not None]
    if not long.any() or spread == 0.0 or not related:
        return out
    least = MOVED * spread + 2.0 * _step(y)
    jump = JUMP * float(np.percentile(steps[edges], 95))
    for start, stop in zip(starts[long], stops[long], strict=True):
        leaps = stop < y.size and steps[stop - 1] > jump
        # a channel that stands still as well has no say: the taxels of one message freeze together
        if (leaps or not holds) and _agree(related, start, stop, least):
            out[start:stop] = True
    return out


def _agree(related: list[tuple[np.ndarray, float]], start: int, stop: int, least: float) -> bool:
    """Whether one or more of the others moved, and each that did by as much as should have moved this one by `least`."""
    moved = False
    for other, slope in related:
        part = other[start:stop]
        by = abs(slope) * float(part.max() - part.min())
        if 0.0 < by <= least:
            return False
        moved = moved or by > least
    return moved


def _slope(y: np.ndarray, other: np.ndarray) -> float | None:
    """How much y moves with another channel; None where they are hardly related."""
    a, b = y - y.mean(), other - other.mean()
    norm = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b / (b @ b)) if norm > 0.0 and a @ b > 0.7 * norm else None


def _sizes(r: Recording) -> list[str]:
    notes = []
    if r.depth is None:
        return notes
    if np.ptp(r.depth) < SHALLOW:
        notes.append(f"the depth varies by {1e6 * np.ptp(r.depth):.3g} um only: too little to identify a skin, or its unit is wrong")
    thickness = r.declared.skin_thickness_mm
    if thickness and r.depth.max() > 1e-3 * thickness:
        notes.append(f"the depth reaches {1e3 * r.depth.max():.3g} mm, but the skin is declared to be {thickness:g} mm thick")
    for name, y in r.channels.items():
        if name.startswith("taxel") and r.taxel_units[int(name[6:])] != "N":
            continue
        with np.errstate(all="ignore"):  # a row may vary by so little that its square is nothing
            falls = np.ptp(y) > 0.0 and np.ptp(r.depth) > 0.0 and np.corrcoef(y, r.depth)[0, 1] < -0.5
        if falls:
            notes.append(f"{name} falls when the skin is pressed: check its sign (compression is positive)")
    return notes + _proportions(r)


def impossible(r: Recording, asked: Sequence[int] | None = None) -> str:
    """What no skin can do, so that a unit must be wrong, in a sentence without the recording's name; empty where there is nothing of it.

    `asked` are the taxels that are to be compared; left out, all in newtons. What follows neither depth nor force proves nothing.
    """
    return _more_than_applied(r, _in_newtons(r) if asked is None else asked) or _as_no_skin(r)


def far_too_little(r: Recording, asked: Sequence[int] | None = None) -> str:
    """The same for taxels that feel hardly anything of the force: their unit may be wrong, or the plunger far away from all of them."""
    if r.depth is None or r.force is None:
        return ""
    applied = _slope(r.force, r.depth)
    felt = max((_slope(r.taxels[i], r.depth) or 0.0 for i in (_in_newtons(r) if asked is None else asked)), default=0.0)
    if applied is None or not 0.0 < felt < FAR_TOO_LITTLE * applied:
        return ""
    share = f"{100 * felt / applied:.2g} % of the applied force"
    return f"the strongest taxel feels {share}: its unit is wrong, or the plunger is nowhere near a taxel"


def _in_newtons(r: Recording) -> list[int]:
    return [i for i, unit in enumerate(r.taxel_units) if unit == "N"]


def _more_than_applied(r: Recording, asked: Sequence[int]) -> str:
    """A taxel that feels far more than what presses; without a load cell, more than any skin that is pressed so deep."""
    against = r.depth if r.force is None else r.force
    if against is None or not asked:
        return ""
    slopes = {i: _slope(r.taxels[i], against) or 0.0 for i in asked}
    i, slope = max(slopes.items(), key=lambda entry: entry[1])
    if slope <= (HARD if r.force is None else FAR_TOO_MUCH):
        return ""
    if r.force is None:
        return f"taxel_{i} changes by {slope:.3g} N per m of depth, which no skin does: check its unit and calibration"
    return (
        f"taxel_{i} changes by {slope:.3g} N per newton of applied force, and no taxel feels more than is applied: check the units (is "
        "the force in N, not in mN?), the calibrations, and which column is which"
    )


def _as_no_skin(r: Recording) -> str:
    applied = None if r.depth is None or r.force is None else _slope(r.force, r.depth)
    if applied is None or SOFT <= applied <= HARD:
        return ""
    return f"force changes by {applied:.3g} N per m of depth, which no skin does: check the units of depth and force"


def _proportions(r: Recording) -> list[str]:
    """Taxels that feel far more, or far less, than what is applied."""
    felt = [s for y, unit in zip(r.taxels, r.taxel_units, strict=True) if unit == "N" and (s := _slope(y, r.depth)) is not None]
    applied = None if r.force is None else _slope(r.force, r.depth)
    if not felt or not applied:
        return []
    if MOST * applied < sum(felt) <= FAR_TOO_MUCH * applied:
        return [f"the taxels together feel {sum(felt) / applied:.3g} times the applied force: check the units and calibrations"]
    if max(felt) < LEAST * applied:
        return [
            f"the strongest taxel feels {100 * max(felt) / applied:.2g} % of the applied force: check its unit, or where the plunger is"
        ]
    return []


def apparent_delay(u: np.ndarray, y: np.ndarray, dt: float) -> float:
    """Seconds by which y comes after u: the slope of the phase between them, weighted by their common power."""
    window = np.hanning(u.size)
    a, b = np.fft.rfft((u - u.mean()) * window), np.fft.rfft((y - y.mean()) * window)
    cross = b * np.conj(a)
    omega = 2 * np.pi * np.fft.rfftfreq(u.size, dt)
    weight = np.abs(cross)
    near = weight > 1e-3 * weight.max()
    if not near.any():
        return 0.0
    w, o = weight[near], omega[near]
    return float(-np.sum(w * o * np.angle(cross[near])) / max(np.sum(w * o**2), 1e-300))
