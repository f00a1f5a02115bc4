"""Noise of the encoder, beside the rounding to its steps: more than rig.yaml declares, or unjudged where it declares none.

It is white noise found from differences of neighbouring readings, the median over sessions, so that motion and a few wrong samples do not
count. A stage that dithers does so, too: whether the plunger really moved cannot be seen in the depth alone, and the sentence says so.
"""

import numpy as np

from skin_ident.criticism.baseline.residual import stiffness
from skin_ident.criticism.sessions.cutoff import beside_rounding
from skin_ident.criticism.telemetry.noise_level import OTHER_LEVEL, declared_noise
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_models.model import Model

DITHER = "a stage that dithers reads the same"
DECLARED = "encoder_noise_um in rig.yaml: the rms of the depth's readings while the stage stands still with its motor off"


def find_encoder_noise(recordings: list) -> list[Symptom]:
    """The symptom that the depth is `OTHER_LEVEL` times as noisy as rig.yaml declares, or more. Less noise than declared is no fault."""
    declared = recordings[0].declared.encoder_noise_um
    if declared is None or 1e6 * (noise := _noise(recordings)) <= OTHER_LEVEL * declared:
        return []
    ratio = 1e6 * noise / declared
    why = f"the noise of the depth is {1e6 * noise:.3g} µm, {ratio:.2g} times the {declared:.3g} µm that rig.yaml declares; {DITHER}"
    numbers = {"times_expected": quantity(ratio, "1"), "white": quantity(noise, "m")}
    return [Symptom("noise", sensor_of("depth", len(recordings[0].taxels)), ("depth",), numbers, {"why": why, "kind": "level"})]


def undeclared_noise(recordings: list, model: Model) -> str:
    """Why nothing can be said about the noise of the encoder, where none is declared, and its noise, pressed through the stiffness of the
    skin, is as large as the noise that some channel is declared to have; else an empty text."""
    recording = recordings[0]
    declared = {c: level for c in recording.channels if (level := declared_noise(recording, c))}
    if recording.declared.encoder_noise_um is not None or not declared:
        return ""
    noise = _noise(recordings)
    felt = {c: noise * stiffness(model, c) for c in declared}
    most = max(felt, key=lambda c: felt[c] / declared[c])
    if felt[most] < declared[most]:
        return ""
    there = f"{felt[most]:.2g} N of {most}, as much as the noise that rig.yaml declares of it ({declared[most]:.2g} N) or more"
    return f"the noise of the depth is {1e6 * noise:.3g} µm and makes {there}; {DITHER}, and nothing declares how much there should be"


def _noise(recordings: list) -> float:
    """White noise of the depth beside rounding, m rms: the median over the sessions; 0 without a depth."""
    return float(np.median([beside_rounding(r) for r in recordings])) if recordings[0].depth is not None else 0.0
