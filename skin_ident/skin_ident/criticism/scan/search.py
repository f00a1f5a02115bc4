"""The search: estimate the noise, fit every cause in turn, name the best that passes the held-out gate; repeat, exchange, eliminate."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.scan.candidates import Candidate
from skin_ident.criticism.scan.fitting import Fit, Member, fit
from skin_ident.criticism.scan.gate import Gain, gain_of
from skin_ident.criticism.scan.noise import Estimated, estimate
from skin_ident.criticism.scan.score import worth
from skin_ident.criticism.scan.trials import (
    CLOSE_SCORES,
    Setting,
    Trial,
    judge_in,
    promising,
    surveyed,
    taken,
    trial,
    with_candidate,
    without_candidate,
)

MOST_FINDINGS = 5  # causes that a search names at most
SHORTLIST = 4  # causes that are tested at the gate before the search gives up
PARAMETER = 5.0  # fall of the cost that an exchanged form must bring per additional parameter
FITS = 1.5  # cost per cell of a model that fits
BETTER = 1.0  # twice nats by which another form of the same cause must fit better
REACH = 0.05  # a rival that explains less than the cause by at most this share cannot be told from it
CLEAR = 20.0  # twice nats: a rival that explains less by more than this is told apart, unless the cause's own misfit is larger still
FINE = 30.0  # score that a shape needs where placing errors could explain it instead

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Named:
    """One cause in the extended model: its held-out gain, its score `explained` (twice nats), and its rivals, each with how much less it
    explains."""

    candidate: Candidate
    gain: Gain
    explained: float
    rivals: tuple[tuple[Candidate, float], ...] = ()
    or_placing: bool = False  # placing errors of the plunger could look the same


@dataclass(frozen=True, eq=False)
class Search:
    """The result of a search. `rounds` holds for every round its trials, the best first, and the cause named in it; `last` are the trials
    after the last named cause."""

    baseline: Fit
    extended: Fit
    named: tuple[Named, ...]
    noise: Estimated
    last: tuple[Trial, ...]
    rounds: tuple[tuple[tuple[Trial, ...], str | None], ...]


def search(start: Member, s: Setting, progress: Progress = lambda stage: None) -> Search:
    """Search for the causes that the model `start` lacks on the cells of `s`."""
    noise = estimate(start, s.cells, s.rich, s.floor)
    baseline = present = fit(start, s.cells, noise.noise.whitener())
    named: list[Named] = []
    rounds = []
    while True:
        progress("estimating the noise")
        noise, trials, present = surveyed(present, [n.candidate for n in named], s)
        if len(named) == MOST_FINDINGS:
            break
        progress("holding out depths and distances")
        found = _first_believed(present, promising(trials, [n.candidate for n in named], noise, s), noise, s)
        rounds.append((trials, found and found[1].candidate.cause))
        if found is None:
            break
        present = found[0]
        named.append(found[1])
        progress(f"named {found[1].candidate.cause} in the {found[1].candidate.where}")
        present, named = _exchanged(present, named, noise, s)
    present, named, dropped = _eliminated(present, named, noise, s)
    if dropped:
        noise, trials, present = surveyed(present, [n.candidate for n in named], s)
    fine = _fine_shape(present, named, noise, s)
    if fine is not None:
        present, named = fine[0], [*named, fine[1]]
        rounds.append(((), fine[1].candidate.cause))
        noise, trials, present = surveyed(present, [n.candidate for n in named], s)
    named = [n if n.or_placing else replace(n, rivals=_rivals(present, n, named, noise, s)) for n in named]
    baseline = fit(baseline.member, s.cells, noise.noise.whitener())
    return Search(baseline, present, tuple(named), noise, trials, tuple(rounds))


def _first_believed(present: Fit, trials: list[Trial], noise: Estimated, s: Setting):
    """The first of `trials` that passes the held-out gate, as (fit, finding); None where none of the first SHORTLIST causes does."""
    causes: list[str] = []
    for t in trials:
        if t.candidate.cause in causes:
            continue
        causes.append(t.candidate.cause)
        if len(causes) > SHORTLIST:
            break
        gain = gain_of(present.member, t.fit.member, t.candidate, noise.noise, s.cells, s.test)
        if gain.passed:
            return t.fit, Named(t.candidate, gain, t.score)
    return None


def _exchanged(present: Fit, named: list[Named], noise: Estimated, s: Setting) -> tuple[Fit, list[Named]]:
    """Replace a named cause by another one where the whole model then fits better by more than CLOSE_SCORES, or by another form of the same
    cause where it fits better by more than BETTER (twice nats, less PARAMETER for each additional parameter). The gate must be passed
    again."""
    for n in named:
        base = without_candidate(n.candidate, present.member, s.test.start)
        others = taken([o.candidate for o in named if o is not n], s)
        found = _better(present, base, n.candidate, others, noise, s)
        if found is None:
            continue
        c, after, more = found
        before = fit(base, s.cells, noise.noise.whitener())
        gain = gain_of(before.member, after.member, c, noise.noise, s.cells, s.test)
        if gain.passed:
            present = after
            named = [replace(o, candidate=c, gain=gain, explained=o.explained + more) if o is n else o for o in named]
    return present, named


def _better(
    present: Fit, base: Member, old: Candidate, others: set[str], noise: Estimated, s: Setting
) -> tuple[Candidate, Fit, float] | None:
    """The cause or form that, added to `base` in the place of `old`, fits best and clearly better than the present model: the candidate,
    its fit, and by how much (twice nats)."""
    whitener, best = noise.noise.whitener(), None
    for c in s.able:
        if c == old or c.cause in others or (c.cause == "off_centre" and not s.both_sides):
            continue
        found = min((fit(m, s.cells, whitener) for m in with_candidate(c, base, s.cells)), key=lambda f: f.cost)
        more = present.cost - found.cost - PARAMETER * (found.member.unknowns.size - present.member.unknowns.size)
        if more > (BETTER if c.cause == old.cause else CLOSE_SCORES) and (best is None or more > best[2]):
            best = (c, found, more)
    return best


def _fine_shape(present: Fit, named: list[Named], noise: Estimated, s: Setting) -> tuple[Fit, Named] | None:
    """A shape of the spread that passes only where all distances are taken as exact, as (fit, finding), or None.

    Placing errors can look like a shape with more bends than the distances resolve. Where the same distances are off at all depths, and a
    shape also predicts the distances left out, both causes are given.
    """
    causes = {n.candidate.cause for n in named}
    if noise.noise.placing == 0.0 or causes & {"spread_shape", "off_centre"}:
        return None
    exact = estimate(present.member, s.cells, s.rich, s.floor, placing=False)
    if exact.deviance < noise.deviance + CLOSE_SCORES:
        return None
    j = judge_in(exact, s)
    present = fit(present.member, s.cells, j.whitener)
    trials = [trial(present, c, j, s) for c in s.able if c.cause == "spread_shape"]
    for t in sorted(trials, key=lambda t: -t.score):
        gain = gain_of(present.member, t.fit.member, t.candidate, exact.noise, s.cells, s.test)
        if t.score > FINE and gain.passed:
            return t.fit, Named(t.candidate, gain, t.score, or_placing=True)
    return None


def _eliminated(present: Fit, named: list[Named], noise: Estimated, s: Setting) -> tuple[Fit, list[Named], bool]:
    """Remove every cause (the last one named excepted) whose score is no longer positive, or which no longer passes the gate, beside the
    others. Returns the fit, the causes kept, and whether any was removed."""
    dropped = False
    for n in list(reversed(named[:-1])):
        before, score, gain = _worth(present, n, noise, s)
        if score <= 0.0 or not gain.passed:
            present, named, dropped = before, [o for o in named if o is not n], True
        else:
            named = [replace(o, gain=gain, explained=score) if o is n else o for o in named]
    return present, named, dropped


def _worth(present: Fit, n: Named, noise: Estimated, s: Setting) -> tuple[Fit, float, Gain]:
    j = judge_in(noise, s)
    before = fit(without_candidate(n.candidate, present.member, s.test.start), s.cells, j.whitener)
    count = max(present.member.unknowns.size - before.member.unknowns.size, 1)
    score = j.score(before.cost - present.cost, present, n.candidate.names, count)
    return before, score, gain_of(before.member, present.member, n.candidate, noise.noise, s.cells, s.test)


def _rivals(present: Fit, n: Named, named: list[Named], noise: Estimated, s: Setting) -> tuple[tuple[Candidate, float], ...]:
    """The causes that explain nearly as much in the place of a named one, each with how much less it explains (twice nats)."""
    j = judge_in(noise, s)
    others = {o.candidate.cause for o in named}
    twins = {"spread_shape", "off_centre"} if not s.both_sides else set()
    base = fit(without_candidate(n.candidate, present.member, s.test.start), s.cells, j.whitener)
    own = _explained(base, present, s)
    degrees = j.degrees(present, n.candidate.names)
    misfit = max(present.cost - FITS * len(s.cells), CLEAR)  # a rival may fit worse by the cause's own misfit, however much both explain
    reach = min(REACH * own, misfit)
    best: dict[str, tuple[Candidate, float]] = {}
    for c in (c for c in s.able if c.cause not in others and not _brings(c, n.candidate)):
        t = trial(base, c, j, s)
        short = own - _explained(base, t.fit, s)
        twin = {c.cause, n.candidate.cause} == twins and (t.score > 0.0 or c.cause == "spread_shape")
        near = t.score > 0.0 and (short < reach or worth(short, degrees) < CLOSE_SCORES)
        if (near or twin) and short < best.get(c.cause, (c, np.inf))[1]:
            best[c.cause] = (c, float(short))
    return tuple(sorted(best.values(), key=lambda b: b[1]))


def _brings(c: Candidate, other: Candidate) -> bool:
    """Whether `c` explains whatever another cause does, because it frees all its parameters and more: as a shape with a width of its own
    does beside `spread_width`."""
    return c.cause != other.cause and bool(other.names) and set(other.names) < set(c.names)


def _explained(before: Fit, after: Fit, s: Setting) -> float:
    """Fall of the cost from `before` to `after`, less log N for each additional unknown (BIC)."""
    return before.cost - after.cost - float(np.log(len(s.cells))) * (after.member.unknowns.size - before.member.unknowns.size)
