"""One low-pass for everything: measured force, simulated force and every direction pass through the same filter, at full rate.

An encoder of a few micrometres makes its derivative noisy; filtering only one side of the comparison turns that into a false delay. The
filter is a centred, linear-phase FIR, so it shifts nothing. Samples at the ends, where it would reach beyond the record, are dropped.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.signal import firwin, oaconvolve

from skin_ident.estimators.scale import white_scale

CUTOFF_HZ = 8.0  # cut-off, above the thesis's motions and below what the encoder's steps disturb
WIDER = 2.5  # the depth itself, which effects see, keeps this many times the band

# Half length in periods of the cut-off, and the Kaiser window's beta: short for the band, so that an edge costs few samples; sharp for the
# depth, whose ripple would pass into every force.
SHORT, SHARP = (1.5, 5.0), (3.0, 8.0)

LEAST = 0.5  # smallest divisor in `thin`, the sum of the taps on seen samples


@dataclass(frozen=True)
class Band:
    """The common low-pass for data sampled every `dt` seconds. `slowest` is the longest sampling period, s, of the recordings it is
    compared with. Samples that are not `seen` (N,) are left out: the filter averages the others."""

    dt: float
    cutoff: float = CUTOFF_HZ
    slowest: float = 0.0
    seen: np.ndarray | None = field(default=None, compare=False)

    @property
    def edge(self) -> float:
        """Cut-off in Hz, at most a fifth of the lowest sampling rate."""
        return min(self.cutoff, 0.2 / max(self.dt, self.slowest))

    @property
    def narrowed(self) -> float:
        """The factor by which the band would keep more samples had the cut-off not been lowered for a slow motion (see `cutoff`)."""
        return min(CUTOFF_HZ, 0.2 / max(self.dt, self.slowest)) / self.edge

    @cached_property
    def every(self) -> int:
        """Decimation factor: one filtered sample in `every` is kept. The rate left is about three times the cut-off, and as nearly the same
        for all sessions as their sampling allows."""
        slowest = max(self.dt, self.slowest)
        kept = slowest * max(1, int(1.0 / (slowest * 3.0 * self.edge)))
        return max(1, round(kept / self.dt))

    @property
    def spacing(self) -> float:
        """Time between kept samples, s."""
        return self.dt * self.every

    @cached_property
    def kernel(self) -> np.ndarray:
        """Taps of the low-pass; their number less one is a multiple of `every`, so that decimation starts on a whole window."""
        return _low_pass(self.edge, self.dt, self.every)

    def smooth(self, x: np.ndarray) -> np.ndarray:
        """The depth (N,), m, as effects see it: low-passed with a cut-off well above the band's, ends extended, same length."""
        return _filtered(x, self._wide)

    def speed(self, x: np.ndarray) -> np.ndarray:
        """Speed (N,), m/s, by the derivative of the filter that `smooth` uses: a central difference would lose 4 % at 8 Hz from 100 Hz
        data."""
        half = self._wide.size // 2
        n = np.arange(-half, half + 1)
        taps = _differentiator(self._wide_edge, self.dt, n, SHARP)
        return _filtered(x, taps / -np.sum(n * self.dt * taps))

    @property
    def _wide_edge(self) -> float:
        return min(WIDER * self.edge, 0.4 / self.dt)

    @cached_property
    def _wide(self) -> np.ndarray:
        return _low_pass(self._wide_edge, self.dt, shape=SHARP)

    def blind(self, left_out: np.ndarray) -> "Band":
        """The same band with the samples `left_out` (N,) not seen."""
        seen = ~left_out if self.seen is None else self.seen & ~left_out
        return self if seen.all() else replace(self, seen=seen)

    @cached_property
    def sees(self) -> np.ndarray | float:
        """Sum of the kernel's taps on seen samples, at each kept sample (n,)."""
        return 1.0 if self.seen is None else self._thinned(self.seen.astype(float))

    @cached_property
    def misses(self) -> np.ndarray | float:
        """Share of the kernel's magnitude that falls on unseen samples, at each kept sample (n,). Magnitudes are used because the kernel
        has lobes of both signs, which may cancel in `sees`."""
        magnitude = np.abs(self.kernel)
        return 0.0 if self.seen is None else self._thinned((~self.seen).astype(float), self._in_pieces(magnitude / magnitude.sum()))

    def thin(self, y: np.ndarray) -> np.ndarray:
        """Low-passes the rows of `y` (..., N), drops the edges and decimates."""
        return self._thinned(y) if self.seen is None else self._thinned(y, mask=self.seen) / self._made_up

    def thin_changes(self, changes: np.ndarray, out: np.ndarray) -> None:
        """`thin` of `changes` (C, N) into `out` (C, n), which holds zeros: of the rows that are not zero themselves, for most changes of a
        model are of one channel or two."""
        changed = np.einsum("cn,cn->c", changes, changes) > 0.0  # five times as fast as `np.any`
        out[changed] = self.thin(changes[changed])

    @cached_property
    def _made_up(self) -> np.ndarray:
        return np.maximum(self.sees, LEAST)

    def _thinned(self, y: np.ndarray, pieces: np.ndarray | None = None, mask: np.ndarray | None = None) -> np.ndarray:
        """Low-passes and decimates rows `y`, times a `mask`, with the kernel or with another one given in `pieces`. Only the kept samples
        are computed.

        Rows are cut into pieces of `every` samples, as the kernel is. One matrix product multiplies every piece of the one with every piece
        of the other, and each kept sample is the sum along a diagonal of the result.
        """
        pieces = self._pieces if pieces is None else pieces
        count, every = pieces.shape
        kept = max((y.shape[-1] - self.kernel.size) // every + 1, 0)
        long = kept + count - 1
        cut = np.zeros((*y.shape[:-1], long * every))  # zeros beyond the end, where the kernel's last piece is zero
        used = slice(min(y.shape[-1], long * every))
        np.multiply(y[..., used], 1.0 if mask is None else mask[used], out=cut[..., used])
        room = np.empty((*y.shape[:-1], count * (long + 1)))  # rows one longer than the products, so that a diagonal becomes a column
        products = room[..., : count * long].reshape(*y.shape[:-1], count, long)
        np.matmul(pieces, np.swapaxes(cut.reshape(*y.shape[:-1], long, every), -1, -2), products)
        return room.reshape(*y.shape[:-1], count, long + 1)[..., :kept].sum(axis=-2)

    @cached_property
    def _pieces(self) -> np.ndarray:
        return self._in_pieces(self.kernel)

    def _in_pieces(self, kernel: np.ndarray) -> np.ndarray:
        """A kernel cut into pieces of `every` taps, the last one padded with zeros."""
        return np.pad(kernel, (0, self.every - 1)).reshape(-1, self.every)

    def white(self, y: np.ndarray) -> float:
        """RMS, in the band, of the white noise of `y` (N,). It is found from third differences, which contain little else where samples are
        dense."""
        return float(white_scale(y, 3) * self.passes)

    @property
    def passes(self) -> float:
        """The share of white noise's RMS that passes the filter."""
        return float(np.sqrt(np.sum(self.kernel**2)))

    def times(self, t: np.ndarray) -> np.ndarray:
        """The times of the samples that `thin` returns."""
        half = self.kernel.size // 2
        return t[half : t.size - half : self.every]


def _filtered(x: np.ndarray, taps: np.ndarray) -> np.ndarray:
    half = taps.size // 2
    return oaconvolve(np.pad(x, half, mode="reflect", reflect_type="odd"), taps, mode="valid")


def _differentiator(edge: float, dt: float, n: np.ndarray, shape: tuple[float, float]) -> np.ndarray:
    """Derivative of the windowed sinc of `_low_pass`, 1/s."""
    w, t = 2.0 * np.pi * edge, n * dt
    with np.errstate(divide="ignore", invalid="ignore"):
        ideal = np.where(n == 0, 0.0, (w * t * np.cos(w * t) - np.sin(w * t)) / (np.pi * t**2))
    return ideal * dt * np.kaiser(n.size, shape[1])


def _low_pass(edge: float, dt: float, multiple: int = 1, shape: tuple[float, float] = SHORT) -> np.ndarray:
    half = int(np.ceil(shape[0] / (edge * dt * multiple))) * multiple
    return firwin(2 * half + 1, edge, fs=1.0 / dt, window=("kaiser", shape[1]))
