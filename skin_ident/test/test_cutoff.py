"""The band of a comparison ends where an encoder's steps and noise are more of the motion than the motion."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.sessions.band import CUTOFF_HZ
from skin_ident.criticism.sessions.cutoff import LOWEST_HZ, common_to, cutoff_for, dilution
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.signals import motion

SKIN = Model(Dispersion(m=0.000432, b1=913.6, k1=9549.7, b2=635.1, k2=2879.4), shares=(1.0,))
T = np.arange(4000) / 100.0


def slow(seed=0, step=5e-6, hertz=0.11):
    """A sine read in steps, under noise that wanders."""
    x = 0.42e-3 * (1.0 - np.cos(2.0 * np.pi * (hertz + 0.02 * seed) * T))
    rng, out = np.random.default_rng(seed), SKIN.simulate(motion(T, x))
    force, taxels = (y + lfilter([0.025], [1.0, -0.97], rng.standard_normal(y.shape)) for y in (out.force, out.taxels))
    return Recording(f"slow_{seed}", T, np.round(x / step) * step if step else x, force, taxels)


def quick(step):
    x = 0.42e-3 * (1.0 - np.cos(2.0 * np.pi * 3.0 * T))
    return Recording("quick", T, np.round(x / step) * step, np.zeros(T.size), np.zeros((1, T.size)))


def test_a_quick_motion_bears_the_whole_band_and_a_slow_one_that_is_read_finely():
    assert cutoff_for([quick(20e-6)], 20e-6) == CUTOFF_HZ
    assert cutoff_for([slow(step=1e-8)], 1e-8) == CUTOFF_HZ
    assert cutoff_for([slow(step=0.0)], 0.0) == CUTOFF_HZ


def test_the_coarser_a_slow_motion_is_read_the_narrower_the_band():
    edges = [cutoff_for([slow(step=step)], step) for step in (0.2e-6, 1e-6, 5e-6, 20e-6)]
    assert edges == sorted(edges, reverse=True) and CUTOFF_HZ > edges[2] >= edges[3] >= LOWEST_HZ


def test_a_short_recording_keeps_enough_samples():
    short = slow(step=20e-6).part(0, 1500)
    assert cutoff_for([short], 20e-6) > cutoff_for([slow(step=20e-6)], 20e-6)


@pytest.mark.parametrize("seed", [0, 10])
def test_damping_is_not_lost_in_the_steps_of_an_encoder(seed):
    """Whitened over the whole band it is found at a quarter, and a mount or relaxation are named for the rest."""
    outcome = diagnose([slow(seed), slow(seed + 1)], [slow(seed + 2)])
    skin = outcome.baseline.dispersion
    assert skin.b1 + skin.b2 == pytest.approx(913.6 + 635.1, rel=0.12)
    assert outcome.findings["verdict"] == "nothing_wrong"


def trembling(r, noise=4e-6):
    """The same record by an encoder with white noise."""
    read = r.depth + noise * np.random.default_rng(len(r.name)).standard_normal(T.size)
    return replace(r, depth=read)


def test_noise_of_the_encoder_narrows_the_band_of_a_slow_motion_as_steps_as_loud_do():
    as_loud = np.sqrt(12.0) * 4e-6
    by_noise, by_steps = cutoff_for([trembling(slow(step=0.0), 4e-6)], 0.0), cutoff_for([slow(step=as_loud)], as_loud)
    assert by_noise < CUTOFF_HZ and by_noise == pytest.approx(by_steps, rel=0.2)
    assert cutoff_for([trembling(quick(1e-7), 4e-6)], 1e-7) == CUTOFF_HZ


@pytest.mark.parametrize("seed", [0, 10])
def test_damping_is_not_lost_in_the_noise_of_an_encoder(seed):
    every = [trembling(slow(seed + i, step=0.0)) for i in range(3)]
    outcome = diagnose(every[:2], every[2:])
    skin = outcome.baseline.dispersion
    assert skin.b1 + skin.b2 == pytest.approx(913.6 + 635.1, rel=0.12)
    assert outcome.findings["verdict"] == "nothing_wrong"


def test_what_is_left_of_the_noise_in_the_band_is_told():
    """Little of a quick motion; of a slow one about what the lowest end of the band lets in."""
    by_slow, by_quick = (dilution([prepare(r, common=common_to([r], 0.0))]) for r in map(trembling, (slow(step=0.0), quick(1e-7))))
    assert 1e-3 < by_slow < 0.1 and by_quick < 1e-3
    assert dilution([prepare(slow(step=1e-8))]) < 1e-4
