"""Intervals by profile likelihood: how far each parameter can go while all others give way and the data stay as likely as chance allows.

Every channel is whitened by its own noise model, rows y = H beta + e. With S the covariance of what is left of all channels together, the
deviance is n log det S, and the interval of a parameter holds the values v for which

    min over all others of  n log det S   -   n log det S at the best   <=   n log(1 + g t^2 / n)

with t Student's quantile for so many samples as the noise's colour leaves independent. g is by how much the noise's variance, with what
the fit has taken out of it put back, exceeds the diagonal of S: 1.01 for white noise, 1.05 for one that remembers a third of a second.
Where shares, differences and offsets bend the likelihood the interval is lopsided, which a standard error cannot be.

The estimate is that of least squares in the band of the motion, and the most likely values are others: by chance as long as the noise is
such as its model says, and by far more where something beside noise is left, bursts or a cause that the model lacks. The interval is that
of the estimate, its ends as far from it as from the most likely value, and whatever makes the estimate's variance larger than the
likelihood's (that chance, converter steps, errors that repeat with the motion, which are in no likelihood) is added to either side.
Source: S. A. Murphy, A. W. van der Vaart, J. Amer. Statist. Assoc. 95 (2000) 449; A. Zellner, ibid. 57 (1962) 348, for the joint channels;
J. A. Hausman, Econometrica 46 (1978) 1251, for the variance of the difference between two estimates.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from skin_ident.estimators.converter import with_steps
from skin_ident.estimators.dispersion import Shape, said, settled, shape_of, theta_of
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.regression import Block, Regression
from skin_ident.estimators.sessions import prepare
from skin_ident.estimators.split import jacobian
from skin_ident.estimators.transfer_data import whitened
from skin_ident.recordings.recording import Recording
from skin_models.signals import Motion

INNER, OUTER = 12, 40  # rounds of letting the others give way, and of looking for the interval's end
CLOSE = 1e-3  # of the way to the end
EXACT = 1e-6  # of what is measured: noise below this is rounding
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
    """Intervals (low, high) about what `fit_dispersion` estimates, by the names of the parameters, SI. Raises `FitError` as that does."""
    sessions, _ = prepare(recordings, motions)
    shape = shape_of(sessions, mass, offsets)
    regression, blocks = settled(sessions, shape)
    to = theta_of(regression, shape)
    beta = np.concatenate(regression.coefficients)
    theta, slope = to(beta), jacobian(to, beta)
    if shape.free and theta[0] < 0.0:  # as the estimate: none
        return profile(recordings, 0.0, motions, offsets=offsets, level=level)
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
    """The products of all whitened rows, and where everything is.

    `products`: the Gram matrix of (H_0, e_0, H_1, e_1, …), where e is what the coefficients `base` leave of y; `widths`: columns of each H;
    `places`: parameters by name in the vector of all that is free: first the zeros of every channel, then m, b1, k1, b2, k2 as far as they
    are free, then all shares but the strongest's.
    """

    products: np.ndarray
    rows: int
    widths: tuple[int, ...]
    places: dict[str, int]
    shape: Shape
    base: list[np.ndarray]

    def start(self, theta: np.ndarray, regression: Regression) -> np.ndarray:
        """All that is free, at the values of least squares."""
        zeros = [c[: self._zeros(i)] for i, c in enumerate(regression.coefficients)]
        return np.concatenate([*zeros, [theta[_index(name, self.shape)] for name in self.places]])

    def _zeros(self, channel: int) -> int:
        return self.widths[channel] - 2 - (self.shape.free and channel == 0)

    def coefficients(self, phi: np.ndarray) -> list[np.ndarray]:
        """What every channel's columns are multiplied by."""
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
        """What takes the model off the measured, for all channels side by side (columns of all, channels)."""
        ends, at = np.zeros((len(self.products), len(self.widths))), 0
        for c, (beta, base) in enumerate(zip(self.coefficients(phi), self.base, strict=True)):
            ends[at : at + beta.size, c], ends[at + beta.size, c] = base - beta, 1.0
            at += beta.size + 1
        return ends

    def deviance(self, phi: np.ndarray) -> float:
        """n log det S."""
        ends = self._ends(phi)
        return self.rows * float(np.linalg.slogdet(self._left(ends))[1])

    def _left(self, ends: np.ndarray) -> np.ndarray:
        """S (channels, channels)."""
        left = ends.T @ self.products @ ends / self.rows
        return left + np.diag(1e-12 * np.diag(left))

    def growth(self, phi: np.ndarray, regression: Regression) -> float:
        """The root of g: standard deviation of the noise, as the regression knows it, over what is left at phi."""
        left = np.diag(self._left(self._ends(phi)))
        return max(1.0, float(np.exp(0.5 * np.mean(np.log(np.square(regression.noise) / left)))))

    def at_its_best(self, phi: np.ndarray, held: int | None) -> np.ndarray:
        """The most likely values while the one at `held` stays."""
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
        """Gauss's normal matrix and the slope, with S as it is at phi."""
        ends = self._ends(phi)
        weight = np.linalg.inv(self._left(ends))
        moves = -jacobian(lambda p: self._ends(p).ravel(), phi).reshape(*ends.shape, phi.size)  # (columns, channels, P)
        left = np.einsum("acp,cd->adp", moves, weight)
        slope = np.einsum("adp,ad->p", left, self.products @ ends)
        return np.einsum("adp,adq->pq", left, np.einsum("ab,bdq->adq", self.products, moves)), slope

    def covariance(self, best: np.ndarray) -> np.ndarray:
        """That of all that is free, as far as the likelihood is a parabola."""
        return np.linalg.pinv(self._normal(best)[0], hermitian=True)

    def end(self, best: np.ndarray, place: int, side: float, quantile: float) -> float:
        """Where the deviance has risen by as much as chance allows; infinite where it never does."""
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
    """Columns and residual rows of one block through its channel's noise model, all channels equally long."""
    rows = whitened(np.column_stack([block.columns, block.y - block.columns @ coefficients]).T, ar).T
    return rows[longest - ar.size :]
