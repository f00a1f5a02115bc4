"""Estimates the noise of a scan from the residual of the richest member of the family, by restricted maximum likelihood.

    -2 log L = log |V| + log |J' V^-1 J| + e' P e        P = V^-1 - V^-1 J (J' V^-1 J)^-1 J' V^-1

J holds the tangents of all excited parameters, so that no cause is taken for noise; V is the covariance described in `whitening`. The
overall scale sigma has a closed form; the other three components are searched one after the other. V is diagonal plus low rank, and is
inverted by Woodbury's identity.

Source: D. A. Harville, Journal of the American Statistical Association 72 (1977) 320-338.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.fitting import Member, by_size, tangents
from skin_ident.criticism.scan.whitening import Noise

HUBER = 2.5  # standard deviations beyond which a residual is downweighted (Huber)
SWEEPS = 2  # through the components, each fitted with the others held
WORTH = 2.0  # fall of -2 log L that a component of the noise must bring to be kept


def white(cells: Cells, sigma: float = 1.0) -> Noise:
    """Independent noise of equal variance, for first fits."""
    zero, one = np.zeros(len(cells)), np.ones(len(cells))
    return Noise(sigma, 0.0, 0.0, 0.0, zero, zero, one, cells.row, cells.column)


@dataclass(frozen=True, eq=False)
class Estimated:
    """A noise, -2 log of its restricted likelihood, and the residual (N,) of the richest member over its standard deviation."""

    noise: Noise
    deviance: float
    left: np.ndarray
    spare: int  # residual degrees of freedom: cells less independent tangents


def estimate(m: Member, cells: Cells, rich: tuple[str, ...], floor: float, placing: bool = True) -> Estimated:
    """The noise of the residual of `m`, with its tangents by the parameters `rich` and the sizes projected out; sigma is at least `floor`
    (N). With `placing` False all distances are taken as exact."""
    J = _independent(np.hstack([tangents(m, cells, rich), by_size(m, cells)]))
    e = cells.y - m.predict(cells)
    start = replace(white(cells), slope=slope_of(m, cells), through=m.through(cells))
    found = _search(start, J, e, cells, placing)
    deviance, sigma = _deviance(found, J, e)
    noise = replace(found, sigma=sigma, relative=sigma * found.relative, placing=sigma * found.placing, repeat=sigma * found.repeat)
    noise = replace(noise, sigma=max(sigma, floor))
    left = _left(noise, J, e)
    weight = np.minimum(1.0, HUBER / np.maximum(np.abs(left), 1e-9))
    return Estimated(replace(noise, weight=weight), deviance, left, J.shape[0] - J.shape[1])


def slope_of(m: Member, cells: Cells) -> np.ndarray:
    """d force / d distance of every cell, N/m."""
    h = 1e-3 * m.values["width"]
    ahead, behind = (m.through(replace(cells, r=cells.r + d)) for d in (h, -h))
    return (ahead - behind) / (2.0 * h)


def _search(n: Noise, J: np.ndarray, e: np.ndarray, cells: Cells, placing: bool) -> Noise:
    """`n` with the likeliest ratios of relative, placing and repeat to sigma. A component that gains less than WORTH is zero."""
    typical = {"relative": n.through, "placing": n.slope, "repeat": n.through}
    groups = {"relative": 4, "placing": np.unique(cells.column).size, "repeat": np.unique(cells.row).size}
    able = [c for c in typical if groups[c] >= 4 and np.any(typical[c]) and (placing or c != "placing")]
    best = _deviance(n, J, e)[0]
    for _ in range(SWEEPS):
        for name in able:
            n, best = _component(n, name, 1.0 / float(np.sqrt(np.mean(typical[name] ** 2))), best, J, e)
    return n


def _component(n: Noise, name: str, unit: float, best: float, J: np.ndarray, e: np.ndarray) -> tuple[Noise, float]:
    def cost(x: float) -> float:
        return _deviance(replace(n, **{name: unit * np.exp(x)}), J, e)[0]

    found = minimize_scalar(cost, bounds=(-4.0, 3.0), method="bounded", options={"xatol": 0.15})
    without = _deviance(replace(n, **{name: 0.0}), J, e)[0] if getattr(n, name) else best
    if found.fun < without - WORTH:
        return replace(n, **{name: float(unit * np.exp(found.x))}), float(found.fun)
    return replace(n, **{name: 0.0}), without


def _deviance(n: Noise, J: np.ndarray, e: np.ndarray) -> tuple[float, float]:
    """-2 log L maximised over the overall scale, and that scale; `n` has sigma = 1 and its other components relative to it."""
    _, inverse, log_det = _inverse(n)
    VJ, Ve = inverse(J), inverse(e)
    G = J.T @ VJ
    g = VJ.T @ e
    spare = J.shape[0] - J.shape[1]
    square = max(float(e @ Ve - g @ np.linalg.solve(G, g)), 1e-300)
    log_g = float(np.linalg.slogdet(G)[1])
    return spare * np.log(square / spare) + log_det + log_g, float(np.sqrt(square / spare))


def _inverse(n: Noise) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray], float]:
    """The cells' independent variances (N,), the function that applies V^-1, and log |V|."""
    v, U = n.variance(), n.shared()
    if U.shape[1] == 0:
        return v, lambda x: (x.T / v).T, float(np.log(v).sum())
    W = U / v[:, None]
    middle = np.eye(U.shape[1]) + U.T @ W
    solved = np.linalg.solve(middle, W.T)
    return v, lambda x: (x.T / v).T - W @ (solved @ x), float(np.log(v).sum() + np.linalg.slogdet(middle)[1])


def _left(n: Noise, J: np.ndarray, e: np.ndarray) -> np.ndarray:
    """Residual (N,) with the tangents J projected out and the estimated row and column errors subtracted, over each cell's own standard
    deviation."""
    _, inverse, _ = _inverse(n)
    VJ = inverse(J)
    rest = e - J @ np.linalg.solve(J.T @ VJ, VJ.T @ e)
    own = n.variance() * inverse(rest)  # equals the residual less the best estimate of the row and column errors
    return own / np.sqrt(n.variance())


def _independent(J: np.ndarray) -> np.ndarray:
    """An orthonormal basis of the column space of J, without nearly dependent directions."""
    scaled = J / np.maximum(np.linalg.norm(J, axis=0), 1e-300)
    u, s, _ = np.linalg.svd(scaled, full_matrices=False)
    return u[:, s > 1e-4 * s[0]]
