"""Play of the drive that its encoder is too coarse to read: every screw has a few micrometres of it.

It is no finding, for rounding alone looks like as much. But left out of the model it would be explained by whatever looks like it: damping,
a loop, relaxation. So where it is the best account of all, it is searched beside like a finding, grows and shrinks with every fit, and is
taken out of the findings at the end. It stays in the model where something was found beside it.
"""

from dataclasses import replace

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.search.hardware import no_other_does, too_short
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.vocabulary import PLAY


def is_unread_play(search: Search, trial: Trial) -> bool:
    """Whether a trial is play that the encoder is too coarse to read."""
    return trial.key == PLAY and too_short(PLAY, trial.fit.model, search.encoder_step) is not None


def leave_play_to_hardware(search: Search) -> None:
    """Take play that was searched beside out of the findings; it is one after all where the encoder can read what it has come to."""
    finding = next((n for n in search.named if n.unread), None)
    if finding is None:
        return
    why = too_short(PLAY, search.present.model, search.encoder_step)
    if why is None:
        search.named = [replace(n, unread=False) if n is finding else n for n in search.named]
        return
    search.named = [n for n in search.named if n is not finding]
    if search.named:
        why = replace(why, because=f"{why.because}; the extended model holds it, beside what was found")
    else:
        search.present = fit(search.present.model.lacking(PLAY), search.train, search.noise)
    search.tared |= {PLAY: why} | {a.key: no_other_does(PLAY, why) for a in finding.alternatives}
