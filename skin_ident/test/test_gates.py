"""What must be passed before a cause is believed, each rule beside a record that it lets pass and one that it stops."""

from dataclasses import replace

import numpy as np
import pytest
from gate_records import DEPTH, PLAIN, QUICK, RATE, WHITE, T, recorded
from hide_and_seek import seek

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.gates.another_skin import changes, of_the_skin, solved
from skin_ident.criticism.gates.gate import by_block, gain_of_residuals, held_out_gain, refitted
from skin_ident.criticism.gates.second_opinion import all_in_turn, at_any_scale, halves_in_turn
from skin_ident.criticism.noise.whitening import fit_whitener, stack
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.own import own_course, take_course
from skin_ident.criticism.search.own_again import drop_gain
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.survey import survey
from skin_ident.criticism.search.weighing import heaviest_of, held_again, lighter, tells_more, with_mass
from skin_ident.criticism.sessions.session import prepare, weighed
from skin_ident.recordings.recording import Recording
from skin_models.effects.backlash import Backlash
from skin_models.effects.gain_error import GainStep
from skin_models.effects.lag import Lag
from skin_models.effects.nonlinear_stiffness import PowerStiffness
from skin_models.effects.rate_dependence import PowerDamping


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


@pytest.mark.slow
def test_a_quick_effect_under_slow_noise_is_named(tmp_path):
    """Slow noise makes the plain error large, which then falls by little; the likelihood gains much."""
    assert seek(tmp_path, "backlash", where="rig", form="several", size=0.5, seed=1827596594, protocol="full").right


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
    alone, together = held_out_gain(before, after, train, held, noise), next(all_in_turn(before, after, train, held, noise))
    assert together.passed and together.lower > alone.lower and together.held_out == "every session in turn"
    played = fit(after.extended(Backlash("rig", gap=5e-6)), train, noise).model
    assert not any(gain.passed for gain in all_in_turn(after, played, train, held, noise))


def test_another_skin_does_not_hide_what_a_held_out_session_says():
    """Skin that is stiffer by a hundredth and a half leaves more than a curvature explains, and makes none where there is none."""
    bent = replace(PLAIN, effects=(PowerStiffness("skin", force_sensed=0.06, exponent=2.0),))
    skin = PLAIN.dispersion
    other = replace(bent, dispersion=replace(skin, k1=1.015 * skin.k1, k2=1.015 * skin.k2))
    train, held = [prepare(recorded(bent, seed=seed)) for seed in (1, 2)], [prepare(recorded(other, seed=3))]
    noise = fit_whitener([residual(bent, s) for s in train], train)
    before, after = (fit(m, train, noise).model for m in (PLAIN, bent))
    assert not held_out_gain(before, after, train, held, noise).passed
    as_they_are, with_own = all_in_turn(before, after, train, held, noise)
    assert with_own.passed and with_own.relative > as_they_are.relative
    played = fit(after.extended(Backlash("rig", gap=5e-6)), train, noise).model
    assert not any(gain.passed for gain in all_in_turn(after, played, train, held, noise))


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


def test_a_zero_of_each_session_explains_more_than_wandering_noise_may():
    """No more than any cause must: below that, what wanders slowly enough looks like a zero, and held-out halves of sessions approve."""
    train = [replace(prepare(recorded(PLAIN, zero=zero, seed=k)), name=f"s{k}") for k, zero in enumerate((0.0, 0.003))]
    search = Search(train, [], directions(train[0]), lambda stage: None)
    search.present = fit(PLAIN, train, fit_whitener([residual(PLAIN, s) for s in train], train))
    search.look()
    (run,) = (r for r in search.own_courses() if r.course.key == ("force_offset", "load_cell") and r.course.shape == "constant")
    told = own_course(search, run, [run], [])
    assert told is not None and told[1].cause == "force_offset" and told[1].explained > search.least(search.present.count)
    search.least = lambda count: told[1].explained + 1.0
    assert own_course(search, run, [run], []) is None


