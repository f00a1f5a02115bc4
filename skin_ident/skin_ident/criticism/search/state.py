"""The state of a search for causes, and what can be asked of it: surveys, trials, gains, and what makes a cause worth naming."""

from collections.abc import Callable, Iterable, Iterator
from copy import copy
from dataclasses import dataclass, field, replace

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, fit
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.courses.course import worthwhile
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.claim import Claim
from skin_ident.criticism.gates.gate import MATERIAL_FALL, Gain, deaf, held_out_gain
from skin_ident.criticism.gates.second_opinion import all_in_turn, halves_in_turn
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.search.doubt import yields
from skin_ident.criticism.search.growing import grow
from skin_ident.criticism.search.hardware import stage_does, steps_do
from skin_ident.criticism.search.named import Named, NotNamed
from skin_ident.criticism.search.plausible import plausible
from skin_ident.criticism.search.proposals import Direction
from skin_ident.criticism.search.ranking import Ranked
from skin_ident.criticism.search.rivals import plainest_first
from skin_ident.criticism.search.shortlist import shortlisted
from skin_ident.criticism.search.survey import Survey, survey
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.sessions.beginning import at_rest
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import SENSORS, Key
from skin_models.model import Model

MOST_FINDINGS = 5  # findings or rounds, after which findings are compared with each other again
SHADOW = 0.08  # share of the largest fall of a mean square so far in a channel, below which no further cause is named there
FORM = 0.06  # share of the score of what was named in a sensor, below which another cause there may be its imperfect form
REMEMBERED = 20  # surveys that are kept to come back to
LASTS_S = 30.0  # s of training in all: in less, two bent causes fit any record

Progress = Callable[[str], None]


