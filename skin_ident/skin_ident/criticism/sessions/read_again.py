"""Sessions whose driving signal, depth or force, is read once more with other noise."""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.sessions.session import Session

UNZEROED = 0.25  # of the encoder's step, the largest error of the zero of depth


def read_again(s: Session, read: np.ndarray) -> Session:
    """The session with additional noise `read` (N,) in its driving signal: the depth, m, or the force, N."""
    if s.drive is not None:
        return replace(s, drive=s.drive + s.band.smooth(read))
    return replace(s, motion=replace(s.motion, x=s.motion.x + s.band.smooth(read), v=s.motion.v + s.band.speed(read)))


def with_noise_again(s: Session, draw: np.ndarray) -> Session:
    """The depth-driven session with another realisation of its encoder's white noise, from a `draw` (N,) of 1 rms. In a thinned session
    each sample carries less of that noise, as the earlier low-pass averaged it."""
    return read_again(s, s.depth_noise * replace(s.band, dt=s.period).passes / s.band.passes * draw)


def rounding(s: Session, step: float, phase: float, rng: np.random.Generator) -> Session:
    """The depth-driven session with its depth read again in steps of `step` m, the levels shifted by the share `phase` of a step. Its zero
    is off by up to a quarter of a step, as a zero taken from one reading is."""
    x = s.motion.x
    read = step * (np.round(x / step - phase) + phase)
    return read_again(s, read - x + UNZEROED * step * rng.uniform(-1.0, 1.0))
