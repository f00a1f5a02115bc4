"""A ceiling that only quick touches reach is seen where no model is fitted, and nothing else passes for it."""

import numpy as np
import pytest
from hide_and_seek import seek
from rows import rows
from scipy.signal import lfilter
from world import make_sessions, write_case
from world.hidden import Hide

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telemetry.ceiling import find_ceilings
from skin_ident.recordings.load import load

T = np.arange(4000) / 100.0
NOISE, LEVEL, SLOPE = 0.05, 14.0, 0.06  # N, N, and what is left of the slope beyond the level
SHARES = np.array([1.0, 0.6, 0.2])[:, None]
GENTLE = 4.0 + 3.0 * np.sin(2.0 * np.pi * 0.4 * T)


def said(seed):
    """What a simulation says: gentle waves, and eight quick touches of 70 ms, which no fit has seen."""
    rng, y, unseen = np.random.default_rng(seed), GENTLE.copy(), np.zeros(T.size, bool)
    for begin in 500 + 30 * np.arange(8):
        y[begin : begin + 8] = rng.uniform(16.0, 26.0) * np.sin(np.pi * (np.arange(8) + rng.uniform(0.2, 0.8)) / 8.0)
        unseen[begin - 4 : begin + 12] = True
    return SHARES * y, unseen


def ceilings(spoil):
    """Symptoms of two sessions of a load cell and two taxels; `spoil` makes of what is said what is measured."""
    each = [said(seed) for seed in range(2)]
    raw = [spoil(m) + NOISE * np.random.default_rng(7 + i).standard_normal(m.shape) for i, (m, _) in enumerate(each)]
    channels = ("force", "taxel_0", "taxel_1")
    return find_ceilings(["a", "b"], channels, raw, [m for m, _ in each], [u for _, u in each], 2)


def flat(y):
    return np.minimum(y, LEVEL) + SLOPE * np.maximum(y - LEVEL, 0.0)


def of_force(change):
    return lambda m: np.vstack([change(m[0]), m[1:]])


def test_a_load_cell_that_follows_no_further_is_seen():
    (symptom,) = ceilings(of_force(flat))
    assert (symptom.cause, symptom.where) == ("saturation", "load_cell")
    assert symptom.parameters["level"]["value"] == pytest.approx(LEVEL, rel=0.02)
    assert symptom.parameters["lost"]["value"] == pytest.approx(1.0 - SLOPE, abs=0.03)
    assert set(symptom.bad) == {("a", "force"), ("b", "force")}


@pytest.mark.parametrize(
    "spoil",
    [
        lambda m: m,
        lambda m: flat(m / SHARES) * SHARES,
        of_force(lambda y: lfilter([0.6], [1.0, -0.4], y)),
        of_force(lambda y: np.roll(y, 1)),
        of_force(lambda y: np.where(y > LEVEL, 0.9 * y, y)),
        of_force(lambda y: np.where(y > LEVEL, y - np.random.default_rng(3).uniform(0.0, 8.0, y.size), y)),
    ],
    ids=["nothing", "the skin gives way", "lag", "late", "less gain", "by chance"],
)
def test_what_is_no_ceiling_of_one_sensor_is_not_called_one(spoil):
    assert ceilings(spoil) == []


def test_it_is_named_once_beside_what_else_is_hidden(tmp_path):
    """Reached by the quickest touches of the battery alone."""
    found = seek(tmp_path, "saturation", where="load_cell", form="leaky", size=1.0, seed=1524856)
    assert found.names.count(("saturation", "load_cell")) == 1 and not found.extra


@pytest.mark.parametrize(("where", "seed"), rows([("taxel_0", 202), ("load_cell", 200), ("load_cell", 202), ("taxel_0", 203)], 0))
def test_a_knee_as_amplifiers_have_it_is_one_soft_saturation_and_no_set_of_corners(tmp_path, where, seed):
    sessions, _ = make_sessions([Hide("saturation", where, "soft", 3.0)], seed=seed, protocol="full", n_sessions=3, noise="white")
    write_case(sessions, tmp_path)
    every = load(tmp_path)
    (found,) = diagnose(every[:2], every[2:]).findings["findings"]
    assert (found["cause"], found["evidence"]["forms"]) == ("saturation", ["SoftSaturation"])
