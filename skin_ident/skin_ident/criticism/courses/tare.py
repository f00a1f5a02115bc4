"""Zero errors of good hardware, fitted together: each channel's in each session within what a tare leaves (see `left_by_tare`), and that of
what drives the test (a force within what its tare leaves, a depth within the few micrometres of a stage or its encoder).

Together they can imitate what none of them can alone: under a load that never ends a slope that differs between sessions, under one
repeated motion a loop. So they are fitted jointly,

    min |r - A z|,

where r is the whitened residual and A the whitened change per zero, both projected off what the model may change by itself. The zeros are
accepted if, bounded by what a tare or a good stage leaves, they explain as much as unbounded ones.
"""

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import lsq_linear

from skin_ident.criticism.baseline.residual import residual, simulated
from skin_ident.criticism.courses.carriers import DEPTH, DRIVE, carried
from skin_ident.criticism.courses.left_by_tare import MORE_BY_LARGER_ZEROS, tare_of_drive, tares
from skin_ident.criticism.courses.run import least_depth
from skin_ident.criticism.gates.uncertain import own_rows
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.projection import basis, projected_off
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

# Weight of the ridge term, at the bound of a zero, in standard errors. It shares out zeros that cannot be told apart: under a load that
# never ends a zero of depth equals one of the force.
EVENLY = 0.5

Zeros = dict[str, np.ndarray]  # (C + 1,) by session: the zero of every channel, N, and of what drives the test, depth (m) or force (N)


def zeros(
    model: Model, sessions: list[Session], noise: Whitener, encoder_step: float = 0.0, *, free: bool, driven: bool = True
) -> tuple[Zeros, float]:
    """Zero errors of every channel of `sessions` and, where these are `driven`, of what drives them, and their gain in squared whitened
    units; with the model's own unknowns projected out where they are `free`. Zeros and gain are 0 if larger zeros than tares leave would
    explain clearly more."""
    *channels, drive = _most(sessions, noise, encoder_step)
    most = np.tile([*channels, drive * driven], len(sessions))
    z, fall, able = np.zeros(most.size), 0.0, most > 0.0
    if able.any():
        A = block_diag(*(stack([s.band.thin(_of_each(model, s))], [s], noise) for s in sessions))[:, able] * most[able]
        r = stack([residual(model, s) for s in sessions], sessions, noise)
        if free:
            Q = basis(stack(own_rows(model, sessions, sessions), sessions, noise))
            A, r = projected_off(A, Q), projected_off(r, Q)
        span, triangle = np.linalg.qr(A)
        seen = span.T @ r
        evenly = np.concatenate([triangle, EVENLY * np.eye(len(triangle))]), np.concatenate([seen, np.zeros(len(triangle))])
        bounded = lsq_linear(*evenly, (-1.0, 1.0)).x
        beyond = float(np.sum((seen - triangle @ bounded) ** 2))  # what unbounded zeros explain in addition
        if beyond < MORE_BY_LARGER_ZEROS:
            z[able], fall = bounded * most[able], float(seen @ seen) - beyond
    return dict(zip((s.name for s in sessions), z.reshape(len(sessions), -1), strict=True)), fall


def added_by(found: Zeros, model: Model, sessions: list[Session]) -> dict[str, np.ndarray]:
    """What the zeros add to the simulation of each session, (C, N) N."""
    return {s.name: np.tensordot(found[s.name], _of_each(model, s), 1) for s in sessions}


def _most(sessions: list[Session], noise: Whitener, encoder_step: float) -> list[float]:
    """The largest zero of every channel, N, and of what drives the test, m or N; 0 where there is none."""
    first = sessions[0]
    channels = [0.0 if c in first.stuck else t.leaves for c, t in zip(first.channels, tares(sessions, noise), strict=True)]
    return [*channels, least_depth(encoder_step) if first.drive is None else tare_of_drive(sessions).leaves]


def _of_each(model: Model, s: Session) -> np.ndarray:
    """Change of the channels per unit zero of each channel in turn, and of what drives the test, (C + 1, C, N)."""
    channels = np.eye(len(s.channels))[..., None] * np.ones(s.motion.t.size)
    driven = carried(DEPTH if s.drive is None else DRIVE, (), model, s, simulated(model, s))
    return np.concatenate([channels, driven[None]])
