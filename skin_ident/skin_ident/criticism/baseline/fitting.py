"""Joint output-error fit of a model to several sessions.

Minimises the sum of squared whitened residuals over all unknowns by Levenberg–Marquardt in scaled unknowns; bounds are imposed by clipping.
Jacobians are forward differences of the simulation itself, so any composition of effects can be fitted. From step to step they are
corrected rather than computed anew, as long as they predict well.

Source: L. Ljung, System Identification, 2nd ed., 1999, ch. 7 and 10.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from skin_ident.criticism.baseline.residual import residual, simulated_again
from skin_ident.criticism.baseline.unknowns import Unknown, effect_unknowns, lowest, scales, unknowns, values, with_values
from skin_ident.criticism.noise.growth import Growth
from skin_ident.criticism.noise.whitening import Given, Whitener, fit_whitener, stack, with_growth
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import Key
from skin_models.model import Model
from skin_models.parameter import SHAPE

ITERATIONS = 20
STEP = 1e-4  # of finite differences, in scaled unknowns
SINGULAR = 1e-12  # eigenvalue of the correlations of unknowns, up to which a combination of them is not determined at all
NEAR = 0.01  # relative distance to a bound that depends on another unknown, within which the unknown counts as at its bound
PREDICTED = 0.1  # of the squared change of the residual, that slopes may miss and be kept
TOLERANCE = 1e-4  # relative fall of the cost below which a fit has converged


@dataclass(frozen=True)
class Fit:
    """A fitted model: standard errors by label (`std`), `cost` (sum of squared whitened residuals), and the `count` of whitened samples.
    `std_in_shape` are the standard errors of all unknowns but shape parameters, with the shapes held fixed: where only the product of
    amplitude and shape is determined, `std` of the amplitude is large although the effect is certain."""

    model: Model
    unknowns: tuple[Unknown, ...]
    std: dict[str, float]
    cost: float
    count: int
    std_in_shape: dict[str, float] = field(default_factory=dict)

    def score_over(self, before: "Fit") -> float:
        """Score over another fit in the same noise: the gain, i.e. the fall of the cost V, less the charge for k further unknowns,
        dV - dk log n, in squared whitened units (G. Schwarz, Annals of Statistics 6 (1978) 461-464)."""
        charge = np.log(self.count) * (len(self.unknowns) - len(before.unknowns))
        return float(before.cost - self.cost - charge)

    def under(self, noise: Whitener, sessions: list[Session]) -> "Fit":
        """The same model with its cost on these sessions under another noise model."""
        return replace(self, cost=cost_of(self.model, sessions, noise))


def whitened(model: Model, sessions: list[Session], noise: Whitener) -> np.ndarray:
    """The whitened residuals of all sessions as one vector (R,); where they are noise, of unit variance."""
    return np.concatenate([noise.apply(residual(model, s), s).ravel() for s in sessions])


def tangents(model: Model, sessions: list[Session], which: tuple[Unknown, ...]) -> list[np.ndarray]:
    """d(simulated)/d(scaled unknown) in the common band, N, (U, C, n) for each session."""
    theta, scale = values(model, which), scales(model, which)
    at_ceiling = theta + STEP * scale > np.array([u.parameter.upper for u in which])
    steps = STEP * scale * np.where(at_ceiling, -1.0, 1.0)
    moved = [with_values(model, which, theta + step * row) for step, row in zip(steps, np.eye(theta.size), strict=True)]
    changed = [(m, u.place(model)) for m, u in zip(moved, which, strict=True)]

    def of(s: Session) -> np.ndarray:
        base, others = simulated_again(model, changed, s)
        out = np.zeros((len(which), *s.measured.shape))
        for row, y, c, h in zip(out, others, scale, steps, strict=True):
            s.band.thin_changes(y - base, row)
            row *= c / h
        return out

    return [of(s) for s in sessions]


def fit(
    model: Model, sessions: list[Session], noise: Whitener, iterations: int = ITERATIONS, which: tuple[Unknown, ...] | None = None
) -> Fit:
    """Fit the unknowns `which` of `model` (by default all of them), starting from their present values."""
    which = unknowns(model, sessions[0]) if which is None else which
    model, r, slopes = _descended(model, sessions, noise, iterations, which)
    cost, believed = float(r @ r), int(np.count_nonzero(r))
    if not which:
        return Fit(model, (), {}, cost, believed)
    J, scale = slopes or _slopes(model, sessions, noise, which)
    left = max(int(np.count_nonzero(np.any(J != 0.0, axis=1))) - len(which), 1)
    gram, variance = J.T @ J, cost / left
    inside, amounts = _inside(model, which), np.array([u.parameter.role != SHAPE for u in which])
    masks = np.ones(len(which), bool), inside, inside & amounts
    every, within, in_shape = (_standard_errors(gram, variance, scale, which, free) for free in masks)
    return Fit(model, which, every | within, cost, believed, in_shape)


def approached(model: Model, sessions: list[Session], noise: Whitener, iterations: int, which: tuple[Unknown, ...]) -> Model:
    """The model after the first `iterations` of a fit of the unknowns `which`, from which another fit goes on."""
    return _descended(model, sessions, noise, iterations, which)[0]


def noise_of(model: Model, sessions: list[Session], grows: Growth | None = None, mix: np.ndarray | None = None) -> Whitener:
    """The noise model if the whole residual of `model` is taken for noise. Noise grows with the load as `grows` says, or not at all. The
    channels are decorrelated by a given `mix`, or by one fitted here."""
    return fit_whitener([residual(model, s) for s in sessions], sessions, given=Given(grows=grows, mix=mix))


def grown_noise_of(model: Model, sessions: list[Session]) -> Whitener:
    """The same, with the growth under load fitted too, for a model whose residual is nothing but noise."""
    residuals = [residual(model, s) for s in sessions]
    return with_growth(fit_whitener(residuals, sessions), residuals, sessions)


def cost_of(model: Model, sessions: list[Session], noise: Whitener) -> float:
    """The sum of squared whitened residuals of a model as it is, as in `Fit.cost`."""
    r = whitened(model, sessions, noise)
    return float(r @ r)


def fit_effects(model: Model, sessions: list[Session], noise: Whitener, iterations: int = ITERATIONS) -> Fit:
    """Fit the effects of `model` and keep its dispersion parameters and shares."""
    return fit(model, sessions, noise, iterations, tuple(effect_unknowns(model, sessions[0])))


def cost_with_own(model: Model, key: Key, sessions: list[Session], noise: Whitener) -> float:
    """The cost of a model in some sessions, with the unknowns of the cause and place `key` fitted to these, and a charge for each."""
    own = tuple(u for u in effect_unknowns(model, sessions[0]) if model.effects[u.part].key == key)
    there = fit(model, sessions, noise, which=own)
    return float(there.cost + np.log(there.count) * len(own))


def _descended(model, sessions, noise, iterations, which):
    """Descend until the cost r'r has converged; returns (model, r, slopes), with None for slopes that are not known at the end.

    Slopes that predicted a step well are corrected by what the step changed (C. G. Broyden, Mathematics of Computation 19 (1965) 577-593)
    rather than computed anew. Convergence is believed from computed ones alone.
    """
    model = with_values(model, which, values(model, which)) if iterations else model  # within its bounds
    r, damping, slopes, computed = whitened(model, sessions, noise), 1e-3, None, False
    for _ in range(iterations if which else 0):
        if slopes is None:
            slopes, computed = _slopes(model, sessions, noise, which), True
        before, theta, last = float(r @ r), values(model, which), r
        accepted, now, model, r = _descend(model, sessions, noise, which, slopes, r, damping)
        if not accepted or before - float(r @ r) < TOLERANCE * float(r @ r):
            if computed:
                return model, r, slopes  # they hold at the present values
            slopes = None
            continue
        damping = now
        slopes, computed = _corrected(slopes, (values(model, which) - theta) / slopes[1], last, r), False
    return model, r, None


def _corrected(slopes, step, before, after):
    """The slopes (J, scale), corrected by what a step (U,), in scaled unknowns, changed in the whitened residual; None where they did not
    predict that well."""
    J, scale = slopes
    missed = before - after - J @ step
    if float(missed @ missed) > PREDICTED * float((before - after) @ (before - after)):
        return None
    return J + np.outer(missed, step / float(step @ step)), scale


def _slopes(model: Model, sessions: list[Session], noise: Whitener, which: tuple[Unknown, ...]) -> tuple[np.ndarray, np.ndarray]:
    """The whitened Jacobian (R, U) by scaled unknowns, and their scales (U,)."""
    return stack(tangents(model, sessions, which), sessions, noise), scales(model, which)


def _descend(model, sessions, noise, which, slopes, r, damping):
    """Try steps with growing damping until the cost r'r falls; returns (accepted, damping, model, r)."""
    (J, scale), theta = slopes, values(model, which)
    free = unpressed(theta, which, J.T @ r)
    along = sliding(which, scale, free)
    J = J if free.all() else (J @ along)[:, free]
    gram, gradient = J.T @ J, J.T @ r
    for _ in range(8):
        step = np.zeros(theta.size)
        step[free] = np.linalg.lstsq(gram + damping * np.diag(np.diag(gram) + 1e-12), gradient, rcond=None)[0]
        trial = with_values(model, which, theta + along @ np.clip(step, -2.0, 2.0) * scale)
        e = whitened(trial, sessions, noise)
        if float(e @ e) < float(r @ r):  # and is finite
            return True, max(damping / 10.0, 1e-9), trial, e
        damping *= 10.0
    return False, damping, model, r


