"""Brings samples with their original stamps to an even grid, and counts every repair.

Repeated stamps are dropped, single late samples are sorted in, small jitter is removed from the stamps, and larger jitter and short losses
are interpolated. A clock that steps back raises an error. At a long gap the session is cut, and only its longest stretch is kept. Every
repair is reported, and nothing is copied that needs no repair: ten minutes of 64 taxels are 300 MB.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from skin_ident.recordings.digits import digits_at
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.rows import all_finite, finite, interpolated
from skin_ident.stretches import runs
from skin_models.tables.order import Mended, in_order
from skin_models.words import counted

SNAP = 0.01  # of the period: stamps with less jitter are taken as even
DECIMALS = 4  # numbers of decimals, relative to the period, that are tried for rounded stamps
SAME, SURELY = 1e-6, 0.01  # of the last decimal: tolerance for whole multiples; a tolerance at which floating point cannot decide
BRIDGED = 10  # samples: the longest loss that is interpolated


@dataclass(frozen=True)
class Track:
    """Samples with their stamps: t (N,) s (ns in a topic's own track), blocks of rows (R_i, N), the `digits` (R_i, N) of blocks that were
    interpolated (None for others), and how the stamps were `mended`."""

    t: np.ndarray
    blocks: tuple[np.ndarray, ...]
    warnings: tuple[str, ...] = ()
    whole: bool = False  # whether all values are known to be finite
    interpolated: bool = False
    digits: tuple[np.ndarray | None, ...] = ()
    mended: Mended = field(default_factory=Mended)

    def kept(self, index: np.ndarray | slice, *warnings: str) -> "Track":
        """A selection of the samples, with more warnings."""
        blocks, warnings = tuple(rows[:, index] for rows in self.blocks), (*self.warnings, *warnings)
        digits = tuple(None if d is None else d[:, index] for d in self.digits)
        return replace(self, t=self.t[index], blocks=blocks, warnings=warnings, digits=digits)

    def warned(self, *warnings: str) -> "Track":
        """The track with more warnings."""
        return replace(self, warnings=(*self.warnings, *warnings))


def ordered(track: Track, name: str) -> Track:
    """The track with finite, strictly increasing stamps. Raises `TableError` where the clock steps back."""
    index, mended = in_order(track.t, name)
    return track if index is None else replace(track.kept(index, *mended.notes), mended=mended)


def even(track: Track, name: str, rate_hz: float | None = None) -> Track:
    """The track on an even grid, in s. Short runs of missing numbers are interpolated. Raises `RecordingError`."""
    track = _enough(ordered(track, name), name)
    track = _enough(_bridged(longest_stretch(track, name), name), name)
    steps = np.rint((track.t - track.t[0]) / _period(track.t))
    dt = (track.t[-1] - track.t[0]) / steps[-1]
    track = track.warned(*_rate_warning(dt, rate_hz))
    if steps[-1] == track.t.size - 1 and np.max(np.abs(track.t - track.t[0] - steps * dt)) <= SNAP * dt + _rounded(track.t, dt):
        return replace(track, t=track.t[0] + dt * np.arange(track.t.size))
    return _resampled(track, dt)


def _period(t: np.ndarray) -> float:
    """The sampling period of stamps t (N,) that may be rounded, late or lost.

    The median step is off by the rounding of stamps, which in a long record would look like lost samples. So it only serves to count the
    steps, by which the whole time is then divided.
    """
    between = np.diff(t)
    median = float(np.median(between))
    shared = float(t[-1] - t[0]) / max(float(np.rint(between / median).sum()), 1.0)
    return shared if abs(shared - median) < SNAP * median + _rounded(t, median) else median


def _rounded(t: np.ndarray, dt: float) -> float:
    """The largest error of stamps t (N,) relative to the first due to few decimals: half of the last decimal for each of the two; 0 where
    no rounding is seen."""
    begun = t - t[0]
    for places in range(DECIMALS):
        last = 10.0 ** (np.floor(np.log10(dt)) - places)
        exact = SAME + 4.0 * np.spacing(float(np.max(np.abs(t)))) / last
        if exact < SURELY and np.max(np.abs(begun / last - np.rint(begun / last))) < exact:
            return last  # half for the stamp, half for the first one
    return 0.0


def kept(track: Track, name: str, rate_hz: float | None = None) -> tuple[Track, bool]:
    """The track with its own stamps, in s, and whether they are uneven; short runs of missing numbers are interpolated. Raises
    `RecordingError`."""
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
    """The longest part without a gap, or a run of missing numbers, of more than `BRIDGED` periods."""
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
    why = [f"{counted(cuts.sum(), 'gap')} in time"] if cuts.any() else []
    why += [f"{counted(_runs(bad), 'long run')} of missing numbers"] if bad.any() else []
    return track.kept(keep, f"{', '.join(why)}: {what}")


def _bridged(track: Track, name: str) -> Track:
    """The track with missing numbers interpolated, and cut to begin and end with a complete sample."""
    if track.whole or all(all_finite(rows) for rows in track.blocks):
        return track
    whole = np.logical_and.reduce([finite(rows) for rows in track.blocks])
    if not whole.any():
        raise RecordingError(f"{name}: no sample holds numbers in every channel")
    track = track.kept(slice(int(np.argmax(whole)), whole.size - int(np.argmax(whole[::-1]))))
    blocks, filled, endless = [], 0, 0
    for rows in track.blocks:
        bad = ~np.isfinite(rows)
        filled, endless = filled + int(bad.sum()), endless + int(np.isinf(rows).sum())
        mended = [np.where(b, np.interp(track.t, track.t[~b], row[~b]), row) if b.any() else row for row, b in zip(rows, bad, strict=True)]
        blocks.append(np.array(mended))
    kinds = ((filled - endless, "missing number"), (endless, "infinite number"))
    note = tuple(f"{counted(n, what)} interpolated" for n, what in kinds if n)
    return replace(track, blocks=tuple(blocks), warnings=(*track.warnings, *note), interpolated=filled > 0)


def _rate_warning(dt: float, rate_hz: float | None) -> tuple[str, ...]:
    if rate_hz is None or abs(rate_hz * dt - 1.0) < 0.01:
        return ()
    return (f"sampled at {1 / dt:.6g} Hz, while {rate_hz:.6g} Hz is declared",)


def _long_runs(flags: np.ndarray) -> np.ndarray:
    """The flags without their runs of `BRIDGED` or fewer."""
    out = np.zeros_like(flags)
    if flags.any():
        for start, stop in zip(*runs(flags), strict=True):
            out[start:stop] = stop - start > BRIDGED
    return out


def _runs(flags: np.ndarray) -> int:
    return runs(flags)[0].size
