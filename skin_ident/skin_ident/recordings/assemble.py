"""From named channels on one clock to a `Recording`: calibration, dead taxels, and checks of signs and sizes."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import compress, count
from typing import Any

import numpy as np

from skin_ident.recordings.declared import Calibration, Declared
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.levels import steps_of
from skin_ident.recordings.readings import Readings
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.rows import all_finite, extremes
from skin_ident.recordings.timing import Track, even, kept
from skin_models.tables.order import Mended
from skin_models.tables.table import check_load, check_span

SLOWEST, LONGEST = 1.0, 1000.0  # s between samples, and in all; where both are exceeded, the unit of time is questioned
FLAT, WIDE = 0.07, 0.15  # a load that varies this little (relative) over this share of the depth's range is not in contact there
UNCALIBRATED = "is in volts and has no calibration"
DEAD = "most of its samples are no numbers"
PROBES = 1000  # samples that are checked for NaN first


@dataclass(frozen=True)
class Channels:
    """Measured rows of one kind (depth, force, taxel) and unit (m, N or V): names and samples (R, N). `dead` are the names of taxels most
    of whose samples were NaN.

    Where the samples were interpolated: `steps` are the converter steps of the readings, 0 where there are none; `digits` (R, N) tell
    readings apart (see `digits`); `read` are the instants (M,) s of the readings, and the readings (R, M).
    """

    kind: str
    names: tuple[str, ...]
    unit: str
    rows: np.ndarray
    steps: tuple[float, ...] | None = None
    digits: np.ndarray | None = None
    read: tuple[np.ndarray, np.ndarray] | None = None
    dead: tuple[str, ...] = ()

    def only(self, keep: Sequence[bool]) -> "Channels":
        """The rows that a mask (rows,) selects, with all their attributes."""
        mine, steps = np.asarray(keep, bool), self.steps and tuple(compress(self.steps, keep))
        digits = None if self.digits is None else self.digits[mine]
        read = self.read and (self.read[0], self.read[1][mine])
        names = tuple(compress(self.names, keep))
        dead = tuple(name for name in names if name in self.dead)
        return replace(self, names=names, rows=self.rows[mine], steps=steps, digits=digits, read=read, dead=dead)

    @property
    def readings(self) -> list[Readings | None]:
        """The finite readings of every row at their own instants; None where the row was not interpolated."""
        if self.read is None:
            return [None] * len(self.names)
        t, rows = self.read
        return [Readings(t[known], row[known]) for row in rows for known in [np.isfinite(row)]]


def assemble(
    name: str,
    t: np.ndarray,
    parts: Sequence[Channels],
    declared: Declared,
    warnings: tuple[str, ...] = (),
    keep: bool = False,
    mended: tuple[Mended, ...] = (),
    volts: str = "",
) -> Recording:
    """One recording from channels that share the stamps `t` (N,) s, resampled evenly, unless `keep` leaves the stamps as they are. `mended`
    says what was repaired in the stamps of each topic before; `volts` says how taxels are read in volts, where they are in newtons.

    Raises `RecordingError`.
    """
    notes: list[str] = [*declared.warnings, *warnings]
    unused = list(_unused(declared, parts, volts))
    parts = [p for part in parts for p in _calibrated(t, _live(part, notes), declared, notes) if p.names]
    _some_alive(name, parts)
    _some_numbers(name, parts)
    notes += unused
    if not parts:
        raise RecordingError(f"{name} has neither depth nor force nor taxels")
    whole = all(all_finite(p.rows) for p in parts)
    track, uneven = Track(t, tuple(p.rows for p in parts), whole=whole, digits=tuple(p.digits for p in parts)), False
    if keep:
        track, uneven = kept(track, name, declared.sample_rate_hz)
    else:
        track = even(track, name, declared.sample_rate_hz)
    if track.interpolated:
        parts = [p if p.steps else replace(p, steps=steps_of(p.rows)) for p in parts]
    parts = [replace(p, rows=rows, digits=digits) for p, rows, digits in zip(parts, track.blocks, track.digits, strict=True)]
    taxels = [p for p in parts if p.kind == "taxel"]
    _fits(name, declared, sum(len(p.names) for p in taxels), next((p.rows[0] for p in parts if p.kind == "depth"), None))
    recording = Recording(
        name=name,
        t=track.t,
        depth=_single(name, parts, "depth"),
        force=_single(name, parts, "force"),
        taxels=taxels[0].rows if len(taxels) == 1 else np.concatenate([p.rows for p in taxels]) if taxels else np.empty((0, 0)),
        taxel_names=tuple(n for p in taxels for n in p.names),
        taxel_units=tuple(p.unit for p in taxels for _ in p.names),
        declared=declared,
        warnings=(*notes, *track.warnings),
        uneven=uneven,
        steps=_named(parts, lambda p: p.steps or (0.0,) * len(p.names)),
        digits=_named(parts, lambda p: (None,) * len(p.names) if p.digits is None else p.digits),
        readings=_named(parts, lambda p: [r and r.within(track.t[0], track.t[-1]) for r in p.readings]),
        mended=(*mended, track.mended),
    )
    return _plausible(recording)


def _fits(name: str, declared: Declared, taxels: int, depth: np.ndarray | None) -> None:
    """Raises `RecordingError` where declared values cannot belong to this recording."""
    try:
        declared.checked_for(taxels)
    except RecordingError as error:
        raise RecordingError(f"{name}: {error}") from error
    travel = 0.0 if depth is None else 1e6 * float(np.ptp(depth))
    if declared.encoder_step_um and 0.0 < travel < declared.encoder_step_um:
        step = f"an encoder that steps by {declared.encoder_step_um:g} µm cannot have read a travel of {travel:.3g} µm"
        raise RecordingError(f"{name}: {step}; correct encoder_step_um in rig.yaml")


def _named(parts: list[Channels], of: Callable[[Channels], Iterable]) -> dict[str, Any]:
    """The values that `of` gives for the rows of each part, by the recording's channel names; values of None or 0 are left out."""
    numbers = count()
    named = ((p.kind if p.kind != "taxel" else f"taxel_{next(numbers)}", value) for p in parts for value in of(p))
    return {name: value for name, value in named if np.any(value)}


