"""A motion remembers what was worked out from it, and answers as one that was never asked does."""

from dataclasses import replace

import numpy as np

from skin_models.dispersion import Dispersion
from skin_models.effects.backlash import Backlash
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.model import Model
from skin_models.signals import KEPT, Motion, motion

SKIN = Dispersion(m=0.000432, b1=939.5, k1=9619.0, b2=629.2, k2=2766.0)
PLAIN = Model(SKIN, shares=(0.3, 1.0))


def path() -> Motion:
    t = np.arange(2000) / 100.0
    return motion(t, 5e-4 * np.sin(t) + 3e-4 * np.sin(5.3 * t))


def models() -> list[Model]:
    """More than a motion remembers, that differ in skin, arms and play."""
    skins = [replace(SKIN, b1=b, k1=k) for b in (300.0, 900.0) for k in (5e3, 9e3)]
    effects = [(), (Backlash("rig", gap=5e-5),), (Backlash("rig", gap=8e-5), StressRelaxation("skin", k_sensed=900.0, tau=0.5))]
    return [Model(skin, PLAIN.shares, e) for skin in skins for e in (*effects, (StressRelaxation("skin", k_sensed=900.0, tau=2.0),))]


def test_models_in_turn_answer_as_on_a_motion_of_their_own():
    s, every = path(), models()
    assert len(every) > KEPT
    for model in (*every, *reversed(every)):
        asked, fresh = model.simulate(s), model.simulate(path())
        assert np.array_equal(asked.force, fresh.force) and np.array_equal(asked.taxels, fresh.taxels)


def test_what_was_asked_for_last_is_worked_out_once():
    s = path()
    assert PLAIN.simulate(s) is PLAIN.simulate(s)
    for model in models():
        model.simulate(s)
    assert all(len(known) <= KEPT for known in s.memory.values())


def test_of_a_long_motion_less_is_kept():
    s = motion(np.arange(300_000) / 100.0, np.full(300_000, 1e-3))
    for n in range(5):
        s.once("kind", n, lambda n=n: n)
    assert list(s.memory["kind"]) == [4] and s.once("kind", 4, lambda: "anew") == 4
