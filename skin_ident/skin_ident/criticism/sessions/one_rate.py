"""Whether a record can tell memory of time from memory of the path: this needs a hold, or the same path at another speed.

At one speed v they are the same. Skin that relaxes by k(t) answers a ramp with a force whose slope is k(s / v), a function of only the path
s since the last reversal. A hysteresis of elastic and sliding elements gives such a function, too.
"""

import numpy as np

from skin_ident.criticism.sessions.session import Session

OTHER = 2.5  # ratio of the speeds at the fastest and the slowest tenth of the path, from which there are two speeds
STILL, HELD = 0.2, 0.1  # share of the usual speed below which the plunger rests; share of the contact time from which rests are holds


def at_one_rate(sessions: list[Session]) -> bool:
    """Whether all `sessions` press at one speed and never hold. False for tests that force drives, where the skin's speed is unknown."""
    if any(s.drive is not None for s in sessions):
        return False
    speed = np.concatenate([np.abs(s.motion.v[s.motion.x > 0.0]) for s in sessions])
    if speed.size == 0:
        return False
    slowest, usual, fastest = _along_the_path(speed, (0.1, 0.5, 0.9))
    return bool(fastest < OTHER * slowest and np.mean(speed < STILL * usual) < HELD)


def _along_the_path(speed: np.ndarray, shares: tuple[float, ...]) -> np.ndarray:
    """The speeds at these shares of the path, counted from the slowest samples on."""
    ordered = np.sort(speed)
    path = np.cumsum(ordered)
    return ordered[np.searchsorted(path, np.array(shares) * path[-1])]
