"""What is named in held-out sessions alone goes where causes named after it leave nothing of it, and hides none of these."""

from dataclasses import replace

import numpy as np
import pytest
from world import make_sessions, write_case

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.courses.course import added
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.noise.whitening import white
from skin_ident.criticism.search.alone import drop_alone, take_alone
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.sessions.parting import without_parting
from skin_ident.criticism.sessions.session import prepare, with_reference
from skin_ident.recordings.load import load
from skin_models.effects.saturation import LeakySaturation


def searching(folder, jump: float, gain: float = 1.0) -> Search:
    """A search at its beginning. In the held-out session the load cell has another `gain`, and its zero jumps by `jump` (N) in the
    middle."""
    made, _ = make_sessions(None, seed=72, n_sessions=3, noise="white")
    late = made[2].t > np.median(made[2].t)
    write_case([*made[:2], replace(made[2], force=gain * made[2].force + jump * late)], folder)
    sessions = with_reference([prepare(r) for r in load(folder)])
    start = dispersion_start(sessions[:2], 0.0)
    sessions = [without_parting(s, start.dispersion) for s in sessions]
    search = Search(sessions[:2], sessions[2:], (), lambda stage: None)
    search.noise = white([residual(start, s) for s in sessions[:2]])
    search.present = fit(start, sessions[:2], search.noise)
    search.noise = white([residual(search.present.model, s) for s in sessions[:2]])
    search.present = fit(start, sessions[:2], search.noise)
    return search


def shared(gain: Gain) -> Named:
    return Named("backlash", "rig", gain, 100.0, ())


@pytest.fixture
def named(tmp_path) -> Search:
    """A search that has named a zero that jumps in the held-out session."""
    search = searching(tmp_path / "off", 0.2)
    assert take_alone(search) and [n.key for n in search.named] == [("force_offset", "load_cell")]
    return search


def test_it_stays_where_other_causes_do_not_explain_it(named):
    assert not drop_alone(named), "nothing was named after it"
    named.named.append(shared(named.named[0].gain))
    assert not drop_alone(named) and len(named.named) == 2


def test_it_goes_where_nothing_is_left_of_it(named, tmp_path):
    """The same course, in a search whose sessions have nothing of it without that course."""
    sound = searching(tmp_path / "sound", 0.0)
    without = sound.held
    sound.held, sound.runs, sound.alone = added(sound.held, named.alone.values), named.runs, named.alone
    sound.named = [*named.named, shared(named.named[0].gain)]
    assert drop_alone(sound) and [n.cause for n in sound.named] == ["backlash"] and sound.runs == [] and sound.alone is None
    left, back = (residual(sound.present.model, s[0]) for s in (without, sound.held))
    assert left == pytest.approx(back)


def test_it_hides_no_cause_that_training_shows(named):
    channel = named.named[0].gain.channel
    assert named.fallen(channel) == 0.0
    named.named.append(shared(named.named[0].gain))
    assert named.fallen(channel) > 0.0


@pytest.mark.parametrize("supported", [True, False])
def test_it_is_left_to_a_cause_that_training_supports_and_that_explains_as_much_of_it(tmp_path, supported):
    """A gain of 0.95 in the held-out session alone; a clipped load cell that leaks, as training may show it, explains as much."""
    search = searching(tmp_path, 0.0, gain=0.95)
    clipped = fit(search.present.model.extended(LeakySaturation("load_cell", level=0.3, lost=0.01)), search.train, search.noise, 0)
    explained = 10.0 * search.least(search.present.count) if supported else 0.0
    search.grown = {("saturation", "load_cell"): replace(clipped, cost=search.present.cost - explained)}
    assert take_alone(search) == (not supported)
    assert [n.key for n in search.named] == [("gain_error", "load_cell")] * (not supported)
    assert [*search.doubts] == [("saturation", "load_cell")] * supported
