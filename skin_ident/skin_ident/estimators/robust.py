"""Robust loss: spikes that nobody has recognised pull at a fit no more than the noise around them does.

What is minimised is sum rho((r / c s)^2) of the residuals r of the samples as they were measured, before any low-pass has smeared
a spike over its neighbours. rho is named and meant as in scipy's `least_squares`; with it comes the influence of a residual,

    huber     psi(r) = r up to c s, and +- c s beyond
    soft_l1   psi(r) = r / sqrt(1 + (r / c s)^2)
    cauchy    psi(r) = r / (1 + (r / c s)^2)

The first two let every spike pull like a large residual, which spikes to one side add up to an offset; the last forgets the far ones.
s is the noise's standard deviation by the median of |r|, c lets the loss cost 5 % of precision where there are no spikes. Every sample is
replaced by what the fit says plus psi(r), and least squares repeated until nothing changes: where it stops, sum psi(r) h = 0 with the
low-passed columns h, which is the minimum sought. Coefficients move by (H'H)^-1 H' psi / mean(psi'), so that the covariance is the one of
least squares on psi, colour and all, divided by mean(psi')^2 (the sandwich).
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
FAR = 4.0  # standard deviations: a sample further off is counted as held back
ROUNDS = 20
CLOSE = 0.01  # standard errors: a smaller change of every coefficient ends the search


@dataclass(frozen=True, eq=False)
class Tamed:
    """One channel: its samples per session with psi(r) in the place of r; mean of psi'; s, in the channel's unit; samples beyond 4 s."""

    rows: list[np.ndarray]
    slope: float
    scale: float
    beyond: int


def tamed(measured: Sequence[np.ndarray], fitted: Sequence[np.ndarray], believed: Sequence[np.ndarray], loss: str) -> Tamed:
    """The channel's samples (N_s,) per session, each drawn towards what the fit says.

    `believed` (N_s,) says which samples count for the scale. Raises `FitError` for a loss that is not known.
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
    """What a fit says about its loss."""
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
