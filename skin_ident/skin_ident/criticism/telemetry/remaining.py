"""Which symptoms remain once the named causes are in the model.

Telemetry examines the residual of a first fit. A large effect leaves much in it, and some of that looks like a fault of the record. What
the extended model explains was no fault.
"""

import numpy as np

from skin_ident.criticism.telemetry import lines, more_than_applied, wrong_samples
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.vocabulary import MORE_THAN_APPLIED
from skin_models.model import Model


def remains(symptom: Symptom, recordings: list, channels: tuple[str, ...], rests: list[np.ndarray], model: Model) -> bool:
    """Whether a symptom is still there in measured less simulated (C, N) N of each recording under the extended `model`. Symptoms that no
    model could explain remain."""
    if symptom.evidence.get("kind") == MORE_THAN_APPLIED:
        return more_than_applied.is_left(symptom, model)
    if symptom.channels[0] not in channels:
        return True
    row = channels.index(symptom.channels[0])
    if symptom.cause == "interference":
        there = symptom.evidence.get("only_in", [r.name for r in recordings])
        have = [(e[row], r.dt) for e, r in zip(rests, recordings, strict=True) if r.name in there]
        return lines.is_left(symptom, *map(list, zip(*have, strict=True)))
    return symptom.cause != "outliers" or wrong_samples.are_left(symptom, recordings, row, rests)
