"""The gate: a cause is believed when sessions that were not used to fit it are predicted better.

The held-out sessions are cut into blocks, long against the memory of the noise; the whitened squared error of each block before and
after is resampled by blocks (B. Efron, R. Tibshirani, An Introduction to the Bootstrap, 1993, ch. 8). Without sessions to hold out, each
training session is held out in turn, and both models are fitted to the others.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.fitting import fit
from skin_ident.criticism.residual import residual
from skin_ident.criticism.session import Session
from skin_ident.criticism.whitening import Whitener
from skin_models.model import Model

BLOCK_S = 2.0
RESAMPLES = 1000
FOLD_ITERATIONS = 3


@dataclass(frozen=True)
class Gain:
    """Held-out error before and after, N, in `channel`, the one that gained most; `ci95` bounds the fall of the RMSE there.

    `relative` and `lower` are the fall of the whitened mean square over all channels and its lower 99 % bound: the gate itself.
    """

    channel: str
    before: float
    after: float
    ci95: tuple[float, float]
    relative: float
    lower: float
    held_out: str

    @property
    def passed(self) -> bool:
        return self.lower > 0.0


def held_out_gain(before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> Gain:
    """What `after` gains over `before` on `held`, or by holding out each training session in turn where `held` is empty."""
    if held:
        pairs = [(s, before, after) for s in held]
        said = ", ".join(s.name for s in held)
    elif len(train) > 1:
        pairs = [(s, *_refitted(before, after, [o for o in train if o is not s], noise)) for s in train]
        said = "each session in turn"
    else:
        pairs = [(s, before, after) for s in train]
        said = "nothing: the only session was used to fit"
    return _gain(pairs, noise, said)


def _refitted(before: Model, after: Model, sessions: list[Session], noise: Whitener) -> tuple[Model, Model]:
    return tuple(fit(m, sessions, noise, FOLD_ITERATIONS).model for m in (before, after))


def _gain(pairs: list[tuple[Session, Model, Model]], noise: Whitener, said: str) -> Gain:
    white, plain = [], []  # per block: (before, after) whitened sum; (before, after, count) by channel
    for s, before, after in pairs:
        errors = [residual(m, s) for m in (before, after)]
        size = max(int(BLOCK_S / (s.band.dt * s.band.every)), 4)
        white.append(np.array([_by_block((noise.apply(e, s.weight) ** 2).sum(axis=0), size) for e in errors]))
        plain.append(np.array([[_by_block(row, size) for row in e**2 * s.weight] for e in errors] + [[_by_block(w, size) for w in s.weight]]))
    white, plain = np.concatenate(white, axis=-1), np.concatenate(plain, axis=-1)
    draws = np.random.default_rng(0).integers(0, white.shape[-1], (RESAMPLES, white.shape[-1]))
    falls = 1.0 - white[1][draws].sum(axis=1) / np.maximum(white[0][draws].sum(axis=1), 1e-300)
    rms = np.sqrt(plain[:2].sum(axis=-1) / np.maximum(plain[2].sum(axis=-1), 1e-300))
    c = int(np.argmax((rms[0] - rms[1]) / np.maximum(rms[0], 1e-300)))
    drawn = np.sqrt(plain[:2, c][:, draws].sum(axis=-1) / np.maximum(plain[2, c][draws].sum(axis=-1), 1e-300))
    low, high = np.percentile(drawn[0] - drawn[1], [2.5, 97.5])
    total = 1.0 - white[1].sum() / max(white[0].sum(), 1e-300)
    channel = pairs[0][0].channels[c]
    return Gain(channel, float(rms[0, c]), float(rms[1, c]), (float(low), float(high)), float(total), float(np.percentile(falls, 1.0)), said)


def _by_block(row: np.ndarray, size: int) -> np.ndarray:
    """Sums over consecutive blocks; a short last block is left out."""
    whole = row.size // size * size
    return row[:whole].reshape(-1, size).sum(axis=1)
