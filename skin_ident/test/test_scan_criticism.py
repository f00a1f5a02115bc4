"""Effects hidden in scans by other means than the family that is fitted."""

from collections import Counter

import numpy as np
import pytest
import scan_making as making

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.scan import diagnose_scans
from skin_ident.criticism.vocabulary import CAUSES
from skin_ident.recordings.declared import Declared
from skin_ident.spread_scan import SpreadScan
from skin_models.materials import material


def names(findings):
    return [f["cause"] for f in findings["findings"]]


def rivals(findings):
    return [a["cause"] for f in findings["findings"] for a in f["alternatives"]]


@pytest.mark.parametrize("hidden", making.HIDDEN)
def test_names_what_is_hidden(hidden):
    scans, truth = making.make(hidden, size=2.0, seed=3)
    findings = diagnose_scans(scans).findings
    assert truth.cause in names(findings)
    gain = next(f["gain"] for f in findings["findings"] if f["cause"] == truth.cause)
    assert gain["held_out_rmse_after"] < gain["held_out_rmse_before"] and gain["ci95"][0] > 0.0
    assert findings["extended"]["rmse"]["taxel_0"]["held_out"] < 1.5 * truth.noise
    assert findings["verdict"] in ("explained", "partly_explained")


@pytest.mark.parametrize("noise", making.NOISES)
def test_nothing_wrong_where_nothing_is_hidden(noise):
    for seed, options in enumerate(({}, {"two_sided": True}, {"both": True})):
        scans, truth = making.make(None, seed=seed + 40, noise=noise, **options)
        findings = diagnose_scans(scans).findings
        assert findings["verdict"] == "nothing_wrong" and not findings["findings"]
        if noise in ("white", "fine", "coarse"):  # elsewhere the floor is not the same for all cells
            assert findings["noise_floor"]["taxel_0"]["rms"] == pytest.approx(truth.noise, rel=0.35)


def test_every_cause_lands_in_exactly_one_place():
    for hidden, size in (("tail_leaky", 1.0), ("oval", 1.0), (None, 0.0)):
        findings = diagnose_scans(making.make(hidden, size, seed=1)[0]).findings
        said = [*dict.fromkeys([*names(findings), *rivals(findings)]), *(e["cause"] for e in findings["excluded"] + findings["untestable"])]
        assert Counter(said) == Counter(c.name for c in CAUSES)


def test_one_side_cannot_tell_a_centre_from_a_shape_and_two_sides_can():
    scans, _ = making.make("beside", size=3.0, seed=0)
    assert names(diagnose_scans(scans).findings) == ["off_centre"]
    s = scans[0]
    one = SpreadScan(s.depth, s.distance[11:], s.force[:, 11:], name="one_side.csv")
    findings = diagnose_scans([one]).findings
    assert {"off_centre", "spread_shape"} <= {*names(findings), *rivals(findings)}
    assert any("both sides" in f["separating_experiment"] for f in findings["findings"])
    plain = diagnose_scans([making.make(None, seed=2)[0][0]]).findings
    assert "one side" in next(e["because"] for e in plain["untestable"] if e["cause"] == "off_centre")


def scan_of(width, k, seed=0, name="scan.csv"):
    rng = np.random.default_rng(seed)
    z = np.arange(1, 11)[:, None] * 1e-4
    f = making.plain(z, making.SIDE, k, width) + 0.06 * rng.normal(size=(10, making.SIDE.size))
    return SpreadScan(z[:, 0], making.SIDE, np.round(f, 1), name=name)


def test_a_given_model_is_taken_as_it_is():
    model = material("silicone_4mm").model  # width 5.25 mm, k1 9619 N/m
    assert diagnose_scans([scan_of(5.25e-3, 9619.0)], model=model).findings["verdict"] == "nothing_wrong"
    findings = diagnose_scans([scan_of(4.4e-3, 9619.0)], model=model).findings
    assert names(findings) == ["spread_width"]
    assert findings["findings"][0]["parameters"]["width"]["value"] == pytest.approx(4.4e-3, rel=0.02)
    findings = diagnose_scans([scan_of(5.25e-3, 1.15 * 9619.0)], model=model).findings
    assert names(findings) == ["parameters"] and rivals(findings) == ["gain_error"]


