"""A session of which what drives it, depth or force, has been read once more, with other noise."""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.sessions.session import Session


def read_again(s: Session, read: np.ndarray) -> Session:
    """The session with further noise `read` (N,) in what a simulation is driven by: the depth, m, or the force, N."""
    if s.drive is not None:
        return replace(s, drive=s.drive + s.band.smooth(read))
    return replace(s, motion=replace(s.motion, x=s.motion.x + s.band.smooth(read), v=s.motion.v + s.band.speed(read)))


def with_noise_again(s: Session, draw: np.ndarray) -> Session:
    """The session, driven by a depth, with one more `draw` (N,) of its encoder's white noise, of 1 rms; of fewer samples than were recorded
    each holds less."""
    return read_again(s, s.depth_noise * replace(s.band, dt=s.period).passes / s.band.passes * draw)
