"""Trials: every cause added to a member in turn, in one noise, and judged."""

from dataclasses import dataclass, replace

from skin_ident.criticism.scan.candidates import Candidate, starts
from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.family import QUANTITIES
from skin_ident.criticism.scan.fitting import Fit, Member, fit
from skin_ident.criticism.scan.gate import Test
from skin_ident.criticism.scan.noise import Estimated, estimate
from skin_ident.criticism.scan.score import Judge

AHEAD = 5  # trials that are tried together with every other cause before one is chosen
NOISE_TRIES = 4  # causes around whose fit the noise is estimated, too
CLOSE = 6.0  # score within which two causes cannot be told apart: twenty to one
STEPPED = 0.8  # share of the noise's standard deviation that the converter's steps alone make, from which they are coarse


@dataclass(frozen=True, eq=False)
class Setting:
    """What stays the same through a search: the cells, the causes that can be tested, the directions of the noise, its floor (N)."""

    cells: Cells
    able: tuple[Candidate, ...]
    rich: tuple[str, ...]
    floor: float
    test: Test
    both_sides: bool = True  # without: an offset centre and another shape are two names of one thing


@dataclass(frozen=True, eq=False)
class Trial:
    """A cause added to a member, fitted: `fall` of the cost, and its score."""

    candidate: Candidate
    fit: Fit
    fall: float
    score: float
    promise: float = -1e9  # score together with the best other cause


def surveyed(present: Fit, named: list[Candidate], s: Setting) -> tuple[Estimated, tuple[Trial, ...], Fit]:
    """The noise, the trials of every cause that is not in the model, best first, and the present fit in that noise.

    A cause that is not smooth (saturation, a dead zone, an edge of the spread) is in no direction of the family: the noise is estimated
    around the best few trials of such causes as well, and the likeliest estimate counts.
    """
    noise = estimate(present.member, s.cells, s.rich, s.floor)
    trials, present = _trials(present, named, noise, s)
    tried = sorted((t for t in trials if t.candidate.bends != "level"), key=lambda t: -t.fall)[:NOISE_TRIES]
    others = [estimate(t.fit.member, s.cells, s.rich, s.floor) for t in tried if t.fall > CLOSE]
    best = min(others, key=lambda n: n.deviance, default=noise)
    if best.deviance < noise.deviance - CLOSE / 2.0:
        noise = best
        trials, present = _trials(present, named, noise, s)
    return noise, trials, present


def _trials(present: Fit, named: list[Candidate], noise: Estimated, s: Setting) -> tuple[tuple[Trial, ...], Fit]:
    j = judge_in(noise, s)
    present = fit(present.member, s.cells, j.whitener)
    every = [trial(present, c, j, s) for c in s.able if c.cause not in taken(named, s)]
    return tuple(sorted(every, key=lambda t: -t.score)), present


def taken(named: list[Candidate], s: Setting) -> set[str]:
    """The causes that are not tried beside those named."""
    causes = {c.cause for c in named}
    return causes | {"spread_shape", "off_centre"} if causes & {"spread_shape", "off_centre"} and not s.both_sides else causes


def promising(trials: tuple[Trial, ...], named: list[Candidate], noise: Estimated, s: Setting) -> list[Trial]:
    """The trials that score, the one first that promises most together with one more cause: two small causes hide in one wrong shape."""
    j = judge_in(noise, s)
    scoring = [t for t in trials if t.score > 0.0]
    ahead = []
    for t in scoring[:AHEAD]:
        done = taken([*named, t.candidate], s)
        more = max((trial(t.fit, c, j, s).score for c in s.able if c.cause not in done), default=0.0)
        ahead.append(replace(t, promise=t.score + max(more, 0.0)))
    ahead.sort(key=lambda t: -t.promise)
    if not s.both_sides and any(t.candidate.cause == "spread_shape" for t in scoring):
        ahead.sort(key=lambda t: t.candidate.cause == "off_centre")
    return [*ahead, *scoring[AHEAD:]]


def judge_in(noise: Estimated, s: Setting) -> Judge:
    """The judge for a noise."""
    coarse = s.floor > STEPPED * noise.noise.sigma
    return Judge(noise.noise, noise.noise.whitener(), s.cells, noise.spare, coarse)


def trial(present: Fit, c: Candidate, j: Judge, s: Setting) -> Trial:
    """A cause added to the present fit, from its best start."""
    best = min((fit(m, s.cells, j.whitener) for m in with_candidate(c, present.member)), key=lambda f: f.cost)
    fall = max(present.cost - best.cost, 0.0)
    count = best.member.unknowns.size - present.member.unknowns.size
    return Trial(c, best, fall, j.score(fall, best, c.names, count))


def with_candidate(c: Candidate, m: Member) -> list[Member]:
    """The members from which a fit of `m` with the cause sets out."""
    return [sizes_of(m, True)] if c.cause == "parameters" else starts(c, m)


def without_candidate(c: Candidate, m: Member, start: Member) -> Member:
    """`m` without the cause: its parameters at the values that remove it, and no longer free."""
    if c.cause == "parameters":
        return sizes_of(m, False, start)
    gone = {n: start.values[n] if n == "width" else QUANTITIES[n].neutral for n in c.names}
    m = m.moved(**gone)
    return Member(m.values, m.k, tuple(n for n in m.free if n not in c.names or n in start.free), m.scale, m.steps, m.k_free)


def sizes_of(m: Member, free: bool, start: Member | None = None) -> Member:
    """`m` with its sizes free, or back at those of `start`."""
    return Member(m.values, m.k if start is None else start.k, m.free, m.scale, m.steps, free)
