"""Which of the trials is believed: one that explains enough, predicts held-out data, shortens the description, and is not due to
hardware.
"""

from collections.abc import Iterator
from dataclasses import replace

from skin_ident.criticism.baseline.fitting import Fit, fit
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.blurred import blurred
from skin_ident.criticism.gates.description import shorter_by
from skin_ident.criticism.gates.gate import MUCH_FALL, Gain
from skin_ident.criticism.gates.second_opinion import at_any_scale, beside_own_skin, may_be_another_skin
from skin_ident.criticism.search.by_nature import same_by_nature
from skin_ident.criticism.search.doubt import mending, shadowed, unproven
from skin_ident.criticism.search.hardware import (
    converter_does,
    encoder_does,
    forms_of_hardware,
    hardware_is_off,
    negligible,
    no_other_does,
    too_short,
)
from skin_ident.criticism.search.named import Named, NotNamed
from skin_ident.criticism.search.rivals import CHANCE_SCORE, Rival, own_rivals, reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.trial import Trial, sized
from skin_ident.criticism.search.unread_play import is_unread_play
from skin_ident.criticism.vocabulary import POSITION_OFFSET, ZERO_OF_DEPTH, Key
from skin_models.effect import Effect
from skin_models.model import Model

SURELY = 0.25  # share of the fall of the mean square that its lower bound must exceed for a plainer form, which is a second chance
SHORTER = 15.0  # twice nats by which a cause must shorten the description: some hundreds of causes were compared
DOUBTLESS = 2.0  # times the least gain worth naming, which the best trial must explain for a second opinion, or to be in doubt
ALL = 0.9  # share of what the richest set of directions explains, which a cause must explain that is small beside others
LEFT = 0.02  # share of what a named cause explains at the same place, which its imperfect form may leave for one other cause to explain
FAINT = 0.012  # share of the fall in squares by others that it must exceed as well to be named: more than a ninth of their size
FAR_LESS = 0.6  # share of the score of a trial that held-out data nearly support; one with less is not believed in its place
SMALL, OF_ITS_OWN = 0.3, 0.1  # a trial below SMALL of what a named cause explains must explain OF_ITS_OWN that more of the named would not
KIN = 0.1  # share of what the same cause explains at another place, in the same channel, which its imperfect form may leave for a trial
WIDE, NEARLY = 0.2, 0.95  # a rival, too, explains all but WIDE, where its held-out gain is at least NEARLY that of the best


def first_believed(search: Search, trials: list[Trial], runs: list[Run]) -> tuple[Fit, Named] | None:
    """The best trial that held-out data support, with its fit, as a finding with its rivals; None where there is none. Why a good trial is
    not named, hardware or doubt, is noted in the search. These are not named:

    - a trial that is small beside the largest effect so far in its channel, for it may be that effect's imperfect form, unless it is more
      of a named cause or explains nearly all that anything explains;
    - a trial that more of the named causes would explain;
    - any lesser trial, where the best is what good hardware has anyway, or is a cause that the record itself shows and held-out data
      support, only too small to be named here;
    - a trial that explains less than one which an encoder may account for, unless it is believed beside that one. Where a force drives the
      test this is not asked, for its load cell is a rival of every name in any case;
    - a trial that explains far less than another that held-out data nearly support, or did support before it was taken out again.
    """
    nearly, left_open, in_its_place, known = _of_dropped(search), None, None, {n.key for n in search.named if not n.courses}
    for trial in _forms(trials):
        gain = _gain_of(search, trial, trials[0].score)
        if _is_hardware(search, trial, gain):
            _note_the_like(search, trial, trials)
            return None
        itself = trial.key in known or (not search.shadows(gain) and trial.score > search.form_of_others(*trial.key))
        itself = itself or _explains_all(search, trial)
        if itself and _in_doubt(search, trial, trials[0], gain):
            search.doubts[trial.key] = too_short(trial.key, trial.fit.model, search.encoder_step) or unproven()
        if not _is_believed(search, trial, gain, second_chance=trial not in trials and trial is not in_its_place):
            if trial is trials[0] and trial.key in search.suspected and gain.passed:
                return None
            nearly = max(nearly, trial.score * (gain.lower > 0.0 and sized(trial)))
            continue
        shadow = not itself or (trial.key not in known and gain.squares < FAINT * search.fallen(gain.channel))
        if shadow or _mends_a_form(search, trial, gain):
            if trial.score > reach(trials[0].score):
                search.doubts[trial.key] = (shadowed if shadow else mending)(gain, search.named)
            continue
        rivals = [t for t in trials if t.key != trial.key and _is_rival(search, t, trial, gain)]
        hardware = _hardware_does(search, trial, rivals, gain)
        if hardware and trial.plainer:  # of two numbers each may be small, where the one that does for both is not
            in_its_place = trial.plainer
        elif hardware:
            search.hardware |= hardware
            _note_the_like(search, trial, trials)
            if trial is trials[0] and is_unread_play(search, trial):
                return trial.fit, replace(_finding(search, trial, rivals, trials, runs, gain), unread=True)
            left_open = left_open or (trial if search.train[0].drive is None else None)
        elif trial.score > FAR_LESS * nearly and (left_open is None or _stands_beside(search, trial, left_open)):
            return trial.fit, _finding(search, trial, rivals, trials, runs, gain)
    return None