def test_a_declared_width_is_held_against_the_scans():
    def found(width_mm, scans):
        said = Declared(spread_width_mm=width_mm)
        return diagnose_scans([SpreadScan(s.depth, s.distance, s.force, s.name, declared=said) for s in scans]).findings

    scans = [scan_of(5.9e-3, 9e3, 1, "a.csv"), scan_of(5.9e-3, 9e3, 2, "b.csv")]
    findings = found(5.25, scans)
    assert names(findings) == ["spread_width"] and not rivals(findings)
    assert findings["findings"][0]["parameters"]["width"]["value"] == pytest.approx(5.9e-3, rel=0.02)
    assert findings["baseline"]["parameters"]["width"] == {"value": 5.25e-3, "unit": "m", "std": None}
    findings = found(5.9, scans)
    assert findings["verdict"] == "nothing_wrong" and "spread_width" in [e["cause"] for e in findings["excluded"]]
    silent = diagnose_scans(scans).findings["untestable"]
    assert "spread_width_mm" in next(e["because"] for e in silent if e["cause"] == "spread_width")


def test_held_out_scans_are_the_gate_when_there_are_some():
    train, held = scan_of(5e-3, 9e3, 1, "a.csv"), scan_of(5e-3, 8e3, 2, "b.csv")
    findings = diagnose_scans([train], [held]).findings
    assert findings["verdict"] == "nothing_wrong" and [r["held_out"] for r in findings["recordings"]] == [False, True]
    scan = making.make("flat_punch", 2.0, seed=5)[0][0]
    more = np.random.default_rng(0).normal(0, 0.06, scan.force.shape)
    again = SpreadScan(scan.depth, scan.distance, np.round(scan.force + more, 1), name="again.csv")
    findings = diagnose_scans([scan], [again]).findings
    assert "spread_shape" in names(findings) and "held out" in findings["findings"][0]["evidence"]["held_out"]


@pytest.mark.parametrize(("widths", "said"), [((4e-3, 6.5e-3), True), ((5e-3, 5e-3), False)], ids=["two skins", "one skin"])
def test_scans_that_contradict_each_other_are_not_called_noise(widths, said):
    """What one width of both leaves repeats at all depths, as if the plunger had stood beside every distance."""
    findings = diagnose_scans([scan_of(width, 9e3, i, f"{i}.csv") for i, width in enumerate(widths)]).findings
    assert any("no spread in common" in w for w in findings["warnings"]) is said
    assert (findings["verdict"] in ("partly_explained", "unexplained")) is said


def test_every_held_out_scan_has_a_size_of_its_own():
    train, held = [scan_of(5e-3, 9e3, 1, "a.csv")], [scan_of(5e-3, 20e3, 2, "b.csv"), scan_of(5e-3, 24e3, 3, "c.csv")]
    findings = diagnose_scans(train, held).findings
    assert findings["verdict"] == "nothing_wrong" and findings["baseline"]["rmse"]["taxel_0"]["held_out"] < 0.1


ONE = Declared(skin_thickness_mm=4.0)
PLACED = Declared(skin_thickness_mm=4.0, contact_position_mm={"a.csv": (0.0, 0.0), "b.csv": (20.0, 0.0)})


