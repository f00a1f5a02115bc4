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
from skin_ident.criticism.gates.description import description_length
from skin_ident.criticism.gates.gate import MATERIAL, MUCH, Gain, deaf, held_out_gain
from skin_ident.criticism.gates.second_opinion import all_in_turn, at_any_scale, halves_in_turn
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.search.doubt import shadowed, unproven
from skin_ident.criticism.search.growing import grow, instances, lacking, negligible
from skin_ident.criticism.search.hardware import converter_does, encoder_does, stage_does, stage_is_off, steps_do, too_short
from skin_ident.criticism.search.named import Named, Seen
from skin_ident.criticism.search.own import own_course, refitted, take_alone, take_course
from skin_ident.criticism.search.proposals import Direction
from skin_ident.criticism.search.ranking import Ranked
from skin_ident.criticism.search.rivals import CHANCE, Rival, own_rivals, plainest_first, reach
from skin_ident.criticism.search.shortlist import shortlisted
from skin_ident.criticism.search.survey import Survey, survey
from skin_ident.criticism.search.tared import SHIFT, take_tare, take_zeros
from skin_ident.criticism.search.together import lasts, two_at_once
from skin_ident.criticism.search.trial import OFFSET, Trial, plausible, same_by_nature, sized
from skin_ident.criticism.search.unstuck import unstuck
from skin_ident.criticism.search.wandering import take_wave
from skin_ident.criticism.search.weighing import held_again, lighter, may_be_skin, weigh, weighed, weighs, with_mass
from skin_ident.criticism.sessions.session import Session
from skin_models.effect import Effect
from skin_models.model import Model

