"""The parts of the array analysis, each against something independent of it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal
from world.specimen import draw_specimen

from skin_ident.criticism.array.analysis import ArrayCriticism
from skin_ident.criticism.array.evidence import fitted
from skin_ident.criticism.array.family import Family
from skin_ident.criticism.array.findings import POSSIBLE, excluded, form_of, parameters, untestable
from skin_ident.criticism.array.gains import Gains, _swallowed
from skin_ident.criticism.array.judgement import judge
from skin_ident.criticism.array.layout import Layout, layout_of
from skin_ident.criticism.array.sentences import separating, shift_of, why
from skin_ident.recordings.declared import Declared, declared_from
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.recording import Recording
from skin_models.catalogue import effects
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.signals import motion

T = np.arange(400) / 100.0
MOTION = motion(T, 5e-4 * (1.0 - np.cos(3.0 * T)))


def recording(declared: Declared, taxels: int = 3, **how) -> Recording:
    return Recording("made", T, MOTION.x, MOTION.x * 1e4, np.ones((taxels, 1)) * MOTION.x, declared=declared, **how)


def array(n: int, seed: int, contacts=((0.0, 0.0), (0.0, 0.0)), declared: bool = True):
    """A specimen of the world and its layout under contacts (m)."""
    skin = draw_specimen(np.random.default_rng(seed), 4, n, "row_5mm")
    return skin, Layout(skin.positions, np.array(contacts), skin.width, declared)


def measured(shares, seed: int, error: float = 5e-4) -> Gains:
    """Shares as a good recording gives them."""
    shares = np.array(shares)
    covariance = np.tile((error * shares.max()) ** 2 * np.eye(shares.shape[1]), (len(shares), 1, 1))
    return Gains(shares + error * shares.max() * np.random.default_rng(seed).standard_normal(shares.shape), covariance)


@pytest.mark.parametrize(
    ("declared", "taxels", "units", "word"),
    [
        (Declared(), 1, (), "one taxel"),
        (Declared(), 3, (), "does not declare"),
        (Declared(taxel_positions_mm=((0, 0), (5, 0))), 3, (), "does not declare"),
        (Declared(taxel_positions_mm=((0, 0), (0, 0))), 2, (), "at one place"),
        (Declared(taxel_positions_mm=((0, 0), (5, 0))), 2, ("V", "N"), "not calibrated"),
    ],
)
def test_what_keeps_ratios_from_being_judged_is_said(declared, taxels, units, word):
    assert word in layout_of([recording(declared, taxels, taxel_units=units)])


def test_places_are_counted_from_the_contact_of_each_recording():
    said = declared_from(
        "{taxel_positions_mm: [[0, 0], [5, 0]], contact_position_mm: {made: [2, 1]}, spread_width_mm: 4, taxel_gain_uncertainty: 0.02}"
    )
    layout = layout_of([recording(said, 2), replace(recording(said, 2), name="other")])
    assert np.allclose(layout.places, 1e-3 * np.array([[[-2, -1], [3, -1]], [[0, 0], [5, 0]]]))
    assert layout.several_contacts and layout.width_declared and (layout.width, layout.gain_std) == (0.004, 0.02)
    assert declared_from("contact_position_mm: [1, 2]").contact_of("any") == (1.0, 2.0)
    with pytest.raises(RecordingError, match="contact_position_mm"):
        declared_from("contact_position_mm: [1, 2, 3, 4]")


def test_a_row_has_one_axis_and_a_cross_of_contacts_two():
    _, layout = array(3, 0)
    assert np.allclose(np.abs(layout.axes), [[1.0, 0.0]], atol=1e-6)
    assert len(replace(layout, contacts=np.array([[0.0, 0.0], [0.0, 4e-3]])).axes) == 2


@pytest.mark.parametrize("scale", [1.0, 6.0])
def test_a_shift_is_told_from_a_wrong_calibration_on_fine_arrays_and_coarse(scale):
    """Three taxels 1.6 mm apart, or six times that, under Gaussians written out here that all lie a fourteenth of their width elsewhere."""
    places = scale * np.array([[-0.8e-3, -0.65e-3], [0.8e-3, -0.65e-3], [0.0, 0.8e-3]])
    contacts = scale * np.array([[0.0, 0.0], [1e-3, -0.4e-3], [0.3e-3, 1.1e-3], [-1e-3, -0.4e-3]])
    width, off = scale * 2.5e-3, scale * np.array([0.15e-3, -0.1e-3])
    read = np.exp(-(np.linalg.norm(places - (contacts + off)[:, None], axis=2) ** 2) / width**2)
    layout = Layout(places, contacts, width, True, 0.008)
    verdict = judge(layout, measured(read, 5))
    assert verdict.named and verdict.named.key == ("off_centre", "rig") and not verdict.rivals
    shift = sum(verdict.named.fit.member[f"shift_{a}"] * axis for a, axis in enumerate(layout.axes))
    assert shift == pytest.approx(off, abs=0.3 * np.linalg.norm(off))


@pytest.mark.parametrize("in_turn", [False, True])
@pytest.mark.parametrize("back", [False, True])
def test_what_one_reading_leaves_in_the_next_is_crosstalk_and_no_other_place(back, in_turn):
    """A hundredth of the taxel that was read before it, or after it, as a multiplexer that does not settle leaves it. Where that does not
    rest in between, the last one is read before the first."""
    contacts = np.array([[1e-3, 0.0], [8e-3, 0.0], [11e-3, 0.0]])
    skin, layout = array(4, 0, contacts)
    shares = np.array([skin.shares(q) for q in contacts])
    heard = np.zeros_like(shares)
    heard[:, slice(None, -1) if back else slice(1, None)] = shares[:, slice(1, None) if back else slice(None, -1)]
    heard = np.roll(shares, -1 if back else 1, axis=1) if in_turn else heard
    verdict = judge(replace(layout, gain_std=0.01), measured(shares + 0.015 * heard, 7))
    assert verdict.named.key == ("crosstalk", "taxel")
    assert form_of(verdict.named) == ("next" if back else "previous") + "_in_turn" * in_turn
    assert ("after its own" if back else "before its own") in why(verdict.named, layout)
    assert ("off_centre", "rig") not in {j.key for j in verdict.rivals}


@pytest.mark.parametrize("held", [(0.5e-3, 3.5e-3), (-1.3e-3, -3e-3)])
def test_a_place_that_some_sessions_tell_is_the_same_place_in_all(held):
    """Fitted sessions whose contacts are nearly in the row of the taxels, and one that is held out beside it."""
    contacts = np.array([[0.0, 0.0], [1.8e-3, -0.02e-3], [-1.5e-3, 0.01e-3], held])
    skin, layout = array(3, 1, contacts)
    assert len(replace(layout, contacts=contacts[:3]).axes) == 1 and len(layout.axes) == 2
    train, off = [0, 1, 2], np.array([2e-4, 0.0])
    assert np.array_equal(layout.of(train).of([0]).axes, layout.axes)
    read = measured([skin.shares(q + off) for q in contacts[train]], 0)
    verdict = judge(layout.of(train), read)
    assert verdict.named.key == ("off_centre", "rig")
    found = ArrayCriticism(layout, read, verdict)
    assert shift_of(verdict.causes[0].fit.member, layout) == pytest.approx(off, abs=2e-4)  # across the row they hardly tell
    assert shift_of(verdict.causes[0].fit.member, layout)[0] == pytest.approx(off[0], abs=2e-5)
    told = Family(layout.of([3])).shares(verdict.causes[0].fit.member)[0]
    moved, plain = (skin.shares(contacts[3] + q) for q in (off, 0.0))
    assert np.abs(told - moved * np.mean(told) / np.mean(moved)).max() < 0.5 * np.abs(moved - plain * np.mean(moved) / np.mean(plain)).max()
    assert set(parameters(found.judgement.causes[0], layout)) == {"x", "y"}


def test_the_family_has_the_shares_of_the_world_under_a_moved_contact():
    skin, layout = array(4, 3)
    sign = layout.axes[0, 0]
    assert np.allclose(Family(layout).shares({"shift_0": 4e-4 * sign})[0], skin.shares((4e-4, 0.0)))


def test_the_evidence_of_a_linear_hypothesis_is_the_exact_marginal_likelihood():
    """With shares linear in one taxel's gain, and the scale's prior known, the integral is a Gaussian's."""
    skin, layout = array(3, 1, contacts=((0.0, 0.0),))
    found = measured([skin.shares()], 5, 0.01)
    scale = 3.0  # its logarithm is nearly linear over the little that the data leave of it
    plain, own = skin.shares(), skin.shares() * np.eye(3)[0]
    covariance = found.covariance[0] + 0.15**2 * np.outer(own, own)
    for scatter in (0.0, 0.02):
        more = covariance + scatter**2 * np.diag(found.value[0] ** 2) + scale**2 * np.outer(plain, plain)
        exact = multivariate_normal(plain, more).logpdf(found.value[0]) + 1.5 * np.log(2.0 * np.pi)
        assert fitted(Family(layout), found, scatter, {"gain_0": 0.15}).log_evidence == pytest.approx(exact, abs=0.3)


