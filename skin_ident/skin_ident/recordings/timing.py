"""From stamps as they come to an even grid, with every repair counted.

Repeated stamps are dropped, single late samples sorted in, small jitter snapped, larger jitter and short losses interpolated. A clock
that steps back is refused, and a long gap ends the session: only its longest stretch is kept. Nothing is mended in silence, and nothing
is copied that needs no mending: ten minutes of 64 taxels are 300 MB.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from skin_ident.recordings.digits import digits_at
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.rows import all_finite, finite, interpolated
from skin_ident.stretches import runs
from skin_models.tables.order import Mended, in_order
from skin_models.words import counted

SNAP = 0.01  # of the period: jitter below this is taken as even
DECIMALS = 4  # of a period in which stamps may be written
SAME, SURELY = 1e-6, 0.01  # of the last decimal: a whole number of them, as far as floating point tells, and where it cannot
BRIDGED = 10  # samples: the longest loss that is interpolated


@dataclass(frozen=True)
class Track:
    """Samples with their stamps: t (N,) s (or ns, as long as it is not yet even), blocks of rows (R_i, N), the `digits` (R_i, N) of
    blocks that were interpolated, None of others, and how the stamps were `mended`."""

    t: np.ndarray
    blocks: tuple[np.ndarray, ...]
    warnings: tuple[str, ...] = ()
    whole: bool = False  # known to hold nothing but numbers
    interpolated: bool = False
    digits: tuple[np.ndarray | None, ...] = ()
    mended: Mended = field(default_factory=Mended)

    def kept(self, index: np.ndarray | slice, *warnings: str) -> "Track":
        """A selection of the samples, with more warnings."""
        blocks, warnings = tuple(rows[:, index] for rows in self.blocks), (*self.warnings, *warnings)
        digits = tuple(None if d is None else d[:, index] for d in self.digits)
        return replace(self, t=self.t[index], blocks=blocks, warnings=warnings, digits=digits)

    def warned(self, *warnings: str) -> "Track":
        """The same with more warnings."""
        return replace(self, warnings=(*self.warnings, *warnings))


def ordered(track: Track, name: str) -> Track:
    """The track with finite, strictly increasing stamps. Raises `TableError` where the clock steps back."""
    index, mended = in_order(track.t, name)
    return track if index is None else replace(track.kept(index, *mended.notes), mended=mended)


def even(track: Track, name: str, rate_hz: float | None = None) -> Track:
    """The track on an even grid, in s. Numbers that are missing are bridged where their run is short. Raises `RecordingError`."""
    track = _enough(ordered(track, name), name)
    track = _enough(_bridged(longest_stretch(track, name), name), name)
    steps = np.rint((track.t - track.t[0]) / _period(track.t))
    dt = (track.t[-1] - track.t[0]) / steps[-1]
    track = track.warned(*_rate_warning(dt, rate_hz))
    if steps[-1] == track.t.size - 1 and np.max(np.abs(track.t - track.t[0] - steps * dt)) <= SNAP * dt + _rounded(track.t, dt):
        return replace(track, t=track.t[0] + dt * np.arange(track.t.size))
    return _resampled(track, dt)


def _period(t: np.ndarray) -> float:
    """Of stamps t (N,) that may be rounded, late or lost: the median step is off by what a stamp is rounded to, and a long record would
    seem to have lost samples; so the steps that it counts share the whole time."""
    between = np.diff(t)
    median = float(np.median(between))
    shared = float(t[-1] - t[0]) / max(float(np.rint(between / median).sum()), 1.0)
    return shared if abs(shared - median) < SNAP * median + _rounded(t, median) else median


def _rounded(t: np.ndarray, dt: float) -> float:
    """By how much stamps t (N,) may be off for being written with few decimals: half of the last one each, as is the first of them."""
    begun = t - t[0]
    for places in range(DECIMALS):
        last = 10.0 ** (np.floor(np.log10(dt)) - places)
        exact = SAME + 4.0 * np.spacing(float(np.max(np.abs(t)))) / last
        if exact < SURELY and np.max(np.abs(begun / last - np.rint(begun / last))) < exact:
            return last  # the first stamp is rounded, too
    return 0.0


def kept(track: Track, name: str, rate_hz: float | None = None) -> tuple[Track, bool]:
    """The track with its own stamps, in s, and whether they are uneven; missing numbers are bridged. Raises `RecordingError`."""
    track = _enough(ordered(track, name), name)
    track = _enough(_bridged(longest_stretch(track, name), name), name)
    dt = (track.t[-1] - track.t[0]) / (track.t.size - 1)
    track = track.warned(*_rate_warning(dt, rate_hz))
    off = track.t - track.t[0] - dt * np.arange(track.t.size)
    if np.max(np.abs(off)) <= SNAP * dt:
        return replace(track, t=track.t[0] + dt * np.arange(track.t.size)), False
    return track.warned(f"stamps kept as they are, {1 / dt:.6g} Hz on average (jitter {1e3 * np.std(np.diff(track.t)):.3g} ms)"), True


def _enough(track: Track, name: str) -> Track:
    if track.t.size >= 2:
        return track
    left = counted(track.t.size, "usable sample")
    why = f" ({'; '.join(track.warnings)})" if track.warnings else ""
    raise RecordingError(f"{name} holds {left}: there is nothing to fit{why}")


def _resampled(track: Track, dt: float) -> Track:
    count = int(np.floor((track.t[-1] - track.t[0]) / dt * (1 + 1e-12))) + 1
    t = track.t[0] + dt * np.arange(count)
    steps = np.diff(track.t)
    jitter = np.std(steps[steps < 1.5 * dt])
    lost = int(np.sum(np.maximum(np.rint(steps / dt) - 1, 0)))
    why = [f"jitter {1e3 * jitter:.3g} ms"] if jitter > SNAP * dt or not lost else []
    why += [f"{counted(lost, 'lost sample')} interpolated"] if lost else []
    note = f"resampled evenly at {1 / dt:.6g} Hz ({', '.join(why)})"
    known = track.digits or (None,) * len(track.blocks)
    digits = tuple(digits_at(t, track.t, rows if d is None else d) for rows, d in zip(track.blocks, known, strict=True))
    blocks = tuple(interpolated(t, track.t, rows) for rows in track.blocks)
    return Track(t, blocks, (*track.warnings, note), interpolated=True, digits=digits, mended=track.mended)


def longest_stretch(track: Track, name: str) -> Track:
    """The longest part without a gap of more than `BRIDGED` periods, or with numbers missing for as long."""
    steps = np.diff(track.t)
    cuts = steps > (BRIDGED + 1.5) * float(np.median(steps))
    missing = np.zeros(track.t.size, bool)
    for rows in () if track.whole else track.blocks:
        missing |= ~finite(rows)
    bad = _long_runs(missing)
    if not bad.any() and not cuts.any():
        return track
    label = np.cumsum(np.concatenate([[0], cuts | (bad[1:] != bad[:-1])]))
    sizes = np.bincount(label[~bad], minlength=label[-1] + 1)
    keep = (label == np.argmax(sizes)) & ~bad
    if not keep.any():
        raise RecordingError(f"{name}: no stretch of it holds numbers in every channel")
    left = track.t.size - keep.sum()
    what = f"kept the longest stretch without a gap ({counted(keep.sum(), 'sample')}), left {counted(left, 'sample')} out"
    return track.kept(keep, f"{counted(cuts.sum(), 'gap')} in time, {counted(_runs(bad), 'long run')} of missing numbers: {what}")


def _bridged(track: Track, name: str) -> Track:
    """Short runs of missing numbers interpolated, those at the ends cut off."""
    if track.whole or all(all_finite(rows) for rows in track.blocks):
        return track
    whole = np.logical_and.reduce([finite(rows) for rows in track.blocks])
    if not whole.any():
        raise RecordingError(f"{name}: no sample holds numbers in every channel")
    track = track.kept(slice(int(np.argmax(whole)), whole.size - int(np.argmax(whole[::-1]))))
    blocks, filled = [], 0
    for rows in track.blocks:
        bad = ~np.isfinite(rows)
        filled += int(bad.sum())
        mended = [np.where(b, np.interp(track.t, track.t[~b], row[~b]), row) if b.any() else row for row, b in zip(rows, bad, strict=True)]
        blocks.append(np.array(mended))
    note = (f"{counted(filled, 'missing number')} interpolated",) if filled else ()
    return replace(track, blocks=tuple(blocks), warnings=(*track.warnings, *note), interpolated=filled > 0)


def _rate_warning(dt: float, rate_hz: float | None) -> tuple[str, ...]:
    if rate_hz is None or abs(rate_hz * dt - 1.0) < 0.01:
        return ()
    return (f"sampled at {1 / dt:.6g} Hz, while {rate_hz:.6g} Hz is declared",)


def _long_runs(flags: np.ndarray) -> np.ndarray:
    """The same flags, without runs of `BRIDGED` or fewer."""
    out = np.zeros_like(flags)
    if flags.any():
        for start, stop in zip(*runs(flags), strict=True):
            out[start:stop] = stop - start > BRIDGED
    return out


def _runs(flags: np.ndarray) -> int:
    return runs(flags)[0].size
