"""What training sessions support and others leave in doubt: it is no finding, but must not be called excluded either."""

import numpy as np

from skin_ident.criticism.courses.carriers import SLOPE, ZERO
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.search.named import Named, NotNamed

REPEATED = "more sessions, as deep, as fast and as long as those that support it"
TARED = "tares that are longer than the slow wandering of the noise, and approaches from the air into contact"
QUIET = "the same motions again with less noise in this channel, or rests long enough to see how its noise wanders"
OWN = {ZERO: "its zero", SLOPE: "its gain"}  # in words; the names of the other carriers say what they are


def unproven() -> NotNamed:
    """Why what explains much of training is no finding, where held-out sessions are not surely predicted better with it."""
    why = "the fitted sessions support it, but what is held out is not predicted significantly better with it"
    return NotNamed(np.inf, why, REPEATED, doubt=True)


def absent(sessions: tuple[str, ...]) -> NotNamed:
    """Why what all fitted sessions share is no finding, where the held-out `sessions` lack it and no other one can confirm it."""
    which = " and ".join(sessions)
    why = f"the fitted sessions predict each other better with it, but what is held out ({which}) is predicted better without it"
    return NotNamed(np.inf, why, "another session like the fitted ones, to be held out", doubt=True)


def only_held(sessions: tuple[str, ...]) -> NotNamed:
    """Why what only the held-out `sessions` have is no finding."""
    which = " and ".join(sessions)
    why = f"it explains most of what is wrong in {which} alone, which is held out, so that no other session can confirm it"
    return NotNamed(np.inf, why, f"another session like {which}, to be held out while {which} is fitted", doubt=True)


def yields() -> NotNamed:
    """Why what held-out data support is no finding, where zeros of single sessions explain as much."""
    return NotNamed(np.inf, "zero offsets of single sessions, such as tares and stages leave, explain as much", TARED, doubt=True)


def shadowed(gain: Gain, named: list[Named]) -> NotNamed:
    """Why what held-out data support is no finding beside a `named` cause that explains far more in the same channel. No model of a cause
    fits real skin exactly, and this may be the rest."""
    by = max(named, key=lambda n: n.gain.squares * (gain.channel in n.gain.carried))
    return _left_by(by, f"{_falls(gain)}, which is little compared with what {by.cause} in the {by.where} explains")


def mending(gain: Gain, named: list[Named]) -> NotNamed:
    """Why what held-out data support is no finding where more of what was `named` would explain most of it."""
    by = max(named, key=lambda n: n.explained)
    more = "the causes that are named" if len(named) > 1 else f"{by.cause} in the {by.where}"
    return _left_by(by, f"{_falls(gain)}, and more of {more} would explain most of this fall")


def _falls(gain: Gain) -> str:
    return f"with it the held-out error of {gain.channel} falls from {gain.before:.4g} to {gain.after:.4g} N"


def _left_by(by: Named, why: str) -> NotNamed:
    """Why what an imperfect form of the cause `by` may leave is no finding."""
    needs = f"a session in which {by.cause} in the {by.where} hardly shows, or a form of it that fits better"
    return NotNamed(np.inf, f"{why}: it may be what an imperfect form of that cause leaves", needs, doubt=True)


def wandering(run: Run) -> NotNamed:
    """Why a course of single sessions is no finding, where it does not predict the blocks between those that it was fitted to."""
    what = OWN.get(run.course.carrier, f"the {run.course.carrier}")
    why = f"within single sessions {what} would wander by {run.size:.2g} N rms, but fitted to every other block it does not predict those"
    return NotNamed(np.inf, f"{why} between: noise that wanders does as much", QUIET, doubt=True)
