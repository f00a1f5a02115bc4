"""What physics rules out, whatever it explains."""

from types import SimpleNamespace

import numpy as np
import pytest

from skin_ident.criticism.search.plausible import plausible
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.effects.hysteresis import BoucWenHysteresis, LaggingHysteresis, SensorHysteresis, SkinHysteresis
from skin_models.effects.rate_dependence import PowerDamping
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.model import Model
from skin_models.signals import motion

T = np.arange(2000) / 100.0
DEPTH = 0.5e-3 + 0.4e-3 * np.sin(0.9 * T)
PLAIN = Model(Dispersion(m=0.0, b1=900.0, k1=9000.0, b2=600.0, k2=3000.0), shares=(1.0,))
STIFF = {"k_sensed": 2000.0, "k_dispersed": 1000.0}


def allowed(effect) -> bool:
    truth = PLAIN.simulate(motion(T, DEPTH))
    session = prepare(Recording("made", T, DEPTH, truth.force, truth.taxels))
    named = {"cause": effect.cause, "where": effect.where}
    fitted = SimpleNamespace(model=PLAIN.extended(effect))
    return plausible(SimpleNamespace(key=effect.key, ranked=SimpleNamespace(**named), fit=fitted), [session])


@pytest.mark.parametrize(
    ("effect", "may_be"),
    [
        (SkinHysteresis("skin", **STIFF, threshold=0.2e-3), True),
        (SkinHysteresis("skin", **STIFF, threshold=1.0e-3), False),  # it never yields
        (SkinHysteresis("skin", **STIFF, threshold=0.7e-3), False),  # it yields once, on the way to the deepest press
        (LaggingHysteresis("skin", **STIFF, threshold=0.85e-3), False),
        (SensorHysteresis("load_cell", relative=0.02, threshold=9.0), False),  # of some 12 N
        (SensorHysteresis("load_cell", relative=0.02, threshold=4.0), True),
        (BoucWenHysteresis("skin", **STIFF, threshold=1.0e-3), True),  # it yields all the time
        (BoucWenHysteresis("skin", **STIFF, threshold=5.0e-3), False),  # next to never
        (SkinHysteresis("skin", **STIFF, threshold=1e-6), False),  # a brake
        (StressRelaxation("skin", k_sensed=6000.0, k_dispersed=3000.0, tau=0.01), False),  # a filter
        (StressRelaxation("skin", **STIFF, tau=1.0), True),
        (PowerDamping("skin", force_sensed=-900.0, force_dispersed=-600.0, exponent=1.0), False),  # a motor
    ],
)
def test_what_skin_may_be(effect, may_be):
    assert allowed(effect) is may_be
