"""The loop: estimate the noise, try every cause, let held-out depths and distances decide, repeat, exchange, eliminate."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from skin_ident.criticism.scan.candidates import Candidate, starts
from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.family import QUANTITIES
from skin_ident.criticism.scan.fitting import Fit, Member, fit
from skin_ident.criticism.scan.gate import Gain, Test, gain_of
from skin_ident.criticism.scan.noise import Estimated, estimate
from skin_ident.criticism.scan.score import Judge

MOST_FINDINGS = 5
SHORTLIST = 4  # causes put to the gate before none is named
AHEAD = 5  # trials that are tried together with every other cause before one is chosen
NOISE_TRIES = 4  # causes around whose fit the noise is estimated, too
REACH = 0.05  # a rival within this share of the score, or within CLOSE, cannot be told from the cause
CLOSE = 6.0

Progress = Callable[[str], None]


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


@dataclass(frozen=True, eq=False)
class Named:
    """One cause in the extended model: what it gained when held out, what it explains, and (score lacking) who might be it instead."""

    candidate: Candidate
    gain: Gain
    explained: float
    rivals: tuple[tuple[Candidate, float], ...] = ()


@dataclass(frozen=True, eq=False)
class Search:
    """What a search found. `rounds` holds every round's trials, the best first, and the cause named in it."""

    baseline: Fit
    extended: Fit
    named: tuple[Named, ...]
    refused: tuple[Named, ...]
    noise: Estimated
    judge: Judge
    last: tuple[Trial, ...]
    rounds: tuple[tuple[tuple[Trial, ...], str | None], ...]


def search(start: Member, s: Setting, progress: Progress = lambda stage: None) -> Search:
    """Find what `start` gets wrong on the cells."""
    noise = estimate(start, s.cells, s.rich, s.floor)
    baseline = present = fit(start, s.cells, noise.noise.whitener())
    named: list[Named] = []
    refused: list[Named] = []
    rounds = []
    while True:
        progress("estimating the noise")
        noise, trials, present = _surveyed(present, [n.candidate for n in named], s)
        if len(named) == MOST_FINDINGS:
            break
        progress("holding out depths and distances")
        found = _first_believed(present, _promising(trials, named, noise, s), noise, s, refused)
        rounds.append((trials, found and found[1].candidate.cause))
        if found is None:
            break
        present = found[0]
        named.append(found[1])
        progress(f"named {found[1].candidate.cause} in the {found[1].candidate.where}")
        present, named = _exchanged(present, named, noise, s)
    present, named, dropped = _eliminated(present, named, noise, s)
    if dropped:
        noise, trials, present = _surveyed(present, [n.candidate for n in named], s)
    verdict = _judge(noise, s)
    named = [replace(n, rivals=_rivals(present, n, named, noise, s)) for n in named]
    baseline = fit(baseline.member, s.cells, noise.noise.whitener())
    return Search(baseline, present, tuple(named), tuple(refused), noise, verdict, trials, tuple(rounds))


def _surveyed(present: Fit, named: list[Candidate], s: Setting) -> tuple[Estimated, tuple[Trial, ...], Fit]:
    """The noise, the trials of every cause that is not in the model, best first, and the present fit in that noise.

    A cause that is not smooth (saturation, a dead zone) is in no direction of the family: the noise is estimated around the best few
    trials as well, and the likeliest estimate counts.
    """
    noise = estimate(present.member, s.cells, s.rich, s.floor)
    trials, present = _trials(present, named, noise, s)
    others = [estimate(t.fit.member, s.cells, s.rich, s.floor) for t in trials[:NOISE_TRIES] if t.score > 0.0]
    best = min([noise, *others], key=lambda n: n.deviance)
    if best is not noise:
        noise = best
        trials, present = _trials(present, named, noise, s)
    return noise, trials, present


def _trials(present: Fit, named: list[Candidate], noise: Estimated, s: Setting) -> tuple[tuple[Trial, ...], Fit]:
    j = _judge(noise, s)
    present = fit(present.member, s.cells, j.whitener)
    every = [_trial(present, c, j, s) for c in s.able if c.cause not in taken(named, s)]
    return tuple(sorted(every, key=lambda t: -t.score)), present


def taken(named: list[Candidate], s: Setting) -> set[str]:
    """The causes that are not tried beside those named."""
    causes = {c.cause for c in named}
    return causes | {"spread_shape", "off_centre"} if causes & {"spread_shape", "off_centre"} and not s.both_sides else causes


def _promising(trials: tuple[Trial, ...], named: list[Named], noise: Estimated, s: Setting) -> list[Trial]:
    """The trials that score, the one first that promises most together with one more cause: two small causes hide in one wrong shape."""
    j = _judge(noise, s)
    scoring = [t for t in trials if t.score > 0.0]
    ahead = []
    for t in scoring[:AHEAD]:
        done = taken([*(n.candidate for n in named), t.candidate], s)
        more = max((_trial(t.fit, c, j, s).score for c in s.able if c.cause not in done), default=0.0)
        ahead.append(replace(t, promise=t.score + max(more, 0.0)))
    ahead.sort(key=lambda t: -t.promise)
    if not s.both_sides and any(t.candidate.cause == "spread_shape" for t in scoring):
        ahead.sort(key=lambda t: t.candidate.cause == "off_centre")
    return [*ahead, *scoring[AHEAD:]]


def _judge(noise: Estimated, s: Setting) -> Judge:
    return Judge(noise.noise, noise.noise.whitener(), s.cells, noise.spare)