@pytest.mark.parametrize("held", [False, True])
def test_one_taxel_that_reads_more_in_a_second_scan_has_another_gain_or_another_skin(held):
    def found(k, declared=ONE, late=0.0):
        a, b = scan_of(5e-3, 9e3, 1), scan_of(5e-3, k, 2)
        scans = [SpreadScan(a.depth, a.distance, a.force, "a.csv", declared=declared.of("a.csv"))]
        scans += [SpreadScan(b.depth + late, b.distance, b.force, "b.csv", declared=declared.of("b.csv"))]
        return diagnose_scans(scans[:1], scans[1:]).findings if held else diagnose_scans(scans).findings

    findings = found(1.06 * 9e3)
    assert names(findings) == ["gain_error"] and rivals(findings) == ["parameters"]
    entry = findings["findings"][0]
    size = entry["parameters"]["change_b.csv"]
    assert entry["where"] == "taxel" and abs(size["value"] - 0.06) < 3.0 * size["std"] < 0.03
    assert "known load" in entry["separating_experiment"]
    for unsure in (Declared(), PLACED):  # of which nobody says that they are of one taxel under one skin
        findings = found(1.06 * 9e3, unsure)
        assert findings["verdict"] == "nothing_wrong" and any("more than a.csv" in w for w in findings["warnings"])
    for same in (found(9e3), found(1.01 * 9e3), found(9e3, late=2e-5)):  # as it repeats, and with another zero of depth
        assert "gain_error" not in names(same) and not any("a.csv" in w for w in same["warnings"])


def test_noise_is_held_against_what_is_declared():
    scan = scan_of(5e-3, 9e3)
    said = SpreadScan(scan.depth, scan.distance, scan.force, declared=Declared(taxel_noise_n=(0.02,), taxel_step_n=(0.1,)))
    assert names(diagnose_scans([said]).findings) == ["noise"]


def test_few_depths_or_distances_make_causes_untestable_not_wrong():
    scan = scan_of(5e-3, 9e3)
    shallow = diagnose_scans([SpreadScan(scan.depth[-2:], scan.distance, scan.force[-2:])]).findings
    narrow = diagnose_scans([SpreadScan(scan.depth, scan.distance[:5], scan.force[:, :5])]).findings
    for findings, cause, words in ((shallow, "nonlinear_stiffness", "2 depths"), (narrow, "spread_shape", "5 distances")):
        assert findings["verdict"] == "nothing_wrong"
        assert words in next(e["because"] for e in findings["untestable"] if e["cause"] == cause)


def test_lost_cells_are_left_out():
    scan = making.make("hertz_law", 2.0, seed=1)[0][0]
    force = scan.force.copy()
    force[2, 3] = force[5, 7] = np.nan
    outcome = diagnose_scans([SpreadScan(scan.depth, scan.distance, force)])
    assert names(outcome.findings) == ["nonlinear_stiffness"] and np.isfinite(outcome.scans[0].extended).all()


def test_scans_and_sessions_are_diagnosed_apart():
    class Session:
        name = "session.tsv"

    with pytest.raises(DiagnosisError, match="separately"):
        diagnose([scan_of(5e-3, 9e3), Session()])


@pytest.mark.parametrize("held", [[], [scan_of(5e-3, 9e3)]])
def test_nothing_is_nothing_to_diagnose(held):
    with pytest.raises(DiagnosisError, match="no recording to diagnose"):
        diagnose([], held)


@pytest.mark.campaign
@pytest.mark.parametrize("noise", ["white", "fine", "coarse", "growing", "heavy"])
def test_false_alarms(noise):
    options = ({}, {"two_sided": True}, {"depths": 6}, {"both": True})
    alarms = [i for i in range(120) if diagnose_scans(making.make(None, seed=i, noise=noise, **options[i % 4])[0]).findings["findings"]]
    assert len(alarms) <= 2, alarms


@pytest.mark.campaign
@pytest.mark.parametrize("hidden", making.HIDDEN)
def test_rate_of_names_where_the_effect_is_as_large_as_the_noise(hidden):
    right = 0
    for seed in range(20):
        scans, truth = making.make(hidden, 1.0, seed)
        findings = diagnose_scans(scans).findings
        right += truth.cause in {*names(findings), *rivals(findings)}
    assert right >= (12 if hidden in ("flat_edged", "clips") else 17)
