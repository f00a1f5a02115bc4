"""The description length of a record under a model, with the noise model fitted to that model's own residual.

The search takes the noise from the richest model, lest an effect be taken for noise. But noise that wanders looks, to the richest model,
like two dozen effects. In a short recording its residual then holds too little slow noise, and the next effect stands out too clearly. So
before a cause is named it must also beat the other account of the same record: no such cause, and noise that is more strongly coloured. The
description length is

    L = 2 N log |R| + 2 sum log s + U log(rows),

R R' the covariance of the innovations, N their number, s the factor by which their noise grows under load, U the number of unknowns of the
model. Channels are described as uncorrelated mixtures, each predicted from its own past alone. A model that errs along its stiffness may by
chance give mixtures that separate the encoder's noise from that of the sensors, while its successor does not. So each model is described in
the mixtures of both, and the shorter description counts.

Source: G. Schwarz, Estimating the dimension of a model, Annals of Statistics 6 (1978) 461-464.
"""

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, noise_of
from skin_ident.criticism.noise.growth import Growth
from skin_ident.criticism.sessions.session import Session


def shorter_by(before: Fit, after: Fit, sessions: list[Session], grows: Growth) -> float:
    """Fall of the description length L of `sessions` from `before` to `after`, in twice nats; `grows` is how the noise grows with the
    load."""
    own = [noise_of(f.model, sessions, grows) for f in (before, after)]
    other = [noise_of(f.model, sessions, grows, noise.mix) for f, noise in zip((before, after), reversed(own), strict=True)]
    longer, shorter = (2.0 * min(noise.words(sessions) for noise in noises) for noises in zip(own, other, strict=True))
    samples = sum(int(np.count_nonzero(s.weight.min(axis=0))) for s in sessions) * len(own[0].root)
    return longer - shorter - (len(after.unknowns) - len(before.unknowns)) * float(np.log(max(samples, 2)))
