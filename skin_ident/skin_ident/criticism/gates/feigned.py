"""What errors of the encoder feign of a cause, told by reading the depth anew.

What smooths a depth keeps noise of the encoder from the forces, and what bends or lags makes up for steps that it stops at. How much of
that a cause does depends on both, and a bound that holds for all is far too wide for most.

Noise: what it feigns grows with its variance, and what is true does not. With one more draw of it the variance is twice as large, and of an
explained E(1) it feigns as much as E(2) is larger (SIMEX, linear: J. R. Cook, L. A. Stefanski, J. Am. Stat. Assoc. 89, 1314, 1994).

Steps: their errors are the same wherever the plunger comes back to, and a cause is fitted to just these. So the record is drawn anew as if
the model without the cause were true and the plunger went where it was read, with steps that begin elsewhere and zeros that are set by one
of them; what both models, fitted to it, differ by is feigned (a parametric bootstrap: B. Efron, R. Tibshirani, An Introduction to the
Bootstrap, 1993, section 6.5). Noise would be underrated so: what was read holds some of it, which the forces of such a record follow.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.fitting import cost_of, fit
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.read_again import rounding, with_noise_again
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

SEED = 0  # any: the same record is told the same
DRAWS = 3  # of steps; of noise there are two, one the opposite of the other, so that products with what is left anyway cancel
OF_NOISE = 2.0  # times what noise feigns, which must be explained: of sound records a cause explains 0.6 to 0.9 times that
OF_STEPS = 6.0  # times what steps feign: where the true ones begin no draw knows, and a lag in a sound record explained 5.1 times as much
FEIGNED = 0.5  # of what is explained, from which on it is no cause, whatever bounds allow: at few depths rounding is no noise


def explains_more(before: Model, after: Model, train: list[Session], noise: Whitener, step: float) -> bool:
    """Whether `after` explains clearly more than white noise of the encoder and its steps of `step` m feign together."""
    explained, of_noise, of_steps = _asked(before, after, train, noise, step)
    return explained > OF_NOISE * of_noise + OF_STEPS * of_steps


def is_feigned(before: Model, after: Model, train: list[Session], noise: Whitener, step: float) -> bool:
    """Whether white noise of the encoder and its steps of `step` m feign most of what `after` explains."""
    explained, of_noise, of_steps = _asked(before, after, train, noise, step)
    return of_noise + of_steps > FEIGNED * explained


def _asked(before: Model, after: Model, train: list[Session], noise: Whitener, step: float) -> tuple[float, float, float]:
    """What `after` explains, and what noise and steps feign of it, twice nats."""
    explained = cost_of(before, train, noise) - cost_of(after, train, noise)
    return explained, by_noise(before, after, train, noise, explained), by_steps(before, after, train, noise, step)


def by_noise(before: Model, after: Model, train: list[Session], noise: Whitener, explained: float) -> float:
    """What noise feigns of what is `explained`, twice nats."""
    if not any(s.depth_noise > 0.0 for s in train):
        return 0.0
    rng = np.random.default_rng(SEED)
    draws = [rng.standard_normal(len(s.motion)) for s in train]
    noisier = ([with_noise_again(s, sign * z) for s, z in zip(train, draws, strict=True)] for sign in (1.0, -1.0))
    return max(float(np.mean([_explained(before, after, again, noise) for again in noisier])) - explained, 0.0)


def by_steps(before: Model, after: Model, train: list[Session], noise: Whitener, step: float) -> float:
    """The most that steps of `step` m feign, twice nats, of `DRAWS`."""
    if not step:
        return 0.0
    rng = np.random.default_rng(SEED)
    return max(_explained(before, after, [_made(before, s, step, phase, rng) for s in train], noise) for phase in rng.random(DRAWS))


def _explained(before: Model, after: Model, sessions: list[Session], noise: Whitener) -> float:
    without, with_it = (fit(m, sessions, noise).cost for m in (before, after))
    return max(without - with_it, 0.0)


def _made(model: Model, s: Session, step: float, phase: float, rng: np.random.Generator) -> Session:
    """A session as `model` makes it, read in steps."""
    return replace(rounding(s, step, phase, rng), measured=s.band.thin(simulated(model, s)))
