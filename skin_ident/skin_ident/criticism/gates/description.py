"""How long the description of a record is under a model, its noise fitted to what that very model leaves.

The search takes the noise from the richest model, lest an effect be taken for noise. But noise that wanders is, to the richest model, two
dozen effects; and what these leave of a short recording has too little slow noise, so that the next effect stands out of it. So before a
cause is named it must also stand against the other account of the same record, that without it the noise is merely more coloured:

    L = 2 N log |R| + 2 sum log s + U log(rows),

R R' the covariance of the innovations, N their number, s what their noise grows by under load, U the unknowns of the model.

Source: G. Schwarz, Estimating the dimension of a model, Annals of Statistics 6 (1978) 461-464.
"""

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, noise_of
from skin_ident.criticism.noise.growth import Growth
from skin_ident.criticism.sessions.session import Session


def description_length(fit: Fit, sessions: list[Session], grows: Growth) -> float:
    """L of the fitted model over `sessions`, in twice nats, where noise `grows` so with the load: models are compared under one growth."""
    noise = noise_of(fit.model, sessions, grows)
    samples = sum(int(np.count_nonzero(s.weight.min(axis=0))) for s in sessions)
    return 2.0 * noise.words(sessions) + len(fit.unknowns) * float(np.log(max(samples * len(noise.root), 2)))