def unpressed(theta: np.ndarray, which: tuple[Unknown, ...], gradient: np.ndarray) -> np.ndarray:
    """Mask (U,) of the unknowns that are free to move: those not at a bound that their step would cross. `theta` (U,) are the values,
    `gradient` J'r (U,). A bound that depends on another unknown may have moved a little since, hence the tolerance `NEAR`."""
    lower = lowest(which, theta) + NEAR * np.abs([u.parameter.lower if u.beside else 0.0 for u in which])
    upper = np.array([u.parameter.upper for u in which])
    return ~(((theta <= lower) & (gradient < 0)) | ((theta >= upper) & (gradient > 0)))


def sliding(which: tuple[Unknown, ...], scale: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Matrix (U, U), in scaled unknowns, that couples an unknown at a bound on its sum with another one to that other one: where the other
    one moves, it gives way so that the sum stays at the bound."""
    along, labels = np.eye(len(which)), [u.label for u in which]
    for i in np.flatnonzero(~free):
        if which[i].beside:
            j = labels.index(which[i].beside)
            along[i, j] = -scale[j] / scale[i]
    return along


def _inside(model: Model, which: tuple[Unknown, ...]) -> np.ndarray:
    """Mask (U,) of the unknowns within their lower bounds. The others can give way to nothing: damping that may not be less does not make
    up for a delay that is less than it is."""
    theta = values(model, which)
    return theta > lowest(which, theta) + NEAR * np.abs(theta)


def _standard_errors(
    gram: np.ndarray, variance: float, scale: np.ndarray, which: tuple[Unknown, ...], free: np.ndarray
) -> dict[str, float]:
    """Standard errors of the unknowns that are `free`, a mask (U,), with all others held fixed; 0 for those that change nothing. Those that
    only a combination of others tells from none have very large ones, where a pseudoinverse would give none. `gram` (U, U) is J'J, and
    `variance` that of a whitened residual."""
    gram = gram[np.ix_(free, free)]
    norm = np.sqrt(np.diag(gram))
    norm[norm == 0.0] = np.inf
    size, turned = np.linalg.eigh(gram / np.outer(norm, norm))
    std = np.sqrt(variance * np.sum(turned**2 / np.maximum(size, SINGULAR), axis=1)) * scale[free] / norm
    return dict(zip([u.label for u, f in zip(which, free, strict=True) if f], std.tolist(), strict=True))
