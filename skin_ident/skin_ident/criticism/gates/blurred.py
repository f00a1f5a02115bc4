"""How much of a model's likelihood is lost to the encoder's noise: one that feels this noise explains less than it would at the true depth.

Damping that follows a root of the speed changes most where the plunger almost rests, and there noise flips the sign of the speed. A loop
whose threshold is wider than the noise does not feel it, and would be preferred for that reason alone; so would a mount that smooths the
depth be to a clock that is late (W. A. Fuller, Measurement Error Models, 1987, ch. 1). Let S(x) be the simulation at the true depth x, W
the whitening and n the noise. The squared error grows by |W (S(x + n) - S(x))|^2, and it grows by as much again when one more draw of n
is added. That second growth is what is measured here.
"""

import numpy as np

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.sessions.read_again import with_noise_again
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

SEED = 0  # any value: the same record always gives the same result


def blurred(model: Model, sessions: list[Session], noise: Whitener) -> float:
    """The amount by which noise of the encoder raises the squared error of a model, in whitened units. It is a lower bound, since only the
    white part of that noise is known; 0 where a session has no such noise or is driven by a force."""
    if not all(s.depth_noise > 0.0 and s.drive is None for s in sessions):
        return 0.0
    rng = np.random.default_rng(SEED)
    changes = [_changed(model, s, rng) * s.weight for s in sessions]
    return float(np.sum(stack(changes, sessions, noise) ** 2))


def _changed(model: Model, s: Session, rng: np.random.Generator) -> np.ndarray:
    """Change (C, n), N, of a simulation when the depth is read with one more draw of its noise."""
    return s.band.thin(simulated(model, with_noise_again(s, rng.standard_normal(len(s.motion)))) - simulated(model, s))
