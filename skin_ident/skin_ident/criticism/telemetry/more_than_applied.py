"""A taxel that reads more than what presses on it.

A skin leads a part of the force through a taxel and the rest around it. With the load x (the depth, or the force that drives a test without
one) as the instrument, which noise of the load cell does not bend,

    ratio = sum (x - mean x) taxel / sum (x - mean x) force

is k1 / (k1 + k2) of the thesis's model, below one for every skin. Above one, force and taxel are not in one unit, their columns are
exchanged, a calibration is wrong, or another taxel leaks into this one. Which of them is wrong nobody can tell from the record.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.criticism.telemetry.units import FOLLOWS, declared_step, load_of, pressed
from skin_models.model import Model

KIND = "more than applied"
MORE, SURE = 1.1, 3.0  # a ratio from which it is said, and standard errors above one
BLOCKS = 10  # of a session, for the standard error
LEAST = 0.3  # of the force, that a skin leads through the taxel under the plunger
UNITS = {9.80665: "kilograms-force", 4.44822: "pounds-force", 1000.0: "kilonewtons"}  # how many newtons one of them is
WHOLE = 1e-6  # relative, by which steps of counts may differ from a whole number
APART = "hang one known weight on the load cell, and lay it on the taxel"


@dataclass(frozen=True)
class Ratio:
    """What a taxel reads of the force, and its standard error."""

    value: float
    std: float

    @property
    def is_more(self) -> bool:
        """Whether no skin does that, beyond doubt."""
        return self.value > MORE and self.value - 1.0 > SURE * self.std


def find_more_than_applied(recordings: list, known: tuple[str, ...] = ()) -> list[Symptom]:
    """One symptom, of the taxel that reads most, where all sessions at one place agree that it is more than the force. Channels whose units
    are `known` to be wrong are not asked, nor are taxels in volts or in counts, whose steps are whole numbers."""
    first = recordings[0]
    if first.force is None or "force" in known:
        return []
    asked = [i for i in range(len(first.taxels)) if f"taxel_{i}" not in known and in_newtons(recordings, i)]
    found = [(worst.value, i, worst) for i in asked if (worst := _worst([(r, _ratio(r, i)) for r in recordings]))]
    return [_symptom(recordings, *max(found)[1:])] if found else []


def is_left(symptom: Symptom, model: Model) -> bool:
    """Whether the taxel reads more than what is applied in a model that knows more, too: in one whose taxel drifts away, or whose load cell
    bends under the load, the skin itself may lead less than all of it there."""
    i = int(symptom.channels[-1].rpartition("_")[2])
    return model.shares[i] * model.dispersion.sensed_share >= 1.0


def in_newtons(recordings: list, i: int) -> bool:
    """Whether a taxel's numbers are newtons as far as one can see: neither volts nor counts."""
    seen = (r.step(f"taxel_{i}") for r in recordings)
    step = declared_step(recordings[0], f"taxel_{i}") or next(filter(None, seen), 0.0)
    counts = step >= 1.0 and abs(step / round(step) - 1.0) < WHOLE
    return all(r.taxel_units[i] == "N" for r in recordings) and not counts


def _ratio(r, i: int) -> Ratio | None:
    """None where force or taxel do not follow the load."""
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
    """The least sure of the sessions at a place where all of them are more."""
    places: dict[tuple[float, ...], list[Ratio | None]] = {}
    for r, ratio in ratios:
        places.setdefault(tuple(r.declared.contact_of(r.name)), []).append(ratio)
    agreed = [own for own in places.values() if all(q is not None and q.is_more for q in own)]
    return max((min(own, key=lambda q: q.value) for own in agreed), key=lambda q: q.value, default=None)


def _symptom(recordings: list, i: int, ratio: Ratio) -> Symptom:
    channel, n = f"taxel_{i}", len(recordings[0].taxels)
    taxel = sensor_of(channel, n)
    reads = f"{channel} reads {ratio.value:.3g} ± {ratio.std:.2g} times the force that the load cell says is applied"
    why = "; ".join([f"{reads}, and a skin leads at most all of it through a taxel", *_guesses(channel, ratio.value)])
    evidence = {"why": why, "kind": KIND, "ratio": ratio.value, "std": ratio.std}
    rivals = (("gain_error", "load_cell"), ("gain_error", taxel), ("data_error", taxel))
    rivals += (("crosstalk", taxel),) if n > 1 else ()
    parameters = {"ratio": {**quantity(ratio.value, "1"), "std": ratio.std}}
    return Symptom("data_error", "load_cell", ("force", channel), parameters, evidence, alternatives=rivals, apart=APART)


def _guesses(channel: str, ratio: float) -> list[str]:
    """What would make a share of it that a skin can have."""
    units = [
        f"if the load cell's numbers are {name}, not newtons, its share is {ratio / f:.2g}"
        for f, name in UNITS.items()
        if LEAST < ratio / f < 1.0
    ]
    swapped = [f"if the columns force and {channel} are exchanged, its share is {1.0 / ratio:.2g}"] if LEAST < 1.0 / ratio < 1.0 else []
    return [*swapped, *units]
