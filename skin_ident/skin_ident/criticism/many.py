"""Many taxels: the most loaded ones are searched jointly, then all others in groups.

Every cause at every taxel changes every channel, so a joint search grows with the square of the number of taxels. Causes of skin, rig, load
cell and clock show best in the taxels that are loaded most; these make up the joint search. What it finds stays in the model. The other
taxels are then searched in groups, together with the load cell, for causes of their own only. The ratios of all taxels are judged together,
since that is a small problem.
"""

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.proposing import is_of_array
from skin_ident.criticism.baseline.fitting import fit, noise_of
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.record import bad_samples, inspect, mended_depth
from skin_ident.criticism.search.bounds import undecided
from skin_ident.criticism.search.named import Criticism, Named
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.search.search import eliminate, run
from skin_ident.criticism.search.size import affordable
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.survey import noise_beside
from skin_ident.criticism.sessions.cutoff import common_to
from skin_ident.criticism.sessions.parting import without_parting
from skin_ident.criticism.sessions.session import Session, longest, prepare
from skin_ident.criticism.telemetry.quantization import depth_step
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.telling.findings import found, of_reading, seen
from skin_ident.criticism.telling.untold import is_untold
from skin_ident.criticism.vocabulary import BY_NAME, revised
from skin_ident.recordings.chosen import only_taxels
from skin_models.effect import Effect
from skin_models.model import Model

FEW = 8  # up to so many taxels are searched jointly
JOINT = 6  # taxels of the joint search if there are more
GROUP = 5  # taxels per group of the others
NUMBERED = re.compile(r"\b(taxel[_ ]|share_)(\d+)\b")
# Keys of findings.json whose values are names of sessions, or no text: taxels are not renumbered in them.
OF_SESSIONS = ("name", "session", "held_out", "tested_on", "most_in")

Split = Callable[[list[Session]], tuple[list[Session], list[Session]]]


@dataclass(frozen=True)
class Rest:
    """What was found in the taxels outside the joint search, in the numbering of all taxels."""

    named: tuple[Named, ...]
    entries: tuple[dict[str, Any], ...]
    untestable: tuple[dict[str, Any], ...]
    effects: tuple[Effect, ...]
    symptoms: tuple[Symptom, ...]
    shares: dict[int, float]


def loaded_most(recordings: list) -> list[int]:
    """The taxels of the joint search: from each session in turn the one whose reading varies most, until there are enough.

    Raises `DiagnosisError` where the recordings are too long even for the smallest search.
    """
    most = affordable(recordings, JOINT)
    moved = np.array([np.std(r.taxels, axis=1) for r in recordings])
    chosen: list[int] = []
    for rank in range(moved.shape[1]):
        for row in moved:
            i = int(np.argsort(row)[::-1][rank])
            if i not in chosen and len(chosen) < most:
                chosen.append(i)
    return sorted(chosen)


def some(recordings: list, taxels: list[int]) -> list:
    """The recordings with these taxels only, without the warnings of reading, which refer to all taxels (see `with_those_of_reading`)."""
    each = [only_taxels([r], [r.taxel_names[i] for i in taxels])[0] for r in recordings]
    return [
        replace(few, spread=None if r.spread is None else r.spread[taxels], warnings=(), declared=replace(few.declared, warnings=()))
        for few, r in zip(each, recordings, strict=True)
    ]


def with_those_of_reading(findings: dict[str, Any], recordings: list) -> dict[str, Any]:
    """findings.json of a search of a few taxels, with the warnings of all `recordings` added. These already use the numbers and names of
    the files."""
    entries = [{**e, "warnings": [*r.warnings, *e["warnings"]]} for e, r in zip(findings["recordings"], recordings, strict=True)]
    return {**findings, "recordings": entries, "warnings": [*of_reading(recordings), *findings["warnings"]]}


def renamed(thing: Any, taxels: list[int], sessions: Collection[str] = ()) -> Any:
    """Any structure of texts, with taxels renumbered from their position among `taxels` to their number among all.

    A text refers to a taxel only as `taxel_3`, `taxel 3` or `share_3`. Names of `sessions` are file names and stay as they are, also within
    a sentence; a whole findings.json brings them itself.
    """
    if isinstance(thing, str):
        either = _numbered_or(sessions)
        return either.sub(lambda m: f"{m[1]}{taxels[int(m[2])]}" if m[2] and int(m[2]) < len(taxels) else m[0], thing)
    if isinstance(thing, dict):
        sessions = sessions or [r["name"] for r in thing.get("recordings", ())]
        return {renamed(k, taxels, sessions): v if k in OF_SESSIONS else renamed(v, taxels, sessions) for k, v in thing.items()}
    if isinstance(thing, (list, tuple)):
        return type(thing)(renamed(v, taxels, sessions) for v in thing)
    return thing


