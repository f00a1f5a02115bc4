"""The beginning of a session that begins in contact: a skin that relaxes remembers presses which nobody recorded.

Its arms are simulated as if they had come to rest. What they had not is a transient of their own relaxation times, which a zero that warms
up or a drift looks like. So once skin is known to relax, nothing is compared there until most of that is over.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.sessions.session import Session, motion_under
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.model import Model

TIMES = 4.0  # the longest relaxation time, after which two hundredths of a transient are left
PART = 0.25  # of a session, the most of it that is left out, and what is where the skin has no longest time
TOUCHING = 0.02  # of the greatest depth


def at_rest(session: Session, model: Model) -> Session:
    """The session less its beginning, if it begins in contact and the skin of `model` relaxes."""
    x, t = motion_under(session, model.dispersion).x, session.motion.t
    arms = [e for e in model.effects if e.cause == "stress_relaxation"]
    if not arms or x[0] <= TOUCHING * x.max():
        return session
    whole = PART * float(np.ptp(t))
    seconds = min(whole, TIMES * max(e.tau if isinstance(e, StressRelaxation) else whole for e in arms))
    return replace(session, weight=session.weight * (session.t - t[0] >= seconds))
