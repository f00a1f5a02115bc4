"""The extended model with what the ratios of the taxels show: the declared layout, and the cause as an effect of the catalogue.

The shares of a model are measured ones. Here each is written as the share of the declared layout times an effect. Once the contact is moved
to its place, or the taxel calibrated again, the effect can be removed, and the shares are those of a rig without the fault.

Some effects of the array have no counterpart in the catalogue. Dispersion and shares that were fitted beside such an effect would be wrong
without it, so everything else is fitted again.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any

import numpy as np

from skin_ident.criticism.array.analysis import ArrayCriticism
from skin_ident.criticism.array.bending import Leaning, Settling, Widening
from skin_ident.criticism.array.judgement import Judged
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.proposing import for_anybody, is_of_array
from skin_ident.criticism.array.sentences import shift_of
from skin_ident.criticism.baseline.fitting import Fit, fit
from skin_ident.criticism.baseline.residual import placed
from skin_ident.criticism.baseline.unknowns import Unknown, unknowns
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import Key
from skin_models.effect import Effect
from skin_models.effects.anisotropy import Anisotropy
from skin_models.effects.crosstalk import Crosstalk
from skin_models.effects.gain_error import GainError
from skin_models.effects.leaning import Leaning as CatalogueLeaning
from skin_models.effects.off_centre import OffCentre
from skin_models.effects.spread_depth import SettlingSpreadDepth, SpreadDepth
from skin_models.effects.spread_shape import SpreadShape
from skin_models.effects.spread_width import SpreadWidth
from skin_models.errors import ModelError
from skin_models.model import Model
from skin_models.signals import motion

SILENT = 1e-3  # of the largest share, below which a share is too small to be scaled
PRESS_S, PRESS_SAMPLES = 4.0, 400  # of the press in which readings are compared
STEPS, PROBE = 3, 0.01  # of Newton's method; share of the largest share by which each is moved for its slope
NO_FORM = "no: the simulated skin has no effect of this form; the model file is the best fit without it"
NOT_JUDGED = "no: a cause in the ratios of the taxels is written into the model only where the ratios of all taxels can be judged"
TOO_LARGE = "no: an effect of the simulated skin cannot be as large as that"


@dataclass(frozen=True)
class ToFile:
    """The `extended` model of all taxels, and the `model` that is written instead, with standard errors by label (`std`): the same one,
    unless some of its effects cannot be written."""

    extended: Model
    model: Model
    std: dict[str, float]


def to_file(c: Any, plain: Model, a: ArrayCriticism | str, std: dict[str, float]) -> ToFile:
    """What is written of the extended model of a criticism `c`, which has the standard errors `std`; `plain` is the baseline."""
    model = c.extended.model
    left_out = _lost(model, a)
    if not left_out:
        return ToFile(model, model, std)
    again = _fitted_without(left_out, model, plain, std, c)
    return ToFile(model, again.model, again.std)


def as_written(model: Model, a: ArrayCriticism | str, first: Session) -> Model:
    """The model as it is written to file: as seen from the contact of the session `first`, with the positions of its taxels."""
    if isinstance(a, str):
        return for_anybody(model)
    own = a.layout.of([0])
    width = {"spread_width": {"value": float(a.layout.width), "unit": "m"}}
    here = replace(
        for_anybody(model),
        shares=placed(model, first).shares,
        positions=tuple((float(x), float(y)) for x, y in own.places[0]),
        notes={**model.notes, **width},
    )
    here = _with(here, [known(e) for e in model.effects if is_of_array(e)])
    static = sorted((_effect(t.best, own) for t in a.named), key=lambda e: isinstance(e, Crosstalk))  # neighbours hear wrong gains, too
    return _scaled(_with(here, static), here, float(first.motion.x.max())) if any(static) else here


def unwritten(model: Model, a: ArrayCriticism | str) -> dict[Key, str]:
    """By cause and place: why the model from `as_written` lacks what was named there."""
    bent = [e for e in model.effects if is_of_array(e)]
    keys = [e.key for e in bent]
    if isinstance(a, str):
        return dict.fromkeys(keys, NOT_JUDGED)
    best = [t.best for t in a.named]
    keys += [j.key for j in best]
    try:
        effects = [*map(known, bent), *(_effect(j, a.layout.of([0])) for j in best)]
    except ModelError:  # then none of them is written
        return dict.fromkeys(keys, TOO_LARGE)
    return {key: NO_FORM for key, e in zip(keys, effects, strict=True) if e is None}


def _lost(model: Model, a: ArrayCriticism | str) -> tuple[Effect, ...]:
    """The effects of the array that the model from `as_written` lacks."""
    every = isinstance(a, str) or TOO_LARGE in unwritten(model, a).values()
    return tuple(e for e in model.effects if is_of_array(e) and (every or known(e) is None))


def _fitted_without(left_out: Collection[Effect], model: Model, plain: Model, fitted: Collection[str], c: Any) -> Fit:
    """The `model` without some effects, fitted again from the dispersion and shares of the `plain` one. All shares are free, and of the
    other unknowns those that were `fitted`, given by their labels in `model`."""
    kept = [i for i, e in enumerate(model.effects) if e not in left_out]
    effects, skin = tuple(model.effects[i] for i in kept), replace(plain.dispersion, m=model.dispersion.m)
    start = replace(model, dispersion=skin, shares=plain.shares, effects=effects)

    def was_fitted(u: Unknown) -> bool:
        label = model.listed_as(kept[u.part], u.parameter.name) if isinstance(u.part, int) else u.label
        return u.part == "shares" or label in fitted

    return fit(start, list(c.train), c.last.noise, which=tuple(filter(was_fitted, unknowns(start, c.train[0]))))


def _with(model: Model, effects: Iterable[Effect | None]) -> Model:
    """The model with effects, as far as there are any."""
    return reduce(Model.extended, filter(None, effects), model)


def _scaled(model: Model, measured: Model, depth: float) -> Model:
    """The model with its shares divided by what its effects multiply them by, so that in a press to `depth`, m, its taxels read what those
    of the model with `measured` shares read.

    Effects act on what those before left, and crosstalk on all taxels at once; so the shares are found by Newton's method. Those of silent
    taxels are kept.
    """
    t = np.linspace(0.0, PRESS_S, PRESS_SAMPLES)
    press = motion(t, 0.5 * depth * (1.0 - np.cos(2.0 * np.pi * t / PRESS_S)))

    def levels(shares: np.ndarray) -> np.ndarray:
        """What the taxels read on average."""
        return replace(model, shares=tuple(shares.tolist())).simulate(press).taxels.mean(axis=1)

    wanted, shares = measured.simulate(press).taxels.mean(axis=1), np.array(measured.shares)
    loud = np.flatnonzero(shares > SILENT * shares.max())
    for _ in range(STEPS):
        now, probe = levels(shares), PROBE * shares.max()
        slopes = np.array([(levels(shares + probe * row) - now)[loud] for row in np.eye(shares.size)[loud]]).T / probe
        shares[loud] = np.maximum(shares[loud] + np.linalg.lstsq(slopes, (wanted - now)[loud], rcond=None)[0], 0.0)
    return replace(model, shares=tuple(shares.tolist()))


def known(e: Any) -> Effect | None:
    """The catalogue's effect in place of one made for this layout; None if there is none."""
    if isinstance(e, Leaning):
        x, y = np.array(e.axis) * e.shift / e.deepest
        return CatalogueLeaning("rig", lean_x=float(x), lean_y=float(y))
    if isinstance(e, Widening):
        growth = float(np.clip(e.growth / max(1.0 - e.growth * e.reached(e.usual), 0.2), -1e3, 1e4))
        settles = isinstance(e, Settling)
        return SettlingSpreadDepth("skin", growth=growth, settling=e.settling) if settles else SpreadDepth("skin", growth=growth)
    return None


