"""A transfer function between two measured forces, estimated in the band of the motion, where noise of the input does least harm.

The output error method treats the input as exact, but the load cell has noise. Simulated through the model, that noise asks for less gain
at frequencies where there is nothing but noise. On a slow motion this bias outweighs the data (lead and lag came out at a tenth). So both
forces pass the same low-pass first, which does not change a linear relation. The bias that may remain within the band is added to the
covariance. The rest of the covariance is computed as in `regression`, with the colour of the noise estimated over a wider band; the
sensitivities of the simulation are the regressors.
Source: T. Söderström, Automatica 43 (2007) 939, for errors in the input.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.prefilter import Prefilter, low_pass, prefilters_for, valid
from skin_ident.estimators.regression import Block, Regression, regress
from skin_ident.estimators.robust import LINEAR, Tamed
from skin_ident.estimators.robust_output import robustly
from skin_ident.estimators.sessions import NO_STRETCH
from skin_ident.estimators.transfer_data import Pair, lags, through
from skin_ident.estimators.transfer_fit import TransferFit, unweighted
from skin_ident.estimators.transfer_function import TransferFunction, derivatives

BINS = 2000  # frequencies of numerical integrals


def fit_in_band(pairs: Sequence[Pair], poles: int, offset: bool, loss: str = LINEAR) -> tuple[TransferFit, Tamed | None]:
    """A transfer function with one zero and `poles` poles, fitted to all sessions; `offset` fits a constant per session. Raises `FitError`.

    With a loss other than least squares, the output as it was fitted (see `Tamed`) is returned too, else None.
    """
    return robustly(pairs, lambda tamed: _fitted(tamed, poles, offset), offset, loss)


def _fitted(pairs: Sequence[Pair], poles: int, offset: bool) -> TransferFit:
    prefilters = prefilters_for([(p.u, p.dt) for p in pairs])
    short = [p.name for p, q in zip(pairs, prefilters, strict=True) if q.rows(p.u).size < q.fewest]
    if short:
        raise FitError(f"{short[0]}: {NO_STRETCH} in the band of all sessions together; leave it out, or fit it by itself")
    f, rounds, converged = unweighted([_in_band(p, q) for p, q in zip(pairs, prefilters, strict=True)], 1, poles, offset)
    fit = regress([[_block(p, q, f, offset, i, len(pairs)) for i, (p, q) in enumerate(zip(pairs, prefilters, strict=True))]])
    count = f.theta.size
    pull = fit.inverses[0][-count:, -count:] @ sum(_pull(e.size, q, f, fit) for e, q in zip(fit.residuals[0], prefilters, strict=True))
    covariance = fit.covariance[-count:, -count:] + np.outer(pull, pull) / 3.0  # variance of a bias whose share (0 to 1) is unknown
    measured = [valid(q.rows(p.y), q.kernel) for p, q in zip(pairs, prefilters, strict=True)]
    return TransferFit(f, covariance, fit.residuals[0], fit.ar[0], fit.noise[0], fit.dof, rounds, converged, measured)


def _pull(rows: int, prefilter: Prefilter, f: TransferFunction, fit: Regression) -> np.ndarray:
    """Half the gradient (P,) by theta of what noise of the input adds to the squared error in the band, if all noise were the input's."""
    turns = np.linspace(0.0, np.pi, BINS)
    passed = np.abs(np.exp(-1j * np.outer(turns, np.arange(prefilter.kernel.size))) @ prefilter.kernel) ** 2
    colour = np.abs(1.0 - np.exp(-1j * np.outer(turns, np.arange(1, fit.ar[0].size + 1))) @ fit.ar[0]) ** 2
    s = 1j * turns / (prefilter.dt * prefilter.every)
    top, bottom = np.polyval(f.numerator, s), np.polyval([1.0, *f.denominator], s)
    slopes = [s**i / top for i in reversed(range(len(f.numerator)))] + [-(s**i) / bottom for i in reversed(range(len(f.denominator)))]
    return -rows * np.array([np.mean(passed * fit.noise[0] ** 2 / colour * slope.real) for slope in slopes])


def _in_band(p: Pair, prefilter: Prefilter) -> Pair:
    """The pair through the low-pass of the band, at full rate, without the ends that the filter spoils."""
    kernel = low_pass(prefilter.edge, p.dt, 1.5)
    return replace(p, u=valid(p.u, kernel), y=valid(p.y, kernel))


def _block(p: Pair, prefilter: Prefilter, f: TransferFunction, offset: bool, session: int, sessions: int) -> Block:
    """The residual of the simulation, with its sensitivities as columns: (one constant per session,) then theta.

    The transient from the unknown initial state needs no column: it has died out before the low-pass yields its first sample.
    """
    model, slopes = _sensitivities(f, p)
    constants = np.zeros((sessions * offset, p.u.size))
    constants[session : session + offset] = 1.0
    return Block(prefilter.rows(p.y - model), prefilter.rows(np.concatenate([constants, slopes])).T, prefilter.kernel)


def _sensitivities(f: TransferFunction, p: Pair) -> tuple[np.ndarray, np.ndarray]:
    """The simulated output (N,) and its derivatives (P, N) with respect to theta."""
    num, den, d_num, d_den = derivatives(f, p.dt)
    k, n = den.size, p.u.size
    of_u = lags(through(p.u, den, k - 1), k, n)
    model = num @ of_u
    of_y = lags(through(model, den, k - 1), k, n)[1:]
    return model, d_num @ of_u - d_den[:, 1:] @ of_y
