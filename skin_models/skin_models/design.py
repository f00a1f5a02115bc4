"""How well a layout locates a contact, and how light a contact it detects, before it is built.

A contact of force F at p gives the readings

    y[i] = F w[i](p) + noise of standard deviation sigma, independent on every taxel,

with w the static shares of `SpreadField`. No unbiased estimate of (p, F) from one sample has a smaller covariance than the inverse of

    J = 1 / sigma^2  sum over i of g[i] g[i]^T,        g = d(F w) / d(p, F)        (Cramér and Rao)

and the estimate of maximum likelihood reaches it when the noise is small; `monte_carlo` shows how small. (The bound is local. Near a
taxel whose neighbours feel little, the mirror place explains the readings as well, and the real error is larger; right on such a taxel
the bound goes to infinity, while the real error stays within the ring of places that explain the readings.) The error is far below the
taxels' pitch where the spread makes neighbours overlap: hyperacuity (thesis sections 2.2.2 and 4.3.3). A pitch far above the spread's
width leaves places between the taxels that only one of them feels, where the position cannot be determined at any force.

Source: S. M. Kay, Fundamentals of Statistical Signal Processing: Estimation Theory, 1993, ch. 3; Detection Theory, 1998, ch. 4.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from skin_models.arrays import numbers
from skin_models.errors import ModelError
from skin_models.layout import A201_AREA, Layout, grid
from skin_models.spread.kernels import Gaussian, Kernel

CELL = 30  # places along the cell between taxels; even, so that its middle is one of them


@dataclass(frozen=True, eq=False)
class Design:
    """A flat patch (in the plane z = const) with its spread and the noise of its taxels.

    `peak` is the share of the force that a taxel of `reference_area` right under the contact feels; `along` names the unknown
    coordinates: "xy", or "x" for a row of taxels, which cannot tell one side from the other.
    """

    layout: Layout
    kernel: Kernel
    noise: float  # N, standard deviation of one taxel's reading
    peak: float = 1.0
    reference_area: float = A201_AREA  # m^2
    along: str = "xy"

    def __post_init__(self) -> None:
        if self.along not in ("x", "xy"):
            raise ModelError(f"a contact is located along x or xy, not {self.along!r}")
        if not 0.0 < self.noise < np.inf:
            raise ModelError(f"the noise of a taxel must be a positive force in N, not {self.noise}")
        if not 0.0 < self.peak <= 1.0:
            raise ModelError(f"a taxel feels a share between 0 and 1 of the force right above it, not {self.peak}")
        if np.ptp(self.layout.positions[:, 2]) > 1e-6:
            raise ModelError("design figures are for flat patches: these taxels are not in one plane")

    def shares(self, position: np.ndarray) -> np.ndarray:
        """w, shape (P, T), for contacts at (P, 2) m. Raises `ModelError` for places of another shape."""
        position = numbers(position, "places of contacts")
        if position.ndim != 2 or position.shape[1] != 2:
            raise ModelError(f"places of contacts must be a (P, 2) array, not one of shape {position.shape}")
        offset = position[:, None, :] - self.layout.positions[None, :, :2]
        return self.peak * self.layout.area / self.reference_area * self.kernel.shape(np.hypot(offset[..., 0], offset[..., 1]))

    def slopes(self, position: np.ndarray) -> np.ndarray:
        """dw/dp, shape (P, T, 2) per m, by central differences of a thousandth of the kernel's half width."""
        step = 1e-3 * self.kernel.reach(0.5)
        position = np.asarray(position, float)
        along = (self.shares(position + step * e) - self.shares(position - step * e) for e in np.eye(2))
        return np.stack(list(along), axis=-1) / (2.0 * step)


def localisation_bound(design: Design, position: np.ndarray, force: float) -> np.ndarray:
    """Smallest root mean square error of the position, (P,) m, of contacts of `force` (N) at (P, 2) m; infinite where it is not determined.

    The force is unknown too and is estimated along with the position.
    """
    n = len(design.along)
    gradient = np.concatenate([force * design.slopes(position)[..., :n], design.shares(position)[..., None]], axis=-1)
    information = np.einsum("pti,ptj->pij", gradient, gradient) / design.noise**2
    return np.sqrt(_position_variance(information, n))


def _position_variance(information: np.ndarray, n: int) -> np.ndarray:
    """Trace of the position's block of the inverse, (P,). Scaled first: metres and newtons differ by orders of magnitude."""
    size = np.sqrt(np.maximum(np.einsum("pii->pi", information), 1e-300))
    scaled = information / size[:, :, None] / size[:, None, :]
    told = np.linalg.cond(scaled) < 1e10
    inverse = np.linalg.inv(np.where(told[:, None, None], scaled, np.eye(n + 1)))
    variance = np.einsum("pii->pi", inverse) / size**2
    return np.where(told, variance[:, :n].sum(axis=1), np.inf)


def detectable_force(design: Design, position: np.ndarray, false_alarm: float = 1e-3, missed: float = 1e-3) -> np.ndarray:
    """Smallest force, (P,) N, that the matched filter at (P, 2) m tells from nothing with these two error probabilities.

        F = sigma (z(1 - false_alarm) + z(1 - missed)) / |w|

    The place is taken as known; searching N places for a contact raises the false alarms N-fold. Raises `ModelError` for values
    that are not probabilities.
    """
    if not (0.0 < false_alarm < 1.0 and 0.0 < missed < 1.0):
        raise ModelError(f"false alarms and misses are probabilities between 0 and 1, not {false_alarm} and {missed}")
    size = np.linalg.norm(design.shares(position), axis=1)
    return design.noise * (norm.isf(false_alarm) + norm.isf(missed)) / np.maximum(size, 1e-300)


