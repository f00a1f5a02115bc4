"""A recorded twin of someone else's simulator is criticised as it stands; what it holds beyond our models is not held against it."""

from dataclasses import replace

import numpy as np
import pytest

from skin_ident.cli.diagnose import main
from skin_ident.criticism.baseline.residual import residual, simulated
from skin_ident.criticism.baseline.twin import read_twins
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.record import inspect
from skin_ident.hiding.writing import write_recordings
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.effects.friction import Friction
from skin_models.effects.nonlinear_stiffness import PolynomialStiffness
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.model import Model
from skin_models.signals import motion

SKIN = Dispersion(m=0.000432, b1=939.5, k1=9619.0, b2=629.2, k2=2766.0)
THEIRS = Model(SKIN, (1.0, 0.4)).extended(PolynomialStiffness.typical("skin"))  # a simulator with a curved skin
REAL = THEIRS.extended(StressRelaxation("skin", k_sensed=1500.0, k_dispersed=500.0, tau=1.5))
T = np.arange(4000) / 100.0


def path(seed):
    rng = np.random.default_rng(seed)
    knots = np.repeat(rng.uniform(0.1e-3, 0.8e-3, 40), 2)
    return np.convolve(np.interp(T, np.linspace(0, T[-1], 80), knots), np.hanning(41) / 20.0, mode="same")


def recorded(model, seed, noise=0.0, name="session"):
    x, rng = path(seed), np.random.default_rng(100 + seed)
    out = model.simulate(motion(T, x))
    force, taxels = (y + noise * rng.standard_normal(y.shape) for y in (out.force, out.taxels))
    return Recording(f"{name}_{seed}", T, x, force, taxels)


MEASURED, TWINS = ([recorded(m, i, noise, name) for i in range(3)] for m, noise, name in ((REAL, 0.02, "session"), (THEIRS, 0.0, "twin")))


def names(outcome):
    return [(f["cause"], f["where"]) for f in outcome.findings["findings"]]


def test_the_twin_itself_is_the_baseline():
    looked = inspect(MEASURED[:1])
    twin = read_twins(looked.sessions, MEASURED[:1], TWINS[:1], 0.0)
    said = simulated(twin.surrogate, looked.carrying(twin.beyond(twin.surrogate), twin.known).sessions[0])
    assert np.allclose(said[0], TWINS[0].force, atol=1e-9) and np.allclose(said[1:], TWINS[0].taxels, atol=1e-9)


@pytest.mark.slow
def test_what_the_twin_lacks_is_named_and_what_it_holds_is_not():
    outcome = diagnose(MEASURED[:2], MEASURED[2:], twins=TWINS)
    assert names(outcome) == [("stress_relaxation", "skin")]
    tau = outcome.findings["findings"][0]["parameters"]["tau"]["value"]
    assert tau == pytest.approx(1.5, rel=0.15)
    before, after = (outcome.findings[part]["rmse"]["force"]["held_out"] for part in ("baseline", "extended"))
    assert before == pytest.approx(np.std(MEASURED[2].force - TWINS[2].force), rel=0.3) and after < 0.1 * before
    assert np.allclose(outcome.traces[0].baseline[0], TWINS[0].force, atol=1e-9)


def test_a_twin_that_is_right_is_left_in_peace():
    right = [recorded(REAL, i, name="twin") for i in range(3)]
    assert diagnose(MEASURED[:2], MEASURED[2:], twins=right).findings["verdict"] == "nothing_wrong"


@pytest.mark.slow
def test_wrong_numbers_of_a_twin_are_called_so():
    soft = replace(REAL, dispersion=replace(SKIN, k1=0.8 * SKIN.k1))
    outcome = diagnose(MEASURED[:2], MEASURED[2:], twins=[recorded(soft, i, name="twin") for i in range(3)])
    assert names(outcome)[0] == ("parameters", "skin")


def test_twins_that_do_not_belong():
    with pytest.raises(DiagnosisError, match="2 recordings, but 1 twin"):
        diagnose(MEASURED[:2], twins=TWINS[:1])
    with pytest.raises(DiagnosisError, match="must carry the channels"):
        diagnose(MEASURED[:1], twins=[replace(TWINS[0], force=None)])
    with pytest.raises(DiagnosisError, match="not of the same motion"):
        diagnose(MEASURED[:1], twins=TWINS[1:2])
    with pytest.raises(DiagnosisError, match=r"taxel_1 is missing"):
        diagnose(MEASURED[:1], twins=[TWINS[0].with_taxels([0])])
    with pytest.raises(DiagnosisError, match=r"0\.001 times that of session_0"):
        diagnose(MEASURED[:1], twins=[replace(TWINS[0], depth=1e-3 * TWINS[0].depth)])
    with pytest.raises(DiagnosisError, match="32 are needed"):
        seldom = {name: getattr(TWINS[0], name)[..., ::20] for name in ("t", "depth", "force", "taxels")}
        diagnose(MEASURED[:1], twins=[replace(TWINS[0], **seldom)])
    with pytest.raises(DiagnosisError, match="lasts"):
        diagnose(MEASURED[:1], twins=[TWINS[0].part(0, 2000)])
    with pytest.raises(DiagnosisError, match="not both"):
        diagnose(MEASURED[:1], model=THEIRS, twins=TWINS[:1])


def as_said_beside_the_first(twin):
    """What a twin says on the clock of the first recording, (C, N) N, and its warnings."""
    looked = inspect(MEASURED[:1])
    read = read_twins(looked.sessions, MEASURED[:1], [twin], 0.0)
    return simulated(read.surrogate, looked.carrying(read.beyond(read.surrogate), read.known).sessions[0]), read.warnings[0]


