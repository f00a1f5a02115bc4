"""A zero or a slope that wanders smoothly is told from noise of long memory, from the skin, and from what moves with the plunger."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from world import make_sessions, write_case

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.courses.carriers import ZERO
from skin_ident.criticism.courses.waves import EXCESS, LOW, _line, find_wave, run_of
from skin_ident.criticism.noise.whitening import white
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.wandering import take_wave
from skin_ident.criticism.sessions.parting import without_parting
from skin_ident.criticism.sessions.session import prepare, with_reference
from skin_ident.recordings.load import load

HIGH = 50
SESSIONS, SAMPLES = 3, 1200


def excess(rows):
    """Over the line of noise, of the session where it is least."""
    k = np.arange(1, HIGH + 1)
    cosines = np.cos(np.pi * k[:, None] * np.linspace(0.0, 1.0, rows.shape[1]))
    squares = ((rows - rows.mean(axis=1, keepdims=True)) @ cosines.T) ** 2
    return float(np.min(np.mean(squares[:, :LOW] / _line(squares, LOW), axis=1)))


NOISES = {
    "white": lambda w: w,
    "ar_0.9": lambda w: lfilter([1.0], [1.0, -0.9], w),
    "ar_0.98": lambda w: lfilter([1.0], [1.0, -0.98], w),
    "ar_0.995": lambda w: lfilter([1.0], [1.0, -0.995], w),
    "random_walk": lambda w: np.cumsum(w, axis=1),
    "random_walk_in_white": lambda w: w + 0.05 * np.cumsum(w[:, ::-1], axis=1),
    "pink": lambda w: np.fft.irfft(np.fft.rfft(w) / np.sqrt(np.maximum(np.arange(w.shape[1] // 2 + 1), 1.0)), w.shape[1]),
}


@pytest.mark.parametrize("kind", NOISES)
def test_noise_of_whatever_memory_is_below_the_line(kind):
    rng = np.random.default_rng(7)
    assert max(excess(NOISES[kind](rng.standard_normal((SESSIONS, SAMPLES)))) for _ in range(60)) < EXCESS[ZERO]


@pytest.mark.parametrize("periods", [0.35, 0.7])
def test_a_sine_as_large_as_the_noise_is_above_it(periods):
    rng = np.random.default_rng(8)
    phases = np.arange(SESSIONS)[:, None]
    sine = np.sqrt(2.0) * np.sin(2.0 * np.pi * np.linspace(0.0, 1.0, SAMPLES) / periods + phases)
    assert np.median([excess(sine + rng.standard_normal((SESSIONS, SAMPLES))) for _ in range(20)]) > EXCESS[ZERO]


def wandering(s, phase, *channels):
    wave = np.sin(2.0 * np.pi * (s.t - s.t[0]) / (0.6 * np.ptp(s.t)) + phase)
    force = s.force + 0.01 * np.abs(s.force).max() * wave * ("force" in channels)
    taxels = s.taxels + 0.01 * np.abs(s.taxels).max() * wave[:, None] * ("taxels" in channels)
    return replace(s, force=force, taxels=taxels)


def found(folder, *channels):
    made, _ = make_sessions(None, seed=71, n_sessions=3, noise="white")
    write_case([wandering(s, 1.3 * i, *channels) for i, s in enumerate(made)], folder)
    sessions = with_reference([prepare(r) for r in load(folder)])
    start = dispersion_start(sessions[:2], 0.0)
    sessions = [without_parting(s, start.dispersion) for s in sessions]
    model = fit(start, sessions[:2], white([residual(start, s) for s in sessions[:2]])).model
    noise = white([residual(model, s) for s in sessions[:2]])
    return find_wave(model, sessions[:2], sessions[2:], noise), model, sessions


def test_a_zero_that_wanders_is_found_and_said_for_each_session(tmp_path):
    (wave, gain), model, sessions = found(tmp_path, "force")
    assert wave.course.key == ("drift", "load_cell") and gain.channel == "force" and gain.ci95[0] > 0.0
    said = run_of(wave, model, sessions, 0.0).said
    assert len(said) == 3 and all("wanders from" in words for words in said.values())


@pytest.mark.parametrize(("times", "named"), [(2.0, True), (20.0, False)])
def test_a_wave_beside_a_far_larger_effect_of_its_channel_is_what_that_leaves(tmp_path, times, named):
    (_, gain), model, sessions = found(tmp_path, "force")
    search = Search(sessions[:2], sessions[2:], (), lambda stage: None)
    search.noise = white([residual(model, s) for s in sessions[:2]])
    search.present = fit(model, sessions[:2], search.noise)
    before = np.sqrt(gain.after**2 + times * gain.squares)
    search.named = [Named("hysteresis", "load_cell", replace(gain, before=float(before)), 1e4, ())]
    assert take_wave(search) == named and len(search.named) == 1 + named


def test_what_wanders_in_all_channels_alike_is_no_sensor(tmp_path):
    assert found(tmp_path, "force", "taxels")[0] is None


def test_nothing_wanders_in_sound_sessions(tmp_path):
    assert found(tmp_path)[0] is None
