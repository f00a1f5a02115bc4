"""For every cause that was not named: the amount above which it is excluded, or why it is untestable and what would test it.

A direction of the last survey has an amount z with standard error sd, from the whitened inner products of the directions. The data can test
a cause where a typical amount of it would stand out by `CLEAR` standard errors. It is then excluded above the largest |z| + 1.96 sd of:

- the direction alone;
- the direction beside any of those that explain most of the residual, since two effects may hide each other;
- a round of the search in which the cause came near the one named there, which may have taken its place;
- its fit beside everything else, where that explains something: a delay that the damping makes up for has little of its own in a linear
  view, and any amount in a fit;
- for a gain, the difference between the skins that sessions were allowed to have: it may as well be a gain that differs.

A cause may be both excluded and untestable: a gain that changes part-way is excluded, while one that was wrong throughout passes for
another stiffness. What the record itself shows, such as the steps of a converter, is not excluded below its own size.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit
from skin_ident.criticism.search.named import NotNamed
from skin_ident.criticism.search.proposals import Direction
from skin_ident.criticism.search.ranking import UNEXCITED, Projected
from skin_ident.criticism.search.survey import Survey, detectable
from skin_ident.criticism.telemetry.noise_level import NOISE_SEEN
from skin_ident.criticism.vocabulary import AT_FULL_RATE, CAUSES, GAIN_ERROR, Cause, Key, where_and_clock
from skin_ident.estimators.estimate import HALF_95
from skin_models.model import Model
from skin_models.parameter import SHAPE, Parameter, parameters_of

CLEAR = 3.0  # standard errors
NEAR = 0.35  # share of a round's best score above which a cause came near
MADE_UP = 0.1  # share of a delay's energy that the model's own damping leaves, below which it makes up for all that is linear in it
ALIKE = 0.98  # correlation above which two directions are one
NOT_SEEN = {"noise": NOISE_SEEN}  # what would have been seen, for causes that telemetry alone decides
HOLLOW = "even the largest possible amount of it could not be distinguished here from other causes and noise"


def excluded_and_untestable(
    last: Survey,
    rounds: list[Survey],
    named: set[str],
    known: dict[str, str],
    seen: Mapping[str, Mapping[str, NotNamed]],
    grown: Mapping[Key, Fit],
    skins: float = 0.0,
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Entries of findings.json, excluded and untestable, for all causes not in `named`, from the last survey and those of all `rounds`.
    `known` gives the reason for causes that telemetry alone decides; an empty text means looked for and not found. What is `seen` in the
    record bounds what may be excluded, and so do the fits of causes that were tried last, `grown`, and the relative difference in stiffness
    between the `skins` of the sessions. For a cause that is named, what is seen of it at another place is listed where it is in doubt."""
    p = last.projected
    bounds = np.array([_as_it_grows(b, d, left) for b, d, left in zip(_bounds(last, rounds), p.which, p.left, strict=True)])
    bounds = np.maximum(bounds, [max(_grown(d, grown), _in_skins(d, skins)) for d in p.which])
    excluded, untestable = [], []
    for cause in CAUSES:
        there = seen.get(cause.name, {})
        if cause.name in named:
            untestable += [undecided(cause, where, s) for where, s in there.items() if s.doubt]
            continue
        entries, hollow = _excluded(p, bounds, cause.name, last.model)
        entries = [e for e in entries if e["where"] not in there or e["below"] >= there[e["where"]].size]
        excluded += entries
        untestable += _imitated(p, cause, entries)
        untestable += [{"cause": cause.name, "where": w, "because": HOLLOW, "needs": cause.needs} for w in hollow if w not in there]
        if there:
            untestable += [undecided(cause, where, s) for where, s in there.items()]
            continue
        if cause.name in known and not known[cause.name] and not entries:
            because = NOT_SEEN.get(cause.name, "looked for and not seen")
            excluded.append({"cause": cause.name, "below": None, "unit": "", "because": because})
        elif not (entries or hollow):
            because = known.get(cause.name) or _because(p, cause.name)
            untestable.append({"cause": cause.name, "because": because, "needs": cause.needs})
    return list(map(_with_clock, excluded)), list(map(_with_clock, untestable))


