"""Leaves out the beginning of a session that starts in contact: relaxing skin remembers earlier presses that nobody recorded.

The simulation starts with the skin's relaxation arms at rest. If they were not, the difference is a transient with their relaxation times,
which looks like a drift or like a zero offset that warms up. So once the skin is known to relax, nothing is compared until most of the
transient is over.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.sessions.session import Session, motion_under
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.model import Model

TIMES = 4.0  # longest relaxation times that are left out, after which 2 % of a transient remain
PART = 0.25  # largest share of a session that is left out; also used where the relaxation has no single longest time
TOUCHING = 0.02  # share of the greatest depth above which the first sample counts as contact


def at_rest(session: Session, model: Model) -> Session:
    """The session with zero weight at its beginning, if it starts in contact and the skin of `model` relaxes; else unchanged."""
    x, t = motion_under(session, model.dispersion).x, session.motion.t
    arms = [e for e in model.effects if e.cause == "stress_relaxation"]
    if not arms or x[0] <= TOUCHING * x.max():
        return session
    whole = PART * float(np.ptp(t))
    seconds = min(whole, TIMES * max(e.tau if isinstance(e, StressRelaxation) else whole for e in arms))
    return replace(session, weight=session.weight * (session.t - t[0] >= seconds))
