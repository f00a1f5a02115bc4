"""Errors of the encoder feign causes that make up for them; records with further errors tell how much of what is explained is feigned."""

import numpy as np
import pytest

from skin_ident.criticism.baseline.fitting import cost_of, fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.gates.claim import Claim
from skin_ident.criticism.gates.feigned import by_noise, by_steps
from skin_ident.criticism.gates.gate import held_out_gain
from skin_ident.criticism.gates.resolution import resolved
from skin_ident.criticism.noise.whitening import fit_whitener
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.effects.backlash import Backlash
from skin_models.effects.friction import DahlFriction, Friction
from skin_models.effects.hysteresis import SensorHysteresis
from skin_models.effects.lag import Lag
from skin_models.model import Model
from skin_models.signals import motion

RATE = 100.0  # Hz
NOISY, STEPPED = (4e-6, 0.0), (0.0, 8e-6)  # m of noise, and of a step, in what an encoder reads
T = np.arange(6000) / RATE
PLAIN = Model(Dispersion(m=0.0, b1=900.0, k1=9000.0, b2=600.0, k2=3000.0), shares=(1.0,))


def recorded(seed: int, encoder: tuple[float, float], rubbing: float = 0.0) -> Recording:
    """Loops and rests as an encoder reads them; the load cell's guide rubs with so many N."""
    rng, (noise, step) = np.random.default_rng(seed), encoder
    quick = np.cumsum(rng.standard_normal(3) + 30.0) / 10.0
    x = 0.5e-3 + sum(a * np.sin(w * T + rng.uniform(0.0, 6.0)) for a, w in zip((0.25e-3, 0.1e-3, 0.03e-3), quick, strict=True))
    x = np.where(T % 12.0 > 8.0, x[np.searchsorted(T, T - T % 12.0 + 8.0)], x)
    truth = PLAIN.simulate(motion(T, x))
    y = np.vstack([truth.force + rubbing * np.sign(np.gradient(x)), truth.taxels]) + 0.01 * rng.standard_normal((2, T.size))
    read = x + noise * rng.standard_normal(T.size)
    return Recording("read", T, step * np.round(read / step) if step else read, y[0], y[1:])


def asked(effect, encoder, rubbing: float = 0.0):
    """What an effect explains of two records, what errors feign of that, the gain on a third, and whether it is more than is left open."""
    *train, held = (prepare(recorded(seed, encoder, rubbing)) for seed in (1, 2, 3))
    noise = fit_whitener([residual(PLAIN, prepare(recorded(seed, encoder))) for seed in (1, 2)], train)
    before = fit(PLAIN, train, noise).model
    after = fit(before.extended(effect), train, noise).model
    explained = cost_of(before, train, noise) - cost_of(after, train, noise)
    gain = held_out_gain(before, after, train, [held], noise)
    claim = Claim(effect.key, gain, before, after, train)
    told = resolved(claim, noise, float(np.hypot(np.sqrt(12.0) * encoder[0], encoder[1])))
    by_encoder = by_noise(before, after, train, noise, explained) + by_steps(before, after, train, noise, encoder[1])
    return explained, by_encoder, gain, told


@pytest.mark.parametrize("encoder", [NOISY, STEPPED])
@pytest.mark.parametrize("effect", [Lag("load_cell", tau=3e-3), Backlash("rig", gap=5e-6), SensorHysteresis("load_cell", relative=0.01)])
def test_what_makes_up_for_the_encoder_of_a_sound_record_is_no_finding(effect, encoder):
    explained, by_encoder, gain, told = asked(effect, encoder)
    assert not (told and gain.passed) and explained < 10.0 * by_encoder


@pytest.mark.parametrize("encoder", [NOISY, STEPPED])
@pytest.mark.parametrize("effect", [Friction("load_cell", force=0.01), DahlFriction("load_cell", force=0.01)])
def test_friction_of_half_of_what_it_leaves_open_is_one(effect, encoder):
    explained, by_encoder, gain, told = asked(effect, encoder, rubbing=0.03)
    assert told and explained > 5.0 * by_encoder
    assert gain.squares < (0.5 * gain.before) ** 2
