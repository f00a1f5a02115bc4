"""The parts of the criticism, each against something independent of it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares, lsq_linear
from scipy.signal import lsim

from skin_ident.criticism.baseline.fitting import Fit, cost_of, fit
from skin_ident.criticism.baseline.residual import residual, simulated
from skin_ident.criticism.baseline.unknowns import unknowns, values, with_values
from skin_ident.criticism.gates.gate import by_block
from skin_ident.criticism.noise.whitening import fit_whitener, white
from skin_ident.criticism.search.growing import _extended, _finer, sound_damping
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.search.ranking import signed_pursuit
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.survey import survey
from skin_ident.criticism.search.unstuck import unstuck
from skin_ident.criticism.search.weighing import with_hanging
from skin_ident.criticism.sessions.band import Band
from skin_ident.criticism.sessions.cutoff import common_to
from skin_ident.criticism.sessions.parting import JOLTED, impacts, parted
from skin_ident.criticism.sessions.session import motion_under, prepare, weighed
from skin_ident.recordings.recording import Recording
from skin_models.catalogue import effects
from skin_models.dispersion import Dispersion
from skin_models.effects.hysteresis import SkinHysteresis
from skin_models.effects.inertia import Inertia
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.effects.time_shift import SkewedClock, TimeShift
from skin_models.model import Model
from skin_models.model_file import model_to_dict
from skin_models.parameter import clipped, parameters_of
from skin_models.signals import motion

SILICONE = Model(Dispersion(m=0.000432, b1=939.5, k1=9619.0, b2=629.2, k2=2766.0), shares=(1.0, 0.4))
T = np.arange(4000) / 100.0
DEPTH = 0.5e-3 + 0.3e-3 * np.sin(0.9 * T) + 0.1e-3 * np.sin(4.1 * T)


CORNERS = [0.1, 0.8, 0.3, 0.9, 0.5, 0.5, 0.7, 0.6, 0.95, 0.1, 0.5, 0.4, 0.5, 0.2, 0.8]  # mm
LOOPS = np.interp(
    T, np.cumsum([0, 1, 3, 3, 0.5, 5, 0.5, 2, 8, 2, 1, 1, 3, 4, 6]), 1e-3 * np.array(CORNERS)
)  # large and small, fast and slow


def recording(model: Model, noise: float = 0.0, seed: int = 0, depth: np.ndarray = DEPTH) -> Recording:
    response = model.simulate(motion(T, depth))
    rng = np.random.default_rng(seed)
    return Recording(
        "made",
        T,
        depth,
        response.force + noise * rng.standard_normal(T.size),
        response.taxels + noise * rng.standard_normal((len(model.shares), T.size)),
    )


@pytest.mark.parametrize("rate", [50.0, 100.0, 1000.0])
def test_the_band_keeps_what_is_slow_and_where_it_is(rate):
    band, t = Band(1.0 / rate), np.arange(int(20 * rate)) / rate
    for hertz in (0.2, 1.0, 3.0):
        wave, slope = np.sin(2 * np.pi * hertz * t), 2 * np.pi * hertz * np.cos(2 * np.pi * hertz * t)
        inner = slice(int(2 * rate), int(-2 * rate))
        assert np.allclose(band.smooth(wave)[inner], wave[inner], atol=0.01)
        assert np.allclose(band.speed(wave)[inner], slope[inner], atol=0.01 * np.abs(slope).max())
        assert np.allclose(band.thin(wave), np.interp(band.times(t), t, wave), atol=0.01)


@pytest.mark.parametrize("seed", range(5))
def test_signed_pursuit_reaches_the_constrained_optimum_where_it_may_use_all_directions(seed):
    rng = np.random.default_rng(seed)
    A, r, signs = rng.standard_normal((60, 5)), rng.standard_normal(60), rng.integers(-1, 2, 5)
    z, gain = signed_pursuit(A.T @ A, A.T @ r, signs)
    low, high = np.where(signs > 0, 0.0, -np.inf), np.where(signs < 0, 0.0, np.inf)
    best = lsq_linear(A, r, (low, np.where(high == 0.0, 1e-12, high)))
    assert gain == pytest.approx(r @ r - 2 * best.cost, rel=1e-3)
    assert np.all(z * signs >= 0.0)


@pytest.mark.parametrize(
    ("beside", "own"),
    [
        (StressRelaxation("skin", k_sensed=900.0, k_dispersed=300.0, tau=0.4), False),
        (SkinHysteresis("skin", k_sensed=900.0, k_dispersed=300.0, threshold=2e-4), True),
    ],
)
def test_a_loop_is_one_of_its_own_where_no_more_relaxation_would_do_as_much(beside, own):
    """Relaxation with one arm is in the model; what it leaves is another arm, or a loop."""
    arm = StressRelaxation("skin", k_sensed=2000.0, k_dispersed=600.0, tau=6.0)
    true = replace(SILICONE, effects=(arm, beside))
    s = prepare(recording(true, 0.01, depth=LOOPS))
    noise = fit_whitener([residual(true, s)], [s])
    one_arm = fit(replace(SILICONE, effects=(arm,)), [s], noise)
    share = survey(one_arm.model, [s], directions(s)).of_its_own(("hysteresis", "skin"), {("stress_relaxation", "skin")})
    assert (share > 0.12) if own else (share < 0.05)


@pytest.mark.parametrize("scale", [0.02, 1.0, 5.0])
def test_a_sensor_is_asked_whether_it_bends_within_what_it_reads(scale):
    """A skin so much softer has sensors that read so much less, and clip at so much less."""
    skin = SILICONE.dispersion
    soft = replace(skin, m=0.0, b1=scale * skin.b1, k1=scale * skin.k1, b2=scale * skin.b2, k2=scale * skin.k2)
    r = recording(replace(SILICONE, dispersion=soft))
    for where, reads in (("load_cell", r.force), ("taxel_1", r.taxels[1])):
        levels = [d.effect.level for d in directions(prepare(r)) if d.key == ("saturation", where)]
        assert sum(0.02 < level / reads.max() < 1.0 for level in levels) >= 10


def test_a_fit_recovers_the_truth_from_a_wrong_start():
    session = prepare(recording(SILICONE, noise=0.02))
    start = replace(SILICONE, dispersion=Dispersion(m=0.000432, b1=500.0, k1=6000.0, b2=900.0, k2=5000.0), shares=(1.0, 0.8))
    noise = fit_whitener([residual(SILICONE, session)], [session])
    found = fit(start, [session], noise)
    truth = values(SILICONE, found.unknowns)
    std = np.array([found.std[u.label] for u in found.unknowns])
    assert np.all(np.abs(values(found.model, found.unknowns) - truth) < 5.0 * std + 1e-3 * np.abs(truth))


def test_a_late_load_cell_does_not_bend_what_the_taxels_say():
    """30 ms late, it reads as if the skin gave back more than it took; no damping in all may do that, and that of the taxels is another."""
    skin = replace(SILICONE, dispersion=Dispersion(m=0.000432, b1=60.0, k1=9619.0, b2=40.0, k2=2766.0))
    r = recording(skin, 0.01)
    late = replace(r, force=np.interp(r.t - 0.03, r.t, r.force))
    s = prepare(late)
    start = replace(SILICONE, dispersion=Dispersion(m=0.000432, b1=700.0, k1=9000.0, b2=500.0, k2=2000.0))
    found = fit(start, [s], white([residual(skin, prepare(r))])).model.dispersion
    assert (found.b1, found.k1) == pytest.approx((60.0, 9619.0), rel=0.03)
    assert found.b1 + found.b2 == pytest.approx(-0.5 * s.motion.dt * (found.k1 + found.k2), rel=0.15)


def test_a_mass_that_hangs_explains_with_its_inertia_what_one_that_leans_does_not():
    """Pressed all the time, its weight is a number beside others; only its inertia tells the whole."""
    skin = replace(SILICONE, dispersion=replace(SILICONE.dispersion, m=0.0))
    r = recording(replace(skin, effects=(Inertia("rig", mass=0.5),)), 1e-4)
    sessions = [prepare(r)]
    noise = white([1e-4 * np.random.default_rng(1).standard_normal(s.measured.shape) for s in sessions])
    leaning = fit(replace(skin, dispersion=replace(skin.dispersion, m=0.5)), sessions, noise)
    hanging, seen = with_hanging(leaning, sessions, noise)
    assert (hanging.model.dispersion.m, seen[0].hung) == (0.0, 0.5)
    assert hanging.cost < 0.5 * fit(leaning.model, weighed(sessions), noise).cost


def test_a_cause_that_only_leads_out_of_a_false_minimum_is_not_taken():
    """Driven by force, skin that seems to recover at once has no time constant that a small step could change."""
    skin = replace(SILICONE, dispersion=replace(SILICONE.dispersion, m=0.0))
    whole = recording(skin, 0.002)
    sessions = [prepare(replace(whole, depth=None))]
    search = Search(sessions, [], directions(sessions[0]), lambda stage: None)
    search.noise = white([residual(skin, s) for s in sessions])
    at_once = replace(skin, dispersion=replace(skin.dispersion, b1=0.0, b2=0.0))
    search.present = search.baseline = Fit(at_once, (), {}, cost_of(at_once, sessions, search.noise), sessions[0].measured.size)
    late = fit(skin.extended(TimeShift("clock_taxels", delay=1e-4)), sessions, search.noise)
    finding = Named("time_shift", "clock_taxels", None, 1e4, ())
    assert unstuck(search, late, finding) and not search.present.model.effects
    assert search.baseline is search.present and search.present.cost < 1.1 * late.cost
    assert not unstuck(search, late, finding)


def test_a_fit_ends_where_least_squares_of_scipy_ends():
    """Though it corrects most of its slopes in place of computing them."""
    session = prepare(recording(SILICONE.extended(StressRelaxation("skin", k_sensed=1200.0, k_dispersed=300.0, tau=0.8)), 0.01))
    noise, start = (
        white([np.full(session.measured.shape, 0.01)]),
        SILICONE.extended(StressRelaxation("skin", k_sensed=300.0, k_dispersed=300.0, tau=0.3)),
    )
    which, scale = unknowns(start, session), np.abs(values(start, unknowns(start, session)))
    end = least_squares(
        lambda z: noise.apply(residual(with_values(start, which, z * scale), session), session).ravel(), values(start, which) / scale
    )
    assert fit(start, [session], noise).cost == pytest.approx(2.0 * end.cost, rel=1e-3)


def test_what_was_tried_ahead_is_not_tried_again():
    told: list[str] = []
    relaxing = SILICONE.extended(StressRelaxation("skin", k_sensed=1200.0, k_dispersed=300.0, tau=0.8))
    sessions = [prepare(recording(relaxing.extended(TimeShift("clock_taxels", delay=0.02)), 0.01))]
    search = Search(sessions, [], directions(sessions[0]), told.append)
    search.present = fit(SILICONE, sessions, white([np.full(sessions[0].measured.shape, 0.01)]))
    best = search.trials(search.look())[0]
    ahead = search.ahead(best.fit)
    trials = ahead.trials(ahead.look())
    told.clear()
    search.present = best.fit
    again = search.trials(search.look())
    assert trials and [t.fit for t in again] == [t.fit for t in trials]
    assert not [said for said in told if said.startswith("trying")]


def test_unknowns_are_a_vector_and_back():
    session = prepare(recording(SILICONE))
    which = unknowns(SILICONE, session)
    assert [u.label for u in which] == ["b1", "k1", "b2", "k2", "share_1"]
    moved = with_values(SILICONE, which, values(SILICONE, which) * 1.1)
    assert np.allclose(values(moved, which), values(SILICONE, which) * 1.1)


@pytest.mark.parametrize("cls", effects(), ids=lambda c: f"{c.__name__}")
def test_trying_an_effect_gives_what_simulating_it_gives(cls):
    """On top of a model, or in the place of another of its kind that a run has simulated already."""
    word = next(iter(cls.places))
    e, s = cls.typical(word), motion(T, DEPTH)
    model = replace(SILICONE, positions=((0.0, 0.0), (5e-3, 1e-3)))
    whole = model.extended(e).simulate(s)
    for tried in (model.bent(model.trace(s), e), model.extended(e).again(model.extended(e.absent()).trace(s), e.place)):
        assert np.allclose(tried.force, whole.force, atol=1e-12) and np.allclose(tried.taxels, whole.taxels, atol=1e-12)


def test_a_force_driven_skin_is_pressed_to_the_depth_that_gives_the_force():
    whole = recording(replace(SILICONE, dispersion=replace(SILICONE.dispersion, m=0.0)))
    session = prepare(replace(whole, depth=None))
    depth = motion_under(session, SILICONE.dispersion).x
    inner = slice(300, -300)
    assert np.allclose(depth[inner], DEPTH[inner], atol=2e-6)


def test_a_taxel_under_prescribed_force_follows_thesis_eq_32_also_when_the_force_is_gone():
    skin = replace(SILICONE.dispersion, m=0.0)
    force = 4.0 * np.convolve((T > 5.0) & (T < 12.0), np.hanning(101) / 50.0, mode="same")
    session = prepare(Recording("pressed and let go", T, None, force, np.zeros((1, T.size))))
    taxel = simulated(Model(skin), session)[0]
    k, b = skin.k1 + skin.k2, skin.b1 + skin.b2
    _, expected, _ = lsim(([skin.b1, skin.k1], [b, k]), session.drive, T)
    assert np.allclose(taxel[30:-30], expected[30:-30], atol=0.01)
    assert force[1251] == 0.0 and taxel[1251] > 0.03  # the skin is still coming back


def test_skin_left_behind_by_a_fast_plunger_is_left_out():
    slow, fast = (motion(T, 0.5e-3 * (1 - np.cos(2 * np.pi * hertz * T))) for hertz in (0.1, 4.0))
    assert not parted(slow, SILICONE.dispersion)[100:-100].mean() > 0.12
    assert parted(fast, SILICONE.dispersion).mean() > 0.3


def test_sessions_of_several_rates_are_compared_in_one_band_at_one_rate():
    fast, slow = Band(1.0 / 100.0, slowest=1.0 / 20.0), Band(1.0 / 20.0, slowest=1.0 / 20.0)
    assert fast.edge == slow.edge == 4.0
    assert fast.dt * fast.every == pytest.approx(slow.dt * slow.every)


@pytest.mark.parametrize("seconds", [1.5, 2.1, 3.9])
def test_the_shortest_session_has_blocks_to_draw_from(seconds):
    whole = recording(SILICONE, noise=0.02)
    session = prepare(whole.part(0, int(100 * seconds) + 40))
    blocks = by_block(np.ones(session.measured.shape), session)
    assert blocks.shape[-1] >= 3 and blocks.sum(axis=-1).min() > 0.9 * session.measured.shape[-1]


def test_every_instance_of_a_cause_has_numbers_of_its_own():
    arms = [StressRelaxation("skin", k_sensed=1500.0, k_dispersed=500.0, tau=tau) for tau in (0.3, 8.0)]
    model = SILICONE.extended(arms[0]).extended(arms[1])
    fast, late = model.listed_as(0, "tau"), model.listed_as(1, "tau")
    assert (fast, late) == ("stress_relaxation.skin.tau", "stress_relaxation.skin.tau_2")
    session = prepare(recording(model, noise=0.02))
    found = fit(model, [session], fit_whitener([residual(model, session)], [session]), 2)
    assert len(found.std) == len(found.unknowns) and found.std[late] > 5.0 * found.std[fast] > 0.0
    written = model_to_dict(found.model, found.std)["effects"]
    assert [e["parameters"]["tau"]["std"] for e in written] == [found.std[fast], found.std[late]]


def test_a_jump_where_skin_is_met_again_is_left_out_with_its_last_sample():
    """Up and down so fast that the skin is left behind: met again inside it, the force jumps between two samples."""
    x = 0.6e-3 + 0.6e-3 * np.cos(2.0 * np.pi * 2.5 * T)
    response = SILICONE.simulate(motion(T, x))
    session = prepare(Recording("fast", T, x, response.force, response.taxels))
    jumps = impacts(session.motion, SILICONE.dispersion, JOLTED)
    rises = np.diff(response.force) > 0.3 * response.force.max()
    assert rises.sum() > 20 and jumps[1:][rises].mean() > 0.9


@pytest.mark.parametrize(
    ("late", "of_b1", "of_b2"),
    [(0.12, 9619.0, -9619.0), (0.05, 0.0, 9619.0 + 2766.0)],
    ids=["the taxels are late", "the load cell is late"],
)
def test_damping_that_a_delay_has_eaten_is_found_again(late, of_b1, of_b2):
    """A reading that is late by d, s, has k d less damping: of the taxels under them, of the load cell in all."""
    alike = 0.1  # s, damping over stiffness of both springs
    sound = replace(SILICONE.dispersion, b1=alike * 9619.0, b2=alike * 2766.0)
    eaten = replace(sound, b1=sound.b1 - late * of_b1, b2=sound.b2 - late * of_b2)
    found, delay = sound_damping(eaten)
    assert (found.b1, found.b2, delay) == pytest.approx((sound.b1, sound.b2, late))


@pytest.mark.parametrize("beside", [TimeShift("clock", delay=0.02), StressRelaxation("skin", k_sensed=900.0, tau=0.4)])
def test_a_form_that_has_all_of_a_plain_one_takes_its_place_and_adds_to_it(beside):
    late, skewed = TimeShift("clock_taxels", delay=0.03), SkewedClock("clock_taxels", skew=50.0, delay=0.01)
    grown = _extended(replace(SILICONE, effects=(late, beside)), skewed)
    assert grown.effects[:-1] == (beside,)  # what acts elsewhere stays
    assert (grown.effects[-1].skew, grown.effects[-1].delay) == pytest.approx((50.0, 0.04))


def test_two_forms_of_one_delay_add_up_to_no_more_than_a_model_may_hold():
    late, skewed = TimeShift("clock_taxels", delay=-0.4), SkewedClock("clock_taxels", skew=0.0, delay=-0.7)
    assert _extended(replace(SILICONE, effects=(late,)), skewed).effects[-1].delay == -1.0  # s, its bound


@pytest.mark.parametrize("cls", [c for c in effects() if any(other.refines is c for other in effects())], ids=lambda c: c.__name__)
def test_an_effect_at_the_end_of_its_range_has_finer_forms_that_may_be_tried(cls):
    for end in ("lower", "upper"):
        far = clipped(cls, **{p.name: np.clip(getattr(p, end), -1e9, 1e9) for p in parameters_of(cls)})
        finer = _finer(cls(next(iter(cls.places)), **far))
        assert finer and all(e.cause == cls.cause for e in finer)


def test_the_bounds_of_a_fit_do_not_depend_on_which_recording_comes_first():
    """Skin may seem to give energy back by as much as half a sample is late, of the slowest recording."""
    skin = Dispersion(m=0.0, b1=5.0, k1=900.0, b2=5.0, k2=900.0)

    def record(name, dt):
        t = np.arange(0.0, 20.0, dt)
        x = 1e-3 * np.sin(2.0 * t)
        return Recording(name, t, x, np.clip(1800.0 * x, 0.0, None), np.clip(900.0 * x, 0.0, None)[None])

    slow, quick = record("slow", 0.01), record("quick", 0.002)
    for order in ([slow, quick], [quick, slow]):
        common = common_to(order, 0.0)
        lowest = {u.label: u.parameter.lower for u in unknowns(Model(skin, shares=(1.0,)), prepare(order[0], common=common))}
        assert lowest["b1"] == pytest.approx(-0.5 * 0.01 * 900.0)
