"""What a simulated twin holds beyond the plain model: the effects that a criticism of the twin itself finds.

Many effects have one sign: no friction is less than none. So a twin with too much of one is told by another name, unless what stands in
for it holds that effect, with a number that may turn out to be too large. A twin is read without noise; as much is added as the recording
has, for what would drown in that is no matter.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.search.criticise import criticise
from skin_ident.criticism.search.state import Progress
from skin_ident.criticism.sessions.session import Session
from skin_ident.estimators.scale import white_noise
from skin_models.model import Model

BEYOND = 1.0  # times the recording's noise in the common band (RMS), from which what a twin says beyond its surrogate is asked
MOST = 2  # causes that are looked for in a twin
LEAST = 1e-4  # of the range of a channel, the least that its noise is taken for,
FINEST = 1e-6  # N, of one that never changes

Split = Callable[[list[Session]], tuple[list[Session], list[Session]]]


def with_effects_of(surrogate: Model, said: list[Session], recordings: list, split: Split, mass: float, progress: Progress) -> Model:
    """The surrogate with the effects that a twin holds, which has `said` so in sessions of these recordings; `split` tells those that
    are fitted from those that are held out."""
    noise = [_noise_of(r, s) for r, s in zip(recordings, said, strict=True)]
    if not any(_is_beyond(surrogate, s, n) for s, n in zip(said, noise, strict=True)):
        return surrogate
    rng = np.random.default_rng(0)
    train, held = split([_with_noise(s, n * rng.standard_normal(s.raw.shape)) for s, n in zip(said, noise, strict=True)])
    found = criticise(train, held, None, lambda stage: progress(f"the twin: {stage}"), mass, most=MOST)
    return replace(found.extended.model, name=surrogate.name, source=surrogate.source)


def _noise_of(recording, said: Session) -> np.ndarray:
    """The white noise of every force that was measured, N rms (C, 1)."""
    both = [(recording.channels[c], y) for c, y in zip(said.channels, said.raw, strict=True)]
    return np.array([[max(white_noise(y), LEAST * float(np.ptp(y)), LEAST * float(np.ptp(twin)), FINEST)] for y, twin in both])


def _is_beyond(surrogate: Model, said: Session, noise: np.ndarray) -> bool:
    rest = np.sqrt(np.mean(residual(surrogate, said) ** 2, axis=1, keepdims=True))
    return bool(np.any(rest > BEYOND * said.band.passes * noise))


def _with_noise(said: Session, noise: np.ndarray) -> Session:
    raw = said.raw + noise
    return replace(said, raw=raw, bridged=raw, measured=said.band.thin(raw))
