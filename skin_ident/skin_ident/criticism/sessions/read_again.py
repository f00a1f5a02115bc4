"""A session of which what drives it, depth or force, has been read once more, with other noise."""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.sessions.session import Session


def read_again(s: Session, noise: float, rng: np.random.Generator) -> Session:
    """The session with a further draw of white noise in what a simulation is driven by: the depth, m rms, or the force, N rms."""
    read = noise * rng.standard_normal(len(s.motion))
    if s.drive is not None:
        return replace(s, drive=s.drive + s.band.smooth(read))
    return replace(s, motion=replace(s.motion, x=s.motion.x + s.band.smooth(read), v=s.motion.v + s.band.speed(read)))