def _numbered_or(sessions: Collection[str]) -> re.Pattern[str]:
    """`NUMBERED`, extended so that the name of a session that contains such a word is matched first, without groups. A session whose whole
    name is such a word (`taxel_3`) cannot be told from the taxel in a sentence; the taxel is meant far more often."""
    names = sorted((n for n in sessions if NUMBERED.search(n) and not NUMBERED.fullmatch(n)), key=len, reverse=True)
    return re.compile(rf"(?<!\w)(?:{'|'.join(map(re.escape, names))})(?!\w)|{NUMBERED.pattern}") if names else NUMBERED


def symptom_of_all(s: Symptom, taxels: list[int], sessions: Collection[str] = ()) -> Symptom:
    """A symptom in the numbering of all taxels; `sessions` are names that its words may contain."""
    bad = {(session, renamed(channel, taxels)): mask for (session, channel), mask in s.bad.items()}
    words = ("where", "channels", "parameters", "evidence", "alternatives", "apart")
    return replace(s, bad=bad, **{name: renamed(getattr(s, name), taxels, sessions) for name in words})


def named_of_all(n: Named, taxels: list[int]) -> Named:
    """A named cause in the numbering of all taxels."""
    return replace(
        n, where=renamed(n.where, taxels), alternatives=tuple(replace(a, where=renamed(a.where, taxels)) for a in n.alternatives)
    )


def model_of_few(model: Model, taxels: list[int]) -> Model:
    """A given model of all taxels, reduced to these."""
    place = {f"taxel_{i}": f"taxel_{k}" for k, i in enumerate(taxels)}
    kept = tuple(replace(e, where=place.get(e.where, e.where)) for e in model.effects if e.taxel is None or e.where in place)
    positions = tuple(model.positions[i] for i in taxels) if model.positions else ()
    return replace(model, shares=tuple(model.shares[i] for i in taxels), effects=kept, positions=positions)


def model_of_all(model: Model, taxels: list[int], shares: dict[int, float], more: tuple[Effect, ...], layout: Layout | str) -> Model:
    """The model of a few taxels extended by the `shares` of all others and by `more` effects."""
    every = {**shares, **dict(zip(taxels, model.shares, strict=True))}
    effects = tuple(_placed(replace(e, where=renamed(e.where, taxels)), layout) for e in model.effects)
    positions = tuple((float(x), float(y)) for x, y in layout.seen) if model.positions and isinstance(layout, Layout) else ()
    return replace(model, shares=tuple(every[i] for i in range(len(every))), effects=(*effects, *more), positions=positions)


def _placed(e: Effect, layout: Layout | str) -> Effect:
    """An effect of the array with the positions of all taxels."""
    if isinstance(layout, str) or not (is_of_array(e) and hasattr(e, "taxels")):
        return e
    return replace(e, taxels=tuple((float(x), float(y)) for x, y in layout.seen))


def rest_of(c: Criticism, recordings: list, chosen: list[int], layout: Layout | str, split: Split, step: float, progress) -> Rest:
    """Search every taxel that is not `chosen` for causes of its own, group by group."""
    rest = [i for i in range(len(recordings[0].taxels)) if i not in chosen]
    groups = [list(map(int, g)) for g in np.array_split(rest, int(np.ceil(len(rest) / GROUP)))]
    parts = []
    for k, group in enumerate(groups):
        progress(f"judging the other taxels, group {k + 1} of {len(groups)}")
        parts.append(_group(c, some(recordings, group), group, layout, split, step))
    joined = {name: tuple(x for p in parts for x in getattr(p, name)) for name in ("named", "entries", "untestable", "effects", "symptoms")}
    return Rest(**joined, shares={i: s for p in parts for i, s in p.shares.items()})


def _group(c: Criticism, recordings: list, taxels: list[int], layout: Layout | str, split: Split, step: float) -> Rest:
    """The same for one group of taxels, given in the numbering of all taxels."""
    looked = inspect(recordings)
    own = [s for s in looked.symptoms if s.where.startswith("taxel_")]
    k1 = c.extended.model.dispersion.k1
    plain = _without_taxels(c.extended.model, len(taxels), [layout.seen[i] for i in taxels] if isinstance(layout, Layout) else [])
    known = {s.name: s for s in (*c.train, *c.held)}
    train, held = ([_as_found(without_parting(s, plain.dispersion), known[s.name]) for s in part] for part in split(looked.sessions))
    start = replace(plain, shares=_shares(plain, train))
    which = tuple(d for d in directions(longest(train)) if d.where.startswith("taxel_"))
    search = Search(train, held, which, lambda stage: None, step)
    run(search, fit(start, train, noise_beside(start, train, which)))
    eliminate(search)
    found_here = [n for n in search.named if n.where.startswith("taxel_")]
    not_named = {key: why for key, why in search.not_named.items() if key[1].startswith("taxel_")}
    model, std, names = search.present.model, search.present.std, [r.name for r in recordings]
    effects = [replace(e, where=renamed(e.where, taxels)) for e in model.effects if e.taxel is not None]
    return Rest(
        tuple(named_of_all(n, taxels) for n in found_here),
        tuple(renamed(found(n, model, std, {}), taxels, names) for n in found_here),
        tuple(renamed(undecided(BY_NAME[cause], where, s), taxels, names) for (cause, where), s in not_named.items()),
        tuple(effects),
        tuple(symptom_of_all(s, taxels, names) for s in own),
        {i: s * model.dispersion.k1 / max(k1, 1e-9) for i, s in zip(taxels, model.shares, strict=True)},
    )


