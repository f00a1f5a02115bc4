"""The effects that a simulated twin holds beyond the plain model, found by a criticism of the twin itself.

Many effects have one sign: there is no negative friction. So a twin with too much friction would be reported under another name, unless the
model that stands in for it has that effect with a size that may turn out to be too large. The output of a twin has no noise. As much is
added as the recording has, since what would drown in that does not matter.
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

BEYOND = 1.0  # times the recording's noise in the common band (RMS), above which what a twin has beyond its surrogate is looked for
MOST = 2  # causes that are looked for in a twin
LEAST = 1e-4  # of the range of a channel, the least that its noise is taken to be,
FINEST = 1e-6  # N, the same for a channel that never changes

Split = Callable[[list[Session]], tuple[list[Session], list[Session]]]


def with_effects_of(surrogate: Model, said: list[Session], recordings: list, split: Split, mass: float, progress: Progress) -> Model:
    """The surrogate with the effects that a twin holds. `said` is the twin's output as sessions of these recordings; `split` divides them
    into fitted and held-out ones."""
    noise = [_noise_of(r, s) for r, s in zip(recordings, said, strict=True)]
    if not any(_is_beyond(surrogate, s, n) for s, n in zip(said, noise, strict=True)):
        return surrogate
    rng = np.random.default_rng(0)
    train, held = split([_with_noise(s, n * rng.standard_normal(s.raw.shape)) for s, n in zip(said, noise, strict=True)])
    found = criticise(train, held, None, lambda stage: progress(f"the twin: {stage}"), mass, most=MOST)
    return replace(found.extended.model, name=surrogate.name, source=surrogate.source)


def _noise_of(recording, said: Session) -> np.ndarray:
    """White noise of every measured force, N RMS (C, 1)."""
    both = [(recording.channels[c], y) for c, y in zip(said.channels, said.raw, strict=True)]
    return np.array([[max(white_noise(y), LEAST * float(np.ptp(y)), LEAST * float(np.ptp(twin)), FINEST)] for y, twin in both])


def _is_beyond(surrogate: Model, said: Session, noise: np.ndarray) -> bool:
    rest = np.sqrt(np.mean(residual(surrogate, said) ** 2, axis=1, keepdims=True))
    return bool(np.any(rest > BEYOND * said.band.passes * noise))


def _with_noise(said: Session, noise: np.ndarray) -> Session:
    raw = said.raw + noise
    return replace(said, raw=raw, bridged=raw, measured=said.band.thin(raw))