MOST_FINDINGS = 5
SHADOW = 0.08  # of the largest fall of a mean square so far in a channel, below which no further cause is named there
FORM = 0.06  # of the likelihood gain of what was named in a sensor, below which another cause there may be its imperfect form
SENSORS = ("taxel", "load_cell")
SURELY = 0.25  # of the fall of the mean square, above which its lower bound must be for a plainer form: that is a second chance
SHORTER = 15.0  # twice nats by which a cause must shorten the description: some hundreds of them were asked
DOUBTLESS = 2.0  # times what makes a cause worth naming, which the best one must explain if held-out sessions leave it in doubt
BESIDE = 0.6  # of what a course explains that predicts nothing, the least that a shared cause must explain to be asked beside it
WIDE, NEARLY = 0.2, 0.95  # nor one explaining all but this share, where it predicts held-out data as well but for so little

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
        while len(self.rounds) < self.most:
            self.usual, self.doubts = {}, {}
            last = self.look()
            trials = self.trials(last)
            runs = self.own_courses()
            zeros = set(self.usual)
            best = max([0.0, *(t.score for t in trials), *(r.score for r in runs)])
            free = with_mass(self.present, self.train, self.noise) if self.weighable else None
            light = free is not None and (lighter(self.present.model, free.model) or may_be_skin(self, free))
            if free and weighs(self, free, best):
                weigh(self, free)
                continue
            own, shared = self.choose(trials, runs)
            taken = own or shared
            if (taken and take_tare(self, taken[1])) or (shared and unstuck(self, *shared)):
                continue
            if not (taken or self.zeroed or self.doubts or set(self.usual) - zeros) and take_zeros(self):
                self.zeroed = True
                continue
            alone = not taken and take_alone(self)
            if light and not (taken or alone or self.named):
                weigh(self, free)
                continue
            pair = () if taken or self.named or self.usual else two_at_once(self, trials, runs)
            alone = alone or (not (taken or pair) and take_wave(self))
            new = taken or (pair[0] if pair else None)
            self.refused = 0.0 if new or alone else max((t.score for t in trials), default=0.0)
            self.rounds.append((last, new[1].cause if new else self.named[-1].cause if alone else None))
            if own:
                take_course(self, *own)
            elif shared or pair:
                for after, finding in pair or (shared,):
                    self.accept(after, finding)
            elif not alone:
                return

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
        shared = self.first_believed(trials, runs) if asked else None
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

    def first_believed(self, trials: list[Trial], runs: list[Run]) -> tuple[Fit, Named] | None:
        """The best trial that held-out data support. What is small beside the largest effect so far in a channel may be its imperfect
        form, and is not named. Where the best is what good hardware has anyway, a lesser one is not looked for."""
        for trial in (form for t in trials for form in t.forms if form.score > 0.0):
            effects = instances(trial.fit.model, *trial.key)
            gain, little = self._gain_of(trial, trials[0].score), all(map(negligible, effects))
            usual = stage_is_off(effects, gain) if little else converter_does(trial.key[0], gain, self.train)
            if usual:
                self.usual[trial.key] = usual
            if usual or little:
                return None
            rivals = [t for t in trials if t.key != trial.key and self._rivals(t, trial, gain)]
            shared = tuple(Rival(*t.key, trial.score - t.score, t.fit.model) for t in rivals)
            alternatives = shared + own_rivals(runs, trial.score, {t.key for t in (trial, *rivals)})
            for same in (trial, *(t for t in rivals if t.key == OFFSET)):  # what swallows a force is told from neither
                alternatives += same_by_nature(same, trials, {trial.key, *(a.key for a in alternatives)}, self.train)
            finding = Named(*trial.key, gain, trial.score, alternatives, self.present.model, trial.fit.model)
            told = trial.score > self.least(trial.fit.count) * gain.breadth and sized(trial)  # what it was fitted to must gain by it, too
            told = told and (trial in trials or gain.lower > SURELY * gain.relative)
            much = not self.shadows(gain) and trial.score > self.form_of_others(*trial.key)
            if much and self._in_doubt(trial, trials[0], gain):
                self.doubts[trial.key] = too_short(trial.key, trial.fit.model, self.encoder_step) or unproven()
            believed = told and gain.passed and gain.shows_at(trial.key[1]) and self._shorter(trial.fit)
            if believed and not much and trial.score > reach(trials[0].score):
                self.doubts[trial.key] = shadowed(gain, self.named)
            if not (believed and much):
                continue
            encoder = encoder_does(trial.key, gain, self.present.model, trial.fit.model, self.train, self.encoder_step)
            unread = self._unread([t for t in rivals if t.score > trial.score - CHANCE])
            if encoder is None and not unread:
                return trial.fit, finding
            self.usual |= {trial.key: encoder} if encoder else unread
        return None

    def _unread(self, as_good: list[Trial]) -> dict[tuple[str, str], Seen]:
        """Those of trials that explain `as_good` as the best which are zeros of depth that the encoder does not read, and so leaves."""
        seen = {t.key: too_short(t.key, t.fit.model, self.encoder_step) for t in as_good if t.key[0] == SHIFT}
        return {key: s for key, s in seen.items() if s is not None}

    def _in_doubt(self, trial: Trial, best: Trial, gain: Gain) -> bool:
        """Whether a trial as good as the best explains very much of training, and held-out sessions speak neither for nor against it."""
        able = trial.score > max(reach(best.score), DOUBTLESS * self.least(trial.fit.count) * gain.breadth) and sized(trial)
        several = bool(self.held) or len(self.train) > 1
        return bool(able and several and not gain.passed and not gain.spoilt and gain.relative > 0.0 and self._shorter(trial.fit))

    def _gain_of(self, trial: Trial, best: float) -> Gain:
        """What a trial gains; of one as good as the `best` that explains very much of training a second opinion is asked."""
        models = self.present.model, trial.fit.model, trial.key[1]
        gain = self.gain(*models)
        if gain.spoilt and gain.lower > MUCH:
            gain = at_any_scale(*models[:2], self.train, [] if self.deaf(*models) else self.held, self.noise)
        if gain.passed or self.doubting or trial.score <= max(reach(best), DOUBTLESS * self.least(trial.fit.count)):
            return gain
        return self.second_opinion(*models, gain)

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

    def _shorter(self, after: Fit) -> bool:
        """Whether the record is described in fewer words with a cause than with noise that is merely more coloured."""
        before, behind = (description_length(f, self.train, self.noise.growth) for f in (self.present, after))
        return before - behind > SHORTER

    def resolved(self, key: tuple[str, str], gain: Gain, after: Model) -> bool:
        """Whether a gain is more than what steps of encoder and converters leave open. What else is believed, and is not, is said."""
        seen = steps_do(key[0], gain, self.present.model, after, self.train, self.encoder_step)
        self.usual |= {key: seen} if seen else {}
        return seen is None

    def _rivals(self, other: Trial, best: Trial, gain: Gain) -> bool:
        """Whether `other` cannot be told from `best`: it explains as much of what was fitted, or nearly, and of what was held out. Of the
        same cause at two places one instance each is compared, where one explains most: a second mends its form, wherever it is."""
        one = best.forms[-1].score
        if other.key[0] == best.key[0] and one > (1.0 - WIDE) * best.score and other.forms[-1].score > reach(one):
            return True
        if other.score > reach(best.score):
            return True
        if other.score <= (1.0 - WIDE) * best.score:
            return False
        return self.gain(self.present.model, other.fit.model, other.key[1]).relative >= NEARLY * gain.relative

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
