"""How much of a cause's gain errors of the encoder can mimic, estimated by reading the depth anew.

A cause that smooths the depth keeps noise of the encoder out of the simulated forces. A cause that bends or lags can make up for steps at
which the depth stops. How much it gains so depends on the cause and on the record, and a bound that holds for every cause is far too wide
for most.

Noise: the gain that noise mimics grows with the variance of the noise, and a true gain does not. One more draw of the noise doubles its
variance. If a cause explains E(1) as it is and E(2) with the further draw, noise mimics E(2) - E(1) of E(1) (SIMEX, linear: J. R. Cook,
L. A. Stefanski, J. Am. Stat. Assoc. 89, 1314, 1994).

Steps: their errors are the same whenever the plunger comes back to a depth, and the cause was fitted to just these errors. So the record is
simulated anew as if the model without the cause were true and the plunger went where it was read. It is then read with steps that begin
elsewhere, and from a zero that was set by one of these steps. Both models are fitted to that record, and what the cause gains there is
mimicked (a parametric bootstrap: B. Efron, R. Tibshirani, An Introduction to the Bootstrap, 1993, section 6.5). Noise would be underrated
in this way: the depth that was read already holds some of it, and the simulated forces would follow it.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.fitting import cost_of, fit
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.read_again import rounding, with_noise_again
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

SEED = 0  # any value: the same record always gives the same result
DRAWS = 3  # draws of the steps; noise has two, one the negative of the other, so that products with the rest of the residual cancel
OF_NOISE = 2.0  # times what noise mimics, which a cause must explain: in sound records it explains 0.6 to 0.9 times that
OF_STEPS = 6.0  # times what steps mimic: no draw knows where the true steps begin, and in a sound record a lag explained 5.1 times as much
# Share of the gain above which what is mimicked rules the cause out, whatever bounds allow: at few depths rounding is no noise.
FEIGNED = 0.5


def explains_more(before: Model, after: Model, train: list[Session], noise: Whitener, step: float) -> bool:
    """Whether `after` explains clearly more than the encoder's white noise and its steps of `step` m mimic together."""
    explained, of_noise, of_steps = _asked(before, after, train, noise, step)
    return explained > OF_NOISE * of_noise + OF_STEPS * of_steps


def is_feigned(before: Model, after: Model, train: list[Session], noise: Whitener, step: float) -> bool:
    """Whether the encoder's white noise and its steps of `step` m mimic most of what `after` explains."""
    explained, of_noise, of_steps = _asked(before, after, train, noise, step)
    return of_noise + of_steps > FEIGNED * explained


def _asked(before: Model, after: Model, train: list[Session], noise: Whitener, step: float) -> tuple[float, float, float]:
    """What `after` explains beyond `before`, and how much of it noise and steps mimic, in twice nats."""
    explained = cost_of(before, train, noise) - cost_of(after, train, noise)
    return explained, by_noise(before, after, train, noise, explained), by_steps(before, after, train, noise, step)


def by_noise(before: Model, after: Model, train: list[Session], noise: Whitener, explained: float) -> float:
    """How much of what is `explained` noise of the encoder mimics, twice nats."""
    if not any(s.depth_noise > 0.0 for s in train):
        return 0.0
    rng = np.random.default_rng(SEED)
    draws = [rng.standard_normal(len(s.motion)) for s in train]
    noisier = ([with_noise_again(s, sign * z) for s, z in zip(train, draws, strict=True)] for sign in (1.0, -1.0))
    return max(float(np.mean([_explained(before, after, again, noise) for again in noisier])) - explained, 0.0)


def by_steps(before: Model, after: Model, train: list[Session], noise: Whitener, step: float) -> float:
    """The most that steps of `step` m mimic in any of `DRAWS` draws, twice nats."""
    if not step:
        return 0.0
    rng = np.random.default_rng(SEED)
    return max(_explained(before, after, [_made(before, s, step, phase, rng) for s in train], noise) for phase in rng.random(DRAWS))


def _explained(before: Model, after: Model, sessions: list[Session], noise: Whitener) -> float:
    without, with_it = (fit(m, sessions, noise).cost for m in (before, after))
    return max(without - with_it, 0.0)


def _made(model: Model, s: Session, step: float, phase: float, rng: np.random.Generator) -> Session:
    """A session whose forces are simulated by `model` from the depth as it was read, and whose depth is then read in other steps."""
    return replace(rounding(s, step, phase, rng), measured=s.band.thin(simulated(model, s)))