@pytest.mark.parametrize("n", [3, 4])
def test_shares_as_declared_or_scattered_by_calibrations_are_nobodys_fault(n):
    for seed in range(6):
        skin, layout = array(n, seed)
        for scatter in (0.0, 0.02):
            factors = 1.0 + scatter * np.random.default_rng(seed).standard_normal(n)
            assert judge(layout, measured([skin.shares() * factors] * 2, seed)).named is None


@pytest.mark.parametrize("seed", range(3))
def test_several_contacts_tell_a_wrong_place_from_a_wrong_calibration_and_from_crosstalk(seed):
    contacts = 1e-3 * np.array([[0.0, 0.0], [4.0, 0.0], [-4.0, 0.0]])
    skin, layout = array(3, seed, contacts)
    moved = np.array([skin.shares(q + np.array([2e-4, 0.0])) for q in contacts])
    plain = np.array([skin.shares(q) for q in contacts])
    leaking = np.eye(3) + 0.04 * (np.eye(3, k=1) + np.eye(3, k=-1))
    cases = {("off_centre", "rig"): moved, ("gain_error", "taxel_1"): plain * [1.0, 1.1, 1.0], ("crosstalk", "taxel"): plain @ leaking}
    for key, shares in cases.items():
        judgement = judge(layout, measured(shares, seed))
        assert judgement.named is not None and judgement.named.key == key and not judgement.rivals
        assert judgement.may_have_changed is None
    found = judge(layout, measured(moved, seed)).causes[0].fit
    assert found.member["shift_0"] * layout.axes[0, 0] == pytest.approx(2e-4, abs=4.0 * found.std["shift_0"])


