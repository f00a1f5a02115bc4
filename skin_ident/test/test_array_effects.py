"""The effects by which an array bends what its taxels read, and the model files that are made of them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from skin_ident.criticism.array.bending import Leaning, Settling, SettlingReaching, Walking, Widening
from skin_ident.criticism.array.extending import NO_FORM, NOT_JUDGED, TOO_LARGE, known, unwritten
from skin_ident.criticism.array.hypotheses import Hypothesis
from skin_ident.criticism.array.joining import joined
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.proposing import for_anybody
from skin_ident.criticism.array.smeared import Capacitive, Smeared
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.signals import motion

T = np.arange(400) / 100.0
MOTION = motion(T, 5e-4 * (1.0 - np.cos(3.0 * T)))
ROW = ((-3e-3, 1e-3), (2e-3, 1e-3), (7e-3, 1e-3))
BENDS = [
    Leaning("rig", ROW, (1.0, 0.0), 5e-3, 1e-3, shift=3e-4),
    Walking("rig", ROW, (0.6, 0.8), 5e-3, 4.0, shift=3e-4),
    Widening("skin", ROW, 5e-3, growth=200.0),
    Settling("skin", ROW, 5e-3, usual=7e-4, growth=400.0, settling=2e-4),
    SettlingReaching("skin", ROW, 5e-3, usual=7e-4, growth=400.0, settling=2e-4),
    Smeared("taxel", ROW, share=0.05, tau=0.1),
    Capacitive("taxel", ROW, share=0.05, tau=0.1),
]


@pytest.mark.parametrize("e", BENDS, ids=lambda e: type(e).__name__)
def test_stepping_through_an_effect_is_the_same_as_the_whole(e):
    y = np.linspace(0.2, 1.0, 3)[:, None] * (1.0 + MOTION.x / 1e-3)
    state, stepped = e.initial(), []
    for i in range(len(MOTION)):
        state, row = e.step(state, y[:, i], MOTION[i], MOTION.dt)
        stepped.append(row)
    assert np.allclose(np.array(stepped).T, e.batch(y, MOTION), rtol=1e-9)
    assert np.allclose(e.absent().batch(y, MOTION), y)


@pytest.mark.parametrize("hz", [1000.0, 100.0, 20.0])
def test_smeared_crosstalk_of_a_ramp_is_late_by_its_time_constant_at_any_rate(hz):
    t = np.arange(0.0, 3.0, 1.0 / hz)
    y = np.outer([0.0, 1.0, 0.0], t)
    heard = (Smeared("taxel", ROW, share=0.1, tau=0.03).batch(y, motion(t, 1e-3 * t)) - y)[0] / 0.1
    assert t[-1] - heard[-1] == pytest.approx(0.03, rel=1e-6)


def test_leaning_and_widening_are_the_gaussian_elsewhere_or_wider():
    places, c = np.array(ROW), 5e-3
    plain = np.exp(-((np.hypot(*places.T) / c) ** 2))
    moved = np.exp(-((np.hypot(*(places - [3e-4, 0.0]).T) / c) ** 2))
    deepest = motion(T, np.full(T.size, 1e-3))
    leaning, _, widening, *_ = BENDS
    assert np.allclose(leaning.batch(plain[:, None] * np.ones(T.size), deepest)[:, 0], moved)
    wide = np.exp(-((np.hypot(*places.T) / (1.2 * c)) ** 2)) / 1.2**2
    assert np.allclose(widening.batch(plain[:, None] * np.ones(T.size), deepest)[:, 0], wide)


def test_a_lean_is_written_as_the_effect_of_the_catalogue_that_does_the_same():
    leaning = BENDS[0]
    told = known(leaning)
    model = Model(Dispersion(m=4e-4, b1=900.0, k1=9600.0, b2=600.0, k2=2800.0), (0.6, 0.8, 0.1), positions=ROW)
    model = replace(model, notes={"spread_width": {"value": leaning.width, "unit": "m"}})
    a, b = (replace(model, effects=(e,)).simulate(MOTION).taxels for e in (leaning, told))
    assert np.allclose(a, b, rtol=1e-9) and np.ptp(a[0][a[1] > 0.1] / a[1][a[1] > 0.1]) > 1e-3


def test_a_model_for_anybody_keeps_where_its_taxels_are():
    model = Model(Dispersion(m=0.0, b1=900.0, k1=9600.0, b2=600.0, k2=2800.0), (0.6, 0.8, 0.1), tuple(BENDS), positions=ROW)
    assert for_anybody(model) == replace(model, effects=())


def judged_as(cause: str, where: str, name: str) -> SimpleNamespace:
    """An array in which one cause was named, by one quantity of the family, of size 0.1."""
    member = SimpleNamespace(member={name: 0.1})
    j = SimpleNamespace(key=(cause, where), hypothesis=Hypothesis(cause, where, 0.1, {name: 0.1}), fit=member)
    return SimpleNamespace(named=(SimpleNamespace(best=j),), layout=Layout(np.array(ROW), np.zeros((1, 2)), 5e-3, True))


def test_what_has_no_effect_in_the_catalogue_is_not_said_to_be_in_the_model():
    plain = Model(Dispersion(m=0.0, b1=900.0, k1=9600.0, b2=600.0, k2=2800.0), (0.6, 0.8, 0.1))
    leaning, walking, widening, _, _, smeared, _ = BENDS
    model = replace(plain, effects=(leaning, widening, smeared))
    nothing = SimpleNamespace(named=())
    assert unwritten(model, nothing) == {("crosstalk", "taxel"): NO_FORM}
    assert unwritten(model.extended(walking), nothing) == {("off_centre", "rig"): NO_FORM, ("crosstalk", "taxel"): NO_FORM}
    assert set(unwritten(model, "a taxel is dead").values()) == {NOT_JUDGED} and not unwritten(plain, "a taxel is dead")
    assert unwritten(plain.extended(replace(leaning, deepest=1e-6)), nothing) == {("off_centre", "rig"): TOO_LARGE}
    assert unwritten(plain, judged_as("crosstalk", "taxel", "common")) == {("crosstalk", "taxel"): NO_FORM}
    assert not unwritten(plain, judged_as("crosstalk", "taxel", "leak"))


def test_the_finding_says_that_the_model_does_not_have_it():
    walks = {"cause": "off_centre", "where": "rig", "evidence": {"forms": ["Walking"]}, "alternatives": []}
    lags = walks | {"cause": "lag", "where": "taxel"}
    content = {"findings": [walks, lags], "excluded": [], "untestable": [], "verdict": "explained", "warnings": []}
    model = Model(Dispersion(m=0.0, b1=900.0, k1=9600.0, b2=600.0, k2=2800.0), (0.6, 0.8, 0.1), (BENDS[1],))
    said = [(f["evidence"].get("simulated"), f["evidence"].get("in_model")) for f in joined(content, "a taxel is dead", model)["findings"]]
    assert said == [(NOT_JUDGED, False), (None, None)]
