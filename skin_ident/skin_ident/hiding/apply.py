"""Putting an effect into a recording.

What a sensor or a clock does is done to the measured channel. What the skin or the rig does cannot be done to a recording: the difference
that the effect makes to a simulation of the same motion is added to the measured channels instead.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.sessions.session import Session
from skin_ident.recordings.recording import Recording
from skin_models.effect import Effect, Place
from skin_models.model import Model

QUANTIZATION = "quantization"


def applied(effect: Effect, recording: Recording, session: Session, model: Model, seed: int) -> Recording:
    """The recording as it would have been with `effect`. Channels that change fall on the declared steps of their converters again."""
    after = changed(effect, recording, session, model, seed)
    return after if effect.cause == QUANTIZATION else _converted(recording, after)


def changed(effect: Effect, recording: Recording, session: Session, model: Model, seed: int) -> Recording:
    """The same before the converters."""
    rng = np.random.default_rng([seed, 11])
    if effect.cause == QUANTIZATION and effect.place is Place.DEPTH:
        return replace(recording, depth=effect.batch(recording.depth, session.motion, rng))
    if effect.place is Place.LOAD_CELL:
        return replace(recording, force=effect.batch(recording.force, session.motion, rng))
    if effect.place is Place.TAXEL:
        return replace(recording, taxels=effect.batch(recording.taxels, session.motion, rng))
    difference = simulated(model.extended(effect), session) - simulated(model, session)
    pulls = effect.place not in (Place.DEPTH, Place.SKIN)
    if "force" not in session.channels:
        return replace(recording, taxels=_added(recording.taxels, difference, pulls))
    taxels = _added(recording.taxels, difference[1:], pulls) if len(recording.taxels) else recording.taxels
    return replace(recording, force=_added(recording.force, difference[0], pulls), taxels=taxels)


def _added(y: np.ndarray, difference: np.ndarray, pulls: bool) -> np.ndarray:
    """`y` and what the effect adds. One that `pulls` not leaves nothing where it takes more than there is: the skin that the model still
    presses is left by then."""
    return y + difference if pulls else np.maximum(y + difference, np.minimum(y, 0.0))


def _converted(before: Recording, after: Recording) -> Recording:
    """Where a converter's step is declared and the channel changed, its values are whole steps again."""
    declared = before.declared
    taxels = [_steps(a, b, declared.of_taxel("taxel_step_n", i)) for i, (a, b) in enumerate(zip(after.taxels, before.taxels, strict=True))]
    force = None if after.force is None else _steps(after.force, before.force, declared.force_step_n)
    return replace(after, force=force, taxels=np.array(taxels) if taxels else after.taxels)


def _steps(y: np.ndarray, before: np.ndarray, step: float | None) -> np.ndarray:
    return y if step is None or np.array_equal(y, before) else step * np.round(y / step)
