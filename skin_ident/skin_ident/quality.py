"""Telemetry before any model: what the channels of a session look like, and which of their samples cannot be trusted.

Spikes (`skin_ident.spikes`) are bridged, except in recordings that keep them. A channel that holds one value while the others say that it
should move is frozen or saturated, and those samples are excluded. Sizes that only a wrong unit can give, and a plunger that hardly moves,
are reported.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.recordings.recording import Recording
from skin_ident.spikes import bridged, spikes_of, step_between, witnesses
from skin_ident.stretches import runs
from skin_models.words import counted

FROZEN = 8  # fewest samples at one value for which a channel is tested for being frozen
MOVED = 0.05  # share of its range by which a frozen channel should have moved
NAMED = 3  # spikes of a channel whose times a warning gives
COARSE = 0.01  # s between samples from which two decimals tell times apart
JUMP = 2.0  # a frozen encoder catches up by a jump of more than this many times the 95th percentile of its steps
SOFT, HARD = 30.0, 1e6  # N/m, range of plausible stiffness of a skin under a plunger; outside, a unit is suspected
FAR_TOO_MUCH = 30.0  # times the applied force, which no taxel feels
MOST_FELT, LEAST_FELT = 1.5, 0.01  # of the applied force: the most for all taxels together, the least for the strongest, without a warning
FAR_TOO_LITTLE = 0.002  # of the applied force: if the strongest taxel feels less, its unit is suspected
SHALLOW = 20e-6  # m: smallest variation of the depth without a warning


@dataclass(frozen=True)
class Quality:
    """rate (Hz), depth range (m), speed (m/s rms), share of time in contact; by channel the times at which spikes begin (s, as recorded),
    the number of frozen samples, and the apparent delay (s).

    `delays` are those of each taxel behind the load cell; the skin's own relaxation contributes to them.
    """

    rate: float
    depth_range: float
    speed: float
    contact: float
    spikes: dict[str, tuple[float, ...]]
    frozen: dict[str, int]
    delays: dict[str, float]
    warnings: tuple[str, ...]
    impossible: str = ""  # what no skin can do: a unit must be wrong

    def as_dict(self) -> dict[str, object]:
        """The quality as a dictionary, with units in the names."""
        return {
            "rate_hz": self.rate,
            "depth_range_mm": 1e3 * self.depth_range,
            "speed_rms_mm_per_s": 1e3 * self.speed,
            "in_contact": self.contact,
            "spikes": {name: len(at) for name, at in self.spikes.items() if at},
            "spikes_at_s": {name: list(at) for name, at in self.spikes.items() if at},
            "frozen": {name: n for name, n in self.frozen.items() if n},
            "apparent_delay_ms": {name: 1e3 * delay for name, delay in self.delays.items()},
        }


def inspected(r: Recording) -> tuple[Recording, np.ndarray, Quality]:
    """The recording with its spikes bridged, a mask (N,) of the samples to trust, and what was found."""
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
        warnings=(*_counts(spikes, frozen, r.dt), *_sizes(mended)),
        impossible=impossible(mended) or far_too_little(mended),
    )
    return mended, good, q


def _rows(r: Recording) -> dict[str, np.ndarray]:
    return ({} if r.depth is None else {"depth": r.depth}) | r.channels


def _counts(spikes: dict[str, tuple[float, ...]], frozen: dict[str, int], dt: float) -> list[str]:
    return [f"{name}: {counted(len(at), 'spike')} interpolated (at {_when(at, dt)} s)" for name, at in spikes.items() if at] + [
        f"{name}: {counted(n, 'sample')} frozen or saturated, left out" for name, n in frozen.items() if n
    ]


def _when(at: Sequence[float], dt: float) -> str:
    """The first of these times in words, with enough decimals for samples `dt` s apart: `1.15, 4.20 and 7.31`, or `1.15, 4.20, 7.31, …`."""
    said = [f"{seconds:.{2 if dt >= COARSE else 3}f}" for seconds in at[:NAMED]]
    if len(at) > NAMED:
        return ", ".join([*said, "…"])
    return " and ".join([", ".join(said[:-1]), said[-1]]) if len(said) > 1 else said[0]


def _without_spikes(r: Recording) -> tuple[Recording, dict[str, tuple[float, ...]]]:
    """The recording with its spikes bridged, and the times (s) at which they begin, by channel; unchanged where it keeps its spikes."""
    rows = _rows(r)
    found = {} if r.keeps_spikes else spikes_of(r)
    hit = {name: bridged(r.t, rows[name], spike) for name, spike in found.items() if spike.any()}
    at = {name: tuple(float(s) for s in r.t[runs(found[name])[0]]) if name in hit else () for name in rows}
    if not hit:
        return r, at
    taxels = np.array([hit.get(f"taxel_{i}", y) for i, y in enumerate(r.taxels)])
    return replace(r, depth=hit.get("depth", r.depth), force=hit.get("force", r.force), taxels=taxels), at


def _believable(r: Recording) -> tuple[np.ndarray, dict[str, int]]:
    """A mask (N,) of the samples at which no channel is frozen, and the number of frozen samples by channel."""
    rows = _rows(r)
    asked = [name for name in rows if name == "depth"] + witnesses(r.channels)
    good, counts = np.ones(len(r), bool), {}
    for name, y in rows.items():
        others = [rows[n] for n in asked if n != name]
        frozen = _frozen(y, others, holds=name == "depth")
        counts[name] = int(frozen.sum())
        good &= ~frozen
    return good, counts


def _frozen(y: np.ndarray, others: list[np.ndarray], holds: bool) -> np.ndarray:
    """A mask (N,) of frozen samples: runs of one value during which every other channel that moves says that this one should have moved.

    A depth (`holds`) may be held still while forces relax, so it counts as frozen only where it jumps afterwards.
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
    least = MOVED * spread + 2.0 * step_between(y)
    jump = JUMP * float(np.percentile(steps[edges], 95))
    for start, stop in zip(starts[long], stops[long], strict=True):
        leaps = stop < y.size and steps[stop - 1] > jump
        # a channel that stands still as well does not count: the taxels of one message freeze together
        if (leaps or not holds) and _agree(related, start, stop, least):
            out[start:stop] = True
    return out


