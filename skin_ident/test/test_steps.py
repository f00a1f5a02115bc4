"""Where a step would explain most: the adjoint of the whitening, and steps hidden in strongly coloured noise."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from skin_ident.criticism.noise.growth import Growth
from skin_ident.criticism.noise.steps import sharpest
from skin_ident.criticism.noise.whitening import Given, fit_whitener


def coloured(rng, channels=2, n=1500, pole=0.99):
    """AR(1) noise of unit size, partly shared by the channels."""
    shared, own = (lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], rng.standard_normal((c, n))) for c in (1, channels))
    return 0.6 * shared + 0.8 * own


def seen(weight, load=0.0, t=None):
    """A session, of which the noise model looks at nothing else."""
    return SimpleNamespace(weight=weight, load=np.broadcast_to(load, weight.shape), t=t)


@pytest.mark.parametrize("seed", range(3))
def test_the_adjoint_is_one(seed):
    rng = np.random.default_rng(seed)
    e, w = rng.standard_normal((2, 2, 300))
    session = seen((rng.random((2, 300)) > 0.05).astype(float), load=np.abs(np.sin(0.02 * np.arange(300))))
    noise = replace(fit_whitener([coloured(rng, n=300)], [session]), growth=Growth(np.array([0.7, 3.0]), np.array([1.0, 0.5])))
    there, back = noise.apply(e, session), noise.turned(w, session)
    rounding = 1e-6 * np.linalg.norm(there) * np.linalg.norm(w)  # poles as near to one as these leave seven digits
    assert np.sum(there * w) == pytest.approx(np.sum(e * back), abs=rounding)


@pytest.mark.parametrize("seed", range(5))
def test_a_step_smaller_than_the_noise_is_found_to_the_sample(seed):
    """Noise of AR(0.99) is worth a seventh of its size from sample to sample; a grid of seconds would miss what is plain there."""
    rng = np.random.default_rng(100 + seed)
    t = np.arange(1500) / 25.0
    at = rng.uniform(8.0, 52.0)
    carrier = np.array([1.0 + 0.5 * np.sin(t), 0.7 * np.ones(t.size)])
    plain = coloured(rng)
    session = seen(np.ones(plain.shape), t=t)
    noise = fit_whitener([plain], [session])
    r = noise.apply(plain + 0.8 * carrier * (t >= at), session)
    moments = sharpest(carrier, r, session, noise, most=3)
    assert np.min(np.abs(moments - at)) <= 1.0 / 25.0


def test_a_step_is_found_where_the_noise_is_white_and_there_is_no_filter():
    rng = np.random.default_rng(7)
    t = np.arange(300) / 25.0
    plain, carrier = rng.standard_normal((2, 300)), np.ones((2, 300))
    session = seen(np.ones(plain.shape), t=t)
    noise = fit_whitener([plain], [session], given=Given(order=0))
    moments = sharpest(carrier, noise.apply(plain + 3.0 * (t >= 6.0), session), session, noise, most=1)
    assert moments == pytest.approx([6.0], abs=0.1)
