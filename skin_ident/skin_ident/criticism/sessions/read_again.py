"""A session of which what drives it, depth or force, has been read once more, with other noise."""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.sessions.session import Session

UNZEROED = 0.25  # of the encoder's step, by which a zero of depth is off


def read_again(s: Session, read: np.ndarray) -> Session:
    """The session with further noise `read` (N,) in what a simulation is driven by: the depth, m, or the force, N."""
    if s.drive is not None:
        return replace(s, drive=s.drive + s.band.smooth(read))
    return replace(s, motion=replace(s.motion, x=s.motion.x + s.band.smooth(read), v=s.motion.v + s.band.speed(read)))


def with_noise_again(s: Session, draw: np.ndarray) -> Session:
    """The session, driven by a depth, with one more `draw` (N,) of its encoder's white noise, of 1 rms; of fewer samples than were recorded
    each holds less."""
    return read_again(s, s.depth_noise * replace(s.band, dt=s.period).passes / s.band.passes * draw)


def rounding(s: Session, step: float, phase: float, rng: np.random.Generator) -> Session:
    """The session, driven by a depth, whose way is read in steps of `step` m, which begin at `phase` of one, from a zero that is off by a
    quarter of a step at most, as one is that a reading has set."""
    x = s.motion.x
    read = step * (np.round(x / step - phase) + phase)
    return read_again(s, read - x + UNZEROED * step * rng.uniform(-1.0, 1.0))
