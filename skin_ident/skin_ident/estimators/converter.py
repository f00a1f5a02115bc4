"""The covariance of a dispersion fit, with the errors that converter steps cause."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import block_diag

from skin_ident.estimators.quantization import amplitudes, covariance_of_steps, noise_of, widest_step
from skin_ident.estimators.regression import Block, Regression
from skin_ident.estimators.sessions import Session


def with_steps(
    sessions: Sequence[Session],
    regression: Regression,
    blocks: list[list[Block]],
    values: list[list[np.ndarray]],
    rows: list[list[np.ndarray]] | None = None,
) -> np.ndarray:
    """The joint covariance of all coefficients. `values[channel][session]` (N,) is the prediction of the fit, N.

    `rows` are the samples that were fitted, where they differ from the recorded ones because a robust loss has drawn spikes in.

    Where the noise of a channel hides its steps, its covariance is that of the regression. Elsewhere, the part of the residual that the
    steps explain is taken out of the noise, and the error that the steps cause in the coefficients is added.
    """
    parts, shares = [], []
    for c, (channel, inverse) in enumerate(zip(blocks, regression.inverses, strict=True)):
        step = widest_step([s.raw[c] for s in sessions])
        fitted = [s.raw[c] for s in sessions] if rows is None else rows[c]
        found = None if step is None else _of_channel(sessions, fitted, channel, inverse, values[c], step)
        own, share = (0.0, 1.0) if found is None else found
        share = share if found is None else share / regression.repeated[c] ** 2
        parts.append(own * np.ones_like(inverse))
        shares.append(np.full(len(inverse), share))
    root = np.sqrt(np.concatenate(shares))
    return regression.covariance * np.outer(root, root) + block_diag(*parts)


def _of_channel(sessions: Sequence[Session], fitted, channel: list[Block], inverse: np.ndarray, values: list[np.ndarray], step: float):
    each = zip(sessions, fitted, values, strict=True)
    left = [(y - value)[s.prefilter.samples(part)] for s, y, value in each for part in s.parts]
    variance = float(np.mean(np.square(np.concatenate(left))))
    if not amplitudes(step, noise_of(variance, step)).size:
        return None
    gains, remaining = [], iter(channel)
    for s, value in zip(sessions, values, strict=True):
        rows = np.zeros((s.taxels.shape[1] if s.force is None else s.force.size, len(inverse)))
        for part in s.parts:
            rows[part] = next(remaining).gain(inverse)
        gains.append(s.prefilter.spread(rows, value.size))
    return covariance_of_steps(gains, values, variance, step)
