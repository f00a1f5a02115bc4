"""What noise of the encoder feigns of a gain, told by reading the depth with more of it.

What smooths a depth, or moves where it rests, keeps noise of the encoder from the forces, and what is fitted to a noisy depth makes up for
what the noise has made of damping. All of that grows with the variance of the noise; what a true cause explains does not. With one more
draw of the noise its variance is twice as large: of a gain G(1) the noise feigns as much as G(2) is larger, and G(1) - (G(2) - G(1)) would
be left without any (SIMEX, linear: J. R. Cook, L. A. Stefanski, J. Am. Stat. Assoc. 89, 1314, 1994).
"""

import numpy as np

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.read_again import with_noise_again
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

SEED = 0  # any: the same record is told the same


def feigned(before: Model, after: Model, train: list[Session], noise: Whitener, channel: str) -> float:
    """By how much the mean square in `channel`, N^2, falls more from `before` to `after` where both are fitted to a depth with twice the
    variance of white noise; at least nothing. A draw and its opposite are taken, so that products with what is left anyway cancel. Of
    rounding to steps nothing is told so: its errors are the same wherever the plunger comes back to, and a cause is fitted to these."""
    rng = np.random.default_rng(SEED)
    draws = [rng.standard_normal(len(s.motion)) for s in train]
    noisier = [
        _fall(*(fit(m, again, noise).model for m in (before, after)), again, channel)
        for again in ([with_noise_again(s, sign * z) for s, z in zip(train, draws, strict=True)] for sign in (1.0, -1.0))
    ]
    return max(float(np.mean(noisier)) - _fall(before, after, train, channel), 0.0)


def _fall(before: Model, after: Model, sessions: list[Session], channel: str) -> float:
    """Fall of the mean square in a channel, N^2."""
    was, now = (
        sum(float(np.sum(s.weight[row] * residual(m, settled(m, s))[row] ** 2)) for s, row in _rows(sessions, channel))
        for m in (before, after)
    )
    return (was - now) / max(sum(float(np.sum(s.weight[row])) for s, row in _rows(sessions, channel)), 1.0)


def _rows(sessions: list[Session], channel: str) -> list[tuple[Session, int]]:
    return [(s, s.channels.index(channel)) for s in sessions]