def _of_dropped(search: Search) -> float:
    """The most that a cause explains which was named and taken out again; 0 where there is none."""
    return max((r.score for r in search.survey().ranked if r.key in search.dropped), default=0.0)


def _stands_beside(search: Search, trial: Trial, other: Trial) -> bool:
    """Whether a trial explains as much as an `other`, or is believed beside it."""
    if trial.score > reach(other.score):
        return True
    model = other.fit.model.lacking(trial.key)  # a finer form takes the place of the plain one
    both = fit(replace(model, effects=(*model.effects, *trial.fit.model.having(trial.key))), search.train, search.noise)
    gain = search.gain(model, both.model, trial.key[1])
    return gain.passed and gain.shows_at(trial.key[1]) and both.score_over(other.fit) > search.least(both.count) * gain.breadth


def believed_in_part(search: Search, trial: Trial, gain: Gain) -> bool:
    """Whether a trial of a cause that some sessions lack passes the same tests as a shared cause."""
    if search.shadows(gain) or trial.score <= search.form_of_others(*trial.key) or _mends_a_history(search, trial):
        return False
    if _is_hardware(search, trial, gain) or not _is_believed(search, trial, gain, second_chance=False):
        return False
    return not _hardware_does(search, trial, [], gain)


def _explains_all(search: Search, trial: Trial) -> bool:
    """Whether a trial of one instance explains nearly all that anything explains of the residual. Then it is no leftover of another cause's
    imperfect form, since no single cause has the form of such a leftover, unless that cause explains far more at the same place. A trial
    that explains much more than small amounts of everything is no small effect: it leads the fit out of a false minimum."""
    if trial.plainer is not None:
        return False
    everything = search.survey().explained_by_everything
    return ALL * everything < trial.score < everything / ALL and trial.score > LEFT * _explained_at(search, trial.key[1])


def _explained_at(search: Search, where: str) -> float:
    """The most that a named cause explains at a place; 0 where none is named there."""
    return max((n.explained for n in search.named if n.where == where), default=0.0)


def _mends_a_form(search: Search, trial: Trial, gain: Gain) -> bool:
    """Whether a trial is small and explains little that more of the named causes would not. Soft play, fitted as hard play, leaves a
    loop; and a loop of the load cell, whose form is never exact, leaves a far smaller one that the skin's form may mend."""
    others = {n.key for n in search.named}
    if not others or trial.key in others:
        return False
    kin = [n.explained for n in search.named if n.cause == trial.key[0] and n.gain.channel == gain.channel]
    if trial.score < KIN * max(kin, default=0.0):
        return True
    small = trial.score < SMALL * max(n.explained for n in search.named)
    return small and search.survey().of_its_own(trial.key, others) < OF_ITS_OWN


def _mends_a_history(search: Search, trial: Trial) -> bool:
    """Whether what the skin of some sessions would have explains little beside what is named of the skin of all. Sessions differ in what
    was done to a skin before, and no form of softening or loop remembers quite as a skin does."""
    return trial.key[1] == "skin" and trial.score < SMALL * _explained_at(search, "skin")


def _forms(trials: list[Trial]) -> Iterator[Trial]:
    return (form for t in trials for form in t.forms if form.score > 0.0)


def _is_believed(search: Search, trial: Trial, gain: Gain, *, second_chance: bool) -> bool:
    """Whether a trial explains enough of training and of held-out data to be named."""
    told = trial.score > search.least(trial.fit.count) * gain.breadth and sized(trial)
    surely = not second_chance or gain.lower > SURELY * gain.relative
    return bool(told and surely and gain.passed and gain.shows_at(trial.key[1]) and _is_shorter(search, trial.fit))


def _in_doubt(search: Search, trial: Trial, best: Trial, gain: Gain) -> bool:
    """Whether a trial as good as the best explains very much of training, while held-out sessions speak neither for nor against it."""
    able = trial.score > max(reach(best.score), _doubtless(search, trial) * gain.breadth) and sized(trial)
    several = bool(search.held) or len(search.train) > 1
    return bool(able and several and not gain.passed and not gain.spoilt and not gain.is_against and _is_shorter(search, trial.fit))


def _doubtless(search: Search, trial: Trial) -> float:
    return DOUBTLESS * search.least(trial.fit.count)


def _is_shorter(search: Search, after: Fit) -> bool:
    """Whether the record's description is shorter with the cause than with noise that is merely more coloured."""
    return shorter_by(search.present, after, search.train, search.noise.growth) > SHORTER


def _gain_of(search: Search, trial: Trial, best: float) -> Gain:
    """Gain of a trial; a second opinion is asked for where it is as good as the `best` and explains very much of training."""
    models = search.present.model, trial.fit.model, trial.key[1]
    gain = search.gain(*models)
    gain = _unspoilt(search, models, gain) if gain.spoilt and gain.lower > 0.0 else gain
    if gain.passed or search.doubting or trial.score <= max(reach(best), _doubtless(search, trial)):
        return gain
    return search.second_opinion(*models, gain)


