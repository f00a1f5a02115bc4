"""Robust loss: limits the influence of spikes that telemetry has not recognised.

The fit minimises sum rho((r / c s)^2) over the residuals r of the samples as measured, before any low-pass smears a spike over its
neighbours. rho has the names and definitions of scipy's `least_squares`. Its derivative is the influence of a residual,

    huber     psi(r) = r up to c s, and +- c s beyond
    soft_l1   psi(r) = r / sqrt(1 + (r / c s)^2)
    cauchy    psi(r) = r / (1 + (r / c s)^2)

With the first two, every spike has the influence of a large residual, and spikes to one side add up to an offset; with the last, far spikes
have hardly any influence. s is the standard deviation of the noise, from the median of |r|. c is chosen so that the loss costs 5 % of
precision where there are no spikes.

Every sample is replaced by the prediction of the fit plus psi(r), and least squares is repeated until nothing changes. Then
sum psi(r) h = 0 with the low-passed columns h, which is the minimum. Coefficients move by (H'H)^-1 H' psi / mean(psi'). So their
covariance is that of least squares on psi (including its colour), divided by mean(psi')^2 (the sandwich).
Source: P. J. Huber, Robust Statistics, Wiley 1981, sections 7.6 to 7.8 (modified residuals).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.scale import normal_scale

LINEAR, HUBER, SOFT_L1, CAUCHY = "linear", "huber", "soft_l1", "cauchy"
LOSSES = (LINEAR, HUBER, SOFT_L1, CAUCHY)
TUNING = {HUBER: 1.345, SOFT_L1: 1.287, CAUCHY: 2.385}
FAR = 4.0  # standard deviations: samples with larger residuals are counted as held back
ROUNDS = 20  # at most
CLOSE = 0.01  # standard errors: the iteration ends when every coefficient changes by less


@dataclass(frozen=True, eq=False)
class Tamed:
    """One channel: its samples per session with r replaced by psi(r); the mean of psi'; s, in the channel's unit; the number of samples
    with |r| above FAR s."""

    rows: list[np.ndarray]
    slope: float
    scale: float
    beyond: int


def tamed(measured: Sequence[np.ndarray], fitted: Sequence[np.ndarray], believed: Sequence[np.ndarray], loss: str) -> Tamed:
    """The channel's samples (N_s,) per session, each moved towards the prediction of the fit.

    `believed` (N_s,) masks the trusted samples, from which the scale is estimated. Raises `FitError` for an unknown loss.
    """
    if loss not in TUNING:
        raise FitError(f"the loss is one of {', '.join(LOSSES)}, not {loss!r}")
    left = [y - f for y, f in zip(measured, fitted, strict=True)]
    some = np.concatenate([e[b] for e, b in zip(left, believed, strict=True)])
    scale = normal_scale(some)
    limit = TUNING[loss] * scale
    if limit == 0.0:  # exact data: nothing to weigh against
        return Tamed(list(measured), 1.0, 0.0, 0)
    rows = [f + _influence(e, limit, loss) for e, f in zip(left, fitted, strict=True)]
    return Tamed(rows, float(np.mean(_slope(some, limit, loss))), scale, int(np.sum(np.abs(some) > FAR * scale)))


def noted(loss: str, channels: Mapping[str, Tamed]) -> dict[str, object]:
    """The entry on the loss for the notes of a fit; empty for least squares."""
    each = {name: {"scale": t.scale, "held_back": t.beyond, "mean_slope": t.slope} for name, t in channels.items()}
    return {} if loss == LINEAR else {"loss": {"name": loss, "channels": each}}


def _influence(r: np.ndarray, limit: float, loss: str) -> np.ndarray:
    if loss == HUBER:
        return np.clip(r, -limit, limit)
    return r * (1.0 + (r / limit) ** 2) ** (-0.5 if loss == SOFT_L1 else -1.0)


def _slope(r: np.ndarray, limit: float, loss: str) -> np.ndarray:
    z = (r / limit) ** 2
    if loss == HUBER:
        return (z <= 1.0).astype(float)
    return (1.0 + z) ** -1.5 if loss == SOFT_L1 else (1.0 - z) / (1.0 + z) ** 2
