"""Frozen samples are found; a force that stands still with the plunger, by play in the drive, has none."""

import numpy as np
import pytest
from scipy.signal import lfilter
from world import make_sessions, write_case

from skin_ident.criticism.record import inspect
from skin_ident.criticism.telemetry.outliers import Said, find_outliers
from skin_ident.recordings.load import load


@pytest.mark.parametrize("taxels", [1, 3])
def test_frozen_runs_are_found(tmp_path, taxels):
    sessions, _ = make_sessions("outliers", "load_cell", "frozen", size=2.0, seed=1, n_sessions=2, n_taxels=taxels, noise="white")
    write_case(sessions, tmp_path)
    assert [(s.cause, s.where) for s in inspect(load(tmp_path)).symptoms] == [("outliers", "load_cell")]


@pytest.mark.parametrize("taxels", [1, 3])
def test_a_plunger_with_play_freezes_nothing(taxels):
    """Triangles of 2 s, at whose reversals the plunger rests for 0.1 s; the simulation knows of no play. Steps of 0.07 N hide the noise."""
    rng, t = np.random.default_rng(2), np.arange(6000) * 0.01
    way = 15.0 - 10.0 * np.abs(t % 2.0 - 1.0)
    rests = np.maximum.accumulate(np.where((t % 1.0 > 0.1) | (t < 1.0), np.arange(t.size), 0))
    share = np.array([1.0, 0.4, 0.3, 0.2])[: taxels + 1, None]
    raw = 0.07 * np.round((share * way[rests] + 0.01 * rng.standard_normal((taxels + 1, t.size))) / 0.07)
    channels = ("force", *(f"taxel_{i}" for i in range(taxels)))
    assert not find_outliers(channels, [Said("a", raw - share * way, raw, np.zeros(t.size, bool))], 0.01)


def _taken_for_outliers(noise: np.ndarray, wrong: np.ndarray, step: float) -> list[str]:
    """The channels told, of a force that rises and falls under `noise` (N,) but stands still where it reads something `wrong`."""
    load = 5.0 + 3.0 * np.sin(np.arange(noise.size) / 200.0)
    raw = np.where(np.isnan(wrong), load + noise, wrong + np.roll(load, 1))
    for i in np.flatnonzero(~np.isnan(wrong)):
        if not np.isnan(wrong[i - 1]):
            raw[i] = raw[i - 1]
    raw = step * np.round(raw / step)
    found = find_outliers(("force",), [Said("a", (raw - load)[None], raw[None], np.zeros(load.size, bool))], 0.01)
    return [c for s in found for c in s.channels]


@pytest.mark.parametrize("seed", range(5))
def test_a_reading_that_stands_still_at_a_wrong_value_is_found_beside_noise_of_any_tail(seed):
    rng = np.random.default_rng(seed)
    wrong = np.full(2000, np.nan)
    for at in rng.choice(np.arange(100, 1900, 40), 3, replace=False):
        wrong[at : at + rng.integers(3, 7)] = rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 0.9)
    assert _taken_for_outliers(0.05 * rng.standard_t(5, 2000), wrong, 0.06) == ["force"]


@pytest.mark.parametrize(("freedom", "colour", "size", "step"), [(3.0, 0.99, 0.02, 0.05), (2.5, 0.995, 0.03, 0.2), (2.2, 0.9, 0.05, 0.3)])
def test_noise_that_wanders_in_jumps_does_not_stand_still(freedom, colour, size, step):
    """Innovations with heavy tails, and a converter coarser than what is between them: plateaus far from where the force was."""
    told = 0
    for seed in range(40):
        innovations = np.random.default_rng(seed).standard_t(freedom, 4000)
        told += bool(_taken_for_outliers(size * lfilter([1.0], [1.0, -colour], innovations), np.full(4000, np.nan), step))
    assert told == 0


def _read(seed: int, step: float, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """A load (N,) that presses and rests, and a reading of it."""
    t = np.arange(4000) * 0.0125
    load = 2.0 + np.clip(2.0 * np.sin(1.3 * t + seed), -1.5, 1.5)
    return load, step * np.round((load + noise * np.random.default_rng(seed).standard_normal(t.size)) / step)


def _told(load: np.ndarray, y: np.ndarray) -> list[str]:
    found = find_outliers(("force",), [Said("a", (y - load)[None], y[None], np.zeros(y.size, bool))], 0.0125)
    return [s.evidence["why"] for s in found]


@pytest.mark.parametrize("seed", range(5))
def test_a_last_value_that_is_sent_once_more_is_found_though_it_misses_little(seed):
    """Lost packets of a tenth of a second: within three widths of the noise, but no noise repeats itself."""
    load, y = _read(seed, 0.004, 0.03)
    for at in np.random.default_rng([seed, 1]).choice(np.arange(100, 3900, 50), 24, replace=False):
        y[at : at + 8] = y[at - 1]
    (why,) = _told(load, y)
    assert "runs of frozen samples" in why


@pytest.mark.parametrize(("step", "noise"), [(0.004, 0.03), (0.03, 0.03), (0.1, 0.03), (0.03, 0.0), (0.004, 0.0)])
def test_a_converter_of_any_step_repeats_what_it_reads(step, noise):
    assert [why for seed in range(20) for why in _told(*_read(seed, step, noise))] == []


def test_wide_steps_of_a_converter_are_no_frozen_runs():
    told = 0
    for seed in range(20):
        load, y = _read(seed, 0.001, 0.005)
        codes = np.cumsum(np.random.default_rng(seed).uniform(0.02, 0.08, 120))
        told += bool(_told(load, codes[np.searchsorted(codes, y)]))
    assert told == 0


@pytest.mark.parametrize("seed", range(5))
def test_a_reading_that_rests_while_the_encoder_trembles_is_not_frozen(seed):
    """Holds of a stage whose encoder steps to and fro by 5 µm, under noise that wanders by less than a converter's step in a second."""
    rng, n = np.random.default_rng(seed), 8000
    stiff, depth = 2500.0, np.repeat(rng.uniform(0.1e-3, 0.3e-3, 16), n // 16)
    depth = np.convolve(np.pad(depth, 50, mode="edge"), np.hanning(101) / 50.0, "valid")
    noise = lfilter([np.sqrt(1.0 - 0.995**2)], [1.0, -0.995], rng.standard_normal(n))
    step = 2e-4
    raw = step * np.round((stiff * depth + 2e-4 * noise) / step)
    simulated = stiff * 5e-6 * np.round(depth / 5e-6 + 0.4 * rng.standard_normal(n))
    assert not find_outliers(("force",), [Said("a", (raw - simulated)[None], raw[None], np.zeros(n, bool))], 0.004, (step,))