@pytest.mark.parametrize("degrees", [-4.0, 2.0, 8.0])
def test_a_stage_that_is_turned_is_told_from_one_that_is_elsewhere(degrees):
    contacts = 1e-3 * np.array([[0.0, 0.0], [4.0, 1.0], [-1.0, 4.0], [-3.0, -3.0]])
    skin, layout = array(4, 2, contacts)
    angle = np.radians(degrees)
    turned = contacts @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    verdict = judge(layout, measured([skin.shares(q) for q in turned], 1))
    assert verdict.named.key == ("off_centre", "rig")
    assert not verdict.rivals or abs(degrees) < 3.0  # a spread that is wider aslant bends a row's ratios nearly so
    found = parameters(verdict.named, layout)
    assert found["angle"]["value"] == pytest.approx(angle, abs=4.0 * found["angle"]["std"])
    assert f"turned by {np.degrees(found['angle']['value']):+.2g}°" in why(verdict.named, layout)
    assert np.hypot(found["x"]["value"], found["y"]["value"]) < 1e-4


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("since", [1, 2])
def test_a_gain_that_changed_between_sessions_is_no_crosstalk_without_a_word_of_it(seed, since):
    skin, layout = array(3, seed, 1e-3 * np.array([[0.0, 0.0], [4.0, 0.0], [-4.0, 0.0]]))
    shares = np.array([skin.shares(q) for q in layout.contacts])
    shares[since:, 1] *= 1.04
    judgement = judge(layout, measured(shares, seed))
    assert judgement.named is None or judgement.may_have_changed == "taxel_1"


def test_one_contact_leaves_rivals_and_says_what_would_separate_them():
    skin, layout = array(3, 2, declared=False)
    shares = skin.shares() * [1.0, 1.0, 1.5]
    judgement = judge(layout, measured([shares] * 2, 0), 4.0)
    keys = {judgement.named.key, *(r.key for r in judgement.rivals)}
    assert {("off_centre", "rig"), ("gain_error", "taxel_2")} <= keys
    assert "press at three or more places" in separating(["off_centre", "gain_error"])