def _single(name: str, parts: list[Channels], kind: str) -> np.ndarray | None:
    same = [(n, row) for p in parts if p.kind == kind for n, row in zip(p.names, p.rows, strict=True)]
    if len(same) > 1:
        raise RecordingError(f"{name} has more than one {kind}: {', '.join(n for n, _ in same)}")
    return same[0][1] if same else None


def _live(part: Channels, notes: list[str]) -> Channels:
    """The channels with taxels that are mostly NaN set to zero and marked as dead; `notes` gets a warning for each."""
    if part.kind != "taxel" or all_finite(part.rows[:, :: max(1, part.rows.shape[1] // PROBES)]):
        return part
    keep = np.isfinite(part.rows).mean(axis=1) >= 0.5
    dead = tuple(compress(part.names, ~keep))
    notes += map(_taken_for_dead, dead)
    if keep.all():
        return part
    digits = None if part.digits is None else part.digits * keep[:, None].astype(np.uint32)
    read = part.read and (part.read[0], np.where(keep[:, None], part.read[1], 0.0))
    return replace(part, rows=np.where(keep[:, None], part.rows, 0.0), digits=digits, read=read, dead=dead)


def _taken_for_dead(taxel: str) -> str:
    return f"{taxel}: {DEAD}; it is taken for dead"


def _some_alive(name: str, parts: Sequence[Channels]) -> None:
    """Raises `RecordingError` where no taxel holds numbers."""
    taxels = [p for p in parts if p.kind == "taxel"]
    if taxels and all(len(p.dead) == len(p.names) for p in taxels):
        raise RecordingError(f"{name}: every taxel is dead ({DEAD}); leave the taxels out")


def _some_numbers(name: str, parts: Sequence[Channels]) -> None:
    """Raises `RecordingError` where the depth or the load cell holds no number at all."""
    empty = [n for p in parts if p.kind != "taxel" for n, row in zip(p.names, p.rows, strict=True) if not np.isfinite(row).any()]
    if empty:
        raise RecordingError(f"{name}: {empty[0]} holds no number; mend it, or leave it out")


def _calibrated(t: np.ndarray, part: Channels, declared: Declared, notes: list[str]) -> list[Channels]:
    """Volts to newtons where a slope is declared, every row in its place, for positions and noise are given by it. Uncalibrated volts
    stay, with a warning; a force in volts is refused."""
    if part.unit != "V":
        return [part]
    lines = [declared.calibration.get(n) or declared.calibration.get(f"{n}_V") for n in part.names]
    bare = [n for n, line in zip(part.names, lines, strict=True) if line is None]
    if bare and part.kind == "force":
        raise RecordingError(f"{bare[0]} is in volts: declare its slope_n_per_v under calibration in rig.yaml")
    notes += [
        f"{n} {UNCALIBRATED}: it is taken for a taxel and used as it is, so that N means V there. If it is the load "
        f"cell, declare in rig.yaml calibration: {{{n}: {{channel: force, slope_n_per_v: …}}}}; if a taxel, its slope_n_per_v"
        for n in bare
    ]
    if not any(lines):
        return [part]
    rows = [part.only([other == n for other in part.names]) for n in part.names]
    return [_in_newtons(t, one, line, notes) if line else one for one, line in zip(rows, lines, strict=True)]


def _in_newtons(t: np.ndarray, one: Channels, c: Calibration, notes: list[str]) -> Channels:
    zero, meaning, volts = c.zero_v, c.channel or one.names[0], one.rows
    if zero is None:
        known = np.isfinite(volts[0])
        begins = int(np.argmax(known))
        zero = float(np.median(volts[0, known & (t <= t[begins] + 1.0)])) if known.any() else 0.0
        late = f" from {t[begins]:.6g} s on, where its numbers begin" if begins else ""
        notes.append(f"{meaning}: zero taken as {zero:.6g} V, the median of the first second{late}; declare zero_v to be sure")
    kind, steps = "force" if meaning == "force" else "taxel", one.steps and (abs(c.slope_n_per_v) * one.steps[0],)
    read = one.read and (one.read[0], c.slope_n_per_v * (one.read[1] - zero))
    dead = (meaning,) if one.dead and kind == "taxel" else ()
    return Channels(kind, (meaning,), "N", c.slope_n_per_v * (volts - zero), steps, one.digits, read, dead)


def _unused(declared: Declared, parts: Sequence[Channels], volts: str) -> Iterator[str]:
    """A warning for every calibration that nothing is read with. Newtons are not calibrated again: who made them had a calibration."""
    known = {n: (p.unit, p.kind) for p in parts for n in p.names}
    for name, c in declared.calibration.items():
        found = [known[n] for n in (name, name.removesuffix("_V"), c.channel) if n in known]
        units, kinds = zip(*found, strict=True) if found else ((), ())
        if "V" in units:
            continue
        if "N" not in units:
            yield f"rig.yaml calibrates {name}, which is not a channel in volts here"
            continue
        own = next(n for n in (name, name.removesuffix("_V"), c.channel) if n in known)
        done = f"rig.yaml calibrates {own}, which is in newtons here already: its entry is not used"
        yield done + (f"; with {volts} the volts are read, and it is" if volts and "taxel" in kinds else "")


def _plausible(r: Recording) -> Recording:
    """The recording after checks of its sizes: a size that only a wrong unit can give raises; channels with a reversed sign are corrected,
    with a warning."""
    if r.depth is not None:
        check_span(r.name, np.ptp(r.depth))
    if doubt := slow(r):
        r = r.warned(doubt)
    if r.depth is not None and r.depth.max() <= 0.0 and r.force is not None:
        r = r.warned("the plunger never goes below the surface (depth is never > 0): no dispersion model can be fitted")
    for names, rows in ((("force",), r.force), (r.taxel_names, r.taxels)):
        if rows is not None and rows.size:
            r = _sized(r, names, *extremes(np.atleast_2d(rows)))
    return _turned(r)


def slow(r: Recording) -> str:
    """A warning that milliseconds may have been taken for seconds; empty where that is unlikely, or `rig.yaml` declares the rate."""
    if r.dt <= SLOWEST or r.t[-1] - r.t[0] <= LONGEST or r.declared.sample_rate_hz is not None:
        return ""
    return f"one sample in {r.dt:.3g} s for {r.t[-1] - r.t[0]:.3g} s: is the time in milliseconds?"


def counts_seconds(r: Recording) -> None:
    """Raises `RecordingError` where milliseconds may have been taken for seconds (see `slow`)."""
    if doubt := slow(r):
        raise RecordingError(f"{r.name}: {doubt} If it is not, declare sample_rate_hz in rig.yaml")


def _sized(r: Recording, names: Sequence[str], low: np.ndarray, high: np.ndarray) -> Recording:
    largest = np.maximum(-low, high)
    worst = int(np.argmax(largest))
    check_load(r.name, names[worst], largest[worst])
    still = [n for n, a, b in zip(names, low, high, strict=True) if a == b and _taken_for_dead(n) not in r.warnings]
    return r.warned(f"{', '.join(still)}: the value never changes") if still else r


def _turned(r: Recording) -> Recording:
    r = _with_depth_turned(r)
    against = r.depth if r.depth is not None else r.taxels.sum(axis=0) if len(r.taxels) and "V" not in r.taxel_units else None
    if r.force is None or against is None or not _falls(r.force, against):
        return r
    if r.depth is not None and _falls_too(r):
        taxels = [f"taxel_{i}" for i, unit in enumerate(r.taxel_units) if unit == "N"]
        return r.scaled(dict.fromkeys(("force", *taxels), -1.0)).warned(
            "force and taxels fall when the skin is pressed: the sign of all of them was reversed (compression is positive)"
        )
    return r.scaled({"force": -1.0}).warned("force falls when the skin is pressed: its sign was reversed (compression is positive)")


def _falls_too(r: Recording) -> bool:
    """Whether compression is negative by convention in all channels: some taxel in newtons falls with depth, too, and none rises."""
    taxels = [row for row, unit in zip(r.taxels, r.taxel_units, strict=True) if unit == "N"]
    return any(_falls(row, r.depth) for row in taxels) and not any(_falls(-row, r.depth) for row in taxels)


def _with_depth_turned(r: Recording) -> Recording:
    """The recording with the sign of its depth reversed where the depth counts away from the skin: loads then change where it is below zero
    and not above."""
    whole = r.taxels.sum(axis=0) if r.force is None else r.force
    if r.depth is None or not whole.size or _spread_above(whole, r.depth) >= 1.0:
        return r
    loads = [row for row in (r.force, *r.taxels) if row is not None]
    answering = [row for row in loads if _falls(row, r.depth) or _falls(-row, r.depth)]
    falling = bool(answering) and all(_falls(row, r.depth) for row in answering)
    flat = FLAT if (r.depth.max() > WIDE * np.ptp(r.depth)) else 0.0
    if not answering or not all(_spread_above(row, r.depth) < (1.0 if falling else flat) for row in answering):
        return r
    return replace(r, depth=-r.depth).warned(
        "the loads change while the depth is below zero, and not above: the depth counts away from the skin; its sign was reversed "
        "(depth is positive into the skin)"
    )


def _spread_above(y: np.ndarray, depth: np.ndarray) -> float:
    """Ratio of the standard deviations of `y` (N,) where the depth (N,) is above zero, and below."""
    above = depth > 0.0
    return float(np.std(y[above])) / max(float(np.std(y[~above])), 1e-300) if above.any() and not above.all() else float(above.all())


def _falls(y: np.ndarray, load: np.ndarray) -> bool:
    """Whether `y` (N,) clearly falls while the load (N,) grows."""
    with np.errstate(all="ignore"):  # a row may vary so little that its square underflows
        return np.ptp(y) > 0.0 and np.ptp(load) > 0.0 and float(np.corrcoef(y, load)[0, 1]) <= -0.5
