"""The state of a search for causes, and its loop: survey, try the best few, let held-out sessions decide, repeat."""

from collections.abc import Callable, Iterable, Iterator
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, cost_of, fit
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.courses.carriers import DELAY, SLOPE
from skin_ident.criticism.courses.course import BEHIND, MARGIN, worthwhile
from skin_ident.criticism.courses.kinds import CONSTANT
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.gate import MATERIAL, Gain, deaf, held_out_gain
from skin_ident.criticism.gates.second_opinion import all_in_turn, halves_in_turn
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.search.believing import first_believed
from skin_ident.criticism.search.growing import grow, lacking
from skin_ident.criticism.search.hardware import stage_does, steps_do
from skin_ident.criticism.search.named import Named, Seen
from skin_ident.criticism.search.own import own_course, refitted, take_alone, take_course
from skin_ident.criticism.search.proposals import Direction
from skin_ident.criticism.search.ranking import Ranked
from skin_ident.criticism.search.rivals import plainest_first
from skin_ident.criticism.search.shortlist import shortlisted
from skin_ident.criticism.search.survey import Survey, survey
from skin_ident.criticism.search.tared import take_tare, take_zeros
from skin_ident.criticism.search.together import lasts, two_at_once
from skin_ident.criticism.search.trial import Trial, plausible
from skin_ident.criticism.search.unstuck import unstuck
from skin_ident.criticism.search.wandering import take_wave
from skin_ident.criticism.search.weighing import held_again, may_wait, weigh, weighed, weighs, with_mass
from skin_ident.criticism.sessions.session import Session
from skin_models.effect import Effect
from skin_models.model import Model

MOST_FINDINGS = 5
SHADOW = 0.08  # of the largest fall of a mean square so far in a channel, below which no further cause is named there
FORM = 0.06  # of the likelihood gain of what was named in a sensor, below which another cause there may be its imperfect form
SENSORS = ("taxel", "load_cell")
BESIDE = 0.6  # of what a course explains that predicts nothing, the least that a shared cause must explain to be asked beside it

Progress = Callable[[str], None]


