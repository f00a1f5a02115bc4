"""What a finding says about a given model: its corrected parameters, and which of its effects the record hardly shows."""

from collections.abc import Iterator
from typing import Any

from skin_ident.criticism.search.named import Named
from skin_ident.criticism.vocabulary import cause_at
from skin_models.effect import Effect
from skin_models.model import Model
from skin_models.parameter import AMPLITUDE, parameters_of

SURE = 3.0  # standard errors within which an amplitude counts as zero,
HARDLY = 0.1  # or this share of its given value


def numbers_fitted(named: Named, model: Model, std: dict[str, float]) -> dict[str, Any]:
    """The parameters of a given model that were fitted (dispersion model, shares and its effects); those that were held are left out."""
    numbers = {p.name: (p.value, p.unit) for p in parameters_of(model.dispersion)}
    numbers |= {f"share_{i}": (share, "1") for i, share in enumerate(model.shares)}
    numbers |= {model.listed_as(i, p.name): (p.value, p.unit) for i, _, e in _of_given(named, model) for p in parameters_of(e)}
    return {label: {"value": value, "unit": unit, "std": std[label]} for label, (value, unit) in numbers.items() if label in std}


def not_there(named: Named, model: Model, std: dict[str, float]) -> dict[str, str]:
    """Which effects of a given model the record hardly shows, since all their fitted amplitudes are close to zero; as evidence `why`, or
    {}."""
    if named.cause != "parameters":
        return {}

    def hardly(i: int, given: Effect, e: Effect) -> bool:
        sizes = [p for p in parameters_of(e) if p.role == AMPLITUDE]
        most = (max(SURE * std.get(model.listed_as(i, p.name), 0.0), HARDLY * abs(getattr(given, p.name))) for p in sizes)
        return all(abs(p.value) <= size for p, size in zip(sizes, most, strict=True))

    own = list(_of_given(named, model))
    shown = {e.key for i, given, e in own if not hardly(i, given, e)}  # one of two arms may be there
    gone = dict.fromkeys(e.key for _, given, e in own if given != e and e.key not in shown)
    without = " and ".join(cause_at(*key) for key in gone)
    return {"why": f"the given simulation has {without}, which the record hardly shows"} if without else {}


def _of_given(named: Named, model: Model) -> Iterator[tuple[int, Effect, Effect]]:
    """The effects of the given model, each with its index, as given and as fitted."""
    both = zip(named.before.effects if named.before else (), model.effects, strict=False)
    yield from ((i, given, e) for i, (given, e) in enumerate(both) if type(given) is type(e) and given.where == e.where)