def _with_clock(entry: dict[str, Any]) -> dict[str, Any]:
    """The entry with its place in the words of findings.json, and with the name of the clock if it is one."""
    return {**entry, **where_and_clock(entry["where"])} if "where" in entry else entry


def undecided(cause: Cause, where: str, seen: NotNamed) -> dict[str, Any]:
    """The entry `untestable` for something `seen` at one place that is no finding."""
    entry = {"cause": cause.name, "where": where, "because": seen.because, "needs": seen.needs or cause.needs}
    known = {"in_doubt": seen.doubt, "hardware": seen.hardware, "own_zero": seen.own_zero}
    return entry | {name: True for name, is_so in known.items() if is_so}


def _bounds(last: Survey, rounds: list[Survey]) -> np.ndarray:
    """Upper bound of the amount of every direction of the `last` survey."""
    p = last.projected
    bounds = np.maximum(_amounts(p), _beside_others(p))
    for s in rounds:
        if s.projected.which != p.which:
            continue
        near = {r.key for r in s.ranked if r.score > NEAR * s.ranked[0].score > 0.0}
        contends = np.array([d.key in near for d in p.which])
        bounds = np.where(contends, np.maximum(bounds, _amounts(s.projected)), bounds)
    return bounds


def _as_it_grows(bound: float, d: Direction, left: float) -> float:
    """The upper bound of a direction whose amount is a time, where damping makes up for all that grows in proportion to it: what is left
    grows with its square, so that a smaller amount than the probed one shows less than the linear `bound` supposes. Others as they are."""
    time = next(q for q in parameters_of(d.effect) if q.name == d.parameter).unit == "s"
    return float(np.sqrt(bound * d.probe)) if time and left < MADE_UP and bound < d.probe else float(bound)


def _grown(d: Direction, grown: Mapping[Key, Fit]) -> float:
    """The largest amount of a direction, plus 1.96 standard errors, in the fit of its cause; 0 where it has none."""
    if d.key not in grown:
        return 0.0
    found = grown[d.key]
    mine = [
        (getattr(e, d.parameter), found.std.get(found.model.listed_as(i, d.parameter), 0.0))
        for i, e in enumerate(found.model.effects)
        if e.key == d.key and type(d.effect) in (type(e), e.refines)
    ]
    return max((abs(value) + HALF_95 * std for value, std in mine), default=0.0) / d.size


def _in_skins(d: Direction, skins: float) -> float:
    """The amount of a direction that skins which differ by `skins` may have taken up; 0 for all but gains."""
    return skins / d.size if d.cause == GAIN_ERROR else 0.0


def _amounts(p: Projected) -> np.ndarray:
    """|z| + 1.96 sd of every direction by itself."""
    energies = np.where(p.energies > 0.0, p.energies, np.inf)
    return np.abs(p.product / energies) + HALF_95 / np.sqrt(energies)


def _beside_others(p: Projected) -> np.ndarray:
    """The same of every direction fitted beside one leading direction: the largest value over the leading ones that still explain something
    then."""
    bounds = np.zeros(len(p.which))
    keys = [d.key for d in p.which]
    for column, j in enumerate(p.leading):
        both = p.beside[:, column]
        fit = p.energies * p.energies[j] - both**2
        able = (fit > (1.0 - ALIKE**2) * p.energies * p.energies[j]) & np.array([key != keys[j] for key in keys])
        fit = np.where(able, fit, 1.0)
        other = (p.product[j] * p.energies - p.product * both) / fit
        there = able & (other**2 * fit > np.log(max(p.rows, 2)) * p.energies)
        own = np.abs(p.product * p.energies[j] - p.product[j] * both) / fit + HALF_95 * np.sqrt(p.energies[j] / fit)
        bounds = np.where(there, np.maximum(bounds, own), bounds)
    return bounds


