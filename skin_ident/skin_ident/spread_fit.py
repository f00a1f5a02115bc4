"""Fits the general Gaussian to a static spread scan, as the thesis does in section 4.3.4.

    f(x) = a exp(-((x - b) / c)^2)

A scan runs from the taxel's centre outwards on one side. It is mirrored about the centre, the sample at the centre counted once, and
fitted by least squares; R^2 = 1 - SSE / SST with SST about the mean of the mirrored samples. (With the centre counted twice, one side
alone, or R^2 adjusted for the parameters, the digits of Table 4-8 do not come out.)

All readings of a scan come from one taxel, with one converter step and one noise. Their variances are equal, noise^2 + step^2 / 12, so
equal weights are right. That variance also bounds the standard errors from below. (An alternative was tried: the likelihood of each reading
as an interval of one step. Over 480 fits of 2 to 75 steps it reduced the rms error of c by a seventh without noise, and not at all from
0.15 step of noise on, where its intervals were too narrow: they covered the truth in only 90 %.)
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.special import stdtrit

from skin_ident.spread_scan import SpreadScan, SpreadScanError


@dataclass(frozen=True)
class GaussianFit:
    """Result for one depth. `reason` is empty, or says why there is no fit; the numbers are NaN then."""

    a: float  # N, force at the centre
    b: float  # m, centre
    c: float  # m, width
    r2: float
    a_std: float  # standard errors from the residuals of the samples before mirroring; they take the noise as white
    b_std: float
    c_std: float
    samples: int  # that were fitted, mirrored ones included
    reason: str = ""
    dof: int = 1  # degrees of freedom: independent samples less fitted parameters

    def half_width(self, name: str, level: float = 0.95) -> float:
        """Half width of the confidence interval of a, b or c, by Student's t, because a scan has only about a dozen samples."""
        return float(stdtrit(self.dof, 0.5 + level / 2)) * getattr(self, f"{name}_std")

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """The fitted force at positions `x` (m), N."""
        return self.a * np.exp(-(((np.asarray(x) - self.b) / self.c) ** 2))


def mirrored(distance: np.ndarray, force: np.ndarray, centre: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Positions and forces of a one-sided scan and its mirror image about `centre`; a sample at distance 0 is counted once.

    Raises `SpreadScanError` for distances on both sides: such a scan needs no mirror.
    """
    distance, force = np.asarray(distance, float), np.asarray(force, float)
    if np.any(distance < 0.0):
        raise SpreadScanError("a scan with distances on both sides of the centre is not mirrored: fit it with mirror=False")
    off = distance > 0.0
    return np.r_[centre - distance[off][::-1], centre + distance], np.r_[force[off][::-1], force]


def fit_gaussian(
    distance: np.ndarray,
    force: np.ndarray,
    centre: float = 0.0,
    free_centre: bool = False,
    mirror: bool = True,
    step: float = 0.0,
    noise: float = 0.0,
) -> GaussianFit:
    """Least-squares fit of (R,) forces (N) at (R,) distances (m); NaN forces are left out.

    `centre` is b (12 mm in the thesis's coordinates); `free_centre` fits it. `mirror` reflects a one-sided scan. `step` (N) of the
    converter and `noise` (N, standard deviation) are as declared: the variance of a reading is taken to be at least noise^2 + step^2 / 12,
    however well a few readings on a grid may fit.
    """
    distance, force = np.asarray(distance, float), np.asarray(force, float)
    known = np.isfinite(force)
    distance, force = distance[known], force[known]
    x, y = mirrored(distance, force, centre) if mirror else (distance + centre, force)
    if force.size < 3:
        return _no_fit(x.size, "fewer than 3 forces")
    start = _start(x, y, centre)
    if start is None:
        return _no_fit(x.size, "the force does not fall with distance: nothing but noise reaches the taxel")
    return _refine(x, y, start, free_centre, force.size, noise**2 + step**2 / 12.0)


def fit_spread(scan: SpreadScan, **options) -> tuple[GaussianFit, ...]:
    """A fit for every depth of a scan; `options` as for `fit_gaussian`. A scan with negative distances is not mirrored."""
    options = {"mirror": bool(np.all(scan.distance >= 0.0)), **options}
    return tuple(fit_gaussian(scan.distance, force, **options) for force in scan.force)


def _no_fit(samples: int, reason: str) -> GaussianFit:
    nan = float("nan")
    return GaussianFit(nan, nan, nan, nan, nan, nan, nan, samples, reason)


def _start(x: np.ndarray, y: np.ndarray, centre: float) -> np.ndarray | None:
    """The best (a, b, c) on a grid of widths c, with a by linear least squares; None where the widest is the best, or a is not positive."""
    span = np.ptp(x)
    widths = np.geomspace(span / 50.0, 5.0 * span, 60)
    shapes = np.exp(-(((x - centre) / widths[:, None]) ** 2))
    heights = shapes @ y / np.sum(shapes**2, axis=1)
    errors = np.sum((y - heights[:, None] * shapes) ** 2, axis=1)
    best = int(np.argmin(errors))
    return None if best == widths.size - 1 or heights[best] <= 0.0 else np.array([heights[best], centre, widths[best]])


def _refine(x: np.ndarray, y: np.ndarray, start: np.ndarray, free_centre: bool, independent: int, least: float) -> GaussianFit:
    free = np.array([True, free_centre, True])

    def residual(p: np.ndarray) -> np.ndarray:
        a, b, c = _filled(start, free, p)
        return a * np.exp(-(((x - b) / c) ** 2)) - y

    found = least_squares(residual, start[free], x_scale=np.maximum(np.abs(start[free]), 1e-3), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    a, b, c = _filled(start, free, found.x)
    sse = 2.0 * found.cost
    std = np.zeros(3)
    std[free] = _standard_errors(found.jac, sse / x.size, independent, least)
    r2 = 1.0 - sse / np.sum((y - y.mean()) ** 2)
    return GaussianFit(float(a), float(b), float(abs(c)), float(r2), *map(float, std), x.size, dof=max(1, independent - int(free.sum())))


def _filled(start: np.ndarray, free: np.ndarray, p: np.ndarray) -> np.ndarray:
    full = start.copy()
    full[free] = p
    return full


def _standard_errors(jacobian: np.ndarray, mean_square: float, independent: int, least: float) -> np.ndarray:
    """Standard errors of the fitted parameters. Mirrored samples add no information, so they are those of the `independent` samples before
    mirroring, with a variance of at least `least`."""
    n, k = jacobian.shape
    variance = max(mean_square * independent / max(independent - k, 1), least)
    return np.sqrt(np.diag(np.linalg.pinv(jacobian.T @ jacobian)) * variance * n / independent)
