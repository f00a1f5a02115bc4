"""The diagnosis of recordings: from loaded sessions to findings, an extended model and the curves for the report."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skin_ident.criticism.array.analysis import ArrayCriticism
from skin_ident.criticism.array.exchanged import put_right as columns_put_right
from skin_ident.criticism.array.extending import ToFile, as_written, to_file
from skin_ident.criticism.array.joining import array_criticism, joined
from skin_ident.criticism.array.layout import Layout, layout_of, unplaced
from skin_ident.criticism.array.proposing import array_directions
from skin_ident.criticism.array.spreading import with_spread
from skin_ident.criticism.baseline.living import with_living_shares
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.twin import read_twins
from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.many import (
    FEW,
    criticism_of_all,
    loaded_most,
    model_of_all,
    model_of_few,
    renamed,
    rest_of,
    some,
    symptom_of_all,
    with_rest,
    with_those_of_reading,
)
from skin_ident.criticism.one_rig import of_one_rig
from skin_ident.criticism.record import Inspected, bad_samples, inspect
from skin_ident.criticism.scan import diagnose_scans
from skin_ident.criticism.search.criticise import criticise
from skin_ident.criticism.search.named import Criticism
from skin_ident.criticism.search.state import Progress
from skin_ident.criticism.search.twin_effects import with_effects_of
from skin_ident.criticism.search.weighing import mass_warnings, with_hung
from skin_ident.criticism.sessions.parting import meeting
from skin_ident.criticism.sessions.session import FITTED, KEPT, Session, longest, motion_under, with_reference
from skin_ident.criticism.sessions.thinner import thinner, with_own_of_few
from skin_ident.criticism.telemetry.bursts import told_of_bursts
from skin_ident.criticism.telemetry.encoder_noise import find_encoder_noise
from skin_ident.criticism.telemetry.faults import effects_of, with_effects
from skin_ident.criticism.telemetry.lines import between_lines
from skin_ident.criticism.telemetry.more_than_applied import told_by_noise
from skin_ident.criticism.telemetry.noise_level import at_leisure, by_drive, find_noise
from skin_ident.criticism.telemetry.odd_session import put_right
from skin_ident.criticism.telemetry.pull import find_pull
from skin_ident.criticism.telemetry.quantization import depth_resolution, find_buried, in_uneven_steps
from skin_ident.criticism.telemetry.remaining import remains
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.telemetry.untared import tared
from skin_ident.criticism.telling.alike import in_all_taxels
from skin_ident.criticism.telling.findings import Experiments, as_findings
from skin_ident.criticism.telling.judging import judge
from skin_ident.criticism.telling.leftover import systematic_rest
from skin_ident.criticism.telling.outcome import Outcome, Round, Trace
from skin_ident.criticism.telling.telling import samples_compared, tell
from skin_ident.criticism.telling.untold import beside_silence, with_dead_untold
from skin_ident.criticism.usable import (
    are_other_data,
    belong_together,
    doubted,
    in_sound_units,
    named_apart,
    something_moves,
    warned_first,
)
from skin_ident.criticism.vocabulary import Key, verdict_of
from skin_ident.recordings.mass import KnownMass, known_mass
from skin_ident.separating.choose import separating_experiments
from skin_ident.spread_scan import SpreadScan
from skin_models.errors import ModelError
from skin_models.model import Model

AS_MUCH = 1.1  # ratio of errors within which two results count as equally good
BESIDE = ("adhesion",)  # causes that act only at moments which are not compared; they follow from the motion, so the curves show them
BLOCK_S = 10.0  # s, length of the blocks of a lone session, of which two are fitted and one is held out in turn;
FEWEST_BLOCKS = 9  # least number of blocks; shorter blocks in a session that would have fewer


def diagnose(
    recordings: list,
    hold_out: list | None = None,
    model: Model | None = None,
    progress: Progress = lambda stage: None,
    twins: list | None = None,
) -> Outcome:
    """Criticise the dispersion model, or `model`, on `recordings`; `hold_out` are sessions that are never used to fit.

    `twins` are recordings of a simulation of the same motions, one per session (training sessions first): then these are criticised (see
    `baseline.twin`). Raises `DiagnosisError` where the sessions do not belong together or lack what is needed.
    """
    hold_out = hold_out or []
    if not recordings:
        raise DiagnosisError("there is no recording to diagnose")
    if twins and model is not None:
        raise DiagnosisError("criticise either a model or recorded twins, not both")
    if are_scans([*recordings, *hold_out, *(twins or [])]):
        if twins:
            raise DiagnosisError("a recorded twin is for sessions in time, not for static scans")
        return diagnose_scans(recordings, hold_out, model, progress)
    every = named_apart([*recordings, *hold_out])
    belong_together(every, model)
    every = of_one_rig(every)
    are_other_data(recordings, hold_out)
    something_moves(every[: len(recordings)])
    every, untared = tared(every)
    every, odd = put_right(every)
    every = in_sound_units([doubted(r) for r in every], model, twins)
    layout = layout_of(every, model)
    every, exchanged = columns_put_right(every, layout)
    every = with_spread(every, layout)
    known = _Known(known_mass(every[0].declared), len(recordings), (*untared, *odd, *exchanged), layout)
    if len(every[0].taxels) > FEW:
        if twins:
            raise DiagnosisError(f"a twin of {len(every[0].taxels)} taxels cannot be compared at once: name {FEW} or fewer with --taxels")
        return _of_many(every, known, model, progress)
    progress("inspecting the recordings")
    part = _of_twins(every, twins, known, progress) if twins else _part(every, inspect(every), known, model, progress)
    array = array_criticism(part.criticism, layout, part.seen, every)
    c = part.criticism
    filed = to_file(c, c.baseline.model, array, c.extended.std)
    return _outcome(part, part.findings, array, filed, part.train[0], part.symptoms, set(c.not_named))


@dataclass(frozen=True)
class _Known:
    """What is known before the search: the mass of the skin, the number of training sessions (the first ones), odd sessions and columns
    that were corrected, and a load cell that was tared (`odd`), and the layout of the taxels, or why there is none."""

    mass: KnownMass
    training: int
    odd: tuple[Symptom, ...]
    layout: Layout | str

    def split(self, sessions: list[Session]) -> tuple[list[Session], list[Session]]:
        """Training and held-out sessions, decimated to what a search needs. A lone session becomes both, by blocks."""
        sessions = thinner(sessions)
        return _blocks(sessions[0]) if len(sessions) == 1 else (with_reference(sessions[: self.training]), sessions[self.training :])


@dataclass(frozen=True)
class _Part:
    """The result of the search on one set of sessions. `seen` are the symptoms that are still in the data, `symptoms` all of them."""

    looked: Inspected
    train: list[Session]
    held: list[Session]
    criticism: Criticism
    seen: tuple[Symptom, ...]
    symptoms: tuple[Symptom, ...]
    findings: dict[str, Any]
    experiments: Experiments


def _part(every: list, looked: Inspected, known: _Known, model: Model | None, progress: Progress) -> _Part:
    """Search and judgement on sessions that were already inspected (`looked`). `model` is the given model, or the surrogate of twins."""
    mass, layout = known.mass.kg, known.layout
    every = every if isinstance(layout, str) else warned_first(every, unplaced(every))
    train, held = known.split(looked.sessions)
    step = depth_resolution(every)
    declared = every[0].declared.moving_mass_kg is not None
    c = criticise(train, held, model, progress, mass, array_directions(layout, longest(train)), step, declared)
    c = _with_the_dead(c, looked)
    c = replace(c, named=beside_silence(c.named, every))
    looked = looked.weighed_as(c.train[0])
    set_to, weighs = mass if model is None else model.dispersion.m, c.extended.model.dispersion.m
    if weighs != set_to:
        every = warned_first(every, mass_warnings(weighs, set_to, declared))
    progress("testing whether a pattern is left")
    after = _with_courses(looked.sessions, c)
    seen = (*_in_the_rest(c, every, after, looked.symptoms), *find_pull(c.extended.model, after))
    symptoms = (*known.odd, *seen)
    rest = systematic_rest(c.last, list(c.train), list(c.held), step)
    explained = max((n.gain.squares for n in c.named), default=0.0)
    verdict = verdict_of(bool(c.named or symptoms), rest.is_systematic(explained))
    experiments = separating_experiments(c, progress)
    progress("measuring the gain on held-out data")
    whole = known.split(looked.whole)
    judged = judge(c, symptoms, whole, model)
    findings = as_findings(judged.criticism, symptoms, every, *whole, rest, verdict, model is not None, experiments)
    findings = tell(findings, judged, symptoms, step)
    findings["untestable"] = with_dead_untold(findings["untestable"], [s.where for s in looked.dead])
    if model is None and every[0].depth is not None and weighs == set_to:
        findings["baseline"]["held"] = {"m": {"value": mass, "unit": "kg", "because": known.mass.source}}
    return _Part(looked, train, held, judged.criticism, seen, symptoms, findings, experiments)


def _with_the_dead(c: Criticism, looked: Inspected) -> Criticism:
    """The criticism with shares for the taxels that were given up, estimated from the time when they lived."""
    if not looked.given_up:
        return c
    fits = {which: getattr(c, which) for which in ("baseline", "extended")}
    alive = {which: replace(f, model=with_living_shares(f.model, looked.whole, looked.given_up)) for which, f in fits.items()}
    return replace(c, **alive)


def _of_twins(every: list, twins: list, known: _Known, progress: Progress) -> _Part:
    """The result with a plain surrogate of the twins. If something is wrong, also with a surrogate that contains the effects found in the
    twins, and the better of both results."""
    looked, mass = inspect(every), known.mass.kg
    twin = read_twins(looked.sessions, every, twins, mass)
    every = [r.warned(*warnings) for r, warnings in zip(every, twin.warnings, strict=True)]

    def beside(surrogate: Model) -> _Part:
        carrying = looked.carrying(twin.beyond(surrogate), twin.known)
        return _part(every, carrying, known, surrogate, progress)

    plain = beside(twin.surrogate)
    if plain.findings["verdict"] == "nothing_wrong":
        return plain
    extended = with_effects_of(twin.surrogate, twin.said, every, known.split, mass, progress)
    return plain if extended == twin.surrogate else _better(plain, beside(extended))


def _better(plain: _Part, extended: _Part) -> _Part:
    """The better result of the plain and the extended surrogate: the one with the smaller error; if errors are equal, the one with fewer
    findings; if these are equal too, the extended one, which is closer to the twin."""

    def left(part: _Part) -> float:
        return float(sum(gain["held_out_rmse_after"] for gain in part.findings["gain_by_channel"].values()))

    if not 1.0 / AS_MUCH < left(plain) / left(extended) < AS_MUCH:
        return min(plain, extended, key=left)
    return min(extended, plain, key=lambda part: len(part.findings["findings"]))


def _outcome(
    part: _Part, findings: dict[str, Any], array: ArrayCriticism | str, filed: ToFile, first: Session, symptoms, seen: set[Key]
) -> Outcome:
    """The final result. `first` is the first session with all taxels; `seen` are causes and places, in the same numbering, of which
    something was seen that is no finding."""
    c, findings = part.criticism, joined(findings, array, filed.extended, seen)
    findings["findings"] = in_all_taxels(findings["findings"], len(filed.extended.shares))
    kept, whole = {s.name for s in part.held}, part.looked.whole
    shown = with_effects(c.extended.model, [e for e in effects_of(symptoms) if e.cause in BESIDE])
    traces = tuple(_trace(c, shown, s, own, s.name in kept) for s, own in zip(whole, _with_courses(whole, c), strict=True))
    carried = with_hung(with_effects(_with_layout(filed.model, array, first), effects_of(symptoms)), c.train[0])
    baseline, batteries = with_hung(c.baseline.model, c.train[0]), dict(_batteries(part.experiments))
    return Outcome(findings, baseline, carried, filed.std, traces, (), _rounds(c), batteries)


def _of_many(every: list, known: _Known, model: Model | None, progress: Progress) -> Outcome:
    """`diagnose` for more taxels than one search can take (see `many`)."""
    chosen, layout = loaded_most(every[: known.training]), known.layout
    few = some(every, chosen)
    progress("inspecting the recordings")
    known_of_few = replace(known, odd=(), layout=layout_of(few, model))
    part = _part(few, inspect(few), known_of_few, model and model_of_few(model, chosen), progress)
    c = part.criticism
    rest = rest_of(c, every, chosen, layout, known.split, depth_resolution(every), progress)
    seen = (*(symptom_of_all(s, chosen) for s in part.seen), *rest.symptoms)
    extended = model_of_all(c.extended.model, chosen, rest.shares, rest.effects, layout)
    progress("judging the ratios of all taxels")
    wide = criticism_of_all(c, rest, every, chosen, extended, seen, known.split)
    array = array_criticism(wide, layout, seen, every)
    findings = with_those_of_reading(renamed(part.findings, chosen), every)
    findings = with_rest(findings, known.odd, rest, chosen, len(every[0].taxels))
    told = {(cause, renamed(where, chosen)) for cause, where in c.not_named} | {(u["cause"], u["where"]) for u in rest.untestable}
    plain = model_of_all(c.baseline.model, chosen, rest.shares, (), layout)
    filed = to_file(wide, plain, array, renamed(c.extended.std, chosen))
    outcome = _outcome(part, findings, array, filed, wide.train[0], (*known.odd, *seen), told)
    traces = tuple(replace(t, channels=renamed(t.channels, chosen)) for t in outcome.traces)
    rounds = tuple(replace(r, ranked=renamed(r.ranked, chosen)) for r in outcome.rounds)
    baseline, batteries = with_hung(plain, c.train[0]), renamed(outcome.batteries, chosen)
    return replace(outcome, baseline=baseline, traces=traces, rounds=rounds, batteries=batteries)


def are_scans(recordings: list) -> bool:
    """Whether these are static spread scans. Raises `DiagnosisError` if scans and sessions are mixed."""
    scans = [r.name for r in recordings if isinstance(r, SpreadScan)]
    if scans and len(scans) < len(recordings):
        raise DiagnosisError(f"static scans and sessions are diagnosed separately: leave out {', '.join(scans[:3])}, or everything else")
    return bool(scans)


def _in_the_rest(c: Criticism, recordings: list, sessions: list[Session], known: tuple[Symptom, ...]) -> list[Symptom]:
    """The `known` symptoms that are still in the residual of the extended model, and new ones found there: noise that is not as declared,
    and converter steps so coarse that the noise does not show."""
    model, channels = c.extended.model, sessions[0].channels
    rest = [s.raw - simulated(model, s) for s in sessions]
    calm = [~meeting(motion_under(s, model.dispersion), model.dispersion) for s in sessions]
    slow = [c & at_leisure(s) for c, s in zip(calm, sessions, strict=True)]
    right = [s & ~bad_samples(r, known) for s, r in zip(slow, recordings, strict=True)]  # of each channel
    coarse = {c for s in known if s.cause == "quantization" for c in s.channels}
    uneven = in_uneven_steps(known)  # where steps grow with the reading, so does their residual
    dts = [r.dt for r in recordings]
    told = [told_of_bursts(s, recordings, channels, rest) for s in known if remains(s, recordings, channels, rest, model)]
    rest = between_lines(rest, channels, told, dts)
    found = [
        *(s for s in find_buried(recordings, channels, rest, calm) if s.channels[0] not in coarse),
        *find_noise(recordings, channels, rest, right, lambda: by_drive(model, sessions, recordings, rest, slow)),
        *find_encoder_noise(recordings),
    ]
    return told_by_noise([*told, *(s for s in found if s.channels[0] not in {*sessions[0].stuck, *uneven})])


def _blocks(session: Session) -> tuple[list[Session], list[Session]]:
    """One session split into two, with weight on different blocks of it: two of three blocks to fit, one to hold out."""
    length = min(BLOCK_S, float(np.ptp(session.t)) / FEWEST_BLOCKS)
    block = np.floor((session.t - session.t[0]) / length).astype(int) % 3
    fitted = replace(session, name=f"{session.name}{FITTED}", weight=session.weight * (block != 2))
    kept = replace(session, name=f"{session.name}{KEPT}", weight=session.weight * (block == 2))
    return [fitted], [kept]


def _with_courses(sessions: list[Session], c: Criticism) -> list[Session]:
    """The sessions at full rate, each with what was found to be its own. A lone session was criticised under two other names."""
    own = {s.name: s for s in (*c.train, *c.held)}
    return [with_own_of_few(s, own.get(s.name, c.train[0])) for s in sessions]


def _with_layout(model: Model, array: ArrayCriticism | str, first: Session) -> Model:
    """The model with what the array shows; with the measured shares if no effect of the catalogue can be so large."""
    try:
        return as_written(model, array, first)
    except ModelError as error:
        return as_written(model, str(error), first)


def _trace(c: Criticism, shown: Model, s: Session, own: Session, held: bool) -> Trace:
    before, after = simulated(c.baseline.model, c.before(own)), simulated(shown, own)
    moved = motion_under(s, c.extended.model.dispersion)
    seen = samples_compared(s.name, c)
    left_out = None if seen is None else 1.0 - np.round(np.interp(moved.t, *seen))
    return Trace(s.name, held, moved.t, moved.x, moved.v, s.channels, s.raw, before, after, left_out)


def _batteries(experiments: Experiments) -> Iterator[tuple[str, str]]:
    yield from ((file, e.text) for file, e in experiments.values() if file)


def _rounds(c: Criticism) -> tuple[Round, ...]:
    return tuple(Round(tuple((r.cause, r.where, float(r.gain)) for r in s.ranked[:12]), name) for s, name in c.rounds)
