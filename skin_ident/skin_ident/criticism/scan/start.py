"""The baseline from which a search begins: the thesis's model with a fitted or a declared width, or a given model as it is."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.family import Scale, plain, sizes
from skin_ident.criticism.scan.fitting import Member, fit
from skin_ident.criticism.scan.noise import white
from skin_models.model import Model
from skin_models.signals import motion
from skin_models.spread.kernels import Anisotropic, DepthWidth, Gaussian
from skin_models.spread.noted import kernel_of, spread_width

WIDTHS = 60  # widths of the first grid search
FAR_LESS = 0.1  # share of a plain fit's squared residuals below which what a zero leaves shows that the taxel was not tared
POINTS, RAMP = 2001, 1e4  # samples, and duration in s, of the slow ramp on which a given model is simulated


def plain_start(cells: Cells) -> Member:
    """k z exp(-(r / c)^2) by least squares, one k per scan and one c for all."""
    mean, deepest = cells.depth_span
    d = cells.z / deepest
    reach = float(np.abs(cells.r).max())
    best = min((_linear(cells, d, c) for c in np.geomspace(reach / 50.0, 5.0 * reach, WIDTHS)), key=lambda found: found[0])
    width = best[1]
    m = Member(plain(width), best[2], ("width",), Scale(mean, deepest), _steps(cells, width))
    return fit(m, cells, white(cells).whitener()).member


def zeroed_start(cells: Cells) -> Member:
    """`plain_start`, beside a zero of force where that leaves far less. Without it the curve narrows, or turns over, for a taxel that reads
    far below zero at rest."""
    m, noise = plain_start(cells), white(cells).whitener()
    guess = replace(m.moved(width=float(np.abs(cells.r).max()) / 3.0).freeing("offset"), k=np.full(m.k.size, np.ptp(cells.y)))
    zeroed = fit(guess, cells, noise)
    left = noise.apply(cells.y - m.predict(cells))
    return zeroed.member if zeroed.cost < FAR_LESS * float(left @ left) else m


def declared_start(cells: Cells, width: float) -> Member:
    """k z exp(-(r / c)^2) with a declared width c (m), which is not fitted; one k per scan by least squares."""
    mean, deepest = cells.depth_span
    m = Member(plain(width), _linear(cells, cells.z / deepest, width)[2], (), Scale(mean, deepest), _steps(cells, width))
    return fit(m, cells, white(cells).whitener()).member


def given_start(cells: Cells, model: Model) -> Member:
    """A given model as a member; its level, width and spread are not fitted."""
    mean, deepest = cells.depth_span
    width, kernel = spread_width(model.notes), kernel_of(model.notes)
    values = plain(width)
    if isinstance(kernel, Anisotropic):
        values["ratio"], kernel = float(np.log(kernel.ratio)), kernel.kernel
    if isinstance(kernel, DepthWidth):
        surface = 1.0 + kernel.growth * mean
        values |= {"width": width * surface, "growth": kernel.growth / surface}
        kernel = kernel.kernel
    shape = None if isinstance(kernel, Gaussian) else lambda u: kernel.shape(u * width)
    scale = Scale(mean, deepest, static_law(model, 1.3 * deepest), shape)
    return Member(values, np.ones(int(cells.scan.max()) + 1), (), scale, _steps(cells, width), k_free=False)


def static_law(model: Model, deepest: float) -> Callable[[np.ndarray], np.ndarray]:
    """A function from depth (m) to the force (N) on the model's first taxel right under the plunger, at a ramp so slow that damping does
    not matter."""
    t = np.arange(POINTS) * (RAMP / (POINTS - 1))
    x = np.linspace(0.0, deepest, POINTS)
    felt = model.simulate(motion(t, x)).taxels_truth[0]
    return lambda depth: np.interp(depth, x, felt)


def _linear(cells: Cells, d: np.ndarray, width: float) -> tuple[float, float, np.ndarray]:
    """Sum of squared errors, the width, and the least-squares sizes for that width."""
    s = d * np.exp(-((cells.r / width) ** 2))
    scans = int(cells.scan.max()) + 1
    top, below = (np.bincount(cells.scan, a, scans) for a in (s * cells.y, s * s))
    k = top / np.maximum(below, 1e-300)
    return float(np.sum((cells.y - k[cells.scan] * s) ** 2)), width, k


def _steps(cells: Cells, width: float) -> dict[str, float]:
    return sizes(cells, width) | {"largest": float(cells.y.max())}
