"""Whether a record can tell memory of time from memory of the path: it needs a hold, or the path at another speed.

At one speed v the two are one: skin that relaxes by k(t) answers a ramp with a force whose slope is k(s / v), a function of the path s
since the last reversal alone, which is what a hysteresis of elastic and sliding elements answers, too.
"""

import numpy as np

from skin_ident.criticism.sessions.session import Session

OTHER = 2.5  # times the slowest tenth of the path, from which the fastest tenth is another speed
STILL, HELD = 0.2, 0.1  # of the usual speed, below which the plunger rests; of the time in contact, from which such rests are holds


def at_one_rate(sessions: list[Session]) -> bool:
    """Whether all of `sessions` press at one speed and never hold; never of a test that force drives, where the skin's speed is unknown."""
    if any(s.drive is not None for s in sessions):
        return False
    speed = np.concatenate([np.abs(s.motion.v[s.motion.x > 0.0]) for s in sessions])
    if speed.size == 0:
        return False
    slowest, usual, fastest = _along_the_path(speed, (0.1, 0.5, 0.9))
    return bool(fastest < OTHER * slowest and np.mean(speed < STILL * usual) < HELD)


def _along_the_path(speed: np.ndarray, shares: tuple[float, ...]) -> np.ndarray:
    """Speeds below which those shares of the path were covered."""
    ordered = np.sort(speed)
    path = np.cumsum(ordered)
    return ordered[np.searchsorted(path, np.array(shares) * path[-1])]