@pytest.mark.parametrize(("zeros", "gains"), [((0.0, 0.012, -0.012), (1.0, 1.0, 1.0)), ((0.0, 0.0, 0.0), (1.0, 1.02, 0.98))])
def test_a_gain_that_zeros_explain_is_taken_out_once_they_are_known(zeros, gains):
    """Zeros within a step of the converter, in N, look like gains as long as nobody asks for them. Gains remain."""
    made = [recorded(PLAIN, zero=zero, step=0.02, seed=k) for k, zero in enumerate(zeros)]
    train = [replace(prepare(replace(r, force=g * r.force)), name=f"s{k}") for k, (r, g) in enumerate(zip(made, gains, strict=True))]
    search = Search(train, [], directions(train[0]), lambda stage: None)
    search.present = fit(PLAIN, train, fit_whitener([residual(PLAIN, s) for s in train], train))
    search.look()
    gain = next(r for r in search.own_courses() if r.course.key == ("gain_error", "load_cell"))
    take_course(search, gain, Named(*gain.course.key, None, gain.score, (), courses=gain.said))
    assert not drop_gain(search)  # nobody has asked for zeros
    search.zeroed = 0
    assert drop_gain(search) == any(zeros) and len(search.named) == len(search.runs) == (not any(zeros))


def test_of_what_the_others_do_not_feel_a_fit_to_them_knows_nothing():
    """A gain that steps after the end of all sessions but one was fitted to that one, which shall be predicted."""
    session = prepare(recorded(PLAIN))
    noise = fit_whitener([residual(PLAIN, session)], [session])
    steps = [PLAIN.extended(GainStep(where="load_cell", gain=0.03, after=at)) for at in (20.0, 60.0)]
    seen, unseen = (refitted(PLAIN, after, [session], noise)[1].effects[0].gain for after in steps)
    assert unseen == 0.0 and 0.0 < abs(seen) < 0.002


def test_a_session_is_as_long_as_it_may_be_believed():
    session = prepare(recorded(PLAIN))
    half = replace(session, weight=session.weight * (np.arange(session.t.size) < session.t.size // 2))
    assert session.seconds == pytest.approx(np.ptp(session.t), rel=0.01) and half.seconds == pytest.approx(session.seconds / 2, rel=0.01)


@pytest.mark.parametrize("count", [1, 7, 199, 200, 437, 1999])
def test_every_sample_is_in_one_block(count):
    s = prepare(recorded(PLAIN))
    blocks = by_block(np.ones((2, count)), s)
    assert blocks.sum(axis=1).tolist() == [count, count] and blocks.min() >= blocks.max() - 1.0


def test_another_skin_is_told_in_shares_of_the_shared_one():
    """Also in a session that has a skin of its own already."""
    s = replace(prepare(recorded(PLAIN)), skin={"k1": 1.3})
    more = replace(s, skin={"k1": 1.301})
    change = (residual(PLAIN, s) - residual(PLAIN, more)) / 1e-3
    one = next(own for own, u in zip(changes(PLAIN, s), of_the_skin(PLAIN, s), strict=True) if u.label == "k1")
    assert np.allclose(one, change, atol=1e-3 * np.abs(change).max())


def test_skin_of_a_held_out_session_is_estimated_beside_each_model():
    """Found beside the plain model, it takes up part of the stiffening, and would speak against the stiffening itself."""
    truth = replace(PLAIN, effects=(PowerStiffness("skin", force_sensed=0.3, force_dispersed=0.1, exponent=2.5),))
    stiffer = replace(truth, dispersion=replace(PLAIN.dispersion, k1=1.03 * PLAIN.dispersion.k1, k2=1.03 * PLAIN.dispersion.k2))
    train, held = [prepare(recorded(truth, seed=1))], prepare(recorded(stiffer, 0.8 * DEPTH, seed=2))
    before, after = (fit(m, train, WHITE).model for m in (PLAIN, truth))
    theta, _ = solved(stack([changes(before, held)], [held], WHITE), stack([residual(before, held)], [held], WHITE))
    held = replace(held, skin={u.label: 1.0 + x for u, x in zip(of_the_skin(before, held), theta, strict=True)})
    gain = held_out_gain(before, after, train, [held], WHITE)
    as_found = gain_of_residuals(*([residual(m, held)] for m in (before, after)), [held], WHITE, "as found beside the plain model")
    assert gain.passed and not gain.spoilt
    assert not as_found.passed
