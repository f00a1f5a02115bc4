"""What encoder, converters and stage do by themselves, which a cause must exceed; each rule beside a record that it lets pass and one that
it stops."""

import re
from dataclasses import replace

import numpy as np
import pytest
from gate_records import DEPTH, PLAIN, QUICK, RATE, WHITE, T, recorded
from scipy.signal import lfilter

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.gates import resolution
from skin_ident.criticism.gates.claim import Claim
from skin_ident.criticism.gates.gate import Gain, held_out_gain
from skin_ident.criticism.gates.resolution import held_depths, of_the_converter, of_the_drive, resolved, unread_depth, unread_force
from skin_ident.criticism.noise.whitening import fit_whitener
from skin_ident.criticism.search.hardware import encoder_does, hardware_is_off, too_short
from skin_ident.criticism.search.named import NotNamed
from skin_ident.criticism.sessions.band import Band
from skin_ident.criticism.sessions.cutoff import dilution
from skin_ident.criticism.sessions.session import Session, prepare
from skin_ident.criticism.sessions.thinner import thinner
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.effects.backlash import Backlash
from skin_models.effects.hysteresis import BoucWenHysteresis, SensorHysteresis, SkinHysteresis
from skin_models.effects.position_offset import PositionOffset
from skin_models.effects.rate_dependence import PowerDamping
from skin_models.effects.time_shift import TimeShift
from skin_models.model import Model


def claimed(cause: str, gain: Gain, train: list[Session], before: Model = PLAIN, after: Model = PLAIN) -> Claim:
    """That a cause somewhere gains so."""
    return Claim((cause, ""), gain, before, after, train)


def test_what_good_hardware_does_is_said_and_not_named():
    """A gap of half a micrometre, read in steps of one."""
    session = prepare(recorded(replace(PLAIN, effects=(Backlash("rig", gap=5e-7),)), noise=0.001))
    noise = fit_whitener([residual(PLAIN, session)], [session])
    after = fit(replace(PLAIN, effects=(Backlash("rig", gap=1e-6),)), [session], noise)
    gain = held_out_gain(PLAIN, after.model, [session], [], noise)
    claim = Claim(("backlash", "rig"), gain, PLAIN, after.model, [session])
    said = encoder_does(claim, noise, encoder_step=1e-6)
    length = float(re.search(r"it would be ([\d.]+) µm", said.because)[1])
    assert length == pytest.approx(0.5, rel=0.05) and "reads no finer than 1 µm" in said.because
    assert encoder_does(claim, noise, encoder_step=1e-7) is None


def test_a_loop_within_a_step_of_the_encoder_is_what_encoders_do():
    """A loop of the skin that an encoder makes which lags by 0.5 µm; one that yields over a longer path is none of an encoder."""
    step, k = 5e-6, PLAIN.dispersion.k1 + PLAIN.dispersion.k2

    def said(threshold: float) -> NotNamed | None:
        loop = BoucWenHysteresis("skin", k_sensed=0.5e-6 * k / threshold, k_dispersed=0.0, threshold=threshold)
        return too_short(("hysteresis", "skin"), replace(PLAIN, effects=(loop,)), step)

    assert "half as wide as 0.5 µm, but the encoder reads no finer than 5 µm" in said(0.8 * step).because
    assert said(1.2 * step) is None and said(20.0 * step) is None


def test_a_loop_that_yields_early_is_named_where_it_is_wide():
    """Friction within the skin, of 8 µm of its stiffness."""
    loop = SkinHysteresis("skin", k_sensed=2.0 * PLAIN.dispersion.k1, k_dispersed=2.0 * PLAIN.dispersion.k2, threshold=4e-6)
    assert too_short(("hysteresis", "skin"), replace(PLAIN, effects=(loop,)), 5e-6) is None


def test_what_bends_with_the_reading_may_be_the_converter():
    """A gain of a fifth of a step may be the integral nonlinearity of a converter, which is no loop; one of a step is not."""
    coarse, fine = ([prepare(recorded(PLAIN, step=step))] for step in (0.04, 0.005))
    assert of_the_converter(claimed("nonlinear_stiffness", QUICK, coarse))
    assert not of_the_converter(claimed("nonlinear_stiffness", QUICK, fine)) and not of_the_converter(claimed("hysteresis", QUICK, coarse))
    assert resolved(claimed("hysteresis", QUICK, coarse), WHITE, 0.0)


@pytest.mark.parametrize(("threshold", "its_own"), [(0.01, True), (0.03, False), (0.5, False)])
def test_a_loop_within_half_a_step_is_that_of_the_converter(threshold, its_own):
    """One with hysteresis of its own keeps a reading until the force is some way beyond its level."""
    loop = replace(PLAIN, effects=(SensorHysteresis("load_cell", relative=0.9, threshold=threshold),))
    claim = replace(claimed("hysteresis", QUICK, [prepare(recorded(PLAIN, step=0.04))], after=loop), key=("hysteresis", "load_cell"))
    assert of_the_converter(claim) == its_own


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
    assert resolved(claimed("rate_dependence", small, moving, before, after), noise, 1e-6)
    assert not resolved(claimed("rate_dependence", small, still, after=skin), noise, 1e-6)


