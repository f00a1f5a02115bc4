"""A session's own shares under a model with effects on the taxel readings. There a factor on the reading is not a share of the force, so
the shares are fitted iteratively.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.own_shares import has_own, kept, regression
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

STEPS = 3  # Gauss-Newton steps
PROBE = 0.01  # step of finite differences, of the largest share


def settled(model: Model, session: Session) -> Session:
    """The session with the shares that fit it best under `model`."""
    if not has_own(session):
        return session
    s, free, taxels = replace(session, pinned=True), ~kept(session), session.taxel_rows
    for _ in range(STEPS):
        probe = PROBE * s.spread.max()
        y, more = (s.band.thin(simulated(model, each)[taxels]) for each in (s, replace(s, spread=s.spread + probe)))
        change = regression((s.measured[taxels] - y)[None], (more - y) / probe, s.weight[taxels])[0]
        s = replace(s, spread=np.maximum(s.spread + change * free, 0.0))
    return replace(s, pinned=False)


def share_rows(model: Model, sessions: list[Session]) -> list[np.ndarray]:
    """d(simulated)/d(share) for every taxel of every session with shares of its own, (S T, C, n) by session."""
    if sessions[0].spread is None:
        return [np.zeros((0, *s.measured.shape)) for s in sessions]
    count = sessions[0].n_taxels
    every = [np.zeros((len(sessions) * count, *s.measured.shape)) for s in sessions]
    for i, (s, out) in enumerate(zip(sessions, every, strict=True)):
        plain = s.band.thin(simulated(model, replace(s, beyond=None)))
        for j in np.flatnonzero(~kept(s)):
            out[i * count + j, j - count] = plain[j - count]
    return every
