"""What noise of the encoder takes from a cause: a form that feels it as it is read explains less than it would of the true depth.

Damping that follows a root of the speed changes most where the plunger all but rests, and there noise turns the sign of its speed. A loop
with a threshold wider than that noise does not notice, and would be preferred for it (W. A. Fuller, Measurement Error Models, 1987, ch. 1).
What a cause A explains of what it does at the true depth x falls by |W (A(x + n) - A(x))|^2, as it does by a further draw of the noise n.
"""

import numpy as np

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.sessions.read_again import with_noise_again
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

SEED = 0  # any: the same record is told the same


def blurred(before: Model, after: Model, sessions: list[Session], noise: Whitener) -> float:
    """The likelihood gain that `after` has over `before` at the least too little for noise of the encoder, of which only what is white is
    known; nothing where it has none, or a force drives the test."""
    if not all(s.depth_noise > 0.0 and s.drive is None for s in sessions):
        return 0.0
    rng = np.random.default_rng(SEED)
    changes = [_changed(before, after, s, rng) * s.weight for s in sessions]
    return float(np.sum(stack(changes, sessions, noise) ** 2))


def _changed(before: Model, after: Model, s: Session, rng: np.random.Generator) -> np.ndarray:
    """By how much what `after` adds to `before` is another (C, n), N, where the depth is read with its noise once more."""
    first, second = (
        simulated(after, each) - simulated(before, each) for each in (s, with_noise_again(s, rng.standard_normal(len(s.motion))))
    )
    return s.band.thin(second - first)