def test_steps_that_beat_against_samples_are_no_damping():
    """A stage that passes 1.04 steps a sample is read as one of 1 a sample that jumps four times a second: damping feels every jump."""
    step = 20e-6
    up = np.abs((T / 0.8 + 1.0) % 2.0 - 1.0) * 0.8 * 1.04 * step * RATE
    read = step * np.round(up / step)
    moving = [prepare(recorded(PLAIN, depth=read, noise=0.01))]
    large = replace(QUICK, before=0.15, after=0.10, relative=0.5)
    assert not resolved(claimed("rate_dependence", large, moving), WHITE, step)
    assert resolved(claimed("hysteresis", large, moving), WHITE, step)
    assert resolved(claimed("rate_dependence", large, [prepare(recorded(PLAIN, noise=0.01))]), WHITE, step)


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
            assert resolved(claimed(cause, gain, noisy), WHITE, np.sqrt(12.0) * 3e-6) is (times > 1.0)
    read = DEPTH + 3e-6 * np.random.default_rng(0).standard_normal(T.size)
    assert prepare(replace(recorded(PLAIN, noise=0.01), depth=read)).depth_noise == pytest.approx(3e-6, rel=0.1)


def test_a_search_that_looks_at_fewer_samples_sees_as_much_noise_of_the_encoder():
    rng, t = np.random.default_rng(0), np.arange(8000) / 1000.0
    x = 0.5e-3 + 0.3e-3 * np.sin(2.0 * t)
    every = prepare(Recording("fast", t, x + 3e-6 * rng.standard_normal(t.size), 12e3 * x, 9e3 * x[None]))
    (fewer,) = thinner([every])
    seen, of_fewer = (unread_force(PLAIN, "force", [s], np.sqrt(12.0) * 3e-6) for s in (every, fewer))
    assert fewer.motion.dt > every.motion.dt and of_fewer == pytest.approx(seen, rel=0.01)


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


def test_a_noisy_force_that_drives_is_no_damping_that_depends_on_speed():
    """Less damping for the little speeds of the noise keeps it from simulated taxels: held-out data approve, and the skin knows nothing."""
    sessions = [prepare(pressed_by_force(seed)) for seed in (1, 2, 3)]
    noise = fit_whitener([residual(PLAIN, s) for s in sessions], sessions)
    before = fit(PLAIN, sessions[:2], noise).model
    quiet = PowerDamping("skin", force_sensed=-0.1, exponent=0.5)
    after = fit(before.extended(quiet), sessions[:2], noise).model
    gain = held_out_gain(before, after, sessions[:2], sessions[2:], noise)
    claim = claimed("rate_dependence", gain, sessions[:2], before, after)
    assert gain.passed and of_the_drive(claim) and "noise of that force" in encoder_does(claim, noise, 0.0).because
    assert unread_force(before, "taxel_0", sessions, 0.0) > 0.0
    gain = replace(QUICK, before=0.02, after=0.0195, relative=0.05)
    little = claimed("lag", gain, sessions, before, after)
    assert of_the_drive(little) and not of_the_drive(replace(little, key=("saturation", "")))
    assert not of_the_drive(replace(little, gain=replace(gain, relative=0.3)))
    assert not of_the_drive(replace(little, train=[prepare(recorded(PLAIN))]))


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
    said = hardware_is_off([PositionOffset("rig", offset=-5e-7)], offset)
    assert "0.5 µm" in said.because and "2.5 µm" in said.because
    assert hardware_is_off([PositionOffset("rig", offset=-5e-7)], replace(offset, after=0.0199)) is None
    assert "0.16 ms" in hardware_is_off([TimeShift("clock_depth", delay=-1.6e-4)], offset).because
    assert hardware_is_off([TimeShift("clock_depth", delay=-4e-4)], offset) is None


@pytest.mark.parametrize("holds", [1, 3, 12])
def test_the_depths_at_which_a_record_rests_are_counted(holds):
    """Rests of equal length, between quick lifts into the air; a ramp is at a new depth all the time."""
    x = np.concatenate([np.r_[np.full(1000, 1e-4 * (i + 3)), np.full(50, -1e-4)] for i in range(holds)])
    t = np.arange(x.size) / RATE
    (held, ramp) = (prepare(Recording("r", t, depth, 0.0 * t, 0.0 * t[None])) for depth in (x, np.linspace(0.0, 1e-3, t.size)))
    assert held_depths([held], 1e-6) == pytest.approx(holds, rel=0.25)
    assert held_depths([ramp], 1e-6) > 100.0
    assert held_depths([held], 0.0) == np.inf


@pytest.mark.parametrize(("cause", "enough"), [("nonlinear_stiffness", False), ("stress_relaxation", True)])
def test_a_zero_of_depth_that_nobody_reads_may_bend_a_force_but_relaxes_nothing(cause, enough):
    """Half of a step of 10 µm beside 12 N/mm is 0.06 N, of which a free stiffness leaves half; a taxel beside it knows better."""
    both = prepare(recorded(PLAIN))
    train, squares = [prepare(replace(recorded(PLAIN), taxels=np.empty((0, T.size)), taxel_names=(), taxel_units=()))], 0.04**2
    gain = replace(QUICK, before=float(np.sqrt(0.005**2 + squares)), after=0.005)
    of_force = replace(PLAIN, shares=())
    noise = fit_whitener([residual(of_force, s) for s in train], train)
    assert resolved(claimed(cause, gain, train, of_force, of_force), noise, 10e-6) is enough
    assert resolved(claimed(cause, gain, [both]), WHITE, 10e-6)
