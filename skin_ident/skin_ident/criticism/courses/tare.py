"""Zeros as a tare leaves them: a reading in steps sets each channel's zero, in each session, no better than to one of them.

All of them together feign what no single one does: under a load that never ends a slope that differs between sessions, under one motion
that is repeated a loop. So they are fitted at once,

    min |r - A z|,

where r is the whitened residual and A the whitened zeros, both less what the model may change by itself. They are a tare's as long as they
explain as much with |z| at most a step of the converter each.
"""

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import lsq_linear

from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.courses.course import basis
from skin_ident.criticism.gates.resolution import converter_step
from skin_ident.criticism.gates.uncertain import own_rows
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

BOUND = 10.0  # fall of the squared whitened error, by which larger zeros may explain more

Zeros = dict[str, np.ndarray]  # N, (C,) by session


def zeros(model: Model, sessions: list[Session], noise: Whitener, *, free: bool) -> tuple[Zeros, float]:
    """What tares may have left of every channel's zero in `sessions`, and the fall of the squared whitened error with it, beside the
    model's own numbers where they are `free`; nothing, where they do not leave so much."""
    channels = sessions[0].channels
    steps = np.tile([0.0 if c in sessions[0].stuck else converter_step(sessions, c) for c in channels], len(sessions))
    z, fall, able = np.zeros(steps.size), 0.0, steps > 0.0
    if able.any():
        A = block_diag(*(stack([_of_each(s)], [s], noise) for s in sessions))[:, able]
        r = stack([residual(model, s) for s in sessions], sessions, noise)
        if free:
            Q = basis(stack(own_rows(model, sessions, sessions), sessions, noise))
            A, r = A - Q @ (Q.T @ A), r - Q @ (Q.T @ r)
        span, triangle = np.linalg.qr(A)
        seen = span.T @ r
        bounded = lsq_linear(triangle, seen, (-steps[able], steps[able])).x
        beyond = float(np.sum((seen - triangle @ bounded) ** 2))  # what larger ones explain
        if beyond < BOUND:
            z[able], fall = bounded, float(seen @ seen) - beyond
    return dict(zip((s.name for s in sessions), z.reshape(len(sessions), -1), strict=True)), fall


def _of_each(s: Session) -> np.ndarray:
    """A zero of one in every channel in turn, (C, C, n)."""
    one = np.eye(len(s.channels))[..., None] * np.ones(s.motion.t.size)
    return s.band.thin(one)
