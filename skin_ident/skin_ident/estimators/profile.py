"""Confidence intervals by profile likelihood: the range over which a parameter can vary, with all others refitted, while the likelihood
does not fall by more than chance allows.

Every channel is whitened by its own noise model; its rows are y = H beta + e. With S the covariance of the residuals of all channels
together, the deviance is n log det S. The interval of a parameter holds the values v for which

    min over all others of  n log det S   -   n log det S at the best   <=   n log(1 + g t^2 / n)

Here t is Student's quantile for the effective number of independent samples. g corrects for the noise that the fit has absorbed: the
variance of the noise, corrected for that, over the diagonal of S (1.01 for white noise, 1.05 for noise correlated over a third of a
second). Shares, differences and offsets make the likelihood asymmetric, and the interval with it, which a standard error cannot show.

The estimate is that of least squares in the band of the motion, which differs from the most likely values: by chance as long as the noise
follows its model, and by far more where the residual is more than noise (bursts, or a cause that the model lacks). The interval is placed
about the estimate, with its ends as far from it as they are from the most likely value. Where the variance of the estimate is larger than
that of the likelihood (by that chance, by converter steps, or by errors that repeat with the motion, which no likelihood contains), the
difference is added on either side.
Source: S. A. Murphy, A. W. van der Vaart, J. Amer. Statist. Assoc. 95 (2000) 449; A. Zellner, ibid. 57 (1962) 348, for the joint channels;
J. A. Hausman, Econometrica 46 (1978) 1251, for the variance of the difference between two estimates.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from skin_ident.estimators.converter import with_steps
from skin_ident.estimators.dispersion import Shape, said, shape_of, theta_of, within_bounds
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.regression import Block, Regression
from skin_ident.estimators.sessions import prepare
from skin_ident.estimators.split import jacobian
from skin_ident.estimators.transfer_data import whitened
from skin_ident.recordings.recording import Recording
from skin_models.signals import Motion

INNER, OUTER = 12, 40  # most iterations for refitting the other parameters, and for finding the end of an interval
CLOSE = 1e-3  # relative tolerance of the root of the deviance at the end of an interval
EXACT = 1e-6  # share of a channel's rms below which its noise is only rounding
DISPERSION = ("m", "b1", "k1", "b2", "k2")


Intervals = dict[str, tuple[float, float]]


def profile(
    recordings: Sequence[Recording],
    mass: float | str = 0.0,
    motions: Sequence[Motion] | None = None,
    *,
    offsets: bool = False,
    level: float = 0.95,
) -> Intervals:
    """Intervals (low, high) about the estimates of `fit_dispersion`, by parameter, SI. Raises `FitError` as that does, and for data
    without noise."""
    sessions, _ = prepare(recordings, motions)
    shape, _, (regression, blocks), _ = within_bounds(sessions, shape_of(sessions, mass, offsets))
    to = theta_of(regression, shape)
    beta = np.concatenate(regression.coefficients)
    theta, slope = to(beta), jacobian(to, beta)
    if any(noise <= EXACT * np.sqrt(np.mean(np.square(np.concatenate(y)))) for noise, y in _noise_and_rows(regression)):
        raise FitError("these data are exact, or nearly so: without noise there is no likelihood; leave --profile out")
    likelihood = _likelihood(blocks, regression, shape, theta)
    best = likelihood.at_its_best(likelihood.start(theta, regression), None)
    quantile, grown = float(stdtrit(regression.dof, 0.5 + level / 2)), likelihood.growth(best, regression)
    known = with_steps(sessions, regression, blocks, said(sessions, shape, regression))
    variance, likely = np.diag(slope @ known @ slope.T), grown**2 * np.diag(likelihood.covariance(best))
    found = {}
    for name, place in likelihood.places.items():
        estimate, more = theta[_index(name, shape)], max(0.0, variance[_index(name, shape)] - likely[place])
        far = [abs(likelihood.end(best, place, side, quantile * grown) - best[place]) for side in (-1.0, 1.0)]
        low, high = np.hypot(far, quantile * np.sqrt(more))
        found[name] = (float(estimate - low), float(estimate + high))
    return found


def _noise_and_rows(regression: Regression):
    return zip(regression.noise, regression.measured, strict=True)


def _index(name: str, shape: Shape) -> int:
    return DISPERSION.index(name) if name in DISPERSION else 5 + shape.live.index(int(name.removeprefix("share_")))


@dataclass(frozen=True, eq=False)
class Likelihood:
    """The likelihood of all whitened rows, by their Gram matrix.

    `products`: the Gram matrix of (H_0, e_0, H_1, e_1, …), where e is the residual of y with the coefficients `base`; `widths`: number of
    columns of each H; `places`: indices of the parameters in the vector phi of all free ones, which holds first the zero offsets of every
    channel, then m, b1, k1, b2, k2 as far as they are free, then all shares but the strongest.
    """

    products: np.ndarray
    rows: int
    widths: tuple[int, ...]
    places: dict[str, int]
    shape: Shape
    base: list[np.ndarray]

    def start(self, theta: np.ndarray, regression: Regression) -> np.ndarray:
        """The vector phi of all free parameters, at the values of least squares."""
        zeros = [c[: self._zeros(i)] for i, c in enumerate(regression.coefficients)]
        return np.concatenate([*zeros, [theta[_index(name, self.shape)] for name in self.places]])

    def _zeros(self, channel: int) -> int:
        return self.widths[channel] - 2 - (self.shape.free and channel == 0)

    def coefficients(self, phi: np.ndarray) -> list[np.ndarray]:
        """The coefficients of every channel's columns for the parameters phi."""
        v = {name: phi[at] for name, at in self.places.items()}
        first, out, used = np.array([v["b1"], v["k1"]]), [], 0
        rest = np.array([v.get("b2", 0.0), v.get("k2", 0.0)])
        for channel in range(len(self.widths)):
            taxel, zeros = channel - self.shape.force, self._zeros(channel)
            pair = first + rest if taxel < 0 else first * v.get(f"share_{self.shape.live[taxel]}", 1.0)
            mass = [v["m"]] if self.shape.free and taxel < 0 else []
            out.append(np.concatenate([phi[used : used + zeros], mass, pair]))
            used += zeros
        return out

    def _ends(self, phi: np.ndarray) -> np.ndarray:
        """A matrix (columns of all channels, channels) by which the stacked rows (H_0, e_0, …) give the residuals of all channels."""
        ends, at = np.zeros((len(self.products), len(self.widths))), 0
        for c, (beta, base) in enumerate(zip(self.coefficients(phi), self.base, strict=True)):
            ends[at : at + beta.size, c], ends[at + beta.size, c] = base - beta, 1.0
            at += beta.size + 1
        return ends

    def deviance(self, phi: np.ndarray) -> float:
        """The deviance n log det S."""
        ends = self._ends(phi)
        return self.rows * float(np.linalg.slogdet(self._left(ends))[1])

    def _left(self, ends: np.ndarray) -> np.ndarray:
        """The residual covariance S (channels, channels)."""
        left = ends.T @ self.products @ ends / self.rows
        return left + np.diag(1e-12 * np.diag(left))

    def growth(self, phi: np.ndarray, regression: Regression) -> float:
        """The root of g, at least 1: the standard deviation of the noise by the regression over that of the residual at phi."""
        left = np.diag(self._left(self._ends(phi)))
        return max(1.0, float(np.exp(0.5 * np.mean(np.log(np.square(regression.noise) / left)))))

    def at_its_best(self, phi: np.ndarray, held: int | None) -> np.ndarray:
        """The most likely values with the parameter at index `held` fixed (None: with all free)."""
        free = np.array([i for i in range(phi.size) if i != held])
        for _ in range(INNER):
            normal, slope = self._normal(phi)
            scale = np.sqrt(np.diag(normal)[free])
            step = np.linalg.lstsq(normal[np.ix_(free, free)] / np.outer(scale, scale), slope[free] / scale, rcond=1e-13)[0]
            phi = phi.copy()
            phi[free] += step / scale
            if np.max(np.abs(step)) < 1e-4:  # standard errors
                break
        return phi

    def _normal(self, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The Gauss-Newton normal matrix and gradient at phi, with S taken as constant."""
        ends = self._ends(phi)
        weight = np.linalg.inv(self._left(ends))
        moves = -jacobian(lambda p: self._ends(p).ravel(), phi).reshape(*ends.shape, phi.size)  # (columns, channels, P)
        left = np.einsum("acp,cd->adp", moves, weight)
        slope = np.einsum("adp,ad->p", left, self.products @ ends)
        return np.einsum("adp,adq->pq", left, np.einsum("ab,bdq->adq", self.products, moves)), slope

    def covariance(self, best: np.ndarray) -> np.ndarray:
        """The covariance of all free parameters, in the quadratic approximation of the likelihood."""
        return np.linalg.pinv(self._normal(best)[0], hermitian=True)

    def end(self, best: np.ndarray, place: int, side: float, quantile: float) -> float:
        """The value of a parameter, to one `side` of the best, at which the deviance has risen by as much as chance allows; infinite where
        it never does."""
        spread = self.covariance(best)[:, place]
        lowest, n = self.deviance(best), self.rows
        wanted = np.sqrt(n * np.log1p(quantile**2 / n))
        unit = np.sqrt(max(spread[place], 1e-300))
        far = quantile
        for _ in range(OUTER):
            phi = self.at_its_best(best + side * far * spread / unit, place)
            risen = np.sqrt(max(0.0, self.deviance(phi) - lowest))
            if abs(risen - wanted) < CLOSE * wanted:
                return float(phi[place])
            far *= float(np.clip(wanted / max(risen, 1e-9), 0.3, 3.0))
            if far > 1e4 * quantile:
                break
        return side * float("inf")


def _likelihood(blocks: list[list[Block]], regression: Regression, shape: Shape, theta: np.ndarray) -> Likelihood:
    longest = max(a.size for a in regression.ar)
    each = zip(blocks, regression.coefficients, regression.ar, strict=True)
    stacked = [np.concatenate([_white(block, c, ar, longest) for block in channel]) for channel, c, ar in each]
    scaled = np.concatenate(stacked, axis=1)
    widths = tuple(len(p) for p in regression.inverses)
    strongest = int(np.argmax(theta[5:])) if shape.taxels else 0
    names = [*(["m"] if shape.free else []), "b1", "k1", *(["b2", "k2"] if shape.force and shape.taxels else [])]
    names += [f"share_{i}" for place, i in enumerate(shape.live) if place != strongest]
    begin = sum(widths) - 2 * len(widths) - shape.free
    places = {name: begin + i for i, name in enumerate(names)}
    return Likelihood(scaled.T @ scaled, len(scaled), widths, places, shape, regression.coefficients)


def _white(block: Block, coefficients: np.ndarray, ar: np.ndarray, longest: int) -> np.ndarray:
    """Columns and residual of one block, whitened by its channel's noise model and cut so that all channels are equally long."""
    rows = whitened(np.column_stack([block.columns, block.y - block.columns @ coefficients]).T, ar).T
    return rows[longest - ar.size :]
