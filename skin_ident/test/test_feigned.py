"""Noise of the encoder feigns causes that smooth it away; more of it tells how much of a gain is feigned."""

import numpy as np
import pytest

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.gates.feigned import feigned
from skin_ident.criticism.gates.gate import held_out_gain
from skin_ident.criticism.gates.resolution import resolved
from skin_ident.criticism.noise.whitening import fit_whitener
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.effects.backlash import Backlash
from skin_models.effects.friction import DahlFriction, Friction
from skin_models.effects.lag import Lag
from skin_models.model import Model
from skin_models.signals import motion

RATE, READ = 100.0, 4e-6  # Hz, m of noise in what an encoder reads
T = np.arange(6000) / RATE
PLAIN = Model(Dispersion(m=0.0, b1=900.0, k1=9000.0, b2=600.0, k2=3000.0), shares=(1.0,))


def recorded(seed: int, rubbing: float = 0.0) -> Recording:
    """Quick loops read with noise; the load cell's guide rubs with so many N."""
    rng = np.random.default_rng(seed)
    quick = np.cumsum(rng.standard_normal(3) + 30.0) / 10.0
    x = 0.5e-3 + sum(a * np.sin(w * T + rng.uniform(0.0, 6.0)) for a, w in zip((0.25e-3, 0.1e-3, 0.03e-3), quick, strict=True))
    truth = PLAIN.simulate(motion(T, x))
    y = np.vstack([truth.force + rubbing * np.sign(np.gradient(x)), truth.taxels]) + 0.01 * rng.standard_normal((2, T.size))
    return Recording("read", T, x + READ * rng.standard_normal(T.size), y[0], y[1:])


def asked(effect, rubbing: float = 0.0):
    """The gain of an effect on a held-out record, what the noise feigns of it, and whether the gain is more than is left open."""
    *train, held = (prepare(recorded(seed, rubbing)) for seed in (1, 2, 3))
    noise = fit_whitener([residual(PLAIN, prepare(recorded(seed))) for seed in (1, 2)], train)
    before = fit(PLAIN, train, noise).model
    after = fit(before.extended(effect), train, noise).model
    gain = held_out_gain(before, after, train, [held], noise)
    told = resolved(gain, effect.cause, before, after, train, noise, np.sqrt(12.0) * READ)
    return gain, feigned(before, after, train, noise, gain.channel), told


@pytest.mark.parametrize("effect", [Lag("load_cell", tau=3e-3), Backlash("rig", gap=5e-6)])
def test_what_smooths_the_noise_of_a_sound_record_is_feigned(effect):
    gain, by_noise, told = asked(effect)
    assert not told and by_noise > 0.6 * gain.squares


@pytest.mark.parametrize("effect", [Friction("load_cell", force=0.01), DahlFriction("load_cell", force=0.01)])
def test_friction_of_half_that_noise_is_not(effect):
    gain, by_noise, told = asked(effect, rubbing=0.03)
    assert gain.passed and told and by_noise < 0.2 * gain.squares
    assert gain.squares < (0.5 * gain.before) ** 2
