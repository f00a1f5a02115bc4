"""A transfer function between two measured forces: estimated in the band of the motion, where the input's own noise does least harm.

Output error takes the input for exact. The load cell is not: its noise, simulated through the model, asks for less gain where there is
nothing but noise, and on a slow motion that pull outweighs what the data say (lead and lag came out at a tenth). So both forces go
through one low-pass first, which leaves a linear relation as it is; what the pull may still come to within the band is added to the
covariance. The rest of that is as in `regression`, with the noise's colour estimated over a wider band: the sensitivities of the simulation
are its columns.
Source: T. Söderström, Automatica 43 (2007) 939, for errors in the input.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.signal import oaconvolve

from skin_ident.estimators.prefilter import Prefilter, low_pass, prefilters_for
from skin_ident.estimators.regression import Block, Regression, regress
from skin_ident.estimators.robust import LINEAR, Tamed
from skin_ident.estimators.robust_output import robustly
from skin_ident.estimators.transfer_data import Pair, lags, through
from skin_ident.estimators.transfer_fit import TransferFit, unweighted
from skin_ident.estimators.transfer_function import TransferFunction, derivatives

BINS = 2000  # of frequency


def fit_in_band(pairs: Sequence[Pair], poles: int, offset: bool, loss: str = LINEAR) -> tuple[TransferFit, Tamed | None]:
    """One zero and `poles` poles over all sessions; `offset` gives each a constant of its own. Raises `FitError`.

    With a loss other than least squares, what became of the output comes with the fit.
    """
    return robustly(pairs, lambda tamed: _fitted(tamed, poles, offset), offset, loss)


def _fitted(pairs: Sequence[Pair], poles: int, offset: bool) -> TransferFit:
    prefilters = prefilters_for([(p.u, p.dt) for p in pairs])
    f, rounds, converged = unweighted([_in_band(p, q) for p, q in zip(pairs, prefilters, strict=True)], 1, poles, offset)
    fit = regress([[_block(p, q, f, offset, i, len(pairs)) for i, (p, q) in enumerate(zip(pairs, prefilters, strict=True))]])
    count = f.theta.size
    pull = fit.inverses[0][-count:, -count:] @ sum(_pull(e.size, q, f, fit) for e, q in zip(fit.residuals[0], prefilters, strict=True))
    covariance = fit.covariance[-count:, -count:] + np.outer(pull, pull) / 3.0  # any share of the noise may be the input's
    measured = [oaconvolve(q.rows(p.y), q.kernel, mode="valid") for p, q in zip(pairs, prefilters, strict=True)]
    return TransferFit(f, covariance, fit.residuals[0], fit.ar[0], fit.noise[0], fit.dof, rounds, converged, measured)


def _pull(rows: int, prefilter: Prefilter, f: TransferFunction, fit: Regression) -> np.ndarray:
    """Half the slope (P,) of what the input's noise adds to the squared error within the band, were all the noise the input's."""
    turns = np.linspace(0.0, np.pi, BINS)
    passed = np.abs(np.exp(-1j * np.outer(turns, np.arange(prefilter.kernel.size))) @ prefilter.kernel) ** 2
    colour = np.abs(1.0 - np.exp(-1j * np.outer(turns, np.arange(1, fit.ar[0].size + 1))) @ fit.ar[0]) ** 2
    s = 1j * turns / (prefilter.dt * prefilter.every)
    top, bottom = np.polyval(f.numerator, s), np.polyval([1.0, *f.denominator], s)
    slopes = [s**i / top for i in reversed(range(len(f.numerator)))] + [-(s**i) / bottom for i in reversed(range(len(f.denominator)))]
    return -rows * np.array([np.mean(passed * fit.noise[0] ** 2 / colour * slope.real) for slope in slopes])


def _in_band(p: Pair, prefilter: Prefilter) -> Pair:
    """The same pair at full rate, without what lies above the band, and without the ends that the low-pass takes."""
    kernel = low_pass(prefilter.edge, p.dt, 1.5)
    return replace(p, u=oaconvolve(p.u, kernel, mode="valid"), y=oaconvolve(p.y, kernel, mode="valid"))


def _block(p: Pair, prefilter: Prefilter, f: TransferFunction, offset: bool, session: int, sessions: int) -> Block:
    """What the simulation leaves of the output, and its sensitivities: a constant for every session, then theta.

    How a session came to rest is over before the low-pass lets anything through.
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
