"""Puts an effect into a recording.

An effect of a force sensor is applied to the measured channel itself, and so are coarse steps of the depth encoder. Any other effect
cannot be applied to a recording: it is simulated on the same motion, and the difference from a simulation without it is added to the
measured channels.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.sessions.session import Session
from skin_ident.recordings.recording import Recording
from skin_models.effect import Effect, Place
from skin_models.model import Model

QUANTIZATION = "quantization"
SENSORS = (Place.LOAD_CELL, Place.TAXEL)


def applied(effect: Effect, recording: Recording, session: Session, model: Model, seed: int) -> Recording:
    """The recording as it would have been with `effect`.

    Channels that change are rounded to the declared steps of their converters again: to the nearest step for effects of a sensor, else to
    the step below or above at random, with the probability that keeps the mean, as noise would do. The effect is applied to the recording's
    samples; single readings of topics (`readings`) are dropped.
    """
    recording = replace(recording, readings={})
    after = changed(effect, recording, session, model, seed)
    if effect.cause == QUANTIZATION:
        return after
    return _converted(recording, after, None if effect.place in SENSORS else np.random.default_rng([seed, 13]))


def changed(effect: Effect, recording: Recording, session: Session, model: Model, seed: int) -> Recording:
    """The recording with `effect`, before the rounding by converters."""
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
    """`y` plus what the effect adds. Unless it `pulls`, the effect cannot push a reading below zero (or below `y`, where that is negative):
    where it takes away more force than there is, the plunger has left the skin that the model still presses."""
    return y + difference if pulls else np.maximum(y + difference, np.minimum(y, 0.0))


def _converted(before: Recording, after: Recording, rng: np.random.Generator | None) -> Recording:
    """`after` with every channel that changed rounded to the declared step of its converter, where one is declared."""
    declared = before.declared
    steps = [declared.of_taxel("taxel_step_n", i) for i in range(len(after.taxels))]
    taxels = [_steps(a, b, step, rng) for a, b, step in zip(after.taxels, before.taxels, steps, strict=True)]
    force = None if after.force is None else _steps(after.force, before.force, declared.force_step_n, rng)
    return replace(after, force=force, taxels=np.array(taxels) if taxels else after.taxels)


def _steps(y: np.ndarray, before: np.ndarray, step: float | None, rng: np.random.Generator | None) -> np.ndarray:
    if step is None or np.array_equal(y, before):
        return y
    return step * np.floor(y / step + (0.5 if rng is None else rng.random(y.shape)))
