"""Zeros as good hardware leaves them: each channel's, in each session, as far off as a tare leaves it (see `left_by_tare`), and that of
what drives the test: of a force as a tare leaves it, of depth as a stage, or its encoder, does, a few micrometres.

All of them together feign what no single one does: under a load that never ends a slope that differs between sessions, under one motion
that is repeated a loop. So they are fitted at once,

    min |r - A z|,

where r is the whitened residual and A what zeros change, whitened, both less what the model may change by itself. They are a tare's as long
as they explain as much with |z| at most what a tare leaves, or a good stage does, each.
"""

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import lsq_linear

from skin_ident.criticism.baseline.residual import residual, simulated
from skin_ident.criticism.courses.carriers import DEPTH, DRIVE, carried
from skin_ident.criticism.courses.course import basis
from skin_ident.criticism.courses.left_by_tare import MORE, tare_of_drive, tares
from skin_ident.criticism.courses.run import least_depth
from skin_ident.criticism.gates.uncertain import own_rows
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

EVENLY = 0.5  # standard errors that the largest zero is worth: under a load that never ends a zero of depth is one of the force

Zeros = dict[str, np.ndarray]  # by session, of every channel, N, and of what drives it, depth (m) or force (N): (C + 1,)


def zeros(model: Model, sessions: list[Session], noise: Whitener, encoder_step: float = 0.0, *, free: bool) -> tuple[Zeros, float]:
    """What tares may have left of every channel's zero in `sessions`, and of that of what drives them, and the fall of the squared whitened
    error with it, beside the model's own numbers where they are `free`; nothing, where they do not leave so much."""
    most = np.tile(_most(sessions, noise, encoder_step), len(sessions))
    z, fall, able = np.zeros(most.size), 0.0, most > 0.0
    if able.any():
        A = block_diag(*(stack([s.band.thin(_of_each(model, s))], [s], noise) for s in sessions))[:, able] * most[able]
        r = stack([residual(model, s) for s in sessions], sessions, noise)
        if free:
            Q = basis(stack(own_rows(model, sessions, sessions), sessions, noise))
            A, r = A - Q @ (Q.T @ A), r - Q @ (Q.T @ r)
        span, triangle = np.linalg.qr(A)
        seen = span.T @ r
        evenly = np.concatenate([triangle, EVENLY * np.eye(len(triangle))]), np.concatenate([seen, np.zeros(len(triangle))])
        bounded = lsq_linear(*evenly, (-1.0, 1.0)).x
        beyond = float(np.sum((seen - triangle @ bounded) ** 2))  # what larger ones explain
        if beyond < MORE:
            z[able], fall = bounded * most[able], float(seen @ seen) - beyond
    return dict(zip((s.name for s in sessions), z.reshape(len(sessions), -1), strict=True)), fall


def added_by(found: Zeros, model: Model, sessions: list[Session]) -> dict[str, np.ndarray]:
    """What zeros that were found add to what a model says of each session, (C, N) N."""
    return {s.name: np.tensordot(found[s.name], _of_each(model, s), 1) for s in sessions}


def _most(sessions: list[Session], noise: Whitener, encoder_step: float) -> list[float]:
    """The largest zero of every channel, N, and of what drives them, m or N; 0 where there is none."""
    first = sessions[0]
    channels = [0.0 if c in first.stuck else t.leaves for c, t in zip(first.channels, tares(sessions, noise), strict=True)]
    return [*channels, least_depth(encoder_step) if first.drive is None else tare_of_drive(sessions).leaves]


def _of_each(model: Model, s: Session) -> np.ndarray:
    """What a zero of one in every channel in turn, and in what drives the test, changes, (C + 1, C, N)."""
    channels = np.eye(len(s.channels))[..., None] * np.ones(s.motion.t.size)
    driven = carried(DEPTH if s.drive is None else DRIVE, (), model, s, simulated(model, s))
    return np.concatenate([channels, driven[None]])