@dataclass
class Search:
    """The loop's state: the present fit, what was named, what held-out data refused, and the surveys of all rounds."""

    train: list[Session]
    held: list[Session]
    which: tuple[Direction, ...]
    progress: Progress
    encoder_step: float = 0.0
    weighable: bool = False  # whether the mass may be another than was assumed or declared,
    declared: bool = False  # and somebody declared it

    def __post_init__(self) -> None:
        self.present: Fit  # the model so far, fitted, and the noise that was seen with it, both from `run` on
        self.baseline: Fit  # what was fitted without any cause
        self.led: set[tuple[str, str]] = set()  # causes that only led out of a false minimum
        self.noise: Whitener
        self.named: list[Named] = []
        self.rounds: list[tuple[Survey, str | None]] = []
        self.runs: list[Run] = []
        self.doubting = False  # whether held-out sessions alone decide, for a cause was taken for granted
        self.alone = False  # whether what is wrong in the held-out sessions alone has been looked for, and found
        self.put_out: set[tuple[str, str]] = set()  # causes in whose place another was put: they do not come back into its
        self.suspected: set[tuple[str, str]] = set()
        self.usual: dict[tuple[str, str], Seen] = {}  # what would have been named, and is such as good hardware does
        self.tared: dict[tuple[str, str], Seen] = {}  # zeros of sessions that were taken into the baseline
        self.doubts: dict[tuple[str, str], Seen] = {}  # what training speaks for, and others leave in doubt
        self.most = MOST_FINDINGS  # rounds
        self.zeroed = False  # whether zeros as good hardware leaves them were taken where no cause was believed
        self.refused = 0.0  # what the best cause would explain that was not believed in the last round
        self.wandering = 0.0  # the most that a course explained of training sessions which then predicted nothing
        self.hanging: tuple[Effect, ...] = ()  # of a mass that was declared, what the load cell feels without its weight
        self.befores: dict[tuple[str, str], Model] = {}
        self._surveyed: tuple[Model, list[Session], Survey] | None = None

    def run(self, fitted: Fit) -> None:
        """Name one cause after the other, beginning with the fitted baseline, until held-out data refuse."""
        self.present = fitted
        while len(self.rounds) < self.most and self._round():
            pass

    def _round(self) -> bool:
        """Take what explains most of what the present model leaves, and is believed; return whether to look again."""
        self.usual, self.doubts = {}, {}
        last = self.look()
        trials, runs = self.trials(last), self.own_courses()
        before = set(self.usual)
        mass = with_mass(self.present, self.train, self.noise) if self.weighable else None
        if mass and weighs(self, mass, max([0.0, *(t.score for t in trials), *(r.score for r in runs)])):
            weigh(self, mass)
            return True
        last_resort = mass if mass and may_wait(self, mass) else None
        own, shared = self.choose(trials, runs)
        if own and not take_tare(self, own[1]):
            self._end_round(last, own[1].cause)
            take_course(self, *own)
        elif shared and not (take_tare(self, shared[1]) or unstuck(self, *shared)):
            self._end_round(last, shared[1].cause)
            self.accept(*shared)
        return bool(own or shared) or self._believing_none(last, trials, runs, last_resort, bool(set(self.usual) - before))

    def _believing_none(self, last: Survey, trials: list[Trial], runs: list[Run], mass: Fit | None, usual: bool) -> bool:
        """Take what else may be there where no cause is believed, the plainest first: zeros as tares leave them, if nothing `usual` was
        seen in place of a cause; what is wrong in held-out sessions alone; another `mass`; two causes that hide each other; a wave.
        Return whether to look again."""
        if not (self.zeroed or self.doubts or usual) and take_zeros(self):
            self.zeroed = True
            return True
        if take_alone(self):
            self._end_round(last, self.named[-1].cause)
            return True
        if mass and not self.named:
            weigh(self, mass)
            return True
        pair = () if self.named or self.usual else two_at_once(self, trials, runs)
        if pair:
            self._end_round(last, pair[0][1].cause)
            for after, finding in pair:
                self.accept(after, finding)
            return True
        if take_wave(self):
            self._end_round(last, self.named[-1].cause)
            return True
        self._end_round(last, None, refused=max((t.score for t in trials), default=0.0))
        return False

    def _end_round(self, last: Survey, cause: str | None, refused: float = 0.0) -> None:
        self.rounds.append((last, cause))
        self.refused = refused

    def go_on(self) -> None:
        """From here on as many rounds again."""
        self.most = len(self.rounds) + MOST_FINDINGS

    def unweigh(self) -> None:
        """Hold the mass again where that which was assumed does as well, now that causes are named."""
        held = None if self.declared else held_again(self.present, self.train, self.noise)
        if held:
            self.present, self.train, self.held = held, weighed(self.train, 0.0), weighed(self.held, 0.0)

    def choose(self, trials: list[Trial], runs: list[Run]) -> tuple[tuple[Run, Named] | None, tuple[Fit, Named] | None]:
        """What each session has of its own, where that explains clearly more than any shared cause or where held-out data refuse those. Of
        one cause at one place that form is taken which explains more.

        Where it explains clearly more and yet predicts nothing, noise wanders more than the noise model knows, and no cause is named that
        explains far less. A clock that slips wherever it helps is no noise: where it predicts nothing, it is passed over.
        """
        best = max((t.score for t in trials), default=0.0)
        plain = runs and runs[0].course.shape == CONSTANT and runs[0].course.carrier != SLOPE  # one number, and no other depths feign it
        first = runs and runs[0].score > (best if plain else max(MARGIN * best, best + 10.0))
        same = trials and runs and trials[0].key == runs[0].course.key
        score = runs[0].score if runs else 0.0
        if same and not first:  # in another form than the best trial, which has been refitted, too
            score = max(score, refitted(self, runs[0])[1])
        own = own_course(self, runs, trials) if first or (same and score > best) else None
        if first and not own and runs[0].course.carrier == DELAY:
            return self.choose(trials, [r for r in runs if r.course.carrier != runs[0].course.carrier])
        asked = not own and (not first or best > BESIDE * runs[0].score)
        shared = first_believed(self, trials, runs) if asked else None
        if not (own or shared or first) and runs and score > BEHIND * best:
            own = own_course(self, runs, trials)
        return own, shared

    def ahead(self, present: Fit) -> "Search":
        """The same state with another fit, from which to look further; what is found there is not found here."""
        other = copy(self)
        vars(other).update({name: copy(v) for name, v in vars(self).items() if isinstance(v, (list, dict, set))})
        other.present, other.doubts, other.doubting, other._surveyed = present, {}, True, None
        return other

    @property
    def seen(self) -> dict[tuple[str, str], Seen]:
        """What is in the record and no finding, by cause and place."""
        return self.doubts | self.usual | self.tared

    def own_courses(self) -> list[Run]:
        """What each session may have of its own and has not yet, the plainest first."""
        had = {r.course for r in self.runs}
        runs = worthwhile(self.present.model, self.train, self.noise, self.encoder_step)
        good = [r for r in runs if not r.worth(self.encoder_step) and r.score > self.least(self.present.count)]
        self.usual |= {r.course.key: stage_does(r, self.encoder_step) for r in good}
        return plainest_first([r for r in runs if r.worth(self.encoder_step) and r.course not in had])

    def look(self) -> Survey:
        """Survey what the present model leaves, in the noise that the survey finds."""
        self.progress("surveying every cause")
        last = self.survey()
        self.noise = last.noise
        self.present = replace(self.present, cost=cost_of(self.present.model, self.train, self.noise))
        return last

    def survey(self) -> Survey:
        """Every cause ranked against the present model; that of last time where neither model nor sessions have changed since."""
        if self._surveyed is None or self._surveyed[0] is not self.present.model or self._surveyed[1] is not self.train:
            if self._surveyed:
                self._surveyed[2].kept.clear()
            self._surveyed = self.present.model, self.train, survey(self.present.model, self.train, self.which)
        return self._surveyed[2]

    def trials(self, last: Survey) -> list[Trial]:
        """The most promising causes, each grown and refitted, the best first."""

        def tried(causes: Iterable[Ranked]) -> Iterator[Trial]:
            return (t for t in map(self._trial, causes) if plausible(t, self.train))

        return shortlisted(last.ranked, tried, {n.key for n in self.named}, self.suspected)

    def _trial(self, r: Ranked) -> Trial:
        self.progress(f"trying {r.cause} in the {r.where}")
        grown, *plainer = (self._scored(r, after) for after in grow(self.present, r, self.train, self.which, self.noise))
        return replace(grown, plainer=next(iter(plainer), None))

    def _scored(self, r: Ranked, after: Fit) -> Trial:
        charge = np.log(after.count) * (len(after.unknowns) - len(self.present.unknowns))
        return Trial(r, after, float(self.present.cost - after.cost - charge))

    def least(self, count: int) -> float:
        """The likelihood gain below which a cause is not worth naming, where so many whitened samples count; slow causes gain as much of a
        band that was narrowed, and its noise no less."""
        return MATERIAL * count * self.train[0].band.narrowed

    def form_of_others(self, cause: str, where: str) -> float:
        """The likelihood gain that imperfect forms of other causes, named in the same sensor, may leave to this one."""
        if not where.startswith(SENSORS):  # skin and rig have many causes, each in its own right
            return 0.0
        return max((FORM * n.explained for n in self.named if n.where == where and n.cause != cause), default=0.0)

    def fallen(self, channel: str) -> float:
        """The largest fall of the mean square, N^2, by what has been named and is carried by a channel."""
        return max((n.gain.squares for n in self.named if channel in n.gain.carried), default=0.0)

    def shadows(self, gain: Gain) -> bool:
        """Whether what has been named explains so much more that what gains so may be its imperfect form."""
        return gain.squares <= SHADOW * self.fallen(gain.channel)

    def resolved(self, key: tuple[str, str], gain: Gain, after: Model) -> bool:
        """Whether a gain is more than what steps of encoder and converters leave open. What else is believed, and is not, is said."""
        seen = steps_do(key[0], gain, self.present.model, after, self.train, self.encoder_step)
        self.usual |= {key: seen} if seen else {}
        return seen is None

    def accept(self, after: Fit, finding: Named) -> None:
        """Take a finding. More of a cause that is there already joins it, and its gain then counts from before the first."""
        start = self.befores.setdefault(finding.key, self.present.model)
        same = next((n for n in self.named if n.key == finding.key), None)
        if same is None:
            self.named.append(finding)
        else:
            more = replace(same, gain=self.gain(start, after.model, finding.where), explained=same.explained + finding.explained)
            self.named = [more if n is same else n for n in self.named]
        self.present, self.doubts = after, {}
        self.train, self.held = ([settled(after.model, s) for s in sessions] for sessions in (self.train, self.held))
        self.progress(f"named {finding.cause} in the {finding.where}")

    def second_opinion(self, before: Model, after: Model, where: str, first: Gain) -> Gain:
        """The gain by other sessions, too, or by halves where held-out ones cannot be asked; not where these speak against it, where a lone
        session was fitted, nor of short records, in which a bent cause fits whatever is there."""
        if not (self.held and len(self.train) > 1 and lasts(self)):
            return first
        models, cannot = (before, after, self.train), self.deaf(before, after, where)
        alone = held_out_gain(*models, self.held, self.noise) if cannot else first
        if alone.relative <= 0.0 or alone.spoilt:
            return first
        other = halves_in_turn(*models, self.noise) if cannot else all_in_turn(*models, self.held, self.noise)
        return other if other.passed else first

    def eliminate(self) -> None:
        """Take out causes, last found first, without which the rest predicts as well. The last was just asked, if nothing came after it."""
        asked = self.named[:-1] if self.named and self.named[-1].model is self.present.model else self.named
        for finding in reversed([n for n in asked if not n.courses]):
            without = fit(lacking(self.present.model, *finding.key), self.train, self.noise)
            gain = self.gain(without.model, self.present.model, finding.where)
            if not (gain.passed or self.second_opinion(without.model, self.present.model, finding.where, gain).passed):
                self.present, self.named = without, [n for n in self.named if n is not finding]

    def gain(self, before: Model, after: Model, where: str, refit_before: Callable = fit) -> Gain:
        """What `after` gains over `before` in held-out data; in training sessions by turns where what is held out cannot show it."""
        held = [] if self.deaf(before, after, where) else self.held
        return held_out_gain(before, after, self.train, held, self.noise, refit_before)

    def deaf(self, before: Model, after: Model, where: str) -> bool:
        """Whether what is held out cannot show what `after` changes."""
        return bool(self.held) and deaf(before, after, self.train, self.held, where)
