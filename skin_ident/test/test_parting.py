"""Skin that a fast plunger leaves behind, in a world whose contact is none of the models': force and taxel are cut off at zero, each for
itself, and nothing remembers where the surface was. Written for a rig that samples a thousand times a second, and keeps every tenth."""

from dataclasses import replace

import numpy as np
import pytest
from rows import rows

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.sessions.band import Band
from skin_ident.criticism.sessions.parting import beside_partings, meeting
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.telemetry.quantization import depth_resolution
from skin_ident.estimators.scale import white_noise
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.signals import motion as moved

SKIN = Dispersion(m=0.0, b1=843.0, k1=8529.0, b2=639.0, k2=2623.0)  # thesis Table 4-5: it recovers in 0.13 s
DT, KEPT, LASTS = 1e-3, 10, 24.0
NOISE = 0.02  # N


def motion(i: int) -> np.ndarray:
    """Presses of growing depth, a hold, and a multisine, from air and back into it, m."""
    deep, n = (0.8e-3, 1.0e-3, 1.2e-3)[i], int(LASTS / DT)
    t, part = np.arange(n) * DT, LASTS / 3.0
    presses = 0.5 * deep * (1.0 - np.cos(2.0 * np.pi * (0.5, 0.75, 1.0)[i] * t)) * np.minimum(0.3 + 0.7 * t / part, 1.0)
    hold = 0.7 * deep * np.clip(8.0 * np.minimum(t / part - 1.0, 2.0 - t / part), 0.0, 1.0)
    rng, late = np.random.default_rng(i), t - 2.0 * part
    tones = sum(np.sin(1.4 * np.pi * k * late + rng.uniform(0.0, 2.0 * np.pi)) for k in (1, 2, 3, 5, 7))
    many = deep * (0.6 + 0.1 * tones) * np.clip(2.0 * np.minimum(late, LASTS - t), 0.0, 1.0)
    x = np.select([t < part, t < 2.0 * part], [presses, hold], many)
    rest = np.full(int(1.0 / DT), -0.3e-3)
    way = np.linspace(-0.3e-3, 0.0, int(0.5 / DT))
    x = np.concatenate([rest, way, x, way[::-1], rest])
    return np.convolve(np.pad(x, 25, "edge"), np.ones(51) / 51.0, "valid")


def recorded(i: int, step_um: float = 1.0, trembling: float = 0.0) -> Recording:
    """A session; the encoder's steps are declared, its noise (m rms) is not."""
    x = motion(i)
    v = np.gradient(x, DT)
    sensed, all_of_it = (np.where(x > 0.0, np.maximum(b * v + k * x, 0.0), 0.0)[::KEPT] for b, k in ((843.0, 8529.0), (1482.0, 11152.0)))
    rng, x = np.random.default_rng(40 + i), x[::KEPT]
    force, taxel = (y + NOISE * rng.standard_normal(x.size) for y in (all_of_it, sensed))
    depth = x + trembling * rng.standard_normal(x.size) if trembling else np.round(x * 1e6 / step_um) * step_um * 1e-6
    declared = Declared(encoder_step_um=None if trembling else step_um)
    return Recording(f"press_{i}", np.arange(x.size) * DT * KEPT, depth, force, taxel[None], declared=declared)


def named(outcome) -> list[tuple[str, str]]:
    return [(f["cause"], f["where"]) for f in outcome.findings["findings"]]


def test_numbers_are_found_though_contact_is_another_and_nothing_is_named():
    outcome = diagnose([recorded(i) for i in range(3)])
    found = outcome.baseline.dispersion
    assert (found.b1, found.k1, found.b2, found.k2) == pytest.approx((843.0, 8529.0, 639.0, 2623.0), rel=0.005)
    assert outcome.findings["verdict"] == "nothing_wrong"


@pytest.mark.parametrize(("step_um", "trembling"), rows([(1.0, 1e-6), (5.0, 0.0)], 0))
def test_a_given_model_with_right_numbers_is_not_criticised(step_um, trembling):
    """Neither for the encoder's steps nor for its noise, which a play of a micrometre would keep from the simulation."""
    given = Model(SKIN, shares=(1.0,))
    outcome = diagnose([recorded(i, step_um, trembling) for i in range(3)], model=given)
    assert outcome.findings["verdict"] == "nothing_wrong", named(outcome)
    assert outcome.model.dispersion == SKIN