def test_another_rate_and_another_clock():
    slow = replace(TWINS[0], t=1000.0 + T[::2], depth=None, force=TWINS[0].force[::2], taxels=TWINS[0].taxels[:, ::2])
    said, warnings = as_said_beside_the_first(slow)
    assert np.std(said[0] - TWINS[0].force) < 0.004 and "another clock" in warnings[0]


@pytest.mark.parametrize("late", [0.013, -0.4])
def test_a_twin_whose_clock_began_elsewhere_is_set_by_its_depth(late):
    """Of a delay of 13 ms the fit would make another damping."""
    other = replace(TWINS[0], t=T + late)
    said, warnings = as_said_beside_the_first(other)
    inside = slice(50, -50)
    assert np.std((said[0] - TWINS[0].force)[inside]) < 1e-3 * np.std(TWINS[0].force)
    assert f"{late:+.3g} s" in warnings[-1]


@pytest.mark.parametrize("late", [2.5, -3.0])
def test_clocks_that_cover_each_other_by_chance_begin_together(late):
    """By their stamps most of both is at the same time, but not the same motion."""
    other = replace(TWINS[0], t=T + late)
    said, warnings = as_said_beside_the_first(other)
    assert np.std(said[0] - TWINS[0].force) < 1e-3 * np.std(TWINS[0].force) and "another clock" in warnings[0]


@pytest.mark.slow
def test_a_dead_taxel_says_what_it_says_whatever_its_twin_says():
    """Every session of the twin answers; the measured taxel_1 does not, and nothing is left of it to be explained."""
    level = 0.37
    dead = [replace(r, taxels=np.vstack([r.taxels[:1], np.full((1, len(r)), level)])) for r in MEASURED]
    looked = inspect(dead)
    twin = read_twins(looked.sessions, dead, TWINS, 0.0)
    for s in looked.carrying(twin.beyond(twin.surrogate), twin.known).sessions:
        assert np.abs(residual(twin.surrogate, s)[-1]).max() < 1e-9
    assert ("dead_taxel", "taxel_1") in names(diagnose(dead[:2], dead[2:], twins=TWINS))


def test_clipped_samples_stay_for_the_judgement_of_what_they_are_worth():
    level = 0.9 * max(r.taxels.max() for r in MEASURED)
    clipped = [replace(r, taxels=np.minimum(r.taxels, level)) for r in MEASURED]
    looked = inspect(clipped)
    twin = read_twins(looked.sessions, clipped, TWINS, 0.0)
    carried = looked.carrying(twin.beyond(twin.surrogate), twin.known)
    for left, before, searched in zip(carried.whole, looked.whole, looked.sessions, strict=True):
        assert np.array_equal(left.weight, before.weight) and searched.weight.mean() < left.weight.mean()


@pytest.mark.slow
def test_the_command(tmp_path, capsys):
    write_recordings(MEASURED[:2], tmp_path / "measured")
    write_recordings(TWINS[:2], tmp_path / "twin")
    call = [str(tmp_path / "measured"), "--twin", str(tmp_path / "twin"), "--out", str(tmp_path / "out")]
    assert main(call) == 0 and "stress_relaxation in the skin" in capsys.readouterr().out
    assert main([*call[:3], "--out", str(tmp_path / "no"), "--model", str(tmp_path / "out/model.yaml")]) == 2
    assert "not both" in capsys.readouterr().err and not (tmp_path / "no" / "findings.json").exists()


def test_a_twin_of_nearly_the_same_motion_is_warned_about():
    """A depth that is 2 % larger, as of another gear, is the answer to another motion; reading noise is not."""
    rng, looked = np.random.default_rng(0), inspect(MEASURED[:1])
    for other, said in ((1.02 * TWINS[0].depth, True), (TWINS[0].depth + 1e-6 * rng.standard_normal(T.size), False)):
        warnings = read_twins(looked.sessions, MEASURED[:1], [replace(TWINS[0], depth=other)], 0.0).warnings[0]
        assert any("another motion" in w for w in warnings) is said


@pytest.mark.parametrize("what", ["depth", "force", "taxels"])
def test_a_twin_that_stands_still_is_refused(what):
    still = replace(TWINS[0], **{what: np.zeros_like(getattr(TWINS[0], what))})
    with pytest.raises(DiagnosisError, match=f"the {what} of the twin twin_0 never changes"):
        diagnose(MEASURED[:1], twins=[still])


def test_a_twin_without_depth_keeps_its_clock_where_its_damping_is_wrong():
    """A delay explains only part of that; a clock that is off explains all."""
    thick = recorded(replace(REAL, dispersion=replace(SKIN, b1=1.5 * SKIN.b1, b2=1.5 * SKIN.b2)), 0, name="twin")
    late = replace(recorded(REAL, 0, name="twin"), t=T + 0.04)
    for twin, moved in ((thick, False), (late, True)):
        warnings = read_twins(inspect(MEASURED[:1]).sessions, MEASURED[:1], [replace(twin, depth=None)], 0.0).warnings[0]
        assert any("its clock is set" in w for w in warnings) is moved


@pytest.mark.slow
def test_a_twin_that_rubs_where_the_rig_does_not_is_told_so():
    """No friction is less than none: a twin with too much of it was told hysteresis of the load cell."""
    plain = Model(SKIN, (1.0, 0.4))
    measured, rubs = (
        [recorded(m, i, noise, name) for i in range(3)]
        for m, noise, name in ((plain, 0.02, "session"), (plain.extended(Friction("rig", force=0.15)), 0.0, "twin"))
    )
    (found,) = diagnose(measured[:2], measured[2:], twins=rubs).findings["findings"]
    assert found["cause"] == "parameters" and "friction" in found["evidence"]["why"]
