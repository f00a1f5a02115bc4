"""Which of the trials is believed: it explains enough, predicts what was held out, shortens the description, and no hardware does it."""

from collections.abc import Iterator
from dataclasses import replace

from skin_ident.criticism.baseline.fitting import Fit, fit
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.blurred import blurred
from skin_ident.criticism.gates.description import shorter_by
from skin_ident.criticism.gates.gate import MUCH, Gain
from skin_ident.criticism.gates.second_opinion import at_any_scale
from skin_ident.criticism.search.by_nature import same_by_nature
from skin_ident.criticism.search.doubt import mending, shadowed, unproven
from skin_ident.criticism.search.growing import instances, negligible
from skin_ident.criticism.search.hardware import converter_does, encoder_does, no_other_does, stage_is_off, too_short
from skin_ident.criticism.search.named import Named, NotNamed
from skin_ident.criticism.search.rivals import CHANCE, Rival, own_rivals, reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.tared import SHIFT
from skin_ident.criticism.search.trial import Trial, sized
from skin_ident.criticism.vocabulary import OFFSET, Key

SURELY = 0.25  # of the fall of the mean square, above which its lower bound must be for a plainer form: that is a second chance
SHORTER = 15.0  # twice nats by which a cause must shorten the description: some hundreds of them were asked
DOUBTLESS = 2.0  # times what makes a cause worth naming, which the best one must explain if held-out sessions leave it in doubt
ALL = 0.9  # of what the richest set of directions explains, which a cause must that is small beside others
FAINT = 0.012  # of what the others have explained in squares, which it must besides to be named: more than its ninth in size
FAR_LESS = 0.6  # of what another explains, in whose place no cause is believed where held-out data nearly bear that out
SMALL, OF_ITS_OWN = 0.3, 0.1  # of what was named first explains, below which a cause must explain so much that no more of that does
WIDE, NEARLY = 0.2, 0.95  # a rival, too, explains all but this share, where it predicts held-out data as well but for so little


def first_believed(search: Search, trials: list[Trial], runs: list[Run]) -> tuple[Fit, Named] | None:
    """The best trial that held-out data support, as a finding with its rivals. What is small beside the largest effect so far in a channel
    may be its imperfect form, and is not named, unless it is more of a cause that is; nor is what more of those would explain. Where the
    best is what good hardware has anyway, or the record itself shows one that held-out data bear out and that is only too small to be named
    here, a lesser one is not looked for; nor is one believed that explains less than what an encoder leaves open, unless it stands beside
    that, or far less than another that held-out data nearly bear out; where force drives instead of depth, its load cell is a rival of
    every name in any case. Why a good one is none, hardware or doubt, is noted in the search."""
    nearly, left_open, known = 0.0, None, {n.key for n in search.named if not n.courses}
    for trial in _forms(trials):
        gain = _gain_of(search, trial, trials[0].score)
        if _is_hardware(search, trial, gain):
            _note_the_like(search, trial, trials)
            return None
        itself = trial.key in known or (not search.shadows(gain) and trial.score > search.form_of_others(*trial.key))
        itself = itself or _explains_all(search, trial)
        if itself and _in_doubt(search, trial, trials[0], gain):
            search.doubts[trial.key] = too_short(trial.key, trial.fit.model, search.encoder_step) or unproven()
        if not _is_believed(search, trial, gain, second_chance=trial not in trials):
            if trial is trials[0] and trial.key in search.suspected and gain.passed:
                return None
            nearly = max(nearly, trial.score * (gain.lower > 0.0 and sized(trial)))
            continue
        shadow = not itself or (trial.key not in known and gain.squares < FAINT * search.fallen(gain.channel))
        if shadow or _mends_a_form(search, trial):
            if trial.score > reach(trials[0].score):
                search.doubts[trial.key] = (shadowed if shadow else mending)(gain, search.named)
            continue
        rivals = [t for t in trials if t.key != trial.key and _is_rival(search, t, trial, gain)]
        hardware = _hardware_does(search, trial, rivals, gain)
        if hardware:
            search.hardware |= hardware
            _note_the_like(search, trial, trials)
            left_open = left_open or (trial if search.train[0].drive is None else None)
        elif trial.score > FAR_LESS * nearly and (left_open is None or _stands_beside(search, trial, left_open)):
            return trial.fit, _finding(search, trial, rivals, trials, runs, gain)
    return None


