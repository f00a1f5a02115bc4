"""Rigs of one newton: sensors that read little are asked within what they read, and what skin weighs or a late reading does is told apart
from faults of them."""

from dataclasses import replace

import numpy as np
import pytest
from rows import rows

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.telemetry.noise_level import _with_shared, find_noise
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.signals import motion

T = np.arange(6000) / 125.0
SKIN = Dispersion(m=0.0, b1=0.7, k1=150.0, b2=5.5, k2=810.0)
SHARES = (1.0, 0.9, 0.45)
SINES = np.array([[0.13, 0.31, 0.83, 1.7], [0.3, 0.2, 0.08, 0.03]])  # Hz, mm


def session(seed: int, read=lambda y, t: y, m: float = 0.0, late: float = 0.0) -> Recording:
    """A hardly damped skin pressed by 1.4 mm: 1.3 N, a tenth of that in a taxel, noise of a five hundredth; the load cell is `late`, s."""
    rng = np.random.default_rng(seed)
    phases = rng.uniform(0.0, 2.0 * np.pi, (4, 1))

    def pressed(t):
        hz, mm = SINES[:, :, None]
        return motion(t, 1e-3 * (0.8 + (mm * np.sin(2.0 * np.pi * hz * t + phases)).sum(axis=0)))

    model = Model(replace(SKIN, m=m), tuple(np.array(SHARES) / sum(SHARES)))
    taxels = read(model.simulate(pressed(T)).taxels, T)
    force = model.simulate(pressed(T - late)).force
    force, taxels = force + rng.normal(0.0, 2e-3, T.size), taxels + rng.normal(0.0, 2e-4, taxels.shape)
    return Recording(f"s{seed}", T, pressed(T).x, force, taxels)


def told(*recordings: Recording) -> list[set[tuple[str, str]]]:
    """The names of every finding, with its alternatives."""
    findings = diagnose(list(recordings[:-1]), list(recordings[-1:])).findings
    return [{(one["cause"], one["where"]) for one in (f, *f["alternatives"])} for f in findings["findings"]]


def looping(y: np.ndarray, t: np.ndarray) -> np.ndarray:
    """The second taxel with a Bouc-Wen loop that yields at 10 mN, of which 4 % is 0.4 mN."""
    z = np.zeros(t.size)
    for i, step in enumerate(np.diff(y[1])):
        z[i + 1] = z[i] + step - abs(step) * np.sign(z[i]) * (abs(z[i]) / 0.01) ** 1.5 * (step * z[i] > 0.0)
    return y - 0.06 * np.outer([0.0, 1.0, 0.0], z)


@pytest.mark.parametrize("seed", rows([1, 5], 0))
def test_a_loop_of_a_taxel_that_reads_a_tenth_of_a_newton_is_told(seed):
    assert ("hysteresis", "taxel_1") in told(*(session(10 * seed + i, looping) for i in range(3)))[0]


@pytest.mark.parametrize("late", rows([0.016, 0.024], 0))
def test_a_load_cell_that_is_late_is_told_where_damping_cannot_take_it(late):
    """It takes 6 ms, which are the skin's own, and half a sample: beyond, the skin would give back what it never took."""
    (found,) = told(*(session(i, late=late) for i in range(3)))
    assert ("time_shift", "clock") in found


@pytest.mark.parametrize("mass", rows([0.0, 2.2e-3], 0))
def test_what_skin_may_weigh_is_no_cause(mass):
    """Two grams take 20 mN, ten times the noise."""
    assert told(*(session(i, m=mass) for i in range(3))) == []


def test_thresholds_lie_within_what_a_sensor_reads():
    s = prepare(session(1))
    mine = sorted(d.effect.threshold for d in directions(s) if d.key == ("hysteresis", "taxel_1"))
    assert len(mine) == 7 and mine[4] < 0.5 * np.abs(s.raw[2]).max()
    large = prepare(replace(session(1), taxels=100.0 * session(1).taxels))
    assert max(d.effect.threshold for d in directions(large) if d.key == ("hysteresis", "taxel_1")) == 10.0


@pytest.mark.parametrize("grows", [False, True])
def test_noise_grows_with_the_load_not_with_its_own_readings(grows):
    """Of a taxel that feels less than its noise the highest readings are those of the largest noise."""
    rng, load = np.random.default_rng(4), 1e-3 * np.clip(np.sin(0.5 * T), 0.0, None) * (20.0 if grows else 0.3)
    noise = rng.normal(0.0, 6e-4, T.size) * (1.0 + (2.0 * load / load.max() if grows else 0.0))
    taxel = 6.5e-4 * np.round((load + noise) / 6.5e-4)
    declared = Declared(force_noise_n=6e-4, taxel_noise_n=(6e-4,), taxel_step_n=(6.5e-4,))
    r = Recording("a", T, 1e-3 * np.sin(0.5 * T), load, taxel[None], declared=declared)
    left = np.stack([rng.normal(0.0, 6e-4, T.size), taxel - load])
    found = find_noise([r], ("force", "taxel_0"), [left], [np.ones((2, T.size), bool)], lambda: np.zeros(2))
    assert [s.evidence["kind"] for s in found] == ["growth"] * grows


@pytest.mark.parametrize("shared", [0.0, 0.05])
def test_what_several_channels_share_is_the_encoders(shared):
    """It presses on all of them in proportion; a further draw of white noise may tell too little of an encoder whose noise wanders."""
    rng, ratio = np.random.default_rng(2), np.array([1.0, 0.6, 0.3])
    e = np.outer(ratio, shared * rng.standard_normal(4000)) + 0.02 * rng.standard_normal((3, 4000))
    told = _with_shared(1e-3 * ratio, e)
    assert told == pytest.approx(np.maximum(shared, 1e-3) * ratio, rel=0.1 if shared else 3.0)
