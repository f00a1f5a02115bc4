"""The readings of a channel at their own instants, where its topic came at other instants than those of the recording.

Interpolation to the recording's instants spreads a reading over several samples. So tests of single readings (for a spike, a reading sent
twice, a copied block) use the readings themselves. Evenly sampled channels are interpolated by a cubic spline. Straight lines would
attenuate motion at the frequency f to sinc^2(f / f_s), by 8 % at a sixth of the rate f_s, which would look like damping; a spline loses
0.2 % there. A channel with a higher rate than the recording is low-passed first, so that noise above half the recording's rate is not
aliased.

Source: M. Unser, Splines: a perfect fit for signal and image processing, IEEE Signal Processing Magazine 16(6), 1999, 22-38.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.signal import firwin, oaconvolve

from skin_ident.recordings.rows import all_finite, interpolated
from skin_ident.stretches import runs

CLOSEST = 0.5  # least step in periods for which a spline is used: between stamps closer than that it would oscillate
NEXT = 1.5  # periods: a longer gap means that a reading was lost, and is bridged by a straight line
RINGS = 2.0  # periods over which a spline spreads a wrong reading beyond its neighbours: 0.27 of it in the first, 0.07 in the second
HALF, BETA = 2, 5.0  # low-pass before decimation: half length in kept samples, Kaiser parameter; flat up to a tenth of the kept rate
PIECE = 1 << 15  # instants that are processed at once, which bounds the memory


@dataclass(frozen=True)
class Readings:
    """Readings y (M,) at their own instants t (M,) s, which increase."""

    t: np.ndarray
    y: np.ndarray

    @property
    def period(self) -> float:
        """Median time from one reading to the next, s."""
        return float(np.median(np.diff(self.t))) if self.t.size > 1 else 0.0

    def within(self, start: float, stop: float) -> "Readings":
        """The readings from the instant `start` to `stop`, s."""
        part = slice(np.searchsorted(self.t, start), np.searchsorted(self.t, stop, side="right"))
        return Readings(self.t[part], self.y[part])

    def scaled(self, factor: float) -> "Readings":
        """The readings multiplied by a factor."""
        return replace(self, y=factor * self.y)

    def lowered(self, zero: float) -> "Readings":
        """The readings less a constant."""
        return replace(self, y=self.y - zero)

    def spanned(self, wrong: np.ndarray, t: np.ndarray) -> np.ndarray:
        """A mask of the instants t (N,) that depend on `wrong` readings (mask (M,)): those between the good readings around them."""
        out = np.zeros(t.size, bool)
        for a, b in zip(*runs(wrong), strict=True):
            out[self.span(a, b, t)] = True
        return out

    def span(self, a: int, b: int, t: np.ndarray) -> slice:
        """The instants of t between the readings before and after a..b (b exclusive), or the next one where there is none between."""
        start = int(np.searchsorted(t, self.t[a - 1], side="right")) if a else 0
        stop = int(np.searchsorted(t, self.t[b])) if b < self.t.size else t.size
        start = min(start, t.size - 1)
        return slice(start, max(stop, start + 1))

    def ringing(self, wrong: np.ndarray, dt: float) -> np.ndarray:
        """The mask (N,) of wrong instants (dt s apart), extended to the instants over which the interpolation spreads their errors."""
        beside, out = int(np.ceil(RINGS * max(self.period / dt, 1.0))), wrong.copy()
        for a, b in zip(*runs(wrong), strict=True):
            out[max(a - beside, 0) : b + beside] = True
        return out


def between(t: np.ndarray, known: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows (R, M) at increasing instants `known`, interpolated to the instants t (N,) in the same unit.

    By cubic splines where all readings are finite and evenly spaced. By straight lines where a reading was lost, where the row is constant,
    or where stamps have much jitter. Values are limited to the range of the row. Rows of a higher rate than t are low-passed first.
    """
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
    """A mask (R, M-1) of the steps at which rows (R, M) do not change, and do not in the steps before and after either."""
    same = np.pad(np.diff(rows, axis=1) == 0.0, ((0, 0), (1, 1)), constant_values=True)
    return same[:, :-2] & same[:, 1:-1] & same[:, 2:]


def _low_passed(rows: np.ndarray, few: int) -> np.ndarray:
    """Rows (R, M) low-passed for a decimation by `few`, with their ends extended."""
    padded, taps = before_thinning(rows, few)
    return oaconvolve(padded, taps[None], mode="valid", axes=1)


def before_thinning(rows: np.ndarray, few: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows (R, M) with their ends extended, and the taps of a low-pass for a decimation by `few`: nothing is aliased into the lower half of
    the remaining band."""
    half = HALF * few
    padded = np.pad(rows, ((0, 0), (half, half)), mode="reflect", reflect_type="odd")
    return padded, firwin(2 * half + 1, 1.0 / few, window=("kaiser", BETA))
