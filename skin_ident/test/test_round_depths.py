"""A stage that stops at round depths, and equal weights on a load cell, show levels that are no converter's; a coarse converter is told in
motion. A press that is rare and quick is no row that a logger repeats."""

import numpy as np
import pytest
from scipy.signal import lfilter

from skin_ident.criticism.telemetry.quantization import depth_step, find_quantization, undeclared_steps
from skin_ident.criticism.telemetry.stalled import find_stalled
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.levels import step_of
from skin_ident.recordings.recording import Recording

MICROMETRE = Declared(encoder_step_um=1.0, force_step_n=0.02, taxel_step_n=(0.02,))
UP_AND_DOWN = np.tile(np.r_[0:11, 9:-1:-1], 3)
ANY_ORDER = np.random.default_rng(0).integers(0, 11, 60)


def rounded(y, step):
    return step * np.round(y / step)


def read(dt, x, force, encoder=1e-6, adc=0.02, noise=0.01, declared=MICROMETRE, seed=0):
    """The session as converters with these steps read it, m and N."""
    rng = np.random.default_rng(seed)
    y = np.array([[1.0], [0.6]]) * force + noise * rng.standard_normal((2, force.size))
    return Recording("a", np.arange(force.size) * dt, rounded(x, encoder), rounded(y[0], adc), rounded(y[1:], 0.02), declared=declared)


def staircase(levels, step, dt, dwell, ramp=0.0):
    """Depth (N,), m, that rests at levels for `dwell`, s, and takes `ramp`, s, from one to the next."""
    x, m = np.repeat(step * levels, round(dwell / dt)), max(round(ramp / dt), 1)
    return lfilter(np.full(m, 1.0 / m), 1.0, x)


def relaxing(force, dt, share=0.5, tau=1.0):
    """Force (N,) that jumps higher by `share` and then relaxes."""
    a = np.exp(-dt / tau)
    return force + share * (force - lfilter([1.0 - a], [1.0, -a], force))


LAWS = {
    "elastic": lambda x, dt: 12e3 * x,
    "stiffening": lambda x, dt: 12e6 * x**2,
    "relaxing": lambda x, dt: relaxing(12e3 * x, dt),
    "read a sample late": lambda x, dt: np.concatenate([[0.0], 12e3 * x[:-1]]),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("levels", [UP_AND_DOWN, ANY_ORDER], ids=["up_and_down", "any_order"])
@pytest.mark.parametrize("step", [2e-5, 1e-4, 2.5e-4])
@pytest.mark.parametrize(("dt", "dwell", "ramp"), [(0.1, 3.0, 0.0), (0.1, 0.5, 0.0), (0.02, 3.0, 0.05), (0.02, 1.0, 0.0), (0.01, 2.0, 0.0)])
def test_round_depths_at_which_a_stage_stops_are_no_steps_of_its_encoder(law, levels, step, dt, dwell, ramp):
    x = staircase(levels, step, dt, dwell, ramp)
    r = read(dt, x, LAWS[law](x, dt))
    assert r.step("depth") > 1.25e-6  # it shows levels
    assert find_quantization([r]) == [] and depth_step([r]) == 1e-6


def test_depths_that_are_not_evenly_round_are_no_uneven_steps():
    depths = np.array([0, 10, 20, 50, 70, 100, 130, 200, 270, 300, 500]) * 1e-6
    x = staircase(depths[UP_AND_DOWN], 1.0, 0.1, 2.0)
    assert find_quantization([read(0.1, np.tile(x, 2), 12e3 * np.tile(x, 2))]) == []


@pytest.mark.parametrize("declared", [Declared(force_step_n=0.01), Declared()])
@pytest.mark.parametrize("dt", [0.1, 0.02])
def test_equal_weights_are_no_steps_of_a_load_cell(dt, declared):
    """Each rests on it long enough for its noise to be below a step."""
    force = np.repeat(0.5 * UP_AND_DOWN, round(2.0 / dt))
    taxels = rounded(0.6 * force + 0.01 * np.random.default_rng(1).standard_normal(force.size), 0.02)[None]
    r = Recording("weights", np.arange(force.size) * dt, None, force, taxels, declared=declared)
    assert r.step("force") == pytest.approx(0.5)
    assert find_quantization([r]) == [] and "force" not in undeclared_steps([r])


MOTIONS = {
    "sine": lambda phase: 5e-4 + 4e-4 * np.sin(2.0 * np.pi * phase),
    "triangle": lambda phase: 9e-4 * np.abs(2.0 * phase - 1.0),
    "holds": lambda phase: 1e-3 * np.interp(phase, [0.0, 0.2, 0.4, 0.7, 0.9, 1.0], [0.0, 0.0, 0.83, 0.83, 0.31, 0.0]),
}


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize(("dt", "hz"), [(0.1, 0.0193), (0.02, 0.0973), (0.02, 0.2437), (0.01, 0.2437), (0.002, 0.9731)])
@pytest.mark.parametrize("step", [5e-5, 1e-4])
def test_coarse_converters_are_told_in_motion(motion, dt, hz, step):
    """No period is a whole number of samples, which would be the same few depths again and again."""
    x = MOTIONS[motion]((np.arange(round(max(120.0 * dt / 0.02, 40.0) / dt)) * dt * hz) % 1.0)
    (encoder,) = find_quantization([read(dt, x, 12e3 * x, encoder=step)])
    assert (encoder.where, encoder.parameters["step"]["value"]) == ("rig", pytest.approx(step))
    (cell,) = find_quantization([read(dt, x, 12e3 * x, adc=12e3 * step)])
    assert (cell.where, cell.parameters["step"]["value"]) == ("load_cell", pytest.approx(12e3 * step))


def test_readings_that_skip_levels_in_fast_motion_are_a_converters():
    x = MOTIONS["sine"](np.arange(4000) * 0.01 * 2.937)
    (encoder,) = find_quantization([read(0.01, x, 12e3 * x, encoder=5e-5)])
    assert encoder.where == "rig"


@pytest.mark.parametrize("ramp", [0.0, 0.3])
@pytest.mark.parametrize("seed", range(3))
def test_rare_presses_of_a_stage_are_no_repeated_rows(seed, ramp):
    """The encoder flickers by a step meanwhile, and nothing else moves in more than a thousandth of the samples."""
    rng = np.random.default_rng(seed)
    x = staircase(np.arange(16) % 2, 5e-4, 0.1, 250.0, ramp)
    r = read(0.1, x + 1e-6 * (rng.random(x.size) < 0.01), 12e3 * x, noise=0.002, seed=seed)
    assert find_stalled([r]) == []


@pytest.mark.parametrize("seed", range(4))
def test_motion_at_one_speed_is_no_step_where_holds_flicker_by_less(seed):
    """A stage at 1 mm/s goes 10 um a sample at 100 Hz, and its encoder reads 1 um."""
    rng = np.random.default_rng(seed)
    way = [-0.8e-3]
    for depth in (0.9e-3, -0.8e-3):
        steps = max(int(abs(depth - way[-1]) / 1e-5), 1)
        way += [*np.linspace(way[-1], depth, steps + 1)[1:], *np.full(1200, depth)]
    y = np.round((np.array(way) + 0.2e-6 * rng.standard_normal(len(way))) / 1e-6) * 1e-6
    assert step_of(y) == pytest.approx(1e-6)
    coarse = np.round(np.array(way) / 1e-5) * 1e-5
    assert step_of(coarse) == pytest.approx(1e-5)
