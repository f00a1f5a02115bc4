"""Trials: each cause is added to the present member in turn, fitted in a given noise, and scored."""

from dataclasses import dataclass, replace

from skin_ident.criticism.scan.candidates import Candidate, starts
from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.family import QUANTITIES
from skin_ident.criticism.scan.fitting import Fit, Member, fit
from skin_ident.criticism.scan.gate import Test
from skin_ident.criticism.scan.noise import Estimated, estimate
from skin_ident.criticism.scan.score import Judge
from skin_ident.criticism.scan.start import zeroed_start
from skin_ident.criticism.vocabulary import FORCE_OFFSET

AHEAD = 5  # best trials that are fitted together with every other cause before one is chosen
NOISE_TRIES = 4  # most causes whose residual is also used to estimate the noise
CLOSE_SCORES = 6.0  # twice nats: scores closer than this cannot be told apart (likelihood ratio 20 to 1)
STEPPED = 0.8  # steps are coarse where they alone make more than this share of the noise's standard deviation


@dataclass(frozen=True, eq=False)
class Setting:
    """What stays the same through a search: the cells, the testable causes, the parameters `rich` that are projected out before the noise
    is estimated, and the noise's lower bound `floor` (N)."""

    cells: Cells
    able: tuple[Candidate, ...]
    rich: tuple[str, ...]
    floor: float
    test: Test
    both_sides: bool = True  # else an offset centre cannot be told from another shape


@dataclass(frozen=True, eq=False)
class Trial:
    """A cause added to a member and fitted: the `fall` of the cost, and the score (see `score`)."""

    candidate: Candidate
    fit: Fit
    fall: float
    score: float
    promise: float = -1e9  # its score plus that of the best further cause


def surveyed(present: Fit, named: list[Candidate], s: Setting) -> tuple[Estimated, tuple[Trial, ...], Fit]:
    """The noise, the trials of every cause that is not in the model, best first, and the present fit in that noise.

    A cause that is not smooth (saturation, a dead zone, an edge of the spread) is not covered by the tangents that are projected out, and
    would be taken for noise. So the noise is also estimated from the residuals of the best few trials, and the likeliest estimate counts.
    """
    noise = estimate(present.member, s.cells, s.rich, s.floor)
    trials, present = _trials(present, named, noise, s)
    tried = sorted((t for t in trials if t.candidate.bends != "level"), key=lambda t: -t.fall)[:NOISE_TRIES]
    others = [estimate(t.fit.member, s.cells, s.rich, s.floor) for t in tried if t.fall > CLOSE_SCORES]
    best = min(others, key=lambda n: n.deviance, default=noise)
    if best.deviance < noise.deviance - CLOSE_SCORES / 2.0:
        noise = best
        trials, present = _trials(present, named, noise, s)
    return noise, trials, present


def _trials(present: Fit, named: list[Candidate], noise: Estimated, s: Setting) -> tuple[tuple[Trial, ...], Fit]:
    j = judge_in(noise, s)
    present = fit(present.member, s.cells, j.whitener)
    every = [trial(present, c, j, s) for c in s.able if c.cause not in taken(named, s)]
    return tuple(sorted(every, key=lambda t: -t.score)), present


def taken(named: list[Candidate], s: Setting) -> set[str]:
    """The causes that are not tried any more beside those named: these, and what cannot be told from them."""
    causes = {c.cause for c in named}
    return causes | {"spread_shape", "off_centre"} if causes & {"spread_shape", "off_centre"} and not s.both_sides else causes


def promising(trials: tuple[Trial, ...], named: list[Candidate], noise: Estimated, s: Setting) -> list[Trial]:
    """The trials with a positive score, ordered by the score that they reach together with one further cause: one wrong shape can imitate
    two small causes. From one side of the taxel, `off_centre` comes last where a shape scores too."""
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
    """The judge that scores fits in a noise."""
    coarse = s.floor > STEPPED * noise.noise.sigma
    return Judge(noise.noise, noise.noise.whitener(), s.cells, noise.spare, coarse)


def trial(present: Fit, c: Candidate, j: Judge, s: Setting) -> Trial:
    """The trial of a cause: added to the present fit and fitted from each of its starts, of which the best counts."""
    best = min((fit(m, s.cells, j.whitener) for m in with_candidate(c, present.member, s.cells)), key=lambda f: f.cost)
    fall = max(present.cost - best.cost, 0.0)
    count = best.member.unknowns.size - present.member.unknowns.size
    return Trial(c, best, fall, j.score(fall, best, c.names, count))


def with_candidate(c: Candidate, m: Member, cells: Cells) -> list[Member]:
    """Initial members for a fit of `m` to `cells` with the cause."""
    if c.cause == "parameters":
        return [sizes_of(m, True)]
    return [*starts(c, m), *(_untared(c, m, cells) if c.cause == FORCE_OFFSET else ())]


def _untared(c: Candidate, m: Member, cells: Cells) -> tuple[Member, ...]:
    """The start at the width and zero of a taxel that was plainly not tared: its curve without the zero may be far from that with it."""
    zeroed = zeroed_start(cells)
    if not zeroed.values["offset"] or "width" not in m.free or not m.k_free:
        return ()
    return (replace(m.freeing(*c.names).moved(width=zeroed.values["width"], offset=zeroed.values["offset"]), k=zeroed.k),)


def without_candidate(c: Candidate, m: Member, start: Member) -> Member:
    """`m` without the cause: its parameters at their neutral values, the width as in `start`, and free only if they are in `start`."""
    if c.cause == "parameters":
        return sizes_of(m, False, start)
    gone = {n: start.values[n] if n == "width" else QUANTITIES[n].neutral for n in c.names}
    m = m.moved(**gone)
    return replace(m, free=tuple(n for n in m.free if n not in c.names or n in start.free))


def sizes_of(m: Member, free: bool, start: Member | None = None) -> Member:
    """`m` with its sizes free or fixed (`free`), and set to those of `start` where it is given."""
    return replace(m, k=m.k if start is None else start.k, k_free=free)
