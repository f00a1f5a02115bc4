"""The generalised Maxwell element: a spring, a dashpot and any number of Maxwell arms in parallel.

    G(t) = k + b delta(t) + sum_i k_i exp(-t / tau_i)

Its creep follows from the zeros of the impedance Z(s) = k + b s + sum_i k_i tau_i s / (1 + tau_i s). They lie on the negative real axis and
separate its poles -1 / tau_i, so each is found by bisection in an interval known beforehand; with them

    J(t) = 1 / Z(inf) + t / Z'(0) [k = 0 only] + sum_j (1 - exp(-p_j t)) / (p_j Z'(-p_j)).

Source: N. W. Tschoegl, The Phenomenological Theory of Linear Viscoelastic Behavior, Springer 1989, ch. 4 and 8; B. Gross, Mathematical
Structure of the Theories of Viscoelasticity, Hermann 1953.
"""

from dataclasses import dataclass

import numpy as np

from skin_models.elements.creeping import Creeping
from skin_models.elements.element import Element
from skin_models.elements.relaxing import Relaxing
from skin_models.errors import ModelError
from skin_models.parameter import check_parameters, quantity

HALVINGS = 70  # bisections of an interval of 600 in ln(distance): down to the resolution of a double


@dataclass(frozen=True)
class Prony(Element):
    """`arms` are pairs (stiffness N/m, relaxation time s). Raises `ModelError` unless they are positive and some part resists."""

    k: float = quantity("N/m", 0.0, lower=0.0, doc="stiffness that stays")
    b: float = quantity("N*s/m", 0.0, lower=0.0, doc="damping beside it")
    arms: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        check_parameters(self)
        if not all(np.isfinite(value) and value > 0.0 for arm in self.arms for value in arm):
            raise ModelError("every arm of a Prony series needs a positive stiffness (N/m) and a positive relaxation time (s)")
        if self.k == self.b == 0.0 and not self.arms:
            raise ModelError("a Prony series needs a spring, a dashpot or an arm")

    @property
    def relaxing(self) -> Relaxing:
        """Arms of one and the same relaxation time are taken together."""
        tau, same = np.unique([arm[1] for arm in self.arms], return_inverse=True)
        stiffness = np.bincount(same, weights=[arm[0] for arm in self.arms], minlength=tau.size)
        return Relaxing(self.k, self.b, stiffness, tau)

    @property
    def creeping(self) -> Creeping:
        """The same element driven by force."""
        series = self.relaxing
        p, to_poles = _zeros(series)
        slope = self.b + (series.stiffness / series.tau / to_poles**2).sum(axis=1)
        return Creeping(
            j=0.0 if self.b > 0.0 else 1.0 / (self.k + series.stiffness.sum()),
            fluidity=1.0 / (self.b + series.stiffness @ series.tau) if self.k == 0.0 else 0.0,
            compliance=1.0 / (p * slope),
            delay=1.0 / p,
        )


def _zeros(series: Relaxing) -> tuple[np.ndarray, np.ndarray]:
    """The p > 0 for which Z(-p) = 0, and their distances to every pole, (zeros, arms).

    There is one below the first pole if k > 0, one between any two, one above the last if b > 0. A zero may lie so close to a pole that
    their difference is lost in rounding; so the bisection is in the logarithm of the distance from the nearer end of the interval.
    """
    low, high = _intervals(series)
    poles = 1.0 / series.tau

    def positive(to_poles, p):  # Z(-p) falls from pole to pole
        with np.errstate(divide="ignore"):
            arms = -series.stiffness * p[:, None] / to_poles
        return series.k - series.b * p + arms.sum(axis=1) > 0.0

    middle = 0.5 * (low + high)
    upper = positive(poles - middle[:, None], middle)
    near, sign = np.where(upper, high, low), np.where(upper, -1.0, 1.0)
    from_end = poles - near[:, None]
    inner, outer = np.full(near.size, -600.0), np.zeros(near.size)  # ln of the distance, in half widths
    for _ in range(HALVINGS):
        tried = 0.5 * (inner + outer)
        distance = sign * 0.5 * (high - low) * np.exp(tried)
        further = positive(from_end - distance[:, None], near + distance) == (sign > 0.0)
        inner, outer = np.where(further, tried, inner), np.where(further, outer, tried)
    distance = sign * 0.5 * (high - low) * np.exp(0.5 * (inner + outer))
    return near + distance, from_end - distance[:, None]


def _intervals(series: Relaxing) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the intervals of p that hold one zero each."""
    poles = np.sort(1.0 / series.tau)
    last = poles[-1] if poles.size else 0.0
    first = [0.0] if series.k > 0.0 else []
    beyond = [2.0 * (last + (series.k + series.stiffness.sum()) / series.b)] if series.b > 0.0 else []
    ends = np.concatenate([first, poles, beyond])
    return ends[:-1], ends[1:]