def monte_carlo(design: Design, position: np.ndarray, force: float, trials: int, seed: int) -> np.ndarray:
    """Root mean square error, (P,) m, of the estimate of maximum likelihood over `trials` noisy readings at each of (P, 2) m.

    The search starts from the best place of a grid a third of the spread apart, as an estimator without knowledge would. Raises
    `ModelError` for less than one trial.
    """
    if trials < 1:
        raise ModelError(f"an error is measured by one trial or more, not {trials}")
    rng = np.random.default_rng(seed)
    clean = force * design.shares(position)
    start = _search_grid(design)
    errors = np.empty(len(position))
    for i, (place, reading) in enumerate(zip(np.asarray(position, float), clean, strict=True)):
        readings = reading + rng.normal(0.0, design.noise, (trials, len(design.layout)))
        found = _most_likely(design, readings, start)
        errors[i] = np.sqrt(np.mean(np.sum((found - place)[:, : len(design.along)] ** 2, axis=1)))
    return errors


def _search_grid(design: Design) -> np.ndarray:
    """Places where a contact may be: the patch and half a pitch around it."""
    p, step = design.layout.positions[:, :2], design.kernel.reach(0.5) / 3.0
    around = min(design.layout.pitch, 2.0 * design.kernel.reach(0.1)) / 2.0
    axes = [np.arange(p[:, i].min() - around, p[:, i].max() + around + step, step) for i in range(len(design.along))]
    grids = np.meshgrid(*axes)
    y = grids[1].ravel() if len(axes) == 2 else np.full(grids[0].size, p[0, 1])
    return np.column_stack([grids[0].ravel(), y])


def _most_likely(design: Design, readings: np.ndarray, start: np.ndarray, rounds: int = 12) -> np.ndarray:
    """Most likely places (N, 2) of readings (N, T): the force is linear and drops out; damped Gauss-Newton for the place."""
    place = start[np.argmax(_explained(design.shares(start), readings), axis=1)]
    best, damping = _explained_at(design, place, readings), np.full(len(place), 1e-3)
    for _ in range(rounds):
        trial = place + _newton_step(design, place, readings, damping)
        value = _explained_at(design, trial, readings)
        better = value > best
        place, best = np.where(better[:, None], trial, place), np.where(better, value, best)
        damping = np.where(better, damping / 5.0, damping * 5.0)
    return place


def _explained(w: np.ndarray, readings: np.ndarray) -> np.ndarray:
    """Log-likelihood gained by a contact at (G,) places with the best positive force, times 2 sigma^2: (N, G), N^2."""
    return np.maximum(readings @ w.T, 0.0) ** 2 / np.maximum((w**2).sum(axis=1), 1e-300)


def _explained_at(design: Design, place: np.ndarray, readings: np.ndarray) -> np.ndarray:
    w = design.shares(place)
    return np.maximum((readings * w).sum(axis=1), 0.0) ** 2 / np.maximum((w**2).sum(axis=1), 1e-300)


def _newton_step(design: Design, place: np.ndarray, readings: np.ndarray, damping: np.ndarray) -> np.ndarray:
    n, w = len(design.along), design.shares(place)
    force = (readings * w).sum(axis=1) / np.maximum((w**2).sum(axis=1), 1e-300)
    gradient = np.concatenate([force[:, None, None] * design.slopes(place)[..., :n], w[..., None]], axis=-1)
    normal = np.einsum("pti,ptj->pij", gradient, gradient)
    normal += (damping[:, None] * np.einsum("pii->pi", normal) + 1e-30)[:, :, None] * np.eye(n + 1)
    slope = np.einsum("pti,pt->pi", gradient, readings - force[:, None] * w)
    step = np.zeros((len(place), 2))
    step[:, :n] = np.linalg.solve(normal, slope[..., None])[:, :n, 0]
    return np.clip(step, -design.kernel.reach(0.5), design.kernel.reach(0.5))


@dataclass(frozen=True)
class Acuity:
    """What one pitch gives over the cell between the taxels, away from the edges of a patch."""

    pitch: float  # m
    error_median: float  # m, bound on the position
    error_worst: float  # m
    force_worst: float  # N, detectable anywhere


def acuity(width: float, pitches: np.ndarray, force: float, noise: float, peak: float = 1.0, area: float = A201_AREA) -> list[Acuity]:
    """Error and detectable force against the pitch, for a Gaussian spread of `width` (m) under a contact of `force` (N).

    Taxels keep their `area` (m^2), but never more than their cell, and stand in a square grid that reaches four widths around the cell
    looked at. `peak` is the share of a taxel of `area`. Raises `ModelError` for a pitch that is not positive.
    """
    if not all(0.0 < pitch < np.inf for pitch in pitches):
        raise ModelError("every pitch must be a positive length in m")
    return [_acuity(Gaussian(width=width), float(pitch), force, noise, peak, area) for pitch in pitches]


def _acuity(kernel: Gaussian, pitch: float, force: float, noise: float, peak: float, area: float) -> Acuity:
    side = 2 * max(int(np.ceil(4.0 * kernel.width / pitch)), 2)  # even: the middle of the patch is the middle of a cell
    design = Design(grid(side, side, pitch, min(area, pitch**2)), kernel, noise, peak, area)
    u = (np.arange(CELL) / CELL - 0.5) * pitch  # without the far border, which is the near one of the next cell
    cell = np.stack(np.meshgrid(u, u), axis=-1).reshape(-1, 2)
    error = localisation_bound(design, cell, force)
    return Acuity(pitch, float(np.median(error)), float(error.max()), float(detectable_force(design, cell).max()))