def _unspoilt(search: Search, models: tuple[Model, Model, str], gain: Gain) -> Gain:
    """The gain of a cause that is better beyond doubt and yet spoils a channel, with what lets it do so taken away: held-out sessions have
    a skin of their own or, where it gains much, any scale."""
    held = [] if search.deaf(*models) else search.held
    data = *models[:2], search.train, held, search.noise
    if may_be_another_skin(models[0], held or search.train) and (own := beside_own_skin(*data)).passed:
        return own
    return at_any_scale(*data) if gain.lower > MUCH_FALL else gain


def _is_hardware(search: Search, trial: Trial, gain: Gain) -> bool:
    """Whether a trial is so small that a good stage or converter does as much by itself; if it gains all the same, the reason is noted."""
    little = _is_little(trial)
    after = trial.fit.model
    why = hardware_is_off(after.having(trial.key), gain) if little else converter_does(search.claim(trial.key, gain, after))
    if why:
        search.hardware[trial.key] = why
    return bool(why) or little


def _is_little(trial: Trial) -> bool:
    """Whether every instance of a trial's cause is within what good hardware has anyway."""
    return all(map(negligible, trial.fit.model.having(trial.key)))


def _of_usual_size(search: Search, trial: Trial, least: float) -> list[Effect]:
    """The effects of a trial's cause, in any of its forms, where they are within what good hardware has and explain at least `least`;
    else none. A finer form of a small delay has numbers that are not small."""
    if _is_little(trial):
        return trial.fit.model.having(trial.key)
    present = search.present.model
    if present.having(trial.key):
        return []
    for effect in forms_of_hardware(trial.fit.model.effects[-1]):
        plain = fit(present.extended(effect), search.train, search.noise)
        if negligible(plain.model.effects[-1]) and plain.score_over(search.present) > least:
            return plain.model.having(trial.key)
    return []


def _hardware_does(search: Search, trial: Trial, rivals: list[Trial], gain: Gain) -> dict[Key, NotNamed]:
    """What hardware may do in place of a trial, by cause and place: the encoder the trial itself; or, among all that explains as much, a
    zero of depth too small for the encoder to read, or a cause that is no larger than good hardware has it."""
    encoder = encoder_does(search.claim(trial.key, gain, trial.fit.model), search.noise, search.encoder_step)
    if encoder:
        return {trial.key: encoder}
    least = reach(trial.score)
    as_good = [t for t in rivals if t.score > trial.score - CHANCE_SCORE and t.key[0] == POSITION_OFFSET]
    unread = {t.key: too_short(t.key, t.fit.model, search.encoder_step) for t in as_good}
    usual = {t.key: hardware_is_off(_of_usual_size(search, t, least), gain) for t in (trial, *rivals) if t.score > least}
    return {key: why for key, why in (unread | usual).items() if why is not None}


def _note_the_like(search: Search, trial: Trial, trials: list[Trial]) -> None:
    """Where a trial is left to hardware, note the same for those that explain as much or are the same signal by nature."""
    why = search.hardware.get(trial.key)
    if why is None:
        return
    as_good = [t.key for t in trials if t.score > reach(trial.score) and trial.score > reach(t.score)]
    same = [r.key for r in same_by_nature(trial, trials, {trial.key, *as_good}, search.train)]
    search.hardware |= {key: no_other_does(trial.key, why) for key in (*as_good, *same) if key not in search.hardware}


def _is_rival(search: Search, other: Trial, best: Trial, gain: Gain) -> bool:
    """Whether `other` cannot be told from `best`. It cannot where it explains as much of training, or would without the encoder's noise, or
    nearly as much with nearly the same held-out gain. Where both are the same cause at two places, and one instance explains most, their
    first instances are compared: a second instance mends the form, wherever it is."""
    one = best.forms[-1].score
    if other.key[0] == best.key[0] and one > (1.0 - WIDE) * best.score and other.forms[-1].score > reach(one):
        return True
    if other.score > reach(best.score):
        return True
    if other.score <= (1.0 - WIDE) * best.score:
        return False
    unread, unread_of_best = (blurred(t.fit.model, search.train, search.noise) for t in (other, best))
    if other.score + unread - unread_of_best > reach(best.score):
        return True
    return search.gain(search.present.model, other.fit.model, other.key[1]).relative >= NEARLY * gain.relative


def _finding(search: Search, trial: Trial, rivals: list[Trial], trials: list[Trial], runs: list[Run], gain: Gain) -> Named:
    """A trial as a finding, with all other names that it may have."""
    alternatives = tuple(Rival(*t.key, trial.score - t.score, t.fit.model) for t in rivals)
    alternatives += own_rivals(runs, trial.score, {t.key for t in (trial, *rivals)})
    for same in (trial, *(t for t in rivals if t.key == ZERO_OF_DEPTH)):  # a dead zone cannot be told from a position offset either
        alternatives += same_by_nature(same, trials, {trial.key, *(a.key for a in alternatives)}, search.train)
    return Named(*trial.key, gain, trial.score, alternatives, search.present.model, trial.fit.model)