def _is_row(layout: Layout) -> bool:
    """Whether the taxels lie in one row in the order of their numbers."""
    return len(layout.axes) == 1 and len(set(np.sign(np.diff(layout.taxels @ layout.axes[0])))) == 1


def _effect(j: Judged, layout: Layout) -> Effect | None:
    """The effect of the catalogue for a cause of the array; None if there is none of this form."""
    p, cause = j.fit.member, j.hypothesis.cause
    if cause == "off_centre":
        dx, dy = shift_of(p, layout)
        return OffCentre("rig", dx=float(dx), dy=float(dy))
    if cause == "gain_error":
        return GainError(j.hypothesis.where, gain=float(p["gain_" + j.hypothesis.where.partition("_")[2]]))
    if cause == "crosstalk":
        # Exact at the ends of a row; between two neighbours, of whom the effect takes the mean, the shares keep the rest. None for a plane.
        return Crosstalk("taxel", share=float(p["leak"])) if "leak" in j.hypothesis.free and _is_row(layout) else None
    if cause == "spread_width":
        return SpreadWidth("skin", wider=float(np.expm1(p["width"])))
    if "tail" in j.hypothesis.free:
        return None
    if cause == "spread_shape":
        return SpreadShape("skin", flatness=float(0.5 * p["power"]))
    turn = p.get("turn", 0.0)
    square, axes = np.linalg.eigh([[np.exp(-p["ratio"]), -turn], [-turn, np.exp(p["ratio"])]])
    along = axes[:, 0] if axes[0, 0] >= 0.0 else -axes[:, 0]
    return Anisotropy("skin", stretch=float(0.5 * np.log(square[1] / square[0])), angle=float(np.arctan2(along[1], along[0])))