@dataclass
class Search:
    """The present fit, what was named, what held-out data refused, and the surveys of all rounds.

    `which` are the directions that are ranked, `encoder_step` is the step of the depth, m. Where the mass is `weighable`, it may differ
    from what was assumed, or from what somebody `declared`; that of a given model may be `only_lighter`.
    """

    train: list[Session]
    held: list[Session]
    which: tuple[Direction, ...]
    progress: Progress
    encoder_step: float = 0.0
    weighable: bool = False
    declared: bool = False
    only_lighter: bool = False

    # What is known by now: the present model as fitted, the noise found with it, and the fit without any cause.
    present: Fit = field(init=False)
    noise: Whitener = field(init=False)
    baseline: Fit = field(init=False)
    named: list[Named] = field(default_factory=list)
    befores: dict[Key, Model] = field(default_factory=dict)  # of every named cause, the model before its first instance
    runs: list[Run] = field(default_factory=list)  # courses that were taken
    rounds: list[tuple[Survey, str | None]] = field(default_factory=list)
    most: int = MOST_FINDINGS  # rounds at most

    # Why something that is in the record was not named: of the last round alone, except for the zeros.
    doubts: dict[Key, NotNamed] = field(default_factory=dict)  # training speaks for it, and something else leaves it in doubt
    stage: dict[Key, NotNamed] = field(default_factory=dict)  # courses that explain something, but no more than a good stage does
    hardware: dict[Key, NotNamed] = field(default_factory=dict)  # it would have been named, but good hardware does as much
    tared: dict[Key, NotNamed] = field(default_factory=dict)  # zeros, or skin parameters, of sessions that were taken into the baseline
    grown: dict[Key, Fit] = field(default_factory=dict)  # what the causes tried in the last round come to, where they explain something
    of_stage: float = 0.0  # the highest score of such courses in the last round
    # The same from earlier rounds since the last cause was named: skin, zeros or a mass taken then may hide it now.
    set_aside: dict[Key, NotNamed] = field(default_factory=dict)

    yielded: list[Named] = field(default_factory=list)  # findings in whose place zeros were taken

    # What is not tested again, or is tested differently from now on.
    suspected: set[Key] = field(default_factory=set)  # causes that the record itself has shown
    led: set[Key] = field(default_factory=set)  # causes that only led out of a false minimum
    put_out: set[Key] = field(default_factory=set)  # findings that another replaced: they do not come back in its place
    dropped: set[Key] = field(default_factory=set)  # causes without which the rest predicted as well: what they explained is left to others
    doubting: bool = False  # held-out sessions alone decide, because a cause was taken for granted
    alone: Run | None = None  # what was found to be wrong in held-out sessions alone
    own_skin: bool = False  # the skin may differ from session to session
    zeroed: int | None = None  # number of findings beside which zeros as good hardware leaves them were last asked for; None: none taken
    late: tuple | None = None  # findings and baseline beside which the delay of the depth was last asked for (see `lateness`)
    zeros_of_held: dict[str, np.ndarray] = field(default_factory=dict)  # what these add to held-out sessions, (C, N) N by session
    refused: float = 0.0  # what the best cause would explain that was not believed in the last round
    wandering: float = 0.0  # the highest score in training of a course that then predicted nothing

    _surveyed: Survey | None = None
    _surveys: list[Survey] = field(default_factory=list)  # the latest ones, of states that look ahead as well

    @property
    def not_named(self) -> dict[Key, NotNamed]:
        """What is in the record and no finding, by cause and place."""
        yielded = {n.key: yields() for n in self.yielded}
        return yielded | self.set_aside | self.doubts | self.stage | self.hardware | self.tared

    def ahead(self, present: Fit) -> "Search":
        """A copy of the state with another fit, from which to look further; what is found there does not enter this one, but surveys are
        remembered: what was found ahead is often taken next, and is then looked at again."""
        other = copy(self)
        vars(other).update({name: copy(v) for name, v in vars(self).items() if isinstance(v, (list, dict, set))})
        other.present, other.doubts, other.doubting, other._surveyed, other._surveys = present, {}, True, None, self._surveys
        return other

    def is_new(self, finding: Named) -> bool:
        """Whether a finding is the last one and nothing came after it: then it has just been preferred to all others in its place."""
        return finding is self.named[-1] and finding.model is self.present.model

    def begin_round(self) -> None:
        """Collect anew the reasons why nothing else is named, and set those of the last round aside."""
        self.set_aside |= self.doubts | self.hardware
        self.stage, self.hardware, self.doubts = {}, {}, {}

    def end_round(self, last: Survey, cause: str | None, refused: float = 0.0) -> None:
        """Note which cause a round has named, or how much the best explains that was `refused`."""
        self.rounds.append((last, cause))
        self.refused = refused

    def go_on(self) -> None:
        """Allow as many rounds again from here on."""
        self.most = len(self.rounds) + MOST_FINDINGS

    def look(self) -> Survey:
        """Survey the residual of the present model, and use the noise that the survey finds from now on."""
        self.progress("surveying every cause")
        last = self.survey()
        self.noise = last.noise
        self.present = self.present.under(self.noise, self.train)
        return last

    def survey(self) -> Survey:
        """Every cause ranked against the present model. An earlier survey is returned where model and sessions are those of that one."""
        model, last = self.present.model, self._surveyed
        if last is None or not last.is_of(model, self.train):
            if last:
                last.kept.clear()
            found = next((s for s in self._surveys if s.is_of(model, self.train)), None)
            self._surveyed = found.without_directions() if found else survey(model, self.train, self.which)
            if not found:
                self._surveys.append(self._surveyed.without_directions())
                del self._surveys[:-REMEMBERED]
        return self._surveyed

    def trials(self, last: Survey) -> list[Trial]:
        """The most promising causes of the `last` survey, made of the present fit in the present noise, each grown and refitted, the best
        first."""

        def tried(causes: Iterable[Ranked]) -> Iterator[Trial]:
            return filter(None, (self._possible(r, last.fits) for r in causes))

        ranked = [r for r in last.ranked if r.key not in self.dropped]
        trials = shortlisted(ranked, tried, {n.key for n in self.named}, self.suspected, self.present.count)
        self.grown = {t.key: t.fit for t in trials if t.score > 0.0}
        return trials

    def _possible(self, r: Ranked, known: dict[Key, tuple[Fit, ...]]) -> Trial | None:
        """One cause as a trial, or its first instance alone where physics rules out all instances together; else None."""
        return next((t for t in self.tried(r, known).forms if plausible(t, self.train)), None)

    def tried(self, r: Ranked, known: dict[Key, tuple[Fit, ...]]) -> Trial:
        """One cause as a trial: grown and refitted beside everything else, unless its fits are `known`, where they are put if not."""
        if r.key not in known:
            self.progress(f"trying {r.cause} in the {r.where}")
            known[r.key] = grow(self.present, r, self.train, self.which, self.noise)
        grown, *plainer = (Trial(r, after, after.score_over(self.present)) for after in known[r.key])
        return replace(grown, plainer=next(iter(plainer), None))

    def own_courses(self) -> list[Run]:
        """Courses that sessions may have and that were not taken yet, the simplest first; those that a good stage does are noted."""
        had = {r.course for r in self.runs}
        runs = worthwhile(self.present.model, self.train, self.noise, self.encoder_step)
        good = [r for r in runs if not r.worth(self.encoder_step) and r.score > self.least(self.present.count)]
        self.stage |= {r.course.key: stage_does(r, self.encoder_step) for r in good}
        self.of_stage = max((r.score for r in good), default=0.0)
        return plainest_first([r for r in runs if r.worth(self.encoder_step) and r.course not in had])

    @property
    def lasts(self) -> bool:
        """Whether training sessions are long enough to tell several causes from each other."""
        return sum(s.seconds for s in self.train) >= LASTS_S

    def least(self, count: int) -> float:
        """The score below which a cause is not worth naming, for `count` whitened samples. A narrowed band, which holds fewer
        samples, does not lower it: slow causes gain as much there, and the noise in it is no less."""
        return MATERIAL_FALL * count * self.train[0].band.narrowed

    def form_of_others(self, cause: str, where: str) -> float:
        """The score that imperfect forms of other causes, named in the same sensor, may leave for this one."""
        if not where.startswith(SENSORS):  # skin and rig have many causes, each in its own right
            return 0.0
        return max((FORM * n.explained for n in self.named if n.where == where and n.cause != cause), default=0.0)

    def fallen(self, channel: str) -> float:
        """The largest fall of the mean square, N^2, by a named cause that a channel carries. What held-out sessions alone have does not
        count: where training shows a cause, too, that cause is no shadow of it."""
        fitted = {s.name for s in self.train}
        shared = [n for n in self.named if not n.courses or fitted & set(n.courses)]
        return max((n.gain.squares for n in shared if channel in n.gain.carried), default=0.0)

    def shadows(self, gain: Gain) -> bool:
        """Whether a named cause explains so much more that this gain may be due to its imperfect form."""
        most = self.fallen(gain.channel)
        return most > 0.0 and gain.squares <= SHADOW * most

    def claim(self, key: Key, gain: Gain, after: Model) -> Claim:
        """The claim that `after` gains so over the present model by a cause and place."""
        return Claim(key, gain, self.present.model, after, self.train)

    def steps_do(self, key: Key, gain: Gain, after: Model) -> bool:
        """Whether steps of encoder and converters may account for what `after` gains beside a course of sessions. If so it is noted, since
        everything else speaks for the cause."""
        why = steps_do(self.claim(key, gain, after), None, self.encoder_step)
        self.hardware |= {key: why} if why else {}
        return why is not None

    def gain(self, before: Model, after: Model, where: str, refit_before: Callable = fit) -> Gain:
        """Gain of `after` over `before` in held-out data, or in each training session in turn where held-out data cannot show it."""
        held = [] if self.deaf(before, after, where) else self.held
        return held_out_gain(before, after, self.train, held, self.noise, refit_before)

    def deaf(self, before: Model, after: Model, where: str) -> bool:
        """Whether held-out sessions cannot show what `after` changes."""
        return bool(self.held) and deaf(before, after, self.train, self.held, where)

    def second_opinion(self, before: Model, after: Model, where: str, first: Gain) -> Gain:
        """The gain by other sessions as well, or by halves of sessions where held-out ones cannot show it. `first` stands where held-out
        sessions speak against the cause, where only one session was fitted, and for short records, in which a bent cause fits anything."""
        if not (self.held and len(self.train) > 1 and self.lasts):
            return first
        models, cannot = (before, after, self.train), self.deaf(before, after, where)
        alone = held_out_gain(*models, self.held, self.noise) if cannot else first
        if alone.is_against or alone.spoilt:
            return first
        others = [halves_in_turn(*models, self.noise)] if cannot else all_in_turn(*models, self.held, self.noise)
        return next((other for other in others if other.passed), first)

    def accept(self, after: Fit, finding: Named) -> None:
        """Take a finding. More of a cause that was named already joins that finding, whose gain then counts from before its first
        instance."""
        start = self.befores.setdefault(finding.key, self.present.model)
        same = next((n for n in self.named if n.key == finding.key and not n.courses), None)
        if same is None:
            self.named.append(finding)
        else:
            gain, explained = self.gain(start, after.model, finding.where), same.explained + finding.explained
            lacks = finding if finding.only else same  # a session that lacks one instance lacks all
            more = replace(same, gain=gain, explained=explained, only=lacks.only, free=lacks.free)
            self.named = [more if n is same else n for n in self.named]
        self.doubts, self.set_aside = {}, {}
        compared = sum(s.seconds for s in self.train)
        self.train, self.held = ([at_rest(settled(after.model, s), after.model) for s in sessions] for sessions in (self.train, self.held))
        shorter = sum(s.seconds for s in self.train) < compared
        self.present = fit(after.model, self.train, self.noise) if shorter else after  # what is no longer compared may have biased it
        self.progress(f"named {finding.cause} in the {finding.where}")
