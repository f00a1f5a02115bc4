"""The record's own faults as effects of the catalogue, which the simulated skin carries from then on.

Saturation, coarse steps and a dead taxel follow from the load: a model that has them predicts held-out data better, and the gain is
reported. (Coarse steps predict better only where the noise does not carry the readings across the steps; otherwise the mean is predicted
best without them.) Interference comes in at any phase, and noise and outliers at random. They are in the model that the skin node loads, so
that its topics look like the measured ones, but they predict nothing and no gain is claimed. Faults of the encoder and errors of data are
no part of the simulated chain, and a taxel that dies part-way has no effect in the catalogue.
"""

from collections.abc import Iterable
from dataclasses import replace

from skin_ident.criticism.telemetry.quantization import is_uneven
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.vocabulary import SENSORS
from skin_models.effect import Effect
from skin_models.effects.adhesion import Adhesion
from skin_models.effects.dead_taxel import DeadTaxel
from skin_models.effects.interference import Interference
from skin_models.effects.noise import Noise
from skin_models.effects.outliers import Outliers
from skin_models.effects.quantization import SensorQuantization
from skin_models.effects.saturation import LeakySaturation, Saturation
from skin_models.model import Model
from skin_models.parameter import clipped

PREDICTS = ("saturation", "quantization", "dead_taxel")  # causes that predict held-out data: the others come at random, or are not compared
UNLIKE = "unlike_simulated"  # evidence that the catalogue's effect would take the simulation further from the record


def effect_of(s: Symptom) -> Effect | None:
    """The effect that simulates the symptom; None where the catalogue has none, or none that is like it."""
    if not s.where.startswith((*SENSORS, "skin")) or s.cause not in _MAKERS or s.evidence.get(UNLIKE):
        return None
    return _MAKERS[s.cause](s, {name: q["value"] for name, q in s.parameters.items()})


def effects_of(symptoms: Iterable[Symptom]) -> list[Effect]:
    """The effects of all symptoms that have one."""
    return [e for e in map(effect_of, symptoms) if e is not None]


def with_effects(model: Model, effects: Iterable[Effect]) -> Model:
    """The model with these effects appended, except those it already has."""
    return replace(model, effects=(*model.effects, *(e for e in effects if e not in model.effects)))


def _made(cls: type[Effect], where: str, **values: float) -> Effect:
    """The effect, with values clipped to its bounds."""
    return cls(where, **clipped(cls, **values))


def _dead(s: Symptom, v: dict[str, float]) -> Effect | None:
    return None if s.bad else _made(DeadTaxel, s.where, lost=v["lost"], level=v["level"])


def _outliers(s: Symptom, v: dict[str, float]) -> Effect | None:
    return _made(Outliers, s.where, rate=v["rate"], size=v["size"]) if s.evidence.get("excursions") else None


def _noise(s: Symptom, v: dict[str, float]) -> Effect:
    known = {name: v[name] for name in ("white", "coloured", "proportional", "tau") if name in v}
    return _made(Noise, s.where, **known)


_MAKERS = {
    "adhesion": lambda s, v: _made(Adhesion, s.where, **v),
    "saturation": lambda s, v: _made(LeakySaturation if "lost" in v else Saturation, s.where, **v),
    "quantization": lambda s, v: None if is_uneven(s) else _made(SensorQuantization, s.where, step_force=v["step"]),
    "interference": lambda s, v: _made(Interference, s.where, sine=v["amplitude"], frequency=v["frequency"]),
    "dead_taxel": _dead,
    "outliers": _outliers,
    "noise": _noise,
}