def _stands_beside(search: Search, trial: Trial, other: Trial) -> bool:
    """Whether a trial explains as much as an `other`, or is believed beside it."""
    if trial.score > reach(other.score):
        return True
    own = trial.fit.model.effects[len(search.present.model.effects) :]
    model = other.fit.model
    both = fit(replace(model, effects=(*model.effects, *own)), search.train, search.noise)
    gain = search.gain(model, both.model, trial.key[1])
    return gain.passed and gain.shows_at(trial.key[1]) and both.gain_over(other.fit) > search.least(both.count) * gain.breadth


def believed_in_part(search: Search, trial: Trial, gain: Gain) -> bool:
    """Whether a trial that some sessions lack is believed as one that all share would be."""
    if search.shadows(gain) or trial.score <= search.form_of_others(*trial.key) or _mends_a_history(search, trial):
        return False
    if _is_hardware(search, trial, gain) or not _is_believed(search, trial, gain, second_chance=False):
        return False
    return not _hardware_does(search, trial, [], gain)


def _explains_all(search: Search, trial: Trial) -> bool:
    """Whether a trial of one instance explains nearly all that anything explains of what is left: what an imperfect form of another cause
    leaves, no other cause has the form of. One that explains much more than small amounts of everything is no small effect: it leads the
    fit out of a false minimum."""
    if trial.plainer is not None:
        return False
    everything = search.survey().explained_by_everything
    return ALL * everything < trial.score < everything / ALL


def _mends_a_form(search: Search, trial: Trial) -> bool:
    """Whether a small trial explains little that more of what was named would not: soft play, fitted as hard, leaves a loop."""
    others = {n.key for n in search.named}
    small = trial.score < SMALL * max((n.explained for n in search.named), default=0.0)
    return bool(others) and small and trial.key not in others and search.survey().of_its_own(trial.key, others) < OF_ITS_OWN


def _mends_a_history(search: Search, trial: Trial) -> bool:
    """Whether what the skin of some sessions would have explains little beside what is named of all skin: sessions differ in what was done
    to a skin before, and no form of a softening or a loop remembers quite as a skin does."""
    of_skin = max((n.explained for n in search.named if n.where == "skin"), default=0.0)
    return trial.key[1] == "skin" and trial.score < SMALL * of_skin


def _forms(trials: list[Trial]) -> Iterator[Trial]:
    return (form for t in trials for form in t.forms if form.score > 0.0)


def _is_believed(search: Search, trial: Trial, gain: Gain, *, second_chance: bool) -> bool:
    """Whether a trial explains enough of what it was fitted to, and of what was held out, to be named."""
    told = trial.score > search.least(trial.fit.count) * gain.breadth and sized(trial)
    surely = not second_chance or gain.lower > SURELY * gain.relative
    return bool(told and surely and gain.passed and gain.shows_at(trial.key[1]) and _is_shorter(search, trial.fit))


def _in_doubt(search: Search, trial: Trial, best: Trial, gain: Gain) -> bool:
    """Whether a trial as good as the best explains very much of training, and held-out sessions speak neither for nor against it."""
    able = trial.score > max(reach(best.score), _doubtless(search, trial) * gain.breadth) and sized(trial)
    several = bool(search.held) or len(search.train) > 1
    return bool(able and several and not gain.passed and not gain.spoilt and not gain.is_against and _is_shorter(search, trial.fit))


def _doubtless(search: Search, trial: Trial) -> float:
    return DOUBTLESS * search.least(trial.fit.count)


def _is_shorter(search: Search, after: Fit) -> bool:
    """Whether the record is described in fewer words with a cause than with noise that is merely more coloured."""
    return shorter_by(search.present, after, search.train, search.noise.growth) > SHORTER


