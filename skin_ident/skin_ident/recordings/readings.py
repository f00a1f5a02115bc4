"""What a channel itself was read as, and when, where its topic came at other instants than those of the recording.

Brought onto the recording's instants, a reading stands beside several of these, or between two: what single readings tell (a spike, one
that was sent twice, a block that was copied) is asked of themselves. Between them lies what a cubic spline says of a channel that is read
evenly: straight lines lose sinc^2(f / f_s) of what moves at the frequency f, 8 % at a sixth of the rate f_s, and would be told as damping;
a spline loses 0.2 % there. Of a channel that is read more often than the recording, noise above half the recording's rate would be folded
into what is compared: it is taken out before.

Source: M. Unser, Splines: a perfect fit for signal and image processing, IEEE Signal Processing Magazine 16(6), 1999, 22-38.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.signal import firwin, oaconvolve

from skin_ident.recordings.rows import all_finite, interpolated
from skin_ident.stretches import runs

CLOSEST = 0.5  # of a period: of stamps that tremble more, a spline would swing between two that nearly meet
NEXT = 1.5  # periods, from one reading to the next; in a longer gap a reading was lost, and nobody knows how the channel curved
RINGS = 2.0  # periods beside a wrong reading and its neighbours, to which a spline carries it: 0.27 of it in the first, 0.07 in the second
HALF, BETA = 2, 5.0  # of the low-pass before, half its length in samples that are kept, its Kaiser window: flat to a tenth of their rate
PIECE = 1 << 15  # instants in one go, which bounds the memory


@dataclass(frozen=True)
class Readings:
    """Readings y (M,) at their own instants t (M,) s, which increase."""

    t: np.ndarray
    y: np.ndarray

    @property
    def period(self) -> float:
        """From one to the next, s."""
        return float(np.median(np.diff(self.t))) if self.t.size > 1 else 0.0

    def within(self, start: float, stop: float) -> "Readings":
        """Those from the instant `start` s up to `stop`."""
        part = slice(np.searchsorted(self.t, start), np.searchsorted(self.t, stop, side="right"))
        return Readings(self.t[part], self.y[part])

    def scaled(self, factor: float) -> "Readings":
        """The same, multiplied by a factor."""
        return replace(self, y=factor * self.y)

    def spanned(self, wrong: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Mask of instants t (N,) between the good readings around those that are `wrong` (M,)."""
        out = np.zeros(t.size, bool)
        for a, b in zip(*runs(wrong), strict=True):
            out[self.span(a, b, t)] = True
        return out

    def span(self, a: int, b: int, t: np.ndarray) -> slice:
        """Those between the readings before and after a..b, or the one beside them."""
        start = int(np.searchsorted(t, self.t[a - 1], side="right")) if a else 0
        stop = int(np.searchsorted(t, self.t[b])) if b < self.t.size else t.size
        start = min(start, t.size - 1)
        return slice(start, max(stop, start + 1))

    def ringing(self, wrong: np.ndarray, dt: float) -> np.ndarray:
        """The mask (N,) of instants dt s apart with those beside its runs to which what is wrong there is carried."""
        beside, out = int(np.ceil(RINGS * max(self.period / dt, 1.0))), wrong.copy()
        for a, b in zip(*runs(wrong), strict=True):
            out[max(a - beside, 0) : b + beside] = True
        return out


def between(t: np.ndarray, known: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows (R, M) known at increasing instants, at the instants t (N,), both in the same unit: on cubic splines where all are numbers that
    come evenly, and on straight lines where one was lost, the row stands still, or stamps tremble; no further than any reading of the row.
    What is quicker than the instants can tell is averaged."""
    steps = np.diff(known)
    period = float(np.median(steps))
    if known.size < 4 or steps.min() < CLOSEST * period or not all_finite(rows):
        return interpolated(t, known, rows)
    few = round(float(np.median(np.diff(t))) / period)
    curved, out = make_interp_spline(known, (_low_passed(rows, few) if few > 1 else rows).T), np.empty((t.size, len(rows)))
    still, low, high = _still(rows), rows.min(axis=1), rows.max(axis=1)
    for start in range(0, t.size, PIECE):
        part = t[start : start + PIECE]
        gap = np.clip(np.searchsorted(known, part, side="right"), 1, steps.size) - 1
        straight = still[:, gap].T | (steps[gap] > NEXT * period)[:, None]
        out[start : start + PIECE] = np.where(straight, interpolated(part, known, rows).T, np.clip(curved(part), low, high))
    return out.T


def _still(rows: np.ndarray) -> np.ndarray:
    """Where rows (R, M) stand still from one reading to the next, and before and after it: (R, M-1)."""
    same = np.pad(np.diff(rows, axis=1) == 0.0, ((0, 0), (1, 1)), constant_values=True)
    return same[:, :-2] & same[:, 1:-1] & same[:, 2:]


def _low_passed(rows: np.ndarray, few: int) -> np.ndarray:
    """Rows (R, M) without what is quicker than half the rate that one in so many of them has; ends extended."""
    padded, taps = before_thinning(rows, few)
    return oaconvolve(padded, taps[None], mode="valid", axes=1)


def before_thinning(rows: np.ndarray, few: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows (R, M) with their ends extended, and the taps of the low-pass of which one sample in so many may be kept: nothing is folded into
    the lower half of what is left."""
    half = HALF * few
    padded = np.pad(rows, ((0, 0), (half, half)), mode="reflect", reflect_type="odd")
    return padded, firwin(2 * half + 1, 1.0 / few, window=("kaiser", BETA))