def _excluded(p: Projected, bounds: np.ndarray, cause: str, model: Model) -> tuple[list[dict[str, Any]], list[str]]:
    """One entry per place: the weakest bound over the shapes that the data excite, and as `least` the strongest over the other shapes of
    the same parameter. Also the places where the weakest says nothing, because no skin or sensor can have as much."""
    limits = detectable(p, CLEAR)
    hollow = set()
    places: dict[str, list[tuple[float, dict[str, Any]]]] = {}
    for i, d in enumerate(p.which):
        if d.cause != cause or cause == AT_FULL_RATE or limits[i] > 1.0 or p.left[i] <= UNEXCITED:
            continue
        bound = bounds[i]
        q = next(q for q in parameters_of(d.effect) if q.name == d.parameter)
        if bound * d.size > _most(q, d.where, model):
            hollow.add(d.where)
        at = {q.name: {"value": q.value, "unit": q.unit} for q in parameters_of(d.effect) if q.role == SHAPE}
        entry = {"cause": cause, "where": d.where, "parameter": d.parameter, "below": float(bound * d.size), "unit": q.unit}
        which = {name: said for name, said in (("form", d.effect.form), ("at", at)) if said}
        places.setdefault(d.where, []).append((float(bound), {**entry, **which}))
    return [_weakest(each) for where, each in places.items() if where not in hollow], [where for where in places if where in hollow]


def _weakest(each: list[tuple[float, dict[str, Any]]]) -> dict[str, Any]:
    """The entry with the largest bound of one cause at one place. As `least` it has the smallest of the bounds of the same parameter and
    form at other shapes, where it is the largest of its own shape."""
    _, worst = max(each, key=lambda e: e[0])
    of_shapes: dict[str, dict[str, Any]] = {}
    for _, e in sorted(each, key=lambda e: e[0]):
        if "at" in e and all(e.get(name) == worst.get(name) for name in ("parameter", "form")):
            of_shapes[str(e["at"])] = {"below": e["below"], "at": e["at"]}
    least = min(of_shapes.values(), key=lambda e: e["below"], default=worst)
    return worst | {"least": least} if least["below"] < worst["below"] else worst


def raised(e: dict[str, Any], floor: float) -> dict[str, Any]:
    """An entry of `excluded` whose bounds are no smaller than `floor`."""
    worst = {**e, "below": max(e["below"], floor)}
    if "least" not in e:
        return worst
    least = {**e["least"], "below": max(e["least"]["below"], floor)}
    return {**worst, "least": least} if least["below"] < worst["below"] else {k: v for k, v in worst.items() if k != "least"}


def _most(q: Parameter, where: str, model: Model) -> float:
    """The largest possible amplitude: what its effect allows, and in the skin no more than the skin's whole stiffness."""
    whole = model.dispersion.k1 + model.dispersion.k2
    return min(max(abs(q.lower), abs(q.upper)), whole if where == "skin" and q.unit == "N/m" and whole > 0.0 else np.inf)


def _imitated(p: Projected, cause: Cause, excluded: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One entry for every form of a cause that the model's own parameters imitate entirely, at places where others of its forms are
    excluded."""
    left: dict[tuple[str, str], float] = {}
    for d, share in zip(p.which, p.left, strict=True):
        if d.cause == cause.name:
            left[d.where, d.effect.form] = max(share, left.get((d.where, d.effect.form), 0.0))
    hidden = [at for at, most in left.items() if 0.0 < most <= UNEXCITED]
    return [
        {
            "cause": cause.name,
            "where": where,
            "form": form,
            "because": f"{form or 'a constant one'} looks exactly like a change of the model's own parameters here; only its other forms "
            "are excluded",
            "needs": cause.needs,
        }
        for where, form in hidden
        if any(e["where"] == where for e in excluded)
    ]


def _because(p: Projected, cause: str) -> str:
    mine = [i for i, d in enumerate(p.which) if d.cause == cause]
    if not mine:
        return "no channel of these recordings can show it"
    if all(p.left[i] <= UNEXCITED for i in mine):
        return "in these recordings it looks exactly like a change of the model's own parameters, or does nothing at all"
    return "even a typical amount of it would not stand out from the noise here: the motion hardly excited it"
