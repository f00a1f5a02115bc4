"""Whether the numbers of a given model are wrong."""

from dataclasses import replace

from skin_ident.criticism.baseline.fitting import fit_effects
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.state import Search
from skin_models.model import Model

WRONG = 0.1  # relative fall of the held-out error by which given numbers are called wrong: an imperfect effect bends them a little


def check_numbers(search: Search, given: Model) -> None:
    """Name `parameters` where the numbers of the given model are wrong once every named cause is in it; where they are not, they stay."""
    present = search.present.model
    as_given = replace(present, dispersion=given.dispersion, shares=given.shares, name=given.name, source=given.source)
    frozen = fit_effects(as_given, search.train, search.noise)
    gain = search.gain(frozen.model, present, "skin", fit_effects)
    if gain.passed and gain.before - gain.after > WRONG * gain.before:
        search.named.insert(0, Named("parameters", "skin", gain, frozen.cost - search.present.cost, ()))
    else:
        search.present = frozen