def _agree(related: list[tuple[np.ndarray, float]], start: int, stop: int, least: float) -> bool:
    """Whether at least one other channel moved, and every one that did moved so far that this one should have moved by `least`."""
    moved = False
    for other, slope in related:
        part = other[start:stop]
        by = abs(slope) * float(part.max() - part.min())
        if 0.0 < by <= least:
            return False
        moved = moved or by > least
    return moved


def _slope(y: np.ndarray, other: np.ndarray) -> float | None:
    """The slope of y over another channel; None where their correlation is not above 0.7."""
    a, b = y - y.mean(), other - other.mean()
    norm = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b / (b @ b)) if norm > 0.0 and a @ b > 0.7 * norm else None


def _sizes(r: Recording) -> list[str]:
    """Warnings about sizes and signs that suggest a wrong unit or swapped wires."""
    notes = []
    if r.depth is None:
        return notes
    if np.ptp(r.depth) < SHALLOW:
        notes.append(f"the depth varies by {1e6 * np.ptp(r.depth):.3g} µm only: too little to identify a skin, or its unit is wrong")
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
    """A sentence (without the recording's name) about what no skin can do, so that a unit must be wrong; empty where there is nothing.

    `asked` are the taxels to be checked, by default all in newtons. A channel that follows neither depth nor force proves nothing.
    """
    return _more_than_applied(r, _in_newtons(r) if asked is None else asked) or _as_no_skin(r)


def far_too_little(r: Recording, asked: Sequence[int] | None = None) -> str:
    """The same for taxels that feel hardly any of the force: their unit may be wrong, or the plunger is far from all of them."""
    felt = most_felt(r, asked)
    if not 0.0 < felt < FAR_TOO_LITTLE:
        return ""
    return f"the strongest taxel feels {100 * felt:.2g} % of the applied force: its unit is wrong, or the plunger is nowhere near a taxel"


def too_little(felt: float) -> str:
    """A warning about a strongest taxel that feels this share of the force, if it is small but not far too small; else empty."""
    if not FAR_TOO_LITTLE <= felt < LEAST_FELT:
        return ""
    doubt = "check the units of taxels and load cell (grams-force are no newtons), or where the plunger is"
    return f"the strongest taxel feels {100 * felt:.2g} % of the applied force: {doubt}"


def most_felt(r: Recording, asked: Sequence[int] | None = None) -> float:
    """The share of the applied force that the strongest taxel feels, of those `asked` for or all in newtons; 0 where none follows the
    depth, or where depth or force is missing."""
    applied = None if r.depth is None or r.force is None else _slope(r.force, r.depth)
    if not applied:
        return 0.0
    return max((_slope(r.taxels[i], r.depth) or 0.0 for i in (_in_newtons(r) if asked is None else asked)), default=0.0) / applied


def _in_newtons(r: Recording) -> list[int]:
    return [i for i, unit in enumerate(r.taxel_units) if unit == "N"]


def _more_than_applied(r: Recording, asked: Sequence[int]) -> str:
    """A sentence about a taxel that feels far more than the applied force or, without a load cell, is stiffer than any skin; else empty."""
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
    """Warnings about taxels that feel clearly more, or clearly less, than the applied force."""
    applied = None if r.force is None else _slope(r.force, r.depth)
    if not applied:
        return []
    felt = sum(_slope(r.taxels[i], r.depth) or 0.0 for i in _in_newtons(r))
    if MOST_FELT * applied < felt <= FAR_TOO_MUCH * applied:
        return [f"the taxels together feel {felt / applied:.3g} times the applied force: check the units and calibrations"]
    return [said] if (said := too_little(most_felt(r))) else []


def apparent_delay(u: np.ndarray, y: np.ndarray, dt: float) -> float:
    """Delay of y behind u, s: the slope of their cross-spectrum's phase over frequency, weighted by its magnitude."""
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
