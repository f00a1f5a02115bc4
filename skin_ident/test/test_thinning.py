"""Steps that a course was given before another was known are taken out once it is."""

from dataclasses import replace

import numpy as np
import pytest
from gate_records import PLAIN, T, recorded
from hide_and_seek import seek
from world.hidden import Hide

from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.courses.carriers import DEPTH as OF_DEPTH
from skin_ident.criticism.courses.carriers import SLOPE
from skin_ident.criticism.courses.course import fitted
from skin_ident.criticism.courses.ground import fitted_ground
from skin_ident.criticism.courses.kinds import STEPS, Course
from skin_ident.criticism.courses.thinning import thinned
from skin_ident.criticism.noise.whitening import fit_whitener
from skin_ident.criticism.sessions.session import Session, prepare
from skin_models.effects.gain_error import GainStep
from skin_models.effects.position_offset import PositionOffset

ZERO_OF_DEPTH, GAIN = Course(OF_DEPTH, STEPS, (0, 1), "rig"), Course(SLOPE, STEPS, (0,), "load_cell")
OFF, HALF_WAY = 12e-6, float(T[T.size // 2])


def sessions(gain: float) -> list[Session]:
    """Two sessions in which the surface is nearer than the encoder says, and the load cell reads more from half-way on."""
    spoilt = PLAIN.extended(PositionOffset("rig", offset=OFF)).extended(GainStep("load_cell", gain=gain, after=HALF_WAY))
    return [replace(prepare(recorded(spoilt, seed=seed)), name=str(seed)) for seed in (1, 2)]


@pytest.fixture(scope="module")
def noise():
    plain = [replace(prepare(recorded(PLAIN, seed=seed)), name=str(seed)) for seed in (1, 2)]
    return fit_whitener([residual(PLAIN, s) for s in plain], plain)


def given(course: Course, made: list[Session], noise, *moments: float):
    """The course with steps at these moments in every session, fitted as if it were alone."""
    return fitted(course, PLAIN, made, noise, at={s.name: np.array(moments) for s in made})


def test_a_zero_of_depth_gives_back_the_step_that_feigned_a_gain(noise):
    made, begin = sessions(0.01), float(T[0])
    runs = [given(ZERO_OF_DEPTH, made, noise, begin, HALF_WAY), given(GAIN, made, noise, HALF_WAY)]
    (zero, gain), charge = thinned(runs, fitted_ground(PLAIN, made, noise))
    assert charge > 0.0 and not gain.is_empty
    for s in made:
        assert zero.moments[s.name].tolist() == [begin] and zero.amplitudes[s.name] == pytest.approx(OFF, abs=2e-6)
        assert gain.amplitudes[s.name] == pytest.approx(0.01, abs=2e-3)
        assert zero.said[s.name].startswith("+1") and "," not in zero.said[s.name]


def test_what_another_course_explains_alone_has_no_steps_left(noise):
    made = sessions(0.0)
    runs = [given(ZERO_OF_DEPTH, made, noise, float(T[0])), given(GAIN, made, noise, HALF_WAY)]
    (zero, gain), _ = thinned(runs, fitted_ground(PLAIN, made, noise))
    assert gain.is_empty and not zero.is_empty


def test_where_nothing_is_nothing_is_left(noise):
    made = [replace(prepare(recorded(PLAIN, seed=seed)), name=str(seed)) for seed in (1, 2)]
    gain = given(GAIN, made, noise, HALF_WAY)
    again, charge = thinned([gain], fitted_ground(PLAIN, made, noise))
    assert gain.is_empty and again[0].is_empty and charge == 0.0


def test_steps_that_are_needed_stay(noise):
    made = sessions(0.01)
    both = [given(ZERO_OF_DEPTH, made, noise, float(T[0])), given(GAIN, made, noise, HALF_WAY)]
    again, charge = thinned(both, fitted_ground(PLAIN, made, noise))
    assert charge == 0.0 and [r.moments for r in again] == [r.moments for r in both]


@pytest.mark.slow
def test_a_gain_that_steps_leaves_a_zero_of_depth_its_one_number(tmp_path):
    both = [Hide("position_offset", "rig", None, 1.0), Hide("gain_error", "load_cell", None, 1.0)]
    found = seek(tmp_path, both, seed=426725150).findings["findings"]
    assert [(f["cause"], f["where"]) for f in found] == [("position_offset", "rig"), ("gain_error", "load_cell")]
    assert all(len(steps) == 1 for f in found for steps in f["evidence"]["sessions"].values())


@pytest.mark.slow
def test_a_held_out_session_keeps_its_zeros_beside_a_course(tmp_path):
    """A zero of depth within what the encoder's noise hides is taken into the baseline; without it the session would have another skin."""
    both = [Hide("position_offset", "rig", None, 1.0), Hide("gain_error", "taxel_0", None, 1.0)]
    found = seek(tmp_path, both, seed=430040290, taxels=3, encoder_noise_um=4.0)
    assert found.names == [("gain_error", "taxel")]
