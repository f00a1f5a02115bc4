"""The unknowns of a model as one vector, and back.

The vector is scaled so that a unit step is a sensible step of every unknown. Bounds are those of the parameters.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.sessions.session import Session
from skin_models.dispersion import Dispersion
from skin_models.effect import Place
from skin_models.model import Model
from skin_models.parameter import SHAPE, Parameter, parameters_of

# Parameters of the dispersion model that the channels can determine: with a depth and all channels, with no working taxel, without a load
# cell, and in a test driven by force. That test knows ratios only, so k2 is held as the scale. The mass is set from the skin's density, as
# in the thesis's Table 4-5, unless the record contradicts it.
BY_DEPTH, MATERIAL, TAXELS_ALONE, BY_FORCE = ("b1", "k1", "b2", "k2"), ("b2", "k2"), ("b1", "k1"), ("b1", "k1", "b2")
LATE = 0.5  # sampling periods by which good hardware may be late


@dataclass(frozen=True)
class Unknown:
    """One unknown: where it lives (`part` is "dispersion", "shares" or the index of an effect) and its parameter. If `beside` names another
    unknown, the lower bound applies to the sum of the two."""

    part: str | int
    parameter: Parameter
    label: str
    beside: str = ""

    def place(self, model: Model) -> Place | None:
        """The place in the chain of `model` at which it acts; None if it acts everywhere."""
        if self.part == "dispersion":
            return None
        return Place.SPREAD if self.part == "shares" else model.effects[self.part].place


def unknowns(model: Model, session: Session) -> tuple[Unknown, ...]:
    """All unknowns of a fit of this model to sessions of this kind. The largest share is the reference and stays 1. Sessions at places of
    their own have shares of their own instead (see `own_shares`)."""
    shares = _of_shares(model) if session.spread is None else ()
    return (*_of_dispersion(model, session), *shares, *effect_unknowns(model, session))


def _of_dispersion(model: Model, session: Session) -> Iterator[Unknown]:
    """Those of k1, b1, k2, b2 and m that the channels can determine, with a lower bound on damping (`least_damping`) and an upper one on
    the mass."""
    names = BY_FORCE if session.drive is not None else MATERIAL if _is_silent(session) else BY_DEPTH
    names = names if "force" in session.channels or session.drive is not None else TAXELS_ALONE
    names = (*names, "m") if session.free_mass else names
    under_taxels, in_all = least_damping(model.dispersion, LATE * session.longest_period)
    least, most = {"b1": under_taxels, "b2": in_all}, {"m": session.heaviest}
    for p in parameters_of(model.dispersion):
        if p.name in names:
            within = replace(p, lower=max(p.lower, least.get(p.name, p.lower)), upper=min(p.upper, most.get(p.name, p.upper)))
            u = Unknown("dispersion", within, p.name, "b1" if p.name == "b2" else "")
            yield u if not u.beside or u.beside in names else _by_itself(u, model.dispersion.b1)  # a test without taxels fits b2 alone


def least_damping(skin: Dispersion, late: float) -> tuple[float, float]:
    """Lower bounds of the damping, N s/m, under the taxels (b1) and in all (b1 + b2). Skin gives back no more energy than it took, so
    damping is not negative, but a reading that is `late` (s) by part of a sample makes it look so. A reading that is later than that has a
    cause, which negative damping would hide."""
    return -late * skin.k1, -late * (skin.k1 + skin.k2)


def _of_shares(model: Model) -> Iterator[Unknown]:
    reference = int(np.argmax(model.shares)) if model.shares else -1
    for i, share in enumerate(model.shares):
        if i != reference:
            yield Unknown("shares", Parameter(str(i), "1", share, 0.0, 10.0, typical=1.0), f"share_{i}")


def _by_itself(u: Unknown, other: float) -> Unknown:
    """The unknown with a bound of its own, where the unknown `beside` it is not fitted and stays at the value `other`."""
    return replace(u, beside="", parameter=replace(u.parameter, lower=u.parameter.lower - other))


def those_told(which: tuple[Unknown, ...], model: Model, told: Callable[[Unknown], bool]) -> tuple[Unknown, ...]:
    """The unknowns for which `told` is true. If one of them is bounded in sum with an unknown that is left out, the latter is held at its
    value in `model`; the bound never excludes the present value."""
    kept = [u for u in which if told(u)]
    labels = {u.label for u in kept}
    fixed = {u.label: _value(model, u) for u in which if u.label not in labels}

    def reachable(u: Unknown) -> Unknown:
        # The present values come from a fit to other sessions, under bounds that may differ from these. They must not jump before any data
        # require it. A fit of all unknowns does enforce the bound, whatever its start: negative damping would hide a cause.
        own = _by_itself(u, fixed[u.beside])
        return replace(own, parameter=replace(own.parameter, lower=min(own.parameter.lower, _value(model, u))))

    return tuple(reachable(u) if u.beside in fixed else u for u in kept)


def effect_unknowns(model: Model, session: Session) -> Iterator[Unknown]:
    """The unknowns of the effects that the channels can determine: all that is fitted beside a given dispersion model."""
    for i, e in enumerate(model.effects):
        for p in parameters_of(e):
            if shown(p, session):
                yield Unknown(i, p, model.listed_as(i, p.name))


def shown(p: Parameter, session: Session) -> bool:
    """Whether some channel shows a parameter of an effect. What only taxels feel and what they do not feel are one thing to the load cell
    alone, and count as not felt."""
    return not (p.name.endswith("_sensed") and _is_silent(session))


def _is_silent(session: Session) -> bool:
    """Whether no taxel works, or there is none."""
    return len(session.stuck) == session.n_taxels


def values(model: Model, which: tuple[Unknown, ...]) -> np.ndarray:
    """Present values of the unknowns (U,), each in the unit of its parameter."""
    return np.array([_value(model, u) for u in which])


def _value(model: Model, u: Unknown) -> float:
    if u.part == "shares":
        return model.shares[int(u.parameter.name)]
    thing = model.dispersion if u.part == "dispersion" else model.effects[u.part]
    return float(getattr(thing, u.parameter.name))


def lowest(which: tuple[Unknown, ...], theta: np.ndarray) -> np.ndarray:
    """Lower bounds (U,) of the unknowns, given the values `theta` (U,) of all of them."""
    present = {u.label: value for u, value in zip(which, theta, strict=True)}
    return np.array([u.parameter.lower - (present[u.beside] if u.beside else 0.0) for u in which])


def with_values(model: Model, which: tuple[Unknown, ...], theta: np.ndarray) -> Model:
    """The model with its unknowns set to `theta` (U,), clipped to their bounds."""
    dispersion, shares, effects = {}, list(model.shares), [{} for _ in model.effects]
    highest = np.array([u.parameter.upper for u in which])
    alone = np.where([u.beside == "" for u in which], np.clip(theta, lowest(which, theta), highest), theta)
    for u, value in zip(which, np.clip(theta, lowest(which, alone), highest).tolist(), strict=True):
        if u.part == "dispersion":
            dispersion[u.parameter.name] = value
        elif u.part == "shares":
            shares[int(u.parameter.name)] = value
        else:
            effects[u.part][u.parameter.name] = value
    return replace(
        model,
        dispersion=replace(model.dispersion, **dispersion),
        shares=tuple(shares),
        effects=tuple(e.with_values(**changed) if changed else e for e, changed in zip(model.effects, effects, strict=True)),
    )


def scales(model: Model, which: tuple[Unknown, ...]) -> np.ndarray:
    """A sensible step (U,) of each unknown: its present value, or its typical value where that is larger."""
    total = model.dispersion.k1 + abs(model.dispersion.k2)
    floor = {"m": 0.1, "b1": 0.02 * total, "b2": 0.02 * total, "k1": total, "k2": total}

    def scale(u: Unknown) -> float:
        p = u.parameter
        usual = floor.get(p.name, 0.0) if u.part == "dispersion" else (0.0 if np.isnan(p.typical) else abs(p.typical))
        present = abs(_value(model, u))
        return max(present, usual) if p.role != SHAPE else max(present, 1e-9)

    return np.array([scale(u) or 1.0 for u in which])
