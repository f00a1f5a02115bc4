"""Chooses the session, the channel and the ten seconds that a reader should look at first."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from skin_ident.criticism.telling.outcome import ScanTrace, Trace
from skin_ident.report.shapes import residuals, smooth
from skin_ident.report.view import DIRECT, View

WINDOW_S = 10.0  # s
BESIDE = 0.1  # a change lies beside the compared samples if less than this share of its square is in them
SPIKES, AROUND = "outliers", 21  # the cause; samples of the median about a spike
LEAST_FALL = 0.02  # relative fall of the error below which the extension is taken to change nothing


@dataclass(frozen=True)
class Focus:
    """One session, the row of its most telling channel, and the samples [start, stop) of its most telling seconds."""

    trace: Trace
    row: int
    start: int
    stop: int

    @property
    def channel(self) -> str:
        """Name of the channel."""
        return self.trace.channels[self.row]

    @property
    def beside(self) -> bool:
        """Whether the extension changes the channel almost only in samples that were not compared."""
        return changes_beside(self.trace, self.row)

    @property
    def is_whole(self) -> bool:
        """Whether the seconds are the whole session."""
        return self.stop - self.start == self.trace.t.size

    @property
    def changes(self) -> bool:
        """Whether the extended model differs from the baseline here."""
        return differs(self.trace)

    @property
    def words(self) -> str:
        """What these seconds are, in words."""
        seconds = round(float(self.trace.t[self.stop - 1] - self.trace.t[self.start]))
        return "the whole session" if self.is_whole else f"the {'most telling' if self.changes else 'worst'} {seconds} s"


def focus(traces: tuple[Trace, ...], view: View) -> Focus | None:
    """The session, channel and seconds to show; None without traces.

    -   In general: the held-out session (any session where none was held out) whose error fell most.
    -   Where the verdict is unexplained and nothing was named: the session and channel whose error is furthest above the noise.
    -   Where spikes are named, and no finding is one that improves a simulation: the session and channel with the largest spike.
    """
    usable = [t for t in traces if t.t.size > 1 and t.channels]
    if not usable:
        return None
    tested = [t for t in usable if t.held_out] or usable
    if view.verdict == "unexplained" and not view.findings:
        trace, row = max(((t, row) for t in usable for row in range(len(t.channels))), key=lambda q: _astray(*q, view))
        return Focus(trace, row, *window(trace, row, view.band_hz))
    spiky = [c for f in view.findings if f.cause == SPIKES for c in f.shown_in] if all(f.direct for f in view.findings) else []
    with_spikes = [(t, t.channels.index(c)) for t in usable for c in spiky if c in t.channels]
    if with_spikes:
        trace, row = max(with_spikes, key=lambda q: float(_spikes(*q).max()))
        return Focus(trace, row, *_most(trace, _spikes(trace, row)))
    trace = max(tested, key=_removed)
    row = _row(trace, view)
    # Such a cause acts in moments that are not compared.
    everywhere = any(f.direct and f.cause not in DIRECT and not f.put_right for f in view.findings)
    return Focus(trace, row, *window(trace, row, view.band_hz, everywhere=everywhere))


def differs(trace: Trace | ScanTrace) -> bool:
    """Whether the extended model differs from the baseline anywhere."""
    return not all(np.array_equal(a, b, equal_nan=True) for a, b in zip(trace.baseline, trace.extended, strict=True))


def rms(y: np.ndarray) -> float:
    """Root mean square of the finite samples of y, of any shape; 0 where there are none."""
    y = y[np.isfinite(y)]
    return float(np.sqrt(np.mean(y**2))) if y.size else 0.0


def by_fall(trace: Trace, silent: tuple[str, ...] = ()) -> list[int]:
    """Rows of the channels in the order of the relative fall of their errors, the largest first; `silent` channels are last."""
    falls = [_fall(trace, row) - 10.0 * (c in silent) for row, c in enumerate(trace.channels)]
    return sorted(range(len(trace.channels)), key=lambda row: -round(falls[row], 3))


def window(trace: Trace, row: int, band_hz: float | None = None, seconds: float = WINDOW_S, everywhere: bool = False) -> tuple[int, int]:
    """Samples [start, stop) of the `seconds` in which the extension removes most squared error (below `band_hz`); where it removes none, of
    those with the largest error. `everywhere` includes samples that were not compared."""
    before, after = (smooth(trace.t, r, band_hz) ** 2 for r in residuals(trace, row))
    beside = changes_beside(trace, row)
    worth = (before - after if beside or _fall(trace, row) > LEAST_FALL else after) * (trace.compared | beside | everywhere)
    return _most(trace, worth, seconds)


def _most(trace: Trace, worth: np.ndarray, seconds: float = WINDOW_S) -> tuple[int, int]:
    """Samples [start, stop) of the `seconds` with the largest sum of `worth` (n,)."""
    n = trace.t.size
    width = round(seconds / max((trace.t[-1] - trace.t[0]) / (n - 1), 1e-12)) + 1
    if width >= 0.9 * n:
        return 0, n
    total = np.concatenate([[0.0], np.cumsum(np.nan_to_num(worth))])
    held = total[width:] - total[:-width]
    best = np.flatnonzero(held >= held.max() - 5e-3 * abs(held.max()))  # of about equal windows take the middle one
    start = int(best[best.size // 2])
    return start, start + width


def changes_beside(trace: Trace, row: int) -> bool:
    """Whether the extension changes a channel almost only in samples that were not compared."""
    change = np.nan_to_num(trace.extended[row] - trace.baseline[row]) ** 2
    return bool(np.sum(change) > 0.0 and np.sum(change[trace.compared]) < BESIDE * np.sum(change))


def _spikes(trace: Trace, row: int) -> np.ndarray:
    """Squared deviation (n,) of each sample's residual from the running median of the residual."""
    off = np.nan_to_num(trace.measured[row] - trace.baseline[row])
    return (off - median_filter(off, AROUND, mode="nearest")) ** 2


def _fall(trace: Trace, row: int) -> float:
    before, after = (rms((trace.measured[row] - y[row])[trace.compared]) for y in (trace.baseline, trace.extended))
    return 1.0 - after / before if before > 0.0 else 0.0


def _removed(trace: Trace) -> float:
    return max((_fall(trace, row) for row in range(len(trace.channels))), default=0.0)


def _astray(trace: Trace, row: int, view: View) -> float:
    """The error of a channel over its noise floor, or over the RMS of the measurement where no floor is known."""
    floor = next((e.floor for e in view.errors if e.channel == trace.channels[row] and trace.channels[row] not in view.silent), None)
    left = rms(smooth(trace.t, residuals(trace, row)[1], view.band_hz)[trace.compared])
    return round(left / floor, 2) if floor else left / max(rms(trace.measured[row]), 1e-12)


def _row(trace: Trace, view: View) -> int:
    """The row to show: the channel of the sensor in which a finding lies, if its error falls; else the channel that the finding names as
    gaining most; else the one whose error fell most."""
    alive = [c for c in trace.channels if c not in view.silent]
    named = [(f, c) for f in view.findings for c in f.shown_in if c in alive]
    shown = [c for f, c in named if c == f.gain.channel or _fall(trace, trace.channels.index(c)) > LEAST_FALL]
    return trace.channels.index(shown[0]) if shown else by_fall(trace, view.silent)[0]
