"""What once led the search astray: a skin of another day, a size that only its shape tells, a model that was lost on the way."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from gate_records import PLAIN, QUICK, WHITE, recorded
from rows import rows
from world import make_sessions, write_case

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.search.growing import determined, spared
from skin_ident.criticism.search.partly import _too_slight_to_tell
from skin_ident.criticism.search.trial import Trial, sized
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.load import load
from skin_models.effects.cyclic_softening import CyclicSoftening
from skin_models.effects.eyring_relaxation import EyringRelaxation
from skin_models.effects.nonlinear_stiffness import PowerStiffness
from skin_models.effects.stress_relaxation import StressRelaxation

# Sound records of poor protocols, of which zeros of depth, a mount, a play and a late clock were told: seed, protocol, taxels, noise and
# steps of the encoder in µm, and how far the skin is another from session to session.
SOUND = {
    "another skin in a session held out": (51815985, "single_rate_triangles", 3, 0.0, 1.0, 0.01),
    "another skin in every session": (1285114280, "single_rate_triangles", 1, 0.0, 1.0, 0.01),
    "a mass that was weighed in noise of the encoder": (1811815050, "single_sine", 3, 4.0, 1.0, 0.01),
    "noise of the encoder that a play makes up for": (1757556677, "holds_only", 2, 1.5, 1.0, 0.0),
    "steps of the encoder that a delay makes up for": (1714707236, "single_sine", 1, 0.0, 20.0, 0.0),
}


@pytest.mark.parametrize("name", rows(list(SOUND)[::-1], 2))
def test_poor_records_are_sound(tmp_path, name):
    seed, protocol, taxels, encoder, step, between = SOUND[name]
    setting = {"encoder_step_um": step, "encoder_noise_um": encoder, "between": between}
    write_case(make_sessions([], seed=seed, protocol=protocol, n_taxels=taxels, **setting)[0], tmp_path)
    recordings = load(tmp_path)
    assert diagnose(recordings[:2], recordings[2:]).findings["findings"] == []


@pytest.mark.parametrize("seed", rows([9302, 9101], 1))
def test_an_amplifier_that_averages_lags_and_its_mount_does_not_give(tmp_path, seed):
    """The mean of ten readings is no filter of two poles, whose rest had passed for a mount."""

    def averaged(force):
        return np.convolve(np.concatenate([np.full(9, force[0]), force]), np.full(10, 0.1), "valid")

    sessions, _ = make_sessions([], n_taxels=1 + seed % 2, seed=seed)
    write_case([replace(s, force=averaged(s.force)) for s in sessions], tmp_path)
    recordings = load(tmp_path)
    (found,) = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert (found["cause"], found["where"]) == ("lag", "load_cell") and found["evidence"]["forms"] == ["AveragedLag"]


def test_held_out_data_speak_against_a_cause_only_where_no_error_falls():
    """Neither the likelihood nor the plain error falls beyond doubt: of one that does the other may be another day's skin."""
    worse = replace(QUICK, relative=-0.02)
    assert not worse.is_against and not worse.passed and not QUICK.is_against
    assert replace(worse, ci95=(-0.001, 0.002)).is_against and replace(worse, after=0.0199).is_against


def test_a_cause_whose_size_and_shape_are_only_known_as_a_product_is_of_a_size():
    """Softening over a length of several times the depth grows as depth does: either number may be anything, their ratio may not."""
    softens = replace(PLAIN, effects=(CyclicSoftening("skin", softening=0.1, length=2e-3),))
    sessions = [prepare(recorded(softens, 0.8e-3 * (1.0 - np.exp(-np.arange(4000) / 1500)) * np.sin(np.arange(4000) / 40.0) ** 2))]
    after = fit(softens, sessions, WHITE)
    assert not determined(after) and determined(after, after.std_in_shape)
    assert sized(Trial(SimpleNamespace(cause="cyclic_softening", where="skin"), after, 1e3))


@pytest.mark.parametrize(("of_force", "slight"), [(0.003, True), (0.05, False)])
def test_a_hundredth_of_the_force_in_one_session_is_another_days_skin(of_force, slight):
    bent = replace(PLAIN, effects=(PowerStiffness("skin", force_sensed=of_force * 4.5, force_dispersed=of_force * 1.5, exponent=1.5),))
    key = ("nonlinear_stiffness", "skin")
    sessions = [prepare(recorded(PLAIN, seed=i)) for i in range(3)]
    sessions = [replace(s, lacks=frozenset() if i == 1 else frozenset({key})) for i, s in enumerate(sessions)]
    trial = SimpleNamespace(key=key, fit=SimpleNamespace(model=bent))
    assert _too_slight_to_tell(SimpleNamespace(trial=trial, ahead=SimpleNamespace(train=sessions))) == slight
    assert _too_slight_to_tell(SimpleNamespace(trial=trial, ahead=SimpleNamespace(train=[*sessions, sessions[0]]))) == slight


@pytest.mark.parametrize("arms", [1, 2])
def test_an_instance_that_others_have_taken_over_is_taken_out(arms):
    """An Eyring element that was named first explains nothing beside the Maxwell arms that the skin has; each of the arms does."""
    maxwell = tuple(StressRelaxation("skin", k_sensed=300.0, k_dispersed=100.0, tau=tau) for tau in (0.3, 3.0)[:arms])
    depth = 0.2e-3 * (1.0 + np.tanh(4.0 * np.sin(np.arange(4000) / 200.0)))
    sessions = [prepare(recorded(replace(PLAIN, effects=maxwell), depth, seed=i)) for i in range(2)]
    first, key = EyringRelaxation("skin", k_sensed=1.0, k_dispersed=1.0, stretch=1e-4, flow_time=10.0), ("stress_relaxation", "skin")
    fitted = fit(replace(PLAIN, effects=(first, *maxwell)), sessions, WHITE)
    kept = spared(fitted, key, sessions, WHITE).model.having(key)
    assert [type(e) for e in kept] == [StressRelaxation] * arms
    assert [e.tau for e in kept] == pytest.approx([e.tau for e in maxwell], rel=0.15)