def _gain_of(search: Search, trial: Trial, best: float) -> Gain:
    """What a trial gains; of one as good as the `best` that explains very much of training a second opinion is asked."""
    models = search.present.model, trial.fit.model, trial.key[1]
    gain = search.gain(*models)
    if gain.spoilt and gain.lower > MUCH:
        gain = at_any_scale(*models[:2], search.train, [] if search.deaf(*models) else search.held, search.noise)
    if gain.passed or search.doubting or trial.score <= max(reach(best), _doubtless(search, trial)):
        return gain
    return search.second_opinion(*models, gain)


def _is_hardware(search: Search, trial: Trial, gain: Gain) -> bool:
    """Whether a trial is so little as a good stage or converter does; what is seen of it is noted."""
    effects = instances(trial.fit.model, *trial.key)
    little = all(map(negligible, effects))
    why = stage_is_off(effects, gain) if little else converter_does(search.claim(trial.key, gain, trial.fit.model))
    if why:
        search.hardware[trial.key] = why
    return bool(why) or little


def _hardware_does(search: Search, trial: Trial, rivals: list[Trial], gain: Gain) -> dict[Key, NotNamed]:
    """What the steps of an encoder do in place of a trial: all of it, or of those that explain as much a zero of depth that they hide."""
    encoder = encoder_does(search.claim(trial.key, gain, trial.fit.model), search.noise, search.encoder_step)
    if encoder:
        return {trial.key: encoder}
    as_good = [t for t in rivals if t.score > trial.score - CHANCE and t.key[0] == SHIFT]
    unread = {t.key: too_short(t.key, t.fit.model, search.encoder_step) for t in as_good}
    return {key: why for key, why in unread.items() if why is not None}


def _note_the_like(search: Search, trial: Trial, trials: list[Trial]) -> None:
    """Note of what explains as much as a trial that is left to hardware, or is the same by nature, that it is, too."""
    why = search.hardware.get(trial.key)
    if why is None:
        return
    as_good = [t.key for t in trials if t.score > reach(trial.score) and trial.score > reach(t.score)]
    same = [r.key for r in same_by_nature(trial, trials, {trial.key, *as_good}, search.train)]
    search.hardware |= {key: no_other_does(trial.key, why) for key in (*as_good, *same) if key not in search.hardware}


def _is_rival(search: Search, other: Trial, best: Trial, gain: Gain) -> bool:
    """Whether `other` cannot be told from `best`: it explains as much of what was fitted, or would but for the encoder's noise, or nearly,
    and of what was held out. Of the same cause at two places one instance each is compared, where one explains most: a second mends its
    form, wherever it is."""
    one = best.forms[-1].score
    if other.key[0] == best.key[0] and one > (1.0 - WIDE) * best.score and other.forms[-1].score > reach(one):
        return True
    if other.score > reach(best.score):
        return True
    if other.score <= (1.0 - WIDE) * best.score:
        return False
    unread, unread_of_best = (blurred(search.present.model, t.fit.model, search.train, search.noise) for t in (other, best))
    if other.score + unread - unread_of_best > reach(best.score):
        return True
    return search.gain(search.present.model, other.fit.model, other.key[1]).relative >= NEARLY * gain.relative


def _finding(search: Search, trial: Trial, rivals: list[Trial], trials: list[Trial], runs: list[Run], gain: Gain) -> Named:
    """A trial by its name, and by all others that it may have."""
    alternatives = tuple(Rival(*t.key, trial.score - t.score, t.fit.model) for t in rivals)
    alternatives += own_rivals(runs, trial.score, {t.key for t in (trial, *rivals)})
    for same in (trial, *(t for t in rivals if t.key == OFFSET)):  # what swallows a force is told from neither
        alternatives += same_by_nature(same, trials, {trial.key, *(a.key for a in alternatives)}, search.train)
    return Named(*trial.key, gain, trial.score, alternatives, search.present.model, trial.fit.model)
