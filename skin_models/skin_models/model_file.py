"""Models as YAML: what `fit` and `diagnose` write, `skin_node` loads and a person edits.

    schema: 1
    name: silicone 4 mm
    source: thesis Table 4-5
    dispersion:
      m: {value: 0.000432, unit: kg}
      ...
    shares: [1.0]
    effects:
      - cause: stress_relaxation
        where: skin
        parameters:
          tau: {value: 0.8, unit: s, std: 0.05}
          ...

Where the taxels are, for effects of the spread and contacts that move: `positions: {value: [[0.0, 0.0], [0.014, 0.0]], unit: m}`.

An effect that comes in several forms also says which: `form: hunt_crossley`. Without the entry it is the plainest.

Every parameter must be there, with its unit: a file that leaves one out, says one twice, or says mm where m is meant, is refused with one
sentence.
"""

import os
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import yaml

from skin_models.catalogue import effect_class
from skin_models.dispersion import Dispersion
from skin_models.effect import Effect
from skin_models.errors import ModelError
from skin_models.model import Model
from skin_models.parameter import parameters_of
from skin_models.spread.noted import kernel_of
from skin_models.strict_yaml import load_yaml
from skin_models.whole_file import whole_file

SCHEMA = 1


def load_model(path: str | os.PathLike) -> Model:
    """The model in a YAML file. Raises `ModelError` naming the file and what is wrong with it."""
    try:
        return model_from_dict(load_yaml(Path(path).read_text(encoding="utf-8")))
    except (OSError, UnicodeDecodeError) as error:
        raise ModelError(f"cannot read the model {path}: {getattr(error, 'strerror', None) or error}") from error
    except yaml.YAMLError as error:
        raise ModelError(f"{path} is not YAML: {' '.join(str(error).split())}") from error
    except ModelError as error:
        raise ModelError(f"{path}: {error}") from error


def save_model(model: Model, path: str | os.PathLike, std: Mapping[str, float] | None = None) -> None:
    """Write a model whole or not at all. `std` gives standard errors by parameter, keyed `k1`, or as `Model.listed_as` says.

    Raises `ModelError` where it cannot be written.
    """
    path, text = Path(path), yaml.safe_dump(model_to_dict(model, std or {}), sort_keys=False, allow_unicode=True)
    try:
        with whole_file(path) as partial:
            partial.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ModelError(f"cannot write the model {path}: {error.strerror or error}") from error


def model_to_dict(model: Model, std: Mapping[str, float] | None = None) -> dict[str, Any]:
    """The content of the YAML file; changing it leaves the model as it is."""
    std = std or {}
    spreads = [{p: std[name] for p in e.values if (name := model.listed_as(i, p)) in std} for i, e in enumerate(model.effects)]
    return {
        "schema": SCHEMA,
        "name": model.name,
        "source": model.source,
        "dispersion": _parameters_to_dict(model.dispersion, std),
        "shares": [float(share) for share in model.shares],
        **({"positions": {"value": [[float(x), float(y)] for x, y in model.positions], "unit": "m"}} if model.positions else {}),
        "effects": [_effect_to_dict(e, spread) for e, spread in zip(model.effects, spreads, strict=True)],
        **({"notes": deepcopy(model.notes)} if model.notes else {}),
    }


