"""Effects of rig, sensors and clock against what their equations say where that can be worked out by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp, trapezoid
from scipy.signal import lsim

from skin_models.catalogue import effects
from skin_models.effects.backlash import Backlash, SlackEncoder, WindUp, ZeroedBacklash
from skin_models.effects.crosstalk import Crosstalk
from skin_models.effects.drift import Creep, LogDrift, LogGainDrift, WarmingUp
from skin_models.effects.gain_error import GainStep
from skin_models.effects.hysteresis import LoadedSensorHysteresis, SensorHysteresis
from skin_models.effects.lag import AveragedLag, Lag, OneSidedLag, SecondOrderLag
from skin_models.effects.mount_compliance import JointedMount, MountCompliance, PowerMount
from skin_models.effects.quantization import SensorQuantization
from skin_models.effects.time_shift import Scanning, SkewedClock, TimeShift
from skin_models.operators.elapsed import Elapsed
from skin_models.operators.play import play
from skin_models.signals import motion

MM = 1e-3


def at_times(x, dt=1e-3):
    return motion(np.arange(len(x)) * dt, np.asarray(x, float))


def triangle(depths, samples=400):
    corners = np.asarray(depths, float)
    return np.interp(np.linspace(0, corners.size - 1, samples * (corners.size - 1) + 1), np.arange(corners.size), corners)


def test_loops_of_a_sensor_under_a_load_are_as_high_as_the_load():
    loops = LoadedSensorHysteresis(where="taxel", relative=0.3, threshold=0.1, growth=1.0)
    plain = SensorHysteresis(where="taxel", relative=0.3, threshold=0.1)
    areas = []
    for middle in (2.0, 4.0):
        y = triangle([middle + d for d in (-1.0, 1.0, -1.0, 1.0, -1.0)])[None]
        areas.append([trapezoid(e.batch(y, at_times(y[0]))[0, 800:], y[0, 800:]) for e in (loops, plain)])
    (lower, flat), (higher, same) = areas
    assert same == pytest.approx(flat) and higher / lower == pytest.approx(2.0, rel=0.02) and lower / flat == pytest.approx(2.0, rel=0.02)


def test_backlash_swallows_the_first_part_of_a_reversal():
    gap = 0.2 * MM
    tip = Backlash(where="rig", gap=gap).batch(triangle([0.0, 2 * MM, MM]), None)
    assert tip[400] == pytest.approx(2 * MM - gap / 2)
    assert tip[400:480] == pytest.approx(tip[400]) and tip[-1] == pytest.approx(MM + gap / 2)


def test_a_drive_that_winds_up_loses_the_same_depth_over_a_way():
    gap, way = 0.2 * MM, 0.05 * MM
    x = triangle([0.0, 2 * MM, MM])
    tip = WindUp(where="rig", gap=gap, distance=way).batch(x, None)
    assert tip[400] == pytest.approx(2 * MM - gap / 2) and tip[-1] == pytest.approx(MM + gap / 2)
    back = x[400] - x[400:]
    assert x[400:] - tip[400:] == pytest.approx(gap * np.exp(-back / way) - gap / 2)


def test_what_a_slack_encoder_loses_is_given_back_but_for_the_crossing():
    gap = 0.2 * MM
    tip = triangle([0.0, 2 * MM, MM])
    reading = play(tip, gap / 2)
    found = SlackEncoder(where="rig", gap=gap, distance=1e-7).batch(reading, at_times(tip))
    read = np.flatnonzero(np.diff(reading, prepend=reading[0]))
    assert found[read] == pytest.approx(tip[read], abs=1e-7) and read.size > 600
    assert found[401:480] == pytest.approx(2 * MM), "it crosses when the reading moves"
    ahead = SlackEncoder(where="rig", gap=gap, distance=1e-7, lead=0.08).batch(reading, at_times(tip))
    assert ahead[402:480] == pytest.approx(2 * MM - gap), "or so long before"


def test_drift_counts_from_the_first_sample_whatever_the_clock_says():
    x, y = np.zeros(1001), np.full(1001, 2.0)
    for cls in (c for c in effects() if issubclass(c, Elapsed)):
        now, then = at_times(x, 0.1), motion(1.7e9 + np.arange(1001) * 0.1, x)
        e = cls.typical(next(iter(cls.places)))
        assert e.batch(y, now) == pytest.approx(e.batch(y, then), abs=1e-4)
    s = at_times(x, 0.1)
    zero = LogDrift(where="load_cell", per_decade=0.2, tau=0.1).batch(y, s) - y
    assert (zero[99], zero[999]) == pytest.approx((0.4, 0.6), abs=1e-3)
    assert LogGainDrift(where="load_cell", per_decade=0.1, tau=0.1).batch(y, s)[99] == pytest.approx(2.0 * 1.2, abs=1e-3)
    assert WarmingUp(where="load_cell", change=0.2, tau=10.0).batch(y, s)[[0, 100]] - 2.0 == pytest.approx(
        [0.0, 0.2 * (1.0 - np.exp(-1.0))]
    )
    step = GainStep(where="load_cell", gain=0.5, after=50.0).batch(y, s)
    assert np.array_equal(np.unique(step), [2.0, 3.0]) and step[499] == 2.0 and step[501] == 3.0


def test_a_lag_follows_a_ramp_at_its_time_constant():
    t, tau = np.arange(0.0, 2.0, 0.01), 0.1
    out = Lag(where="load_cell", tau=tau).batch(3.0 * t, at_times(np.zeros(t.size), 0.01))
    assert out == pytest.approx(3.0 * (t - tau * -np.expm1(-t / tau)), abs=1e-12)


@pytest.mark.parametrize("tau", [0.0004, 0.0125, 0.0333])
def test_an_average_is_late_by_half_its_window_and_takes_out_what_fits_into_it(tau):
    lag = AveragedLag(where="load_cell", tau=tau)
    t = np.arange(1000) * 1e-3
    ramp, hum = np.array([[0.0]]) + t, np.sin(2 * np.pi * t / (2 * tau))[None]
    np.testing.assert_allclose(lag.batch(ramp, at_times(t))[0, 100:], t[100:] - tau, atol=1e-12)
    if tau > 2e-3:  # sampled finely enough to be drawn by straight lines
        assert np.abs(lag.batch(hum, at_times(t))[0, 100:]).max() < 0.01


def test_a_one_sided_lag_follows_a_ramp_up_sooner_than_one_down():
    tau, recovery, t = 0.03, 4.0, np.arange(400) * 0.01
    lag = OneSidedLag(where="taxel", tau=tau, recovery=recovery)
    ramps = np.array([5.0 + 3.0 * t, 5.0 - 3.0 * t])
    late = (ramps - lag.batch(ramps, at_times(np.zeros(t.size), 0.01)))[:, -1] / 3.0
    assert late == pytest.approx([tau / 2.0, -2.0 * tau], rel=1e-6)
    alike = OneSidedLag(where="taxel", tau=tau, recovery=1.0).batch(np.sin(ramps), at_times(np.zeros(t.size), 0.01))
    assert alike == pytest.approx(Lag(where="taxel", tau=tau).batch(np.sin(ramps), at_times(np.zeros(t.size), 0.01)), abs=1e-12)


@pytest.mark.parametrize("damping", [0.3, 0.7071, 1.0, 3.0])
def test_a_second_order_lag_is_the_filter_of_its_transfer_function(damping):
    t, tau = np.arange(0.0, 3.0, 0.01), 0.1
    y = np.interp(t, [0.0, 0.2, 0.5, 1.0, 1.5, 3.0], [0.0, 0.0, 2.0, -1.0, 3.0, 3.0])
    _, expected, _ = lsim(([1.0], [(tau / (2.0 * damping)) ** 2, tau, 1.0]), y, t)
    lag = SecondOrderLag(where="load_cell", tau=tau, damping=damping)
    assert lag.batch(y, at_times(np.zeros(t.size), 0.01)) == pytest.approx(expected, abs=1e-9)
    late = lag.batch(5.0 + 3.0 * t, at_times(np.zeros(t.size), 0.01))
    assert late[-1] == pytest.approx(5.0 + 3.0 * (t[-1] - tau), abs=5e-3)  # late by tau, at rest before


def test_creep_goes_on_under_load_and_comes_back_without():
    t = np.arange(0.0, 200.0, 0.1)
    y = np.where((t > 50.0) & (t <= 100.0), 4.0, 0.0)
    out = Creep(where="taxel", creep=0.05, tau=8.0).batch(y[None], at_times(np.zeros(t.size), 0.1))[0] - y
    held = (t > 51.0) & (t < 99.0)
    assert out[held] == pytest.approx(0.2 * -np.expm1(-(t[held] - 50.05) / 8.0), abs=2e-4)
    assert out[t < 50.0] == pytest.approx(0.0) and abs(out[-1]) < 1e-5


def test_a_delay_and_a_skew_shift_a_line_exactly():
    t = np.arange(0.0, 20.0, 0.01)
    s, line = at_times(np.zeros(t.size), 0.01), np.array([5.0 * t, -t])
    late = SkewedClock(where="clock_taxels", delay=0.0334, skew=1000.0).batch(line, s)
    assert late[:, 10:] == pytest.approx(np.array([[5.0], [-1.0]]) * (t - 0.0334 - 1e-3 * t)[10:])
    early = TimeShift(where="clock_taxels", delay=-0.0334).batch(line, s)
    assert early[0, :-10] == pytest.approx(5.0 * (t + 0.0334)[:-10])


@pytest.mark.parametrize("per_taxel", [0.0125, -0.004])
def test_taxels_that_are_read_in_turn_are_each_later_than_the_one_before(per_taxel):
    s = at_times(np.zeros(200))
    t = np.arange(200) * s.dt
    rows = np.stack([np.sin(3.0 * t), 2.0 * np.sin(3.0 * t), np.cos(5.0 * t)])
    read = Scanning(where="clock_taxels", per_taxel=per_taxel).batch(rows, s)
    for i, (row, late) in enumerate(zip(rows, read, strict=True)):
        assert np.allclose(late, np.interp(t - i * per_taxel, t, row))


def test_a_running_simulation_passes_an_early_channel_on():
    e, s = TimeShift(where="clock", delay=-0.03), at_times(np.zeros(5))
    state = e.initial()
    for i in range(5):
        state, y = e.step(state, float(i), s[i], s.dt)
        assert y == i


def test_crosstalk_takes_the_mean_of_the_neighbours():
    y = np.array([1.0, 10.0, 100.0])
    assert Crosstalk(where="taxel", share=0.1).apply(y, None) == pytest.approx([2.0, 15.05, 101.0])
    assert Crosstalk(where="taxel", share=0.1).apply(np.array([7.0]), None) == pytest.approx([7.0])


def test_mount_and_skin_are_springs_in_series():
    stiffness, compliance, x = 8000.0, 2e-5, np.array([-MM, MM])
    tip = MountCompliance(where="rig", compliance=compliance, stiffness=stiffness).apply(x, None)
    assert tip == pytest.approx([-MM, MM / (1.0 + compliance * stiffness)])
    assert x[1] - tip[1] == pytest.approx(compliance * stiffness * tip[1])


@given(give=st.floats(1e-9, 1e-3), closing=st.floats(1e-6, 1e-2))
def test_a_joint_gives_with_the_logarithm_of_the_force(give, closing):
    x = np.linspace(-MM, 3 * MM, 50)
    tip = JointedMount(where="rig", give=give, closing=closing).apply(x, None)
    pressed = x > 0.0
    assert np.array_equal(tip[~pressed], x[~pressed])
    assert (tip + give * np.log1p(np.maximum(tip, 0.0) / closing))[pressed] == pytest.approx(x[pressed], rel=1e-9)
    assert (np.diff(tip) > 0.0).all() and (tip[pressed] <= x[pressed]).all()


@pytest.mark.parametrize("give", [2e-6, 10e-6])
def test_a_ball_gives_by_two_thirds_of_the_power_of_the_force_of_skin_behind_it(give):
    """Beside both in series, x = tip + L (u / 1 mm)^p under u = tip + T tip', to less than a tenth of what the ball gives."""
    recovery, p, t = 0.1, 2 / 3, np.linspace(0.0, 0.8, 400)

    def depth(at):
        return MM * np.sin(np.pi * at / 0.8) ** 2 + 0.02 * MM

    def speed(at, tip):
        return (MM * (np.maximum(depth(at) - tip, 0.0) / give) ** (1 / p) - tip) / recovery

    start = depth(0.0) - give * (depth(0.0) / MM) ** p
    true = solve_ivp(speed, (0.0, t[-1]), [start], "Radau", t, rtol=1e-8, atol=1e-12).y[0]
    s = motion(t, depth(t))
    tip = PowerMount(where="rig", give=give, recovery=recovery).apply(s.x, s)
    loaded = s.x + recovery * s.v > 0.1 * MM
    assert np.abs(tip - true)[loaded].max() < 0.1 * give and np.abs(s.x - true)[loaded].max() > 0.8 * give
    assert PowerMount(where="rig", give=give).apply(-s.x, s) == pytest.approx(-s.x)


def test_quantized_readings_are_multiples_of_the_step():
    y = np.linspace(-3.0, 3.0, 777)
    out = SensorQuantization(where="load_cell", step_force=0.07).apply(y, None)
    assert np.abs(out - y).max() <= 0.035 + 1e-12 and np.abs(out / 0.07 - np.round(out / 0.07)).max() < 1e-9


def test_a_rig_that_was_zeroed_by_touching_loses_depth_on_the_way_out_alone():
    x = 1e-3 * triangle([0, 1, 0, 1])
    tip = ZeroedBacklash(where="rig", gap=0.1e-3, zero=1.0).batch(x, at_times(x))
    way = np.sign(np.diff(x, prepend=-1.0))
    settled = np.abs(x - 0.5e-3) < 0.3e-3
    assert (tip - x)[settled & (way > 0)] == pytest.approx(0.0, abs=1e-12)
    assert (tip - x)[settled & (way < 0)] == pytest.approx(0.1e-3, abs=1e-12)
