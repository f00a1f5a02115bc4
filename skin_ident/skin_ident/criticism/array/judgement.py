"""Which cause, if any, the ratios of the taxels support."""

from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np

from skin_ident.criticism.array.evidence import Fitted, covariance_root, fitted
from skin_ident.criticism.array.family import Family
from skin_ident.criticism.array.gains import Gains
from skin_ident.criticism.array.hypotheses import CHANGE, GAIN, NOTHING, Background, Hypothesis, backgrounds, hypotheses
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.vocabulary import Key

SURE = 0.99  # probability that something is wrong, above which the best cause is named
REACH = 3.0  # log odds within which a rival cannot be told from the best cause,
AT_ONE_PLACE = 10.0  # and if all sessions press at one place: then causes differ only by the exact shape of spread or leak
MOST_SUSPECTS = 6  # taxels tried for a gain error or a gain that changed; the latter takes a fit for every split of the sessions
MOST_REPEATS = 4  # pairs of taxels that are fitted for crosstalk
KNOWN = 1e-4  # relative standard error of a calibration or width that is known practically exactly
MUCH_LESS = 0.5  # ratio of standard errors, with exact declarations to without, below which the declarations limit a bound
WIDER = 10.0  # factor on the prior standard deviations that makes them too wide to matter


@dataclass(frozen=True, eq=False)
class Judged:
    """One hypothesis with its log posterior odds against "nothing wrong", and its fit in the best component of the background. `limited`:
    its bound comes from the declared uncertainties and hardly from noise; with exact calibrations and width it would be much tighter."""

    hypothesis: Hypothesis
    log_odds: float
    fit: Fitted
    background: Background
    limited: bool = False

    @property
    def key(self) -> Key:
        """Cause and place."""
        return self.hypothesis.key


@dataclass(frozen=True, eq=False)
class Judgement:
    """The comparison: `nothing` wrong, and all `causes`, the most probable first. `sure` is the probability that something is wrong;
    `unaided` are the causes in the same order, fitted without prior knowledge of their size (none beside another cause); `changed` is the
    taxel whose gain has most probably changed between sessions, with the log odds of that; `reach` is how much lower the log odds of a
    rival may be."""

    nothing: Judged
    causes: tuple[Judged, ...]
    sure: float
    unaided: tuple[Judged, ...] = ()
    changed: tuple[str, float] = ("", -np.inf)
    reach: float = REACH

    @property
    def named(self) -> Judged | None:
        """The best cause, if something is wrong beyond doubt."""
        return self.causes[0] if self.causes and self.sure > SURE else None

    @property
    def rivals(self) -> tuple[Judged, ...]:
        """Causes that cannot be told from the best one."""
        return tuple(c for c in self.causes[1:] if c.log_odds > self.causes[0].log_odds - self.reach)

    @property
    def may_have_changed(self) -> str | None:
        """The taxel whose gain may not be the same in all sessions, if that cannot be told from the best cause; else None."""
        taxel, log_odds = self.changed
        return taxel if log_odds > self.causes[0].log_odds - self.reach else None


@dataclass(frozen=True)
class Pair:
    """Two causes that are there together, and the log of their prior times evidence."""

    causes: tuple[Hypothesis, Hypothesis]
    log: float

    @property
    def keys(self) -> set[Key]:
        """Cause and place of both."""
        return {h.key for h in self.causes}


def judge(layout: Layout, measured: Gains, thickness_mm: float | None = None, beside: Hypothesis = NOTHING) -> Judgement:
    """Compare all causes with each other and with "nothing wrong"; or with "nothing else wrong", `beside` a cause that is free in all of
    them."""
    family = Family(layout)
    mixture = list(backgrounds(layout, thickness_mm))

    def weighed(h: Hypothesis) -> Judged:
        fits, logs = _fits(family, measured, mixture, h, beside)
        best = int(np.argmax(logs))
        return Judged(h, float(np.logaddexp.reduce(logs) + np.log(h.prior)), fits[best], mixture[best])

    nothing = weighed(NOTHING)
    suspects = _suspects(family, measured, nothing.fit)
    listed = hypotheses(layout, suspects, _repeats(family, measured, nothing))
    others = [h for h in listed if h.key != beside.key]
    every = [replace(j, log_odds=j.log_odds - nothing.log_odds) for j in map(weighed, others)]
    causes = _one_each(sorted((j for j in every if _of_right_sign(j.hypothesis, j.fit)), key=lambda j: -j.log_odds))
    wrong = np.logaddexp.reduce([c.log_odds for c in causes])
    sure = float(1.0 / (1.0 + np.exp(-min(wrong, 700.0))))
    reach = REACH if layout.several_contacts else AT_ONE_PLACE
    unaided = () if beside is not NOTHING else tuple(_unaided(family, measured, c) for c in causes)
    judgement = Judgement(replace(nothing, log_odds=0.0), tuple(causes), sure, unaided, reach=reach)
    if not (judgement.named and layout.several_contacts):
        return judgement
    taxel, log = _changed(family, measured, mixture, suspects, beside)
    return replace(judgement, changed=(taxel, log - nothing.log_odds))