def _trial(present: Fit, c: Candidate, j: Judge, s: Setting) -> Trial:
    best = min((fit(m, s.cells, j.whitener) for m in with_candidate(c, present.member)), key=lambda f: f.cost)
    fall = present.cost - best.cost
    count = best.member.unknowns.size - present.member.unknowns.size
    return Trial(c, best, fall, j.score(fall, best, c.names, count))


def with_candidate(c: Candidate, m: Member) -> list[Member]:
    """The members from which a fit of `m` with the cause sets out."""
    return [replace_sizes(m, True)] if c.cause == "parameters" else starts(c, m)


def without_candidate(c: Candidate, m: Member, start: Member) -> Member:
    """`m` without the cause: its parameters at the values that remove it, and no longer free."""
    if c.cause == "parameters":
        return replace_sizes(m, False, start)
    gone = {n: start.values[n] if n == "width" else QUANTITIES[n].neutral for n in c.names}
    m = m.moved(**gone)
    return Member(m.values, m.k, tuple(n for n in m.free if n not in c.names or n in start.free), m.scale, m.steps, m.k_free)


def replace_sizes(m: Member, free: bool, start: Member | None = None) -> Member:
    """`m` with its sizes free, or back at those of `start`."""
    return Member(m.values, m.k if start is None else start.k, m.free, m.scale, m.steps, free)


def _first_believed(present: Fit, trials: list[Trial], noise: Estimated, s: Setting, refused: list[Named]):
    """The best trial that held-out cells support, as (fit, finding), or None. What they do not support is kept in `refused`."""
    causes: list[str] = []
    for t in trials:
        if t.candidate.cause in causes:
            continue
        causes.append(t.candidate.cause)
        if len(causes) > SHORTLIST:
            break
        gain = gain_of(present.member, t.fit.member, t.candidate, noise.noise, s.cells, s.test)
        finding = Named(t.candidate, gain, t.score)
        if gain.passed:
            return t.fit, finding
        refused.append(finding)
    return None


def _exchanged(present: Fit, named: list[Named], noise: Estimated, s: Setting) -> tuple[Fit, list[Named]]:
    """Put another cause, or another form, in the place of a named one wherever the whole then fits better by more than CLOSE."""
    whitener = noise.noise.whitener()
    for i, n in enumerate(named):
        others = taken([o.candidate for o in named if o is not n], s)
        base = without_candidate(n.candidate, present.member, s.test.start)
        best = None
        for c in s.able:
            if c == n.candidate or c.cause in others:
                continue
            found = min((fit(m, s.cells, whitener) for m in with_candidate(c, base)), key=lambda f: f.cost)
            charge = (found.member.unknowns.size - present.member.unknowns.size) * 5.0
            worth = present.cost - found.cost - charge
            if c.cause == "off_centre" and not s.both_sides:
                continue
            if worth > (1.0 if c.cause == n.candidate.cause else CLOSE) and (best is None or worth > best[0]):
                best = (worth, found, c)
        if best is None:
            continue
        before = fit(base, s.cells, whitener)
        gain = gain_of(before.member, best[1].member, best[2], noise.noise, s.cells, s.test)
        if gain.passed:
            present = best[1]
            named = [replace(o, candidate=best[2], gain=gain, explained=o.explained + best[0]) if o is n else o for o in named]
    return present, named


def _eliminated(present: Fit, named: list[Named], noise: Estimated, s: Setting) -> tuple[Fit, list[Named], bool]:
    """Take out every cause without which the rest fits and predicts just as well."""
    dropped = False
    for n in list(reversed(named[:-1])):
        before, worth, gain = _worth(present, n, noise, s)
        if worth <= 0.0 or not gain.passed:
            present, named, dropped = before, [o for o in named if o is not n], True
        else:
            named = [replace(o, gain=gain, explained=worth) if o is n else o for o in named]
    return present, named, dropped


def _worth(present: Fit, n: Named, noise: Estimated, s: Setting) -> tuple[Fit, float, Gain]:
    j = _judge(noise, s)
    before = fit(without_candidate(n.candidate, present.member, s.test.start), s.cells, j.whitener)
    count = max(present.member.unknowns.size - before.member.unknowns.size, 1)
    worth = j.score(before.cost - present.cost, present, n.candidate.names, count)
    return before, worth, gain_of(before.member, present.member, n.candidate, noise.noise, s.cells, s.test)


def _rivals(present: Fit, n: Named, named: list[Named], noise: Estimated, s: Setting) -> tuple[tuple[Candidate, float], ...]:
    """The causes that in the place of a named one explain nearly as much, with what they lack."""
    j = _judge(noise, s)
    others = {o.candidate.cause for o in named}
    same = {"spread_shape", "off_centre"} if not s.both_sides else set()
    base = fit(without_candidate(n.candidate, present.member, s.test.start), s.cells, j.whitener)
    count = max(present.member.unknowns.size - base.member.unknowns.size, 1)
    own = j.score(base.cost - present.cost, present, n.candidate.names, count)
    best: dict[str, tuple[Candidate, float]] = {}
    for c in s.able:
        if c.cause in others:
            continue
        score = _trial(base, c, j, s).score
        short, twin = own - score, {c.cause, n.candidate.cause} == same
        if (short < max(CLOSE, REACH * own) or twin) and score > 0.0 and (c.cause not in best or short < best[c.cause][1]):
            best[c.cause] = (c, float(short))
    return tuple(sorted(best.values(), key=lambda b: b[1]))
