"""Output error under a robust loss: spikes of the output are moved towards the prediction, and the fit is repeated (see `robust`)."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from skin_ident.estimators.robust import CLOSE, LINEAR, ROUNDS, Tamed, tamed
from skin_ident.estimators.transfer_data import Pair
from skin_ident.estimators.transfer_fit import TransferFit


def robustly(
    pairs: Sequence[Pair], fitted: Callable[[Sequence[Pair]], TransferFit], offset: bool, loss: str
) -> tuple[TransferFit, Tamed | None]:
    """The fit that `fitted` makes of the sessions under a loss, with its covariance, and the output as it was fitted (None for least
    squares).

    `offset` fits a constant per session. Raises `FitError`.
    """
    fit, held = fitted(pairs), None
    everything = [np.ones(p.y.size, bool) for p in pairs]
    for _ in range(ROUNDS if loss != LINEAR else 0):
        before = fit.function.theta
        held = tamed([p.y for p in pairs], [_said(p, fit, offset) for p in pairs], everything, loss)
        fit = fitted([replace(p, y=y) for p, y in zip(pairs, held.rows, strict=True)])
        if np.all(np.abs(fit.function.theta - before) <= CLOSE * fit.std):
            break
    return (fit, held) if held is None else (replace(fit, covariance=fit.covariance / held.slope**2), held)


def _said(p: Pair, fit: TransferFit, offset: bool) -> np.ndarray:
    """The predicted output (N,), simulated from rest at the input's first value; with `offset`, plus a constant for the session."""
    y = fit.function.simulate(p.u, p.dt)
    return y + float(np.median(p.y - y)) if offset else y