def _as_found(session: Session, joint: Session) -> Session:
    """A session of other taxels with what the `joint` search found to be the session's own and not of single taxels."""
    lacks = frozenset(key for key in joint.lacks if not key[1].startswith("taxel_"))
    mine = {"beyond": session.beyond, "course": session.course, "spread": session.spread, "reference": session.reference}
    return session.with_own_of(replace(joint, lacks=lacks, **mine))


def _without_taxels(model: Model, count: int, places: list) -> Model:
    """The model without effects of single taxels, for `count` others at `places`."""
    seen = tuple((float(x), float(y)) for x, y in places)
    effects = tuple(replace(e, taxels=seen) if is_of_array(e) and hasattr(e, "taxels") else e for e in model.effects if e.taxel is None)
    return replace(model, shares=(1.0,) * count, effects=effects, positions=())


def _shares(plain: Model, sessions: list[Session]) -> tuple[float, ...]:
    """Shares by regression of the measured readings on those simulated with a share of one."""
    one = [s.measured[s.taxel_rows] - residual(plain, s)[s.taxel_rows] for s in sessions]
    read = [s.measured[s.taxel_rows] for s in sessions]
    weight = [s.weight[s.taxel_rows] for s in sessions]
    up = sum((a * b * w).sum(axis=1) for a, b, w in zip(one, read, weight, strict=True))
    down = sum((a * a * w).sum(axis=1) for a, w in zip(one, weight, strict=True))
    return tuple(float(q) for q in np.maximum(up / np.maximum(down, 1e-300), 1e-6))


def criticism_of_all(
    c: Criticism, rest: Rest, recordings: list, chosen: list[int], model: Model, symptoms: tuple, split: Split
) -> Criticism:
    """The criticism with all taxels in its sessions and model, as the analysis of the array needs it."""
    own = {s.name: s for s in (*c.train, *c.held)}
    mended = [mended_depth(r, symptoms) for r in recordings]
    common = common_to(mended, depth_step(mended))
    sessions = [prepare(r, bad_samples(r, symptoms), common) for r in mended]
    train, held = (
        [without_parting(s, model.dispersion).with_own_of(_of_all_taxels(own[s.name], s, chosen)) for s in part] for part in split(sessions)
    )
    noise = noise_of(model, train)
    named = (*(named_of_all(n, chosen) for n in c.named), *rest.named)
    extended, last = replace(c.extended, model=model), replace(c.last, noise=noise)
    return replace(c, extended=extended, last=last, named=named, train=tuple(train), held=tuple(held))


def _of_all_taxels(few: Session, s: Session, chosen: list[int]) -> Session:
    """What was found to be a session's own in the `chosen` taxels, in the channels of `s`, which has all taxels; shares are those of
    `s`."""
    first = len(s.channels) - s.n_taxels
    mine = [*range(first), *(first + i for i in chosen)]

    def placed(rows: np.ndarray | None) -> np.ndarray | None:
        if rows is None:
            return None
        out = np.zeros_like(s.raw)
        out[mine] = rows
        return out

    lacks = frozenset((cause, renamed(where, chosen)) for cause, where in few.lacks)
    return replace(few, beyond=placed(few.beyond), course=placed(few.course), lacks=lacks, spread=s.spread, reference=s.reference)


def with_rest(findings: dict[str, Any], odd: tuple[Symptom, ...], rest: Rest, chosen: list[int], count: int) -> dict[str, Any]:
    """findings.json of the joint search with what was found in the other taxels. What is in doubt at one place stays listed where the same
    cause is named at another."""
    entries = [*(seen(s) for s in (*odd, *rest.symptoms)), *findings["findings"], *rest.entries]
    named = {(e["cause"], e["where"]) for e in entries}
    causes, told = {cause for cause, _ in named}, named | {(a["cause"], a["where"]) for e in entries for a in e["alternatives"]}
    open_still = [
        u
        for u in (*findings["untestable"], *rest.untestable)
        if u["cause"] not in causes or is_untold(u) or (u.get("in_doubt") and (u["cause"], u["where"]) not in told)
    ]
    said = (
        f"of {count} taxels those that are loaded most ({', '.join(map(str, chosen))}) were searched together with skin, rig and load "
        "cell; the others, in groups, for causes of their own alone"
    )
    return {
        **findings,
        "findings": entries,
        "excluded": [e for e in findings["excluded"] if (e["cause"], e.get("where")) not in named],
        "untestable": open_still,
        "verdict": revised(findings["verdict"], bool(entries)),
        "warnings": [said, *findings["warnings"]],
    }