def test_a_declared_uncertainty_decides_whether_a_gain_is_wrong():
    skin, layout = array(4, 1)
    found = measured([skin.shares() * [1.06, 1.0, 1.0, 1.0]] * 2, 0)
    assert judge(replace(layout, gain_std=0.005), found).named.key == ("gain_error", "taxel_0")
    assert judge(replace(layout, gain_std=0.05), found).named is None


def test_what_is_left_open_is_told_the_most_probable_first():
    """The same in every run of a program, which lays out a set as chance has it."""
    skin, layout = array(4, 1)
    judgement = replace(judge(layout, measured([skin.shares() * [1.06, 1.0, 1.0, 1.0]] * 2, 0)), sure=0.8)
    told = [u["cause"] for u in untestable(ArrayCriticism(layout, None, judgement)) if u.get("left_open")]
    judged = [j.hypothesis.cause for j in judgement.causes]
    assert told == sorted(told, key=judged.index) and len(told) > 2


@pytest.mark.parametrize(("hearing", "heard", "seed"), [(3, 2, 1), (4, 0, 2), (0, 3, 3)])
def test_a_taxel_that_repeats_one_other_is_told_from_a_wrong_calibration_by_several_contacts(hearing, heard, seed):
    """A row of five at 5 mm under Gaussians written out here; what is repeated comes and goes with the place that is pressed."""
    places = np.array([[5e-3 * i, 0.0] for i in range(5)])
    contacts = np.array([[0.0, 0.0], [5e-3, 0.0], [11e-3, 0.0], [19e-3, 0.0]])
    plain = np.exp(-(np.linalg.norm(places - contacts[:, None], axis=2) ** 2) / 5.25e-3**2)
    read = plain.copy()
    read[:, hearing] += 0.08 * plain[:, heard]
    verdict = judge(Layout(places, contacts, 5.25e-3, True), measured(read, seed), None)
    assert verdict.named and verdict.named.key == ("crosstalk", f"taxel_{hearing}")
    assert verdict.named.fit.member[f"repeat_{hearing}_{heard}"] == pytest.approx(0.08, rel=0.1)
    assert not verdict.rivals


def test_a_taxel_that_repeats_another_under_one_contact_passes_for_a_wrong_calibration():
    skin, layout = array(5, 7)
    read = np.tile(skin.shares(), (2, 1))
    read[:, 2] *= 1.25  # which is a twentieth of taxel 1
    said = judge(layout, measured(read, 7), None)
    assert {j.key for j in (said.named, *said.rivals)} >= {("crosstalk", "taxel_2"), ("gain_error", "taxel_2")}


@pytest.mark.slow
def test_what_three_taxels_cannot_tell_is_bounded_by_no_expectation():
    """Neighbours that leak 10 % under one contact and a spread of unknown width: what is ruled out of crosstalk is not what is there."""
    leak, below = 0.1, []
    for seed in range(40):
        skin, layout = array(3, seed, declared=False)
        y = skin.shares()
        heard = y + leak * np.array([y[1], y[0] + y[2], y[1]])
        judgement = judge(layout, measured([heard, heard], seed), thickness_mm=6)
        if judgement.sure <= POSSIBLE:
            bounds = excluded(ArrayCriticism(layout, None, judgement))
            below.append(min((e["below"] for e in bounds if (e["cause"], e["where"]) == ("crosstalk", "taxel")), default=np.inf))
    assert len(below) > 5 and min(below) > leak


def test_a_dead_zone_of_one_taxel_leaves_the_shares_of_the_others_certain():
    dead = next(e for e in effects() if e.cause == "dead_zone" and e.form == "hard")
    skin = Dispersion(m=0.0, b1=0.0, k1=3000.0, b2=0.0, k2=1000.0)
    s = SimpleNamespace(motion=motion(np.arange(3.0), np.array([0.0, 1e-3, 0.0])))
    shares = np.array([0.01, 0.5, 0.01])
    own, all_alike = (Model(skin, shares=tuple(shares)).extended(dead(where, threshold=0.05)) for where in ("taxel_0", "taxel"))
    assert _swallowed(own, s, shares) == pytest.approx([0.05 / 3.0, 0.0, 0.0]) and np.count_nonzero(_swallowed(all_alike, s, shares)) == 2
