"""From stamps as they come to an even grid, with every repair counted.

Repeated stamps are dropped, single late samples sorted in, small jitter snapped, larger jitter and short losses interpolated. A clock
that steps back is refused, and a long gap ends the session: only its longest stretch is kept. Nothing is mended in silence.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.recordings.errors import RecordingError

SNAP = 0.01  # of the period: jitter below this is taken as even
BRIDGED = 10  # samples: the longest loss that is interpolated
LATE_RUN = 3  # so many samples in a row behind the newest one are no longer "late" but a clock that stepped back


@dataclass(frozen=True)
class Track:
    """Samples with their stamps: t (N,) s, rows (R, N)."""

    t: np.ndarray
    rows: np.ndarray
    warnings: tuple[str, ...] = ()

    def kept(self, index: np.ndarray | slice, *warnings: str) -> "Track":
        """A selection of the samples, with more warnings."""
        return Track(self.t[index], self.rows[:, index], (*self.warnings, *warnings))


def ordered(track: Track, name: str) -> Track:
    """The track with finite, strictly increasing stamps. Raises `RecordingError` where the clock steps back."""
    finite = np.isfinite(track.t)
    if not finite.all():
        track = track.kept(finite, f"{counted((~finite).sum(), 'sample')} without a time stamp dropped")
    if track.t.size < 2:
        raise RecordingError(f"{name} holds {counted(track.t.size, 'sample')}: there is nothing to fit")
    return _without_repeats(_sorted(track, name))


def _sorted(track: Track, name: str) -> Track:
    behind = track.t < np.maximum.accumulate(track.t)
    if not behind.any():
        return track
    first = int(np.argmax(behind))
    if _longest_run(behind) > LATE_RUN:
        back = track.t[first - 1] - track.t[first]
        raise RecordingError(f"{name}: the clock steps back by {back:.6g} at sample {first}; cut it there, or repair its stamps")
    return track.kept(np.argsort(track.t, kind="stable"), f"{counted(behind.sum(), 'sample')} out of order sorted by time")


def _without_repeats(track: Track) -> Track:
    repeated = np.diff(track.t, prepend=-np.inf) <= 0.0
    if not repeated.any():
        return track
    return track.kept(~repeated, f"{counted(repeated.sum(), 'repeated time stamp')} dropped, the first sample of each kept")


def even(track: Track, name: str, rate_hz: float | None = None) -> Track:
    """The track on an even grid. NaN samples are bridged where their run is short. Raises `RecordingError`."""
    track = longest_stretch(ordered(track, name), name)
    track = _bridged_nan(track, name)
    if track.t.size < 2:
        raise RecordingError(f"{name} holds {counted(track.t.size, 'usable sample')}: there is nothing to fit ({'; '.join(track.warnings)})")
    period = float(np.median(np.diff(track.t)))
    steps = np.rint((track.t - track.t[0]) / period)
    dt = (track.t[-1] - track.t[0]) / steps[-1]
    warnings = _rate_warning(dt, rate_hz)
    if steps[-1] == track.t.size - 1 and np.max(np.abs(track.t - track.t[0] - steps * dt)) <= SNAP * dt:
        return Track(track.t[0] + dt * np.arange(track.t.size), track.rows, (*track.warnings, *warnings))
    return _resampled(track, dt, warnings)


def _resampled(track: Track, dt: float, warnings: tuple[str, ...]) -> Track:
    count = int(np.floor((track.t[-1] - track.t[0]) / dt * (1 + 1e-12))) + 1
    t = track.t[0] + dt * np.arange(count)
    rows = np.array([np.interp(t, track.t, row) for row in track.rows]).reshape(len(track.rows), count)
    jitter = np.std(np.diff(track.t)[np.diff(track.t) < 1.5 * dt])
    lost = int(np.sum(np.maximum(np.rint(np.diff(track.t) / dt) - 1, 0)))
    note = f"resampled evenly at {1 / dt:.6g} Hz (jitter {1e3 * jitter:.3g} ms"
    return Track(t, rows, (*track.warnings, *warnings, note + (f", {counted(lost, 'lost sample')} interpolated)" if lost else ")")))


def longest_stretch(track: Track, name: str) -> Track:
    """The longest part without a gap of more than `BRIDGED` periods, or with NaN for as long."""
    period = float(np.median(np.diff(track.t)))
    bad = _long_runs(~np.isfinite(track.rows).all(axis=0))
    cuts = np.diff(track.t) > (BRIDGED + 1.5) * period
    if not bad.any() and not cuts.any():
        return track
    label = np.cumsum(np.concatenate([[0], cuts | (bad[1:] != bad[:-1])]))
    sizes = np.bincount(label[~bad], minlength=label[-1] + 1)
    keep = (label == np.argmax(sizes)) & ~bad
    if not keep.any():
        raise RecordingError(f"{name}: no stretch of it holds numbers in every channel")
    left = track.t[~keep].size
    what = f"kept the longest stretch without a gap ({counted(keep.sum(), 'sample')}), left {counted(left, 'sample')} out"
    return track.kept(keep, f"{counted(cuts.sum(), 'gap')} in time, {counted(_runs(bad), 'long run')} of missing numbers: {what}")


def _bridged_nan(track: Track, name: str) -> Track:
    bad = ~np.isfinite(track.rows)
    if not bad.any():
        return track
    inside = ~bad.any(axis=0)
    first, last = int(np.argmax(inside)), inside.size - int(np.argmax(inside[::-1]))
    if not inside.any():
        raise RecordingError(f"{name}: no sample holds numbers in every channel")
    track, bad = track.kept(slice(first, last)), bad[:, first:last]
    rows = [np.where(b, np.interp(track.t, track.t[~b], row[~b]), row) for row, b in zip(track.rows, bad, strict=True)]
    return Track(track.t, np.array(rows), (*track.warnings, f"{counted(bad.sum(), 'missing number')} interpolated"))


def _rate_warning(dt: float, rate_hz: float | None) -> tuple[str, ...]:
    if rate_hz is None or abs(rate_hz * dt - 1.0) < 0.01:
        return ()
    return (f"sampled at {1 / dt:.6g} Hz, while {rate_hz:.6g} Hz is declared",)


def _long_runs(flags: np.ndarray) -> np.ndarray:
    """The same flags, without runs of `BRIDGED` or fewer."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    out = np.zeros_like(flags)
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        out[start:stop] = stop - start > BRIDGED
    return out


def _longest_run(flags: np.ndarray) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return int(np.max(edges[1::2] - edges[::2], initial=0))


def _runs(flags: np.ndarray) -> int:
    return int(np.sum(np.diff(flags.astype(int), prepend=0) == 1))


def counted(count: int, noun: str) -> str:
    """`3 samples`, `1 sample`."""
    return f"{int(count)} {noun}" + ("" if count == 1 else "s")
