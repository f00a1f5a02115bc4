"""What a finding says of a given model: its numbers, put right, and which of its effects the record has not."""

from collections.abc import Iterator
from typing import Any

from skin_ident.criticism.search.named import Named
from skin_ident.criticism.vocabulary import cause_at
from skin_models.effect import Effect
from skin_models.model import Model
from skin_models.parameter import AMPLITUDE, parameters_of

SURE = 3.0  # standard errors, within which a size is nothing


def refitted(named: Named, model: Model, std: dict[str, float]) -> dict[str, Any]:
    """The numbers of a given model that were fitted, and those of its effects: what is held is as it was given."""
    skin = {p.name: p for p in parameters_of(model.dispersion)}
    effects = {model.listed_as(i, p.name): p for i, _, e in _of_given(named, model) for p in parameters_of(e)}
    return {label: {"value": p.value, "unit": p.unit, "std": std[label]} for label, p in (skin | effects).items() if label in std}


def not_there(named: Named, model: Model, std: dict[str, float]) -> dict[str, str]:
    """Which effects of a given model the record has not: all their sizes are nothing, within what is known of them."""
    if named.cause != "parameters":
        return {}

    def is_nothing(i: int, e: Effect) -> bool:
        sizes = [p for p in parameters_of(e) if p.role == AMPLITUDE]
        return all(abs(p.value) <= SURE * std.get(model.listed_as(i, p.name), 0.0) for p in sizes)

    without = [cause_at(e.cause, e.where) for i, given, e in _of_given(named, model) if given != e and is_nothing(i, e)]
    return {"why": f"the given model has {' and '.join(without)}, of which the record shows nothing"} if without else {}


def _of_given(named: Named, model: Model) -> Iterator[tuple[int, Effect, Effect]]:
    """The effects of the given model by their place in the list, as given and as fitted."""
    both = zip(named.before.effects if named.before else (), model.effects, strict=False)
    yield from ((i, given, e) for i, (given, e) in enumerate(both) if type(given) is type(e) and given.where == e.where)
