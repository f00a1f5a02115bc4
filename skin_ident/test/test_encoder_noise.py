"""Noise of the encoder: a finding against what is declared, open where nothing is and it matters, and nothing otherwise."""

from dataclasses import replace

import numpy as np
import pytest
from making import recording

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telemetry.encoder_noise import find_encoder_noise, undeclared_noise
from skin_ident.recordings.declared import Declared, declared_from
from skin_models.dispersion import Dispersion
from skin_models.model import Model

STEP = 1e-6  # m
SKIN = Model(Dispersion(k1=3000.0, b1=20.0, k2=3000.0, b2=20.0, m=0.001))


def read(seed, noise_um, **declared):
    rng, sound = np.random.default_rng(seed), recording(seed, sigma=0.004)
    depth = STEP * np.round((sound.depth + 1e-6 * noise_um * rng.standard_normal(len(sound))) / STEP)
    return replace(sound, depth=depth, declared=Declared(**declared))


@pytest.mark.parametrize("seed", range(4))
def test_noise_of_twice_the_declared_level_is_found_and_measured(seed):
    (found,) = find_encoder_noise([read(seed + 10 * i, 6.0, encoder_noise_um=3.0) for i in range(3)])
    assert (found.cause, found.where, found.channels) == ("noise", "rig", ("depth",))
    assert found.parameters["white"] == {"value": pytest.approx(6e-6, rel=0.1), "unit": "m"}
    assert found.parameters["times_expected"]["value"] == pytest.approx(2.0, rel=0.1)
    assert "2 times the 3 µm" in found.evidence["why"] and "dithers" in found.evidence["why"]


@pytest.mark.parametrize("noise_um", [0.0, 1.0, 3.0, 3.6])
@pytest.mark.parametrize("seed", range(3))
def test_noise_as_declared_or_less_is_none(seed, noise_um):
    sessions = [read(seed, noise_um, encoder_noise_um=3.0)]
    assert find_encoder_noise(sessions) == [] and undeclared_noise(sessions, SKIN) == ""


def test_one_loud_session_of_three_is_no_level_of_the_encoder():
    assert find_encoder_noise([read(i, level, encoder_noise_um=3.0) for i, level in enumerate((3.0, 3.0, 9.0))]) == []


def test_undeclared_noise_is_left_open_where_it_is_as_large_as_that_of_a_channel():
    """6 µm times 6 N/mm are 36 mN."""
    less, more = (undeclared_noise([read(0, 6.0, force_noise_n=level, taxel_noise_n=(level,))], SKIN) for level in (0.03, 0.06))
    assert "N of force, as much as the noise that rig.yaml declares" in less and more == ""
    assert undeclared_noise([read(0, 6.0)], SKIN) == ""
    assert undeclared_noise([replace(read(0, 6.0, force_noise_n=0.03), depth=None)], SKIN) == ""


def test_it_is_read_from_rig_yaml():
    assert declared_from("encoder_noise_um: 2.5").encoder_noise_um == 2.5


@pytest.mark.parametrize(("declared_um", "told"), [(6.0, "nothing"), (3.0, "finding"), (None, "untestable")])
def test_the_whole_diagnosis_tells_it(declared_um, told):
    """A load cell and a taxel with less noise than the depth makes in them."""
    declared = dict(force_noise_n=0.004, taxel_noise_n=(0.004,), **({"encoder_noise_um": declared_um} if declared_um else {}))
    sessions = [replace(read(i, 6.0, **declared), name=f"run_{i}") for i in range(3)]
    outcome = diagnose(sessions[:2], sessions[2:]).findings
    assert [(f["cause"], f["where"]) for f in outcome["findings"]] == [("noise", "rig")] * (told == "finding")
    untestable = [u for u in outcome["untestable"] if u["cause"] == "noise"]
    assert [u["where"] for u in untestable] == ["rig"] * (told == "untestable")
    assert all("encoder_noise_um" in u["needs"] for u in untestable)
    assert any(e["cause"] == "noise" for e in outcome["excluded"]) == (told == "nothing")
