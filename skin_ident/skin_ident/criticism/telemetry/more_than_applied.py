"""A taxel that reads more than the applied force.

Skin leads a part of the force through a taxel and the rest around it. The load x (the depth, or the force that drives a test without depth)
serves as an instrument, so that noise of the load cell does not bias the ratio:

    ratio = sum (x - mean x) taxel / sum (x - mean x) force

is k1 / (k1 + k2) of the thesis's model, below one for every skin. Above one, force and taxel are not in the same unit, their columns are
exchanged, a calibration is wrong, or another taxel leaks into this one. The ratio cannot tell which; where noise is declared, a load cell
that is as much too quiet as numbers in another unit are too small speaks for that unit.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.criticism.telemetry.units import FOLLOWS, declared_step, load_of, pressed
from skin_ident.criticism.vocabulary import MORE_THAN_APPLIED
from skin_models.model import Model

MORE, SURE = 1.1, 3.0  # least ratio that is reported; standard errors by which it must exceed one
BLOCKS = 10  # blocks of a session, for the standard error
LEAST = 0.3  # least share of the force that skin leads through the taxel under the plunger
UNITS = {9.80665: "kilograms-force", 4.44822: "pounds-force", 1000.0: "kilonewtons"}  # newtons in one of each unit
AS_QUIET = 0.25  # relative deviation of the noise, over what is declared, from what it is in another unit
WHOLE = 1e-6  # relative deviation of a step from a whole number, up to which readings are counts
APART = "hang one known weight on the load cell, and lay it on the taxel"


@dataclass(frozen=True)
class Ratio:
    """The ratio of a taxel's reading to the force, and its standard error."""

    value: float
    std: float

    @property
    def is_more(self) -> bool:
        """Whether the ratio is clearly more than any skin can have."""
        return self.value > MORE and self.value - 1.0 > SURE * self.std


def find_more_than_applied(recordings: list, known: tuple[str, ...] = ()) -> list[Symptom]:
    """At most one symptom: the taxel with the highest ratio, if all sessions at one place agree that it reads more than the force. Not
    tested are channels whose units are `known` to be wrong, and taxels in volts or in counts, whose steps are whole numbers."""
    first = recordings[0]
    if first.force is None or "force" in known:
        return []
    asked = [i for i in range(len(first.taxels)) if f"taxel_{i}" not in known and in_newtons(recordings, i)]
    found = [(worst.value, i, worst) for i in asked if (worst := _worst([(r, _ratio(r, i)) for r in recordings]))]
    return [_symptom(recordings, *max(found)[1:])] if found else []


def is_left(symptom: Symptom, model: Model) -> bool:
    """Whether the taxel reads more than the applied force in the extended model, too. If its taxel drifts, or its load cell is not linear,
    the model's skin may lead less than the whole force through the taxel."""
    i = int(symptom.channels[-1].rpartition("_")[2])
    return model.shares[i] * model.dispersion.sensed_share >= 1.0


def told_by_noise(symptoms: Sequence[Symptom]) -> list[Symptom]:
    """The symptoms, where noise tells the unit of a load cell that reads less than a taxel: its noise is then no finding of its own, but
    evidence for that unit."""
    more = next((s for s in symptoms if s.evidence.get("kind") == MORE_THAN_APPLIED), None)
    quiet = next((s for s in symptoms if (s.cause, s.where, s.evidence.get("kind")) == ("noise", "load_cell", "level")), None)
    if not (more and quiet):
        return [*symptoms]
    times = quiet.parameters["times_expected"]["value"]
    unit = next((name for f, name in _units(more.evidence["ratio"]) if abs(times * f - 1.0) < AS_QUIET), None)
    if not unit:
        return [*symptoms]
    why = f"{more.evidence['why']}; its noise, too, is {times:.2g} times what rig.yaml declares, as numbers in {unit} are"
    return [replace(s, evidence={**s.evidence, "why": why}) if s is more else s for s in symptoms if s is not quiet]


def in_newtons(recordings: list, i: int) -> bool:
    """Whether a taxel's numbers appear to be newtons: neither volts nor counts."""
    seen = (r.step(f"taxel_{i}") for r in recordings)
    step = declared_step(recordings[0], f"taxel_{i}") or next(filter(None, seen), 0.0)
    counts = step >= 1.0 and abs(step / round(step) - 1.0) < WHOLE
    return all(r.taxel_units[i] == "N" for r in recordings) and not counts


def _ratio(r, i: int) -> Ratio | None:
    """The ratio in one session; None where force or taxel do not follow the load."""
    x = r.force if r.depth is None else load_of(r, "force")
    if x is None:
        return None
    x, *rows = (row[pressed(r)] for row in (x, r.force, r.taxels[i]))
    if np.any(np.ptp(rows, axis=1) == 0.0) or min(np.corrcoef(x, y)[0, 1] for y in rows) < FOLLOWS:
        return None
    x = x - x.mean()
    force, taxel = (np.array([b.sum() for b in np.array_split(x * (y - y.mean()), BLOCKS)]) for y in rows)
    value = float(taxel.sum() / force.sum())
    scatter = np.sum((taxel - value * force) ** 2) * BLOCKS / (BLOCKS - 1)
    return Ratio(value, float(np.sqrt(scatter) / force.sum()))


def _worst(ratios: list[tuple[object, Ratio | None]]) -> Ratio | None:
    """Among places where all sessions have a ratio above one, the highest of their lowest ratios; None if there is no such place."""
    places: dict[tuple[float, ...], list[Ratio | None]] = {}
    for r, ratio in ratios:
        places.setdefault(tuple(r.declared.contact_of(r.name)), []).append(ratio)
    agreed = [own for own in places.values() if all(q is not None and q.is_more for q in own)]
    return max((min(own, key=lambda q: q.value) for own in agreed), key=lambda q: q.value, default=None)


def _symptom(recordings: list, i: int, ratio: Ratio) -> Symptom:
    channel, n = f"taxel_{i}", len(recordings[0].taxels)
    taxel = sensor_of(channel, n)
    reads = f"{channel} reads {ratio.value:.3g} ± {ratio.std:.2g} times the force that the load cell says is applied"
    why = "; ".join([f"{reads}, and no taxel can receive more than the applied force", *_guesses(channel, ratio.value)])
    evidence = {"why": why, "kind": MORE_THAN_APPLIED, "ratio": ratio.value, "std": ratio.std}
    rivals = (("gain_error", "load_cell"), ("gain_error", taxel), ("data_error", taxel))
    rivals += (("crosstalk", taxel),) if n > 1 else ()
    parameters = {"ratio": {**quantity(ratio.value, "1"), "std": ratio.std}}
    return Symptom("data_error", "load_cell", ("force", channel), parameters, evidence, alternatives=rivals, apart=APART)


def _guesses(channel: str, ratio: float) -> list[str]:
    """Explanations, in words, under which the ratio becomes a share that skin can have."""
    units = [f"if the load cell's numbers are {name}, not newtons, its share is {ratio / f:.2g}" for f, name in _units(ratio)]
    swapped = [f"if the columns force and {channel} are exchanged, its share is {1.0 / ratio:.2g}"] if LEAST < 1.0 / ratio < 1.0 else []
    return [*swapped, *units]


def _units(ratio: float) -> list[tuple[float, str]]:
    """The units of the load cell's numbers, as newtons in one and name, in which the ratio becomes a share that skin can have."""
    return [(f, name) for f, name in UNITS.items() if LEAST < ratio / f < 1.0]
