"""Effects many times as large as the noise: named alone, though a first fit leaves much that looks like faults of the record."""

import numpy as np
import pytest
from rows import rows

from skin_ident.criticism.telemetry.excursions import excursions
from skin_ident.criticism.telemetry.outliers import Said, find_outliers
from skin_ident.hiding.campaign import Case, result
from skin_ident.recordings.recording import Recording

LARGE = [
    ("backlash", 30.0), ("backlash", 5.0), ("stress_relaxation", 30.0), ("rate_dependence", 5.0), ("nonlinear_stiffness", 5.0),
    ("mount_compliance", 5.0), ("drift", 30.0), ("saturation", 30.0), ("friction", 20.0),
]  # fmt: skip


@pytest.mark.parametrize(("cause", "size"), rows(LARGE, 0))
def test_a_large_effect_is_named_alone(cause, size):
    r = result(Case(cause, size, 0))
    assert r["named"] == [(cause, r["where"])] and r["verdict"] == "explained"
    assert r["over_oracle"] is None or r["over_oracle"] < 1.1


def noisy(seed=0, n=4000):
    return 0.02 * np.random.default_rng(seed).standard_normal(n)


def found(wrong, model, jumps):
    e = noisy() + wrong
    return find_outliers(("force",), [Said("a", e[None], (model + e)[None], jumps)], 0.01)


def test_a_push_that_the_model_smooths_is_no_excursion():
    """A plunger that hurries on by 50 µm between two samples pushes for that time; of a smoothed depth it pushes less, and for longer."""
    model, push = np.zeros(4000), np.zeros(4000)
    model[1998:2003] += [0.4, 0.8, 1.0, 0.8, 0.4]
    push[2000] += 2.0
    assert not excursions(push + noisy(), model + push + noisy(), 0.5).any()
    assert excursions(push + noisy(), push + noisy(), 0.5).any()


def test_a_halt_on_the_way_in_is_no_excursion():
    """A plunger that halts for one sample between two ramps pushes less for that long, while the force goes on rising with depth."""
    model, push = 0.12 * np.arange(200.0), np.zeros(200)
    model[97:104] -= [0.0, 0.2, 0.5, 0.6, 0.5, 0.2, 0.0]
    push[100] -= 1.2
    assert not excursions(push + noisy(n=200), model + push + noisy(n=200), 0.5).any()


def test_pushes_of_a_mass_are_no_outliers():
    """A load cell that carries a kilogram is pushed for a sample where the plunger starts and stops; spikes come whenever they like."""
    at = np.arange(100, 4000, 300)
    speed = 5e-5 * (np.searchsorted(at, np.arange(4000)) % 2)
    path = np.cumsum(speed) + 3e-7 * np.random.default_rng(1).standard_normal(4000)
    e, later = noisy(), noisy()
    e[at] += np.diff(path, 2)[at - 1] / 0.01**2
    later[at + 40] += np.where(np.arange(at.size) % 2, 0.5, -0.5)
    rest = np.zeros(4000, bool)
    pushed, spikes = (find_outliers(("force",), [Said("a", y[None], y[None], rest, path)], 0.01, reads=1e-6) for y in (e, later))
    assert not pushed and spikes[0].evidence["excursions"] == at.size
    assert find_outliers(("force",), [Said("a", e[None], e[None], rest)], 0.01)
    slow = Recording("b", np.arange(4000) * 0.1, path, e)  # pushed as much, though its plunger took ten times as long
    heavier = noisy()
    heavier[at] += np.diff(path, 2)[at - 1] / 0.1**2
    sessions = [Said("a", e[None], e[None], rest, path), Said("b", 1.0 * heavier[None], heavier[None], rest, path, slow)]
    assert not find_outliers(("force",), sessions, 0.01, reads=1e-6)


@pytest.mark.parametrize(("others", "quick", "told"), [(0.5, 12e-6, False), (0.5, 0.0, True), (0.0, 12e-6, True)])
def test_what_every_channel_feels_of_a_quick_motion_is_no_outlier(others, quick, told):
    """Between two readings the stage was faster than the encoder tells. At rest the same is a spike, and so is what one channel feels."""
    rng, jumps, at = np.random.default_rng(2), np.zeros(4000, bool), np.array([1000, 2000, 3000])
    path = 1e-6 * np.round(0.2 * rng.standard_normal(4000)) + quick * np.searchsorted(at, np.arange(4000), "right")
    e = np.array([noisy(), 0.5 * rng.permutation(noisy())])
    e[:, at] += [[2.0], [others]]
    found = find_outliers(("force", "taxel_0"), [Said("a", e, e, jumps, path)], 0.01, reads=1e-6)
    assert ("load_cell" in [s.where for s in found]) == told


@pytest.mark.parametrize("at_landings", [True, False])
def test_jumps_at_landings_alone_are_no_outliers(at_landings):
    jumps = np.zeros(4000, bool)
    for a in range(200, 4000, 400):
        jumps[a : a + 20] = True
    wrong = np.zeros(4000)
    wrong[(210 if at_landings else 310) : 4000 : 400] = 3.0
    assert bool(found(wrong, np.zeros(4000), jumps)) is not at_landings


@pytest.mark.parametrize("at_landing", [True, False])
def test_what_all_channels_feel_at_a_landing_is_no_outlier_of_one(at_landing):
    """Two quick touches of stiff skin at 60 Hz: too few to say that they are where the plunger lands, but all sensors feel them."""
    jumps, e = np.zeros(4000, bool), np.array([noisy(0), noisy(1)])
    for a in range(200, 4000, 40):
        jumps[a : a + 20] = True
    for i in (1210, 2410):
        e[:, i if at_landing else i + 20] += 3.0
    assert bool(find_outliers(("force", "taxel_0"), [Said("a", e, e, jumps)], 0.01)) is not at_landing
