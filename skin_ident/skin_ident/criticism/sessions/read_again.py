"""A session whose depth an encoder has read once more, with other noise."""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.sessions.session import Session


def read_again(s: Session, noise: float, rng: np.random.Generator) -> Session:
    """The session with a further draw of white noise, m rms, in the depth that a simulation is driven by."""
    read = noise * rng.standard_normal(len(s.motion))
    return replace(s, motion=replace(s.motion, x=s.motion.x + s.band.smooth(read), v=s.motion.v + s.band.speed(read)))