def pairs(layout: Layout, measured: Gains, alone: Judgement, b: Background) -> list[Pair]:
    """All pairs of the causes of a judgement, the most probable first, in one component of the background."""
    family, found = Family(layout), []
    for one, other in combinations((j.hypothesis for j in alone.causes), 2):
        fit = fitted(family, measured, b.scatter, b.and_with(one, other))
        if _of_right_sign(one, fit) and _of_right_sign(other, fit):
            found.append(Pair((one, other), fit.log_evidence + float(np.log(one.prior * other.prior))))
    return sorted(found, key=lambda p: -p.log)


def _fits(
    family: Family, measured: Gains, mixture: list[Background], h: Hypothesis, beside: Hypothesis
) -> tuple[list[Fitted], list[float]]:
    """The fit of a hypothesis in every component of the mixture, and the log of evidence times weight. The fits are similar, so each starts
    at the end of the previous one."""
    fits: list[Fitted] = []
    for b in mixture:
        fits.append(fitted(family, measured, b.scatter, b.and_with(beside, h), fits[-1].member if fits else None))
    return fits, [f.log_evidence + float(np.log(b.weight)) for f, b in zip(fits, mixture, strict=True)]


def unlike(layout: Layout, measured: Gains, j: Judged) -> float:
    """Relative misfit (norm) of the shares under a hypothesis, each session scaled by itself. A declared width is kept, unless the
    hypothesis is that it is wrong."""
    declared = {"width"} if layout.width_declared and "width" not in j.hypothesis.free else set()
    member = {name: value for name, value in j.fit.member.items() if name not in declared}
    left = measured.value - measured.at_own_levels(Family(layout).shares(member))
    return float(np.linalg.norm(left) / max(np.linalg.norm(measured.value), 1e-300))


def _unaided(family: Family, measured: Gains, j: Judged) -> Judged:
    """The cause fitted with a prior too wide to matter, in its best component of the mixture."""
    wide = {name: WIDER * std for name, std in j.hypothesis.free.items()}
    fit, exact = (
        fitted(family, measured, scatter, {**j.background.alone, "width": width, **wide})
        for scatter, width in ((j.background.scatter, j.background.width), (KNOWN, KNOWN))
    )
    return replace(j, fit=fit, limited=all(exact.std[name] < MUCH_LESS * fit.std[name] for name in wide))


def _changed(family: Family, measured: Gains, mixture: list[Background], suspects: list[int], beside: Hypothesis) -> tuple[str, float]:
    """The taxel whose gain was most probably another one in one session, or from one session on, and the log of prior times evidence."""
    count, taxels = measured.value.shape
    when = [*([s] for s in range(count)), *(list(range(s, count)) for s in range(1, count - 1))]

    def weighed(taxel: int, sessions: list[int]) -> float:
        loose = measured.loosened(taxel, sessions, GAIN)
        return np.logaddexp.reduce(_fits(family, loose, mixture, NOTHING, beside)[1])

    log, taxel = max((weighed(i, sessions), i) for i in suspects for sessions in when)
    return f"taxel_{taxel}", float(log + np.log(CHANGE / (taxels * len(when))))


def _suspects(family: Family, measured: Gains, nothing: Fitted) -> list[int]:
    """The taxels farthest from the declared layout, in units of their standard errors, the farthest first; all of them if they are few."""
    errors = np.sqrt(np.diagonal(measured.covariance, axis1=1, axis2=2))
    far = np.abs((measured.value - family.shares(nothing.member)) / errors).max(axis=0)
    return [int(i) for i in np.argsort(far)[::-1][:MOST_SUSPECTS]]


def _repeats(family: Family, measured: Gains, nothing: Judged) -> list[str]:
    """The pairs of taxels for which a repeat (crosstalk of one taxel into one other) would explain most of the misfit, to first order."""
    shares, (root, _) = family.shares(nothing.fit.member), covariance_root(measured, nothing.background.scatter)
    left, n = root @ (measured.value - shares).ravel(), shares.shape[1]
    falls = {}
    for i, j in permutations(range(n), 2):
        heard = np.zeros(shares.shape)
        heard[:, i] = shares[:, j]
        d = root @ heard.ravel()
        falls[f"repeat_{i}_{j}"] = float(d @ left) ** 2 / max(float(d @ d), 1e-300)
    return sorted(falls, key=lambda name: -falls[name])[:MOST_REPEATS]


def _of_right_sign(h: Hypothesis, fit: Fitted) -> bool:
    """Whether leaks and tails have the sign that physics allows: a neighbour leaks with its own sign, and a tail adds to the spread."""
    signed = h.free if h.cause == "crosstalk" else [name for name in h.free if name == "tail"]
    return all(fit.member.get(name, 0.0) >= 0.0 for name in signed)


def _one_each(every: list[Judged]) -> list[Judged]:
    """The best form of every cause at every place."""
    best: dict[Key, Judged] = {}
    for j in every:
        best.setdefault(j.key, j)
    return list(best.values())