def test_of_a_given_model_that_is_too_soft_the_numbers_are_wrong_and_nothing_else():
    outcome = diagnose([recorded(i) for i in range(3)], model=Model(replace(SKIN, k1=7000.0), shares=(1.0,)))
    assert named(outcome) == [("parameters", "skin")]
    assert outcome.findings["findings"][0]["parameters"]["k1"]["value"] == pytest.approx(8529.0, rel=0.005)


def test_what_is_left_out_does_not_pass_the_band():
    rng = np.random.default_rng(1)
    y, left_out = rng.standard_normal((2, 3000)), np.zeros(3000, bool)
    left_out[1200:1300] = left_out[2000:2004] = True
    band = Band(0.01).blind(left_out)
    jumped = y + 1e3 * left_out
    assert np.allclose(band.thin(y), band.thin(jumped), atol=1e-9)
    seen = band.sees > 0.9
    assert np.allclose(band.thin(np.full((1, 3000), 3.0))[:, seen], 3.0)
    assert np.array_equal(Band(0.01).blind(np.zeros(3000, bool)).thin(y), Band(0.01).thin(y))
    far = np.abs(band.times(np.arange(3000.0))[:, None] - np.flatnonzero(left_out)).min(axis=1) > band.kernel.size
    assert np.allclose(band.thin(y)[:, far], Band(0.01).thin(y)[:, far])


def test_what_a_band_misses_grows_towards_what_is_left_out():
    """Its lobes of both signs may cancel where they fall on it: that is no sample of which all is seen."""
    left_out = np.arange(3000) >= 1500
    band = Band(0.001).blind(left_out)
    before = band.times(np.arange(3000)) < 1500 - band.kernel.size // 2
    assert np.all(np.diff(band.misses) >= 0.0) and band.misses[-1] == pytest.approx(1.0)
    assert np.allclose(band.misses[before], 0.0) and Band(0.001).misses == 0.0


@pytest.mark.parametrize("seed", range(3))
def test_noise_of_the_depth_is_read_beside_its_motion(seed):
    rng = np.random.default_rng(seed)
    noise = 10.0 ** rng.uniform(-7.0, -5.0)
    x = motion(seed)[::KEPT]
    assert white_noise(x) < 0.02e-6
    trembling = x + noise * rng.standard_normal(x.size)
    assert white_noise(trembling) == pytest.approx(noise, rel=0.1)
    coarse = recorded(seed, step_um=5.0)
    assert depth_resolution([coarse]) == pytest.approx(5e-6, rel=0.2)


@pytest.mark.parametrize(("seconds", "mixed"), [(0.1, True), (8.0, False)])
def test_a_whole_movement_between_two_jumps_is_mixed_with_them(seconds, mixed):
    """Pressed at once a skin says nothing of its movement that the common low-pass could tell from the jump it begins with."""
    t = np.arange(4000) / 200.0
    x = np.interp(t, [1.0, 1.0 + seconds], [-0.5e-3, 1.5e-3])
    force, taxel = (b * np.gradient(x, t) * (x > 0.0) + k * np.maximum(x, 0.0) for b, k in ((1482.0, 11152.0), (843.0, 8529.0)))
    beside = beside_partings(prepare(Recording("pressed", t, x, force, taxel[None])), SKIN)
    moving = (x > 0.1e-3) & (x < 1.4e-3)
    assert beside[moving].all() if mixed else beside[moving].mean() < 0.1
    assert not beside[t > 1.5 + seconds].any()


def test_skin_as_slow_as_a_fit_may_find_it_meets_the_plunger_all_the_same():
    """A test from force to force knows damping by its ratio alone, which may run to its bound: twice of that is no skin."""
    t = np.arange(2000) / 100.0
    frozen = Dispersion(m=0.0, b1=1e9, k1=1e3, b2=0.9e9, k2=1e3)
    assert meeting(moved(t, 1e-3 * np.sin(t)), frozen).any()
