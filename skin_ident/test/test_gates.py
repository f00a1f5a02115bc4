"""What must be passed before a cause is believed, each rule beside a record that it lets pass and one that it stops."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hide_and_seek import seek
from scipy.signal import lfilter

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.gates import resolution
from skin_ident.criticism.gates.gate import Gain, gain_of_residuals, held_out_gain, refitted
from skin_ident.criticism.gates.resolution import held_depths, of_the_converter, of_the_drive, resolved, unread_depth, unread_force
from skin_ident.criticism.gates.second_opinion import all_in_turn, at_any_scale, halves_in_turn
from skin_ident.criticism.noise.whitening import fit_whitener
from skin_ident.criticism.search.hardware import encoder_does, stage_is_off
from skin_ident.criticism.search.own import own_course
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.survey import survey
from skin_ident.criticism.search.weighing import heaviest_of, held_again, lighter, tells_more, weighed, with_mass
from skin_ident.criticism.sessions.band import Band
from skin_ident.criticism.sessions.cutoff import dilution
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.sessions.thinner import thinner
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.effects.backlash import Backlash
from skin_models.effects.gain_error import GainStep
from skin_models.effects.lag import Lag
from skin_models.effects.nonlinear_stiffness import PowerStiffness
from skin_models.effects.position_offset import PositionOffset
from skin_models.effects.rate_dependence import PowerDamping
from skin_models.model import Model
from skin_models.signals import motion

RATE = 100.0
T = np.arange(4000) / RATE
DEPTH = 0.5e-3 + 0.3e-3 * np.sin(0.9 * T) + 0.1e-3 * np.sin(4.1 * T)
PLAIN = Model(Dispersion(m=0.0, b1=900.0, k1=9000.0, b2=600.0, k2=3000.0), shares=(1.0,))
QUICK = Gain("force", ("force",), before=0.02, after=0.0185, ci95=(0.001, 0.002), relative=0.1, lower=0.05, held_out="")


def recorded(
    model: Model, depth: np.ndarray = DEPTH, noise: float = 0.01, step: float = 0.0, zero: float = 0.0, seed: int = 3
) -> Recording:
    """Channels of `model`, the force off by `zero` N, with white noise and rounded to `step` N."""
    rng = np.random.default_rng(seed)
    truth = model.simulate(motion(T, depth))
    y = np.vstack([truth.force + zero, truth.taxels]) + noise * rng.standard_normal((2, T.size))
    y = step * np.round(y / step) if step else y
    return Recording("made", T, depth, y[0], y[1:])


WHITE = fit_whitener([residual(PLAIN, prepare(recorded(PLAIN)))], [prepare(recorded(PLAIN))])


def test_a_mass_that_cannot_fall_below_nothing_explains_no_force_that_is_too_large():
    """Its weight takes from the force: were it free to be negative, it would be the offset."""
    sessions = weighed([prepare(recorded(PLAIN, zero=0.05))])
    noise = fit_whitener([residual(PLAIN, prepare(recorded(PLAIN)))], [sessions[0]])
    found = fit(PLAIN, sessions, noise)
    assert found.model.dispersion.m == 0.0
    best = survey(found.model, sessions, directions(sessions[0]), noise).ranked[0]
    assert (best.cause, best.where) == ("force_offset", "load_cell") and best.score > 100.0


def test_a_mass_that_hardly_matters_is_left_as_it_was():
    session = prepare(recorded(PLAIN))
    light = replace(PLAIN, dispersion=replace(PLAIN.dispersion, m=1e-5))
    noise = fit_whitener([residual(PLAIN, session)], [session])
    assert with_mass(fit(light, [session], noise), [session], noise) is None
    gram = replace(PLAIN, dispersion=replace(PLAIN.dispersion, m=0.001))
    above = [prepare(recorded(PLAIN, zero=0.05))]  # which the gram that a skin weighs takes part of, and an offset all
    present = fit(gram, above, noise)
    best = survey(present.model, above, directions(above[0]), noise).ranked[0]
    free = with_mass(present, above, noise)
    assert lighter(present.model, free.model) and tells_more(free, present, 1.0) and not tells_more(free, present, best.score)
    heavy = [prepare(recorded(replace(PLAIN, dispersion=replace(PLAIN.dispersion, m=0.5))))]
    present = fit(light, heavy, noise)
    free = with_mass(present, heavy, noise)
    assert free.model.dispersion.m == pytest.approx(0.5, rel=0.2) and tells_more(free, present, 1.0)


def test_an_effect_in_one_channel_of_many_need_not_be_larger_there_than_in_one_of_two():
    one = recorded(PLAIN)
    wide = prepare(Recording("made", one.t, one.depth, one.force, np.tile(one.taxels, (3, 1))))
    noise = fit_whitener([np.random.default_rng(1).standard_normal(wide.measured.shape)], [wide])
    before = np.random.default_rng(2).standard_normal(wide.measured.shape)
    one = gain_of_residuals([before], [before * [[0.9], [1.0], [1.0], [1.0]]], [wide], noise, "")
    every = gain_of_residuals([before], [before * 0.9], [wide], noise, "")
    assert (one.carried, one.breadth) == (("force",), 0.5) and every.breadth == 1.0
    seen = replace(one, relative=0.006)
    assert seen.passed and not replace(seen, breadth=1.0).passed and not replace(seen, relative=0.004).passed


def test_a_quarter_of_the_noise_is_enough_whitened_or_plain():
    little = replace(QUICK, after=0.0195, ci95=(1e-4, 9e-4))
    assert replace(little, relative=0.07).passed and not replace(little, relative=0.05).passed
    assert replace(little, relative=0.05, after=0.019).passed


def test_what_good_hardware_does_is_said_and_not_named():
    """A gap of half a micrometre, read in steps of one."""
    session = prepare(recorded(replace(PLAIN, effects=(Backlash("rig", gap=5e-7),)), noise=0.001))
    noise = fit_whitener([residual(PLAIN, session)], [session])
    after = fit(replace(PLAIN, effects=(Backlash("rig", gap=1e-6),)), [session], noise)
    gain = held_out_gain(PLAIN, after.model, [session], [], noise)
    key = ("backlash", "rig")
    said = encoder_does(key, gain, PLAIN, after.model, [session], noise, encoder_step=1e-6)
    length = float(re.search(r"it would be ([\d.]+) µm", said.because)[1])
    assert length == pytest.approx(0.5, rel=0.05) and "reads no finer than 1 µm" in said.because
    assert encoder_does(key, gain, PLAIN, after.model, [session], noise, encoder_step=1e-7) is None


def test_what_bends_with_the_reading_may_be_the_converter():
    """A gain of a fifth of a step may be the integral nonlinearity of a converter, which is no loop; one of a step is not."""
    coarse, fine = ([prepare(recorded(PLAIN, step=step))] for step in (0.04, 0.005))
    assert of_the_converter(QUICK, "nonlinear_stiffness", coarse)
    assert not of_the_converter(QUICK, "nonlinear_stiffness", fine) and not of_the_converter(QUICK, "hysteresis", coarse)
    assert resolved(QUICK, "hysteresis", PLAIN, PLAIN, coarse, WHITE, 0.0)


def test_damping_shows_while_the_stage_moves_and_a_tremble_at_rest_does_not():
    tremble = 1e-6 * np.round(np.random.default_rng(0).random(T.size))
    resting = np.where((T > 5.0) & (T < 35.0), 0.5e-3 + tremble, DEPTH)
    skin = replace(PLAIN, effects=(PowerDamping("skin", force_sensed=20.0, force_dispersed=20.0, exponent=2.0),))
    moving = [prepare(recorded(skin, noise=0.005))]
    still = [prepare(recorded(PLAIN, depth=resting, noise=0.005))]
    noise = fit_whitener([residual(skin, moving[0])], [moving[0]])
    after = fit(skin, moving, noise).model
    before = fit(PLAIN, moving, noise).model
    small = replace(QUICK, before=0.010, after=0.005)
    assert resolved(small, "rate_dependence", before, after, moving, noise, 1e-6)
    assert not resolved(small, "rate_dependence", PLAIN, skin, still, noise, 1e-6)


def test_steps_that_beat_against_samples_are_no_damping():
    """A stage that passes 1.04 steps a sample is read as one of 1 a sample that jumps four times a second: damping feels every jump."""
    step = 20e-6
    up = np.abs((T / 0.8 + 1.0) % 2.0 - 1.0) * 0.8 * 1.04 * step * RATE
    read = step * np.round(up / step)
    moving = [prepare(recorded(PLAIN, depth=read, noise=0.01))]
    large = replace(QUICK, before=0.15, after=0.10, relative=0.5)
    assert not resolved(large, "rate_dependence", PLAIN, PLAIN, moving, WHITE, step)
    assert resolved(large, "hysteresis", PLAIN, PLAIN, moving, WHITE, step)
    assert resolved(large, "rate_dependence", PLAIN, PLAIN, [prepare(recorded(PLAIN, noise=0.01))], WHITE, step)


def test_noise_of_the_encoder_averages_out_but_what_smooths_it_away_is_no_finding(monkeypatch):
    """Unless the noise is asked what it feigns (test_feigned.py). Of 3 µm at 100 Hz four in ten pass the band; they press with stiffness,
    and with damping, which only what smooths may spare, as it may the share of the damping that they hide."""
    monkeypatch.setattr(resolution, "explains_more", lambda *of: False)
    noise, k, b = 3e-6 * Band(1.0 / RATE).passes, 12000.0, 1500.0 * 2.0 * np.pi * 8.0 / np.sqrt(3.0)
    noisy = [replace(prepare(recorded(PLAIN, noise=0.01)), depth_noise=3e-6)]
    hidden = 1500.0 * dilution(noisy) * np.sqrt(np.mean(noisy[0].motion.v ** 2))
    pressed, dragged = (np.sqrt(2.0) * noise * force for force in (k, np.hypot(k, b)))
    dragged = np.hypot(dragged, hidden)
    for cause, least in (("gain_error", pressed), ("backlash", dragged), ("rate_dependence", dragged)):
        for times in (0.8, 1.2):
            gain = replace(QUICK, before=times * least, after=0.0, relative=0.5)
            assert resolved(gain, cause, PLAIN, PLAIN, noisy, WHITE, np.sqrt(12.0) * 3e-6) is (times > 1.0)
    read = DEPTH + 3e-6 * np.random.default_rng(0).standard_normal(T.size)
    assert prepare(replace(recorded(PLAIN, noise=0.01), depth=read)).depth_noise == pytest.approx(3e-6, rel=0.1)


def test_a_search_that_looks_at_fewer_samples_sees_as_much_noise_of_the_encoder():
    rng, t = np.random.default_rng(0), np.arange(8000) / 1000.0
    x = 0.5e-3 + 0.3e-3 * np.sin(2.0 * t)
    every = prepare(Recording("fast", t, x + 3e-6 * rng.standard_normal(t.size), 12e3 * x, 9e3 * x[None]))
    (fewer,) = thinner([every])
    seen, of_fewer = (unread_force(PLAIN, "force", [s], np.sqrt(12.0) * 3e-6) for s in (every, fewer))
    assert fewer.motion.dt > every.motion.dt and of_fewer == pytest.approx(seen, rel=0.01)


def test_a_quick_effect_under_slow_noise_is_named(tmp_path):
    """Slow noise makes the plain error large, which then falls by little; the likelihood gains much."""
    assert seek(tmp_path, "backlash", where="rig", form="several", size=0.5, seed=1827596594, protocol="full").right


def test_steps_of_the_depth_average_out_where_the_stage_moves():
    """At rest an error of a step stays; where the stage passes many of them in a period of the band, little is left."""
    elastic, quick = replace(PLAIN, dispersion=Dispersion(m=0.0, b1=5.0, k1=9000.0, b2=3.0, k2=3000.0)), 0.5e-3 + 0.3e-3 * np.sin(6.0 * T)
    resting, moving = ([prepare(recorded(elastic, depth=depth, noise=0.0))] for depth in (np.full(T.size, 0.5e-3), quick))
    step = 5e-6
    assert unread_depth(resting, step) == pytest.approx(step / np.sqrt(12.0))
    assert unread_depth(moving, step) < 0.5 * step / np.sqrt(12.0)
    rounded = prepare(replace(recorded(elastic, depth=quick, noise=0.0), depth=step * np.round(quick / step)))
    error = residual(elastic, rounded)[0] - residual(elastic, moving[0])[0]
    assert float(np.sqrt(np.mean(error**2))) < 1.2 * 12000.0 * unread_depth(moving, step)


def test_damping_is_not_below_nothing_and_a_late_taxel_is_named_instead():
    """A taxel that is late by 0.15 s makes of k1 a damping of -450 N s/m, which no skin has."""
    late = replace(PLAIN, effects=(Lag("taxel", tau=0.15),))
    sessions = [prepare(recorded(late))]
    noise = fit_whitener([residual(late, sessions[0])], [sessions[0]])
    found = fit(PLAIN, sessions, noise).model
    assert found.dispersion.b1 >= -found.dispersion.k1 / RATE
    best = survey(found, sessions, directions(sessions[0]), noise).ranked[0]
    assert (best.cause, best.where) in {("lag", "taxel"), ("time_shift", "clock_taxels")}


def test_most_of_what_there_is_may_be_gained_in_one_block():
    nearly = replace(QUICK, relative=0.8, lower=-0.002)
    assert nearly.passed and not replace(nearly, relative=0.4).passed
    assert not replace(nearly, ci95=(-0.001, 0.002)).passed and not replace(nearly, lower=-0.1).passed


def test_what_held_out_data_leave_in_doubt_is_asked_of_all_sessions_in_turn():
    """A curvature that a short session can hardly show, and a play that is not there."""
    bent = replace(PLAIN, effects=(PowerStiffness("skin", force_sensed=0.3, exponent=2.0),))
    *train, other = (prepare(recorded(bent, noise=0.05, seed=seed)) for seed in (1, 2, 3))
    held = [replace(other, weight=other.weight * (other.t < 8.0))]
    noise = fit_whitener([residual(bent, s) for s in train], train)
    before, after = (fit(m, train, noise).model for m in (PLAIN, bent))
    alone, together = held_out_gain(before, after, train, held, noise), all_in_turn(before, after, train, held, noise)
    assert together.passed and together.lower > alone.lower and together.held_out == "every session in turn"
    played = fit(after.extended(Backlash("rig", gap=5e-6)), train, noise).model
    assert not all_in_turn(after, played, train, held, noise).passed


def test_a_contact_of_its_own_does_not_hide_what_a_held_out_session_says():
    """A tenth more in the taxel of one session: what bends all is farther off there by the scale alone, and still what bends all."""
    bent = replace(PLAIN, effects=(PowerStiffness("skin", force_sensed=0.3, exponent=2.0),))
    *train, other = (recorded(bent, seed=seed) for seed in (1, 2, 3))
    train, held = [prepare(r) for r in train], [prepare(replace(other, taxels=1.1 * other.taxels))]
    noise = fit_whitener([residual(bent, s) for s in train], train)
    before, after = (fit(m, train, noise).model for m in (PLAIN, bent))
    assert at_any_scale(before, after, train, held, noise).passed
    played = fit(after.extended(Backlash("rig", gap=5e-6)), train, noise).model
    assert not at_any_scale(after, played, train, held, noise).passed


def test_where_a_lone_session_was_fitted_there_is_no_second_opinion():
    """Nothing else was fitted that could predict it in turn."""
    one, other = (prepare(recorded(PLAIN, seed=seed)) for seed in (1, 2))
    search = Search([one], [other], directions(one), lambda stage: None)
    search.noise = fit_whitener([residual(PLAIN, one)], [one])
    assert search.second_opinion(PLAIN, PLAIN.extended(Lag("taxel", tau=1e-3)), "taxel", QUICK) is QUICK


def test_what_a_single_session_shows_is_asked_of_its_halves():
    """Speeds that one session alone has: of a damping that grows with speed the other says nothing."""
    grows = replace(PLAIN, effects=(PowerDamping("skin", force_sensed=20.0, exponent=2.5),))
    slow = 0.5e-3 + 0.3e-3 * np.sin(0.2 * T)
    train = [prepare(recorded(grows, depth, seed=seed)) for depth, seed in ((DEPTH, 1), (slow, 2))]
    noise = fit_whitener([residual(grows, s) for s in train], train)
    before, after = (fit(m, train, noise).model for m in (PLAIN, grows))
    assert halves_in_turn(before, after, train, noise).passed
    lagging = fit(after.extended(Lag("taxel", tau=1e-3)), train, noise).model
    assert not halves_in_turn(after, lagging, train, noise).passed


def test_a_noisy_force_that_drives_is_no_damping_that_depends_on_speed():
    """Less damping for the little speeds of the noise keeps it from simulated taxels: held-out data approve, and the skin knows nothing."""
    sessions = [prepare(pressed_by_force(seed)) for seed in (1, 2, 3)]
    noise = fit_whitener([residual(PLAIN, s) for s in sessions], sessions)
    before = fit(PLAIN, sessions[:2], noise).model
    quiet = PowerDamping("skin", force_sensed=-0.1, exponent=0.5)
    after = fit(before.extended(quiet), sessions[:2], noise).model
    gain = held_out_gain(before, after, sessions[:2], sessions[2:], noise)
    assert gain.passed and of_the_drive(gain, "rate_dependence", before, after, sessions[:2])
    assert "noise of that force" in encoder_does(("rate_dependence", "skin"), gain, before, after, sessions[:2], noise, 0.0).because
    assert unread_force(before, "taxel_0", sessions, 0.0) > 0.0
    little = replace(QUICK, before=0.02, after=0.0195, relative=0.05)
    assert of_the_drive(little, "lag", before, after, sessions) and not of_the_drive(little, "saturation", before, after, sessions)
    assert not of_the_drive(replace(little, relative=0.3), "lag", before, after, sessions)
    assert not of_the_drive(little, "lag", before, after, [prepare(recorded(PLAIN))])


def pressed_by_force(seed: int) -> Recording:
    """Ramps and holds of a force that is measured with far more noise than the taxel."""
    rng = np.random.default_rng(seed)
    force = np.interp(T, [0.0, 3.0, 4.0, 36.0, 37.0, 40.0], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
    k, b = PLAIN.dispersion.k1 + PLAIN.dispersion.k2, PLAIN.dispersion.b1 + PLAIN.dispersion.b2
    depth = lfilter([1.0 / RATE], [b / k + 1.0 / RATE, -b / k], force / k)
    taxel = PLAIN.dispersion.k1 * depth + PLAIN.dispersion.b1 * np.gradient(depth, T)
    noisy = force + 0.02 * rng.standard_normal(T.size), taxel + 0.001 * rng.standard_normal(T.size)
    return Recording(f"made_{seed}", T, None, noisy[0], noisy[1][None])


def test_a_tolerance_of_good_hardware_is_said_and_not_named():
    offset = Gain("force", ("force",), before=0.02, after=0.01, ci95=(0.005, 0.015), relative=0.5, lower=0.4, held_out="")
    said = stage_is_off([PositionOffset("rig", offset=-5e-7)], offset)
    assert "0.5 µm" in said.because and "2.5 µm" in said.because
    assert stage_is_off([PositionOffset("rig", offset=-5e-7)], replace(offset, after=0.0199)) is None


def test_an_assumed_mass_is_fitted_up_to_itself_and_held_again():
    sessions = [prepare(recorded(PLAIN, noise=0.002))]
    noise = fit_whitener([residual(PLAIN, s) for s in sessions], sessions)
    assumed = replace(PLAIN, dispersion=replace(PLAIN.dispersion, m=4e-4))
    free = with_mass(fit(assumed, sessions, noise), sessions, noise)
    assert heaviest_of(assumed, free.model) == 4e-4
    bounded = weighed(sessions, 4e-4)
    light = fit(assumed, bounded, noise)
    assert light.model.dispersion.m < 1e-4 and held_again(light, bounded, noise) is None
    heavy = [prepare(recorded(assumed, noise=0.002))]
    again = held_again(fit(PLAIN, weighed(heavy, 4e-4), noise), weighed(heavy, 4e-4), noise)
    assert again.model.dispersion.m == 4e-4


@pytest.mark.parametrize("holds", [1, 3, 12])
def test_the_depths_at_which_a_record_rests_are_counted(holds):
    """Rests of equal length, between quick lifts into the air; a ramp is at a new depth all the time."""
    x = np.concatenate([np.r_[np.full(1000, 1e-4 * (i + 3)), np.full(50, -1e-4)] for i in range(holds)])
    t = np.arange(x.size) / RATE
    (held, ramp) = (prepare(Recording("r", t, depth, 0.0 * t, 0.0 * t[None])) for depth in (x, np.linspace(0.0, 1e-3, t.size)))
    assert held_depths([held], 1e-6) == pytest.approx(holds, rel=0.25)
    assert held_depths([ramp], 1e-6) > 100.0
    assert held_depths([held], 0.0) == np.inf


def test_a_zero_of_each_session_explains_more_than_wandering_noise_may():
    """No more than any cause must: below that, what wanders slowly enough looks like a zero, and held-out halves of sessions approve."""
    train = [replace(prepare(recorded(PLAIN, zero=zero, seed=k)), name=f"s{k}") for k, zero in enumerate((0.0, 0.003))]
    search = Search(train, [], directions(train[0]), lambda stage: None)
    search.present = fit(PLAIN, train, fit_whitener([residual(PLAIN, s) for s in train], train))
    search.look()
    (run,) = (r for r in search.own_courses() if r.course.key == ("force_offset", "load_cell") and r.course.shape == "constant")
    told = own_course(search, [run], [])
    assert told is not None and told[1].cause == "force_offset" and told[1].explained > search.least(search.present.count)
    search.least = lambda count: told[1].explained + 1.0
    assert own_course(search, [run], []) is None


def test_of_what_the_others_do_not_feel_a_fit_to_them_knows_nothing():
    """A gain that steps after the end of all sessions but one was fitted to that one, which shall be predicted."""
    session = prepare(recorded(PLAIN))
    noise = fit_whitener([residual(PLAIN, session)], [session])
    steps = [PLAIN.extended(GainStep(where="load_cell", gain=0.03, after=at)) for at in (20.0, 60.0)]
    seen, unseen = (refitted(PLAIN, after, [session], noise)[1].effects[0].gain for after in steps)
    assert unseen == 0.0 and 0.0 < abs(seen) < 0.002


@pytest.mark.parametrize(("cause", "enough"), [("nonlinear_stiffness", False), ("stress_relaxation", True)])
def test_a_zero_of_depth_that_nobody_reads_may_bend_a_force_but_relaxes_nothing(cause, enough):
    """Half of a step of 10 µm beside 12 N/mm is 0.06 N, of which a free stiffness leaves half; a taxel beside it knows better."""
    both = prepare(recorded(PLAIN))
    train, squares = [prepare(replace(recorded(PLAIN), taxels=np.empty((0, T.size)), taxel_names=(), taxel_units=()))], 0.04**2
    gain = replace(QUICK, before=float(np.sqrt(0.005**2 + squares)), after=0.005)
    of_force = replace(PLAIN, shares=())
    noise = fit_whitener([residual(of_force, s) for s in train], train)
    assert resolved(gain, cause, of_force, of_force, train, noise, 10e-6) is enough
    assert resolved(gain, cause, PLAIN, PLAIN, [both], WHITE, 10e-6)


def test_a_session_is_as_long_as_it_may_be_believed():
    session = prepare(recorded(PLAIN))
    half = replace(session, weight=session.weight * (np.arange(session.t.size) < session.t.size // 2))
    assert session.seconds == pytest.approx(np.ptp(session.t), rel=0.01) and half.seconds == pytest.approx(session.seconds / 2, rel=0.01)
