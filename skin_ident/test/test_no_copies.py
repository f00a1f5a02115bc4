"""Hum, a motion that is made exactly again and sensors at rest repeat their numbers through coarse converters, and nothing was copied."""

from dataclasses import replace

import numpy as np
import pytest
from test_faults import session
from test_repeats import read, with_block

from skin_ident.criticism.telemetry.copied import find_copies
from skin_ident.recordings.recording import Recording

STEP = 0.05  # N, of the converter


def pressed(hertz, seconds, noise, seed=0, hum=lambda t: np.zeros((3, 1)), between=0.0):
    """One depth pressed every 10 s and held, seen by an encoder of 1 um, and `hum` on depth, force and taxel; between presses the plunger
    lifts off by up to `between`, m, each time by another height."""
    t = np.arange(int(seconds * hertz)) / hertz
    rng = np.random.default_rng(seed)
    depth = np.interp(t % 10.0, [0.0, 1.0, 3.0, 6.0, 8.0, 10.0], [0.0, 0.0, 0.5e-3, 0.5e-3, 0.0, 0.0])
    height = np.interp(t % 10.0, [0.0, 0.5, 1.0, 8.0, 9.0, 10.0], [1.0, 0.5, 0.0, 0.0, 0.8, 1.0]) * between * (1 + t // 10.0)
    on_depth, *on_forces = hum(t)
    skin = 12e3 * depth + 600.0 * np.gradient(depth, t) * (depth > 0.0)
    forces = [share * skin + on + noise * rng.standard_normal(t.size) for share, on in zip((1.0, 0.7), on_forces, strict=True)]
    force, taxel = (np.round(y / STEP) * STEP for y in forces)
    return Recording("pressed", t, np.round((depth - height + on_depth) / 1e-6) * 1e-6, force, taxel[None])


RATES = [(500.0, 50.0), (1000.0, 50.02), (400.0, 49.99), (350.0, 50.0), (600.0, 60.0), (300.0, 50.01)]  # 6 to 20 samples in a period


def humming(hertz, mains, steps, where):
    def hum(t):
        line, other = (np.sin(2.0 * np.pi * mains * t + phase) for phase in (0.3, 1.0))
        return np.array([3e-6 * line * (where == "all"), steps * STEP * line, 0.8 * steps * STEP * other * (where != "force")])

    r = pressed(hertz, 30.0, 0.08 * STEP, int(steps), hum)
    return Recording(r.name, r.t, None if where == "no depth" else r.depth, r.force, r.taxels)


@pytest.mark.parametrize(("hertz", "mains"), [RATES[i] for i in (1, 3, 5)])
@pytest.mark.parametrize("where", ["force", "all", "no depth"])
def test_hum_through_coarse_steps_is_no_copy(where, hertz, mains):
    """In every hold it goes through the same readings, while the encoder stands still, or hums as well."""
    assert find_copies([humming(hertz, mains, 4.0, where)]) == []


@pytest.mark.parametrize("steps", [2.4, 6.0])
@pytest.mark.parametrize(("hertz", "mains"), [RATES[i] for i in (1, 2, 3, 5)])
def test_weak_and_strong_hum_is_no_copy(hertz, mains, steps):
    assert find_copies([humming(hertz, mains, steps, "force")]) == []


@pytest.mark.parametrize(("hertz", "mains"), [(100.0, 49.9), (160.0, 50.03)])
def test_hum_that_looks_like_noise_in_differences_is_no_copy(hertz, mains):
    """Two to four samples in a period, also at several heights in the air."""
    line = 6.0 * STEP * np.array([0.0, 1.0, 0.0])[:, None]
    found = find_copies([pressed(hertz, 30.0, 0.08 * STEP, 0, lambda t: line * np.sin(2.0 * np.pi * mains * t), 1e-4)])
    assert found == []


@pytest.mark.parametrize(("noise", "seed"), [(0.04, 4), (0.04, 6), (0.06, 4)])
def test_a_motion_that_is_made_exactly_again_is_no_copy(noise, seed):
    """Its depth repeats to the last digit in every cycle, also where coarse forces do not."""
    assert find_copies([pressed(100.0, 60.0, noise * STEP, seed)]) == []


@pytest.mark.parametrize("noise", [1.0, 1.5, 3.0])
def test_a_block_without_a_depth_is_copied_where_noise_exceeds_a_step(noise):
    r = pressed(100.0, 60.0, noise * STEP)
    sound = replace(r, depth=None)
    force, taxels = sound.force.copy(), sound.taxels.copy()
    force[3100:3200], taxels[:, 3100:3200] = force[1000:1100], taxels[:, 1000:1100]
    assert len(find_copies([replace(sound, force=force, taxels=taxels)])) == 1 and find_copies([sound]) == []


def test_of_a_motion_that_is_made_again_a_block_in_noise_is_still_copied():
    noisy = pressed(100.0, 60.0, 4.0 * STEP)
    (symptom,) = find_copies([with_block(noisy, "force", 3150, 60, 1000)])
    assert symptom.where == "load_cell" and find_copies([noisy]) == []


def test_a_block_with_its_moving_depth_is_copied_though_the_converter_is_coarse():
    r = read(session(1), force_step=STEP)
    rows = [np.round(r.depth / 1e-6) * 1e-6, r.force.copy(), np.round(r.taxels / STEP) * STEP]
    for row in rows:
        row[..., 1500:1600] = row[..., 1150:1250]
    (symptom,) = find_copies([Recording(r.name, r.t, *rows)])
    assert "100 samples" in symptom.evidence["why"] and len(symptom.channels) == 1 + len(r.taxels)


def test_two_coarse_taxels_that_rest_in_the_air_are_no_copy_of_each_other():
    """Ten minutes, of which eight seconds pressed; both read no counts in the rest."""
    t, rng = 0.01 * np.arange(60_000), np.random.default_rng(0)
    depth = 0.5e-3 * np.sin(np.pi * (t - 100.0) / 8.0) ** 2 * ((t > 100.0) & (t < 108.0))
    taxels = [np.round(share * 8e4 * depth + 0.08 * rng.standard_normal(t.size)) for share in (0.9, 0.4)]
    force = 12e3 * depth + 0.02 * rng.standard_normal(t.size)
    assert find_copies([Recording("rest", t, depth, force, np.array(taxels))]) == []
