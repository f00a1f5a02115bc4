"""Which effect to hide: its cause, place and form, drawn at random where they are left open."""

from collections.abc import Iterable
from difflib import get_close_matches

import numpy as np

from skin_ident.criticism.search.proposals import places_of
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import BY_NAME
from skin_ident.hiding.errors import HidingError
from skin_models.catalogue import effects
from skin_models.effect import Effect
from skin_models.parameter import AMPLITUDE, Parameter, parameters_of

ANYTHING, NOTHING = "any", "none"
ARRAY = ("crosstalk",)  # causes that need more than one taxel
POSSIBLE = {  # physically possible ranges, where the bounds for fits are wider
    ("crosstalk", "share"): (0.0, 0.5),  # a leak adds to the neighbour, and at least half of the force stays where it is
    ("mount_compliance", "late"): (0.0, 0.1),  # s: skin with a damping of 1 kN s/m on a mount that gives 0.1 mm under 1 N
}
KEPT = {"outliers": ("rate",), "dead_taxel": ("lost",)}  # amplitudes that are not scaled but keep their typical value


def check_cause(cause: str, *others: str) -> None:
    """Raises `HidingError` for a word that is no cause of the vocabulary and none of the `others`, or a cause that no effect makes. Whether
    a recording can carry the cause is not checked here."""
    able = {cls.cause for cls in effects()} & set(BY_NAME)
    if cause not in (ANYTHING, *others) and cause not in able:
        raise HidingError(refused(cause, (*able, *others)))


def refused(cause: str, able: Iterable[str], here: str = "") -> str:
    """Why a cause that is not among those that can be hidden (`here`) is refused, and what may be meant."""
    if cause in BY_NAME:
        return f"{cause!r} is in the vocabulary, but cannot be hidden{here}; choose from {', '.join(sorted(able))}"
    near = get_close_matches(cause, able, 1)
    return f"{cause!r} is no cause{f' (did you mean {near[0]}?)' if near else ''}; choose from {', '.join(sorted(able))}"


def hideable(session: Session) -> dict[str, list[tuple[type[Effect], str]]]:
    """Effect classes and places by cause, as far as the channels and the motion of the recording can carry them."""
    found: dict[str, list[tuple[type[Effect], str]]] = {}
    for cls in effects():
        if cls.cause in ARRAY and session.n_taxels < 2:
            continue
        if cls.cause in BY_NAME and any(True for _ in cls.shapes(session.motion)):
            found.setdefault(cls.cause, []).extend((cls, where) for where in places_of(cls, session))
    return {cause: options for cause, options in found.items() if options}


def draw(session: Session, cause: str, where: str, rng: np.random.Generator) -> Effect:
    """An effect of typical size, of random form and shape. `cause` or `where` may be `ANYTHING`. Raises `HidingError`."""
    able = hideable(session)
    if cause != ANYTHING and cause not in able:
        raise HidingError(f"{cause!r} cannot be hidden in this recording; choose from {', '.join(sorted(able))}")
    able = able if cause == ANYTHING else {cause: able[cause]}
    there = {name: [(cls, place) for cls, place in every if _is_at(where, place)] for name, every in able.items()}
    there = {name: options for name, options in there.items() if options}
    if not there:
        places = sorted({place for every in able.values() for _, place in every})
        what = "nothing can" if cause == ANYTHING else f"{cause} cannot"
        raise HidingError(f"{what} sit in {where!r} of this recording; choose from {', '.join(places)}")
    options = there[str(rng.choice(sorted(there)))] if cause == ANYTHING else there[cause]
    places = sorted({place for _, place in options})
    place = places[rng.integers(len(places))]
    forms = [cls for cls, p in options if p == place]
    return _drawn(forms[rng.integers(len(forms))], place, session, rng)


def _is_at(where: str, place: str) -> bool:
    """Whether `place` is the one that was asked for. All clocks of the catalogue also answer to `clock`."""
    return where in (ANYTHING, place, place.split("_")[0] if "clock" in place else place)


def _drawn(cls: type[Effect], place: str, session: Session, rng: np.random.Generator) -> Effect:
    shapes = list(cls.shapes(session.motion))
    effect = cls.typical(place, **shapes[rng.integers(len(shapes))])
    if cls.cause == "interference":  # Hz, within the band in which sizes are measured
        effect = effect.with_values(frequency=float(rng.uniform(0.1, 0.8) * session.band.edge))
    return scaled(effect, -1.0) if _either_sign(effect) and rng.random() < 0.5 else effect


def scaled(effect: Effect, times: float) -> Effect:
    """The effect with its amplitudes multiplied by `times`, clipped to their bounds and to what is physically possible."""
    free = [p for p in parameters_of(effect) if p.role == AMPLITUDE and p.name not in KEPT.get(effect.cause, ())]
    return effect.with_values(**{p.name: float(np.clip(times * p.value, *_limits(effect, p))) for p in free})


def _either_sign(effect: Effect) -> bool:
    return all(_limits(effect, p)[0] < 0.0 for p in parameters_of(effect) if p.role == AMPLITUDE)


def _limits(effect: Effect, p: Parameter) -> tuple[float, float]:
    """Lower and upper limit of a parameter of a hidden effect."""
    return POSSIBLE.get((effect.cause, p.name), (p.lower, p.upper))
