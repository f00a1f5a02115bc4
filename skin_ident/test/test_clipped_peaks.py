"""A few quick peaks that were clipped before noise came on top are saturation, or cannot be told from it; other accidents are not."""

from dataclasses import replace

import numpy as np
import pytest
from test_faults import NOISE, SKIN, T

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.record import inspect
from skin_ident.criticism.telemetry.pile_up import find_saturation
from skin_ident.recordings.recording import Recording
from skin_models.signals import motion

PEAKS, LEVEL = (6.0, 26.0), 15.0  # s, N


def session(seed, spoil, peaks=PEAKS):
    """Gentle waves and a few quick peaks of more than twice their depth; `spoil` acts on the force (N,) before noise."""
    rng = np.random.default_rng(seed)
    waves = 0.2e-3 * (2.5 + np.sin(2.0 * np.pi * rng.uniform(0.3, 0.5) * T)) + 0.05e-3 * np.sin(2.0 * np.pi * 1.3 * T)
    depth = np.maximum(waves, 0.0) + sum(0.8e-3 * np.exp(-(((T - at) / 0.15) ** 2)) for at in peaks)
    out = SKIN.simulate(motion(T, depth))
    force, taxels = (y + NOISE * rng.standard_normal(y.shape) for y in (spoil(out.force), out.taxels))
    return Recording(f"session_{seed}", T, depth, force, taxels)


def clipped(y):
    return np.minimum(y, LEVEL)


def touched(y):
    """Accidents of the same length at other times."""
    out = y.copy()
    for at in PEAKS:
        out[int(100 * at) + 300 : int(100 * at) + 320] -= 2.0
    return out


def lowered(y):
    """On the way up to each peak, and each by another amount."""
    return y - sum((1.0 + i) * (np.abs(T - at + 0.15) < 0.1) for i, at in enumerate(PEAKS))


def of_force(recordings):
    return [s for s in inspect(recordings).symptoms if s.where == "load_cell"]


def test_clipped_peaks_are_saturation_with_outliers_as_the_rival():
    recordings = [session(i, clipped) for i in range(2)]
    (symptom,) = of_force(recordings)
    assert (symptom.cause, symptom.alternatives) == ("saturation", (("outliers", "load_cell"),))
    assert symptom.parameters["level"]["value"] == pytest.approx(LEVEL, abs=NOISE)
    outcome = diagnose([session(i, clipped) for i in range(2)], [session(2, clipped)]).findings
    assert [(f["cause"], f["where"]) for f in outcome["findings"]] == [("saturation", "load_cell")]
    assert not {"saturation", "outliers"} & {e["cause"] for e in outcome["excluded"]}


@pytest.mark.parametrize("spoil", [touched, lowered])
def test_other_accidents_are_outliers_alone(spoil):
    (symptom,) = of_force([session(i, spoil) for i in range(2)])
    assert symptom.cause == "outliers" and not symptom.alternatives


def test_a_lone_clipped_peak_may_be_either():
    def long(seed, spoil):
        r = session(seed, lambda y: y, ())
        depth = r.depth + 0.6e-3 * ((T > 20.0) & (T < 22.0)) * np.sin(np.pi * (T - 20.0) / 2.0)
        out = SKIN.simulate(motion(T, depth))
        rng = np.random.default_rng([seed, 3])
        return replace(r, depth=depth, force=spoil(out.force) + NOISE * rng.standard_normal(T.size), taxels=out.taxels + r.taxels * 0.0)

    (symptom,) = of_force([long(0, lambda y: np.minimum(y, 0.6 * y.max())), session(1, lambda y: y, ())])
    assert symptom.cause == "saturation" or ("saturation", "load_cell") in symptom.alternatives


def test_sound_peaks_raise_nothing():
    assert not of_force([session(i, lambda y: y) for i in range(2)])


@pytest.mark.parametrize("clip", [False, True])
def test_peaks_that_reach_one_level_of_a_coarse_converter_are_clipped_only_if_they_are(clip):
    """Stamps that are uneven have readings interpolated, so that most of them are between two levels."""
    rng, t, step = np.random.default_rng(5), np.arange(8000) / 200.0, 0.05
    depth = 0.5e-3 - 0.3e-3 * np.cos(2.0 * np.pi * 0.25 * t)
    force = SKIN.simulate(motion(t, depth)).force
    read = step * np.round(force / step + 0.4 * rng.standard_normal(t.size))
    read = np.minimum(read, step * np.round(0.93 * force.max() / step)) if clip else read
    uneven = np.interp(t + 1e-3 * rng.uniform(-1.0, 1.0, t.size), t, read)
    assert bool(find_saturation(["a"], ("force",), [uneven[None]], [force[None]], 0, (step,))) == clip
