"""A signal that wanders smoothly through every session. It is tested where no other cause is believed, because the noise model takes it for
noise.
"""

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.courses.course import added
from skin_ident.criticism.courses.gate import believed
from skin_ident.criticism.courses.waves import find_wave, run_of
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.rivals import Rival
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import ZERO_OF_DEPTH


def take_wave(search: Search) -> bool:
    """Name one wave and give every session its own; return whether there was one. `search` is the state of `criticise`. A wave that is
    small beside what a named cause explains in its channel is what that cause's imperfect form leaves."""
    model = search.present.model
    found = find_wave(model, search.train, search.held, search.noise)
    if found is None or any(r.course == found[0].course for r in search.runs):
        return False
    wave, gain = found
    after = fit(model, added(search.train, wave.values), search.noise)
    shows = believed(gain, wave.course) and wave.course.shows(gain)
    if not shows or search.shadows(gain) or search.steps_do(wave.course.key, gain, after.model):
        return False
    run = run_of(wave, model, [*search.train, *search.held], search.present.cost - after.cost)
    search.runs.append(run)
    search.train, search.held = added(search.train, run.values), added(search.held, run.values)
    search.present = fit(after.model, search.train, search.noise)
    search.named.append(Named(*wave.course.key, gain, run.score, _also(search.train[0]), courses=run.said))
    search.progress(f"named {wave.course.cause} in the {wave.course.where}, as a wave")
    return True


def _also(session: Session) -> tuple[Rival, ...]:
    """What the same wave in the only channel may be, where depth drives it: a wave of the zero of depth (see `driving` for a load
    cell's)."""
    return (Rival(*ZERO_OF_DEPTH, 0.0),) if len(session.channels) == 1 and session.drive is None else ()
