"""How long the description of a record is under a model, its noise fitted to what that very model leaves.

The search takes the noise from the richest model, lest an effect be taken for noise. But noise that wanders is, to the richest model, two
dozen effects; and what these leave of a short recording has too little slow noise, so that the next effect stands out of it. So before a
cause is named it must also stand against the other account of the same record, that without it the noise is merely more coloured:

    L = 2 N log |R| + 2 sum log s + U log(rows),

R R' the covariance of the innovations, N their number, s what their noise grows by under load, U the unknowns of the model. Channels are
described as mixtures whose pasts tell nothing of each other. Those of a model that errs along its stiffness may happen to part the noise
of the encoder from that of the sensors, and its successor's not: so each is described in the mixtures of both, and the shorter description
counts.

Source: G. Schwarz, Estimating the dimension of a model, Annals of Statistics 6 (1978) 461-464.
"""

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, noise_of
from skin_ident.criticism.noise.growth import Growth
from skin_ident.criticism.sessions.session import Session


def shorter_by(before: Fit, after: Fit, sessions: list[Session], grows: Growth) -> float:
    """By how much L over `sessions` is less of `after` than of `before`, in twice nats, where noise `grows` so with the load."""
    own = [noise_of(f.model, sessions, grows) for f in (before, after)]
    other = [noise_of(f.model, sessions, grows, noise.mix) for f, noise in zip((before, after), reversed(own), strict=True)]
    longer, shorter = (2.0 * min(noise.words(sessions) for noise in noises) for noises in zip(own, other, strict=True))
    samples = sum(int(np.count_nonzero(s.weight.min(axis=0))) for s in sessions) * len(own[0].root)
    return longer - shorter - (len(after.unknowns) - len(before.unknowns)) * float(np.log(max(samples, 2)))