def model_from_dict(content: Any) -> Model:
    """The model that `model_to_dict` describes. Raises `ModelError` for a missing, unknown or wrongly typed entry."""
    content = _mapping(content, "a model")
    if "schema" not in content:
        raise ModelError(
            f"it does not say schema: {SCHEMA}, with which a model begins; dispersion, shares and effects follow, as the README of "
            "skin_models shows"
        )
    if content["schema"] != SCHEMA:
        raise ModelError(f"schema is {content['schema']!r}; this version reads schema {SCHEMA}")
    _only(content, {"schema", "name", "source", "dispersion", "shares", "positions", "effects", "notes"}, "a model")
    shares = content.get("shares", [1.0])
    if not isinstance(shares, list) or not all(_is_number(share) for share in shares):
        raise ModelError("shares must be a list of numbers, one per taxel")
    effects = content.get("effects") or []
    if not isinstance(effects, list):
        raise ModelError("effects must be a list, every entry with cause, where and parameters")
    model = Model(
        dispersion=Dispersion(**_values(Dispersion, content.get("dispersion"), "dispersion")),
        shares=tuple(float(share) for share in shares),
        effects=tuple(_effect(entry) for entry in effects),
        name=str(content.get("name", "model")),
        source=str(content.get("source", "")),
        notes=_mapping(content.get("notes", {}), "notes"),
        positions=_positions(content["positions"]) if "positions" in content else (),
    )
    kernel_of(model.notes)  # raises for notes on the spread that cannot be understood
    return model


def _positions(entry: Any) -> tuple[tuple[float, float], ...]:
    pairs = entry.get("value") if isinstance(entry, Mapping) and entry.get("unit") == "m" else None
    if not isinstance(pairs, list) or not all(isinstance(p, list) and len(p) == 2 and all(map(_is_number, p)) for p in pairs):
        raise ModelError("positions must be written as {value: [[x, y], …], unit: m}, one pair per taxel")
    return tuple((float(x), float(y)) for x, y in pairs)


def _effect(entry: Any) -> Effect:
    entry = _mapping(entry, "an effect")
    _only(entry, {"cause", "where", "form", "parameters"}, "an effect")
    for key in ("cause", "where", "parameters"):
        if key not in entry:
            raise ModelError(f"an effect has no {key!r}: it needs cause, where and parameters")
    cls = effect_class(str(entry["cause"]), str(entry["where"]), str(entry.get("form", "")))
    return cls(where=str(entry["where"]), **_values(cls, entry["parameters"], cls.cause))


def _effect_to_dict(e: Effect, std: Mapping[str, float]) -> dict[str, Any]:
    form = {"form": e.form} if e.form else {}
    return {"cause": e.cause, "where": e.where, **form, "parameters": _parameters_to_dict(e, std)}


def _parameters_to_dict(thing: Any, std: Mapping[str, float]) -> dict[str, Any]:
    def entry(p):
        spread = {"std": float(std[p.name])} if p.name in std else {}
        return {"value": float(p.value), "unit": p.unit, **spread}

    return {p.name: entry(p) for p in parameters_of(thing)}


def _values(cls: type, entries: Any, label: str) -> dict[str, float]:
    entries, declared = _mapping(entries, label), {p.name: p for p in parameters_of(cls)}
    _only(entries, set(declared), label)
    missing = [name for name in declared if name not in entries]
    if missing:
        raise ModelError(f"{label} lacks {', '.join(missing)}")
    return {name: _value(f"{label}.{name}", entries[name], declared[name].unit) for name in declared}


def _value(label: str, entry: Any, unit: str) -> float:
    if not isinstance(entry, Mapping) or "value" not in entry or "unit" not in entry:
        raise ModelError(f"{label} must be written as {{value: …, unit: {unit}}}")
    _only(entry, {"value", "unit", "std"}, label)
    if str(entry["unit"]) != unit:  # a bare 1 is read as a number
        raise ModelError(f"{label} is in {entry['unit']!r}, but must be in {unit!r}")
    if not _is_number(entry["value"]):
        raise ModelError(f"{label} must have a number as its value, not {entry['value']!r}")
    return float(entry["value"])


def _mapping(thing: Any, label: str) -> dict:
    if not isinstance(thing, Mapping):
        raise ModelError(f"{label} must be a mapping of names to values")
    return dict(thing)


def _only(entries: Mapping, known: set[str], label: str) -> None:
    unknown = sorted(set(map(str, entries)) - known)
    if unknown:
        raise ModelError(f"{label} has an unknown entry {unknown[0]!r}; known are {', '.join(sorted(known))}")


def _is_number(thing: Any) -> bool:
    return isinstance(thing, (int, float)) and not isinstance(thing, bool)
