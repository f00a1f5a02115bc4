"""What shows in the tables themselves: steps, copies, slips of the pen."""

import numpy as np
import pytest
import scan_making as making

from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.scan import diagnose_scans
from skin_ident.criticism.scan.copies import resolution
from skin_ident.criticism.scan.diagnose import direction
from skin_ident.criticism.scan.faults import look
from skin_ident.criticism.scan.levels import find_levels
from skin_ident.recordings.declared import Declared
from skin_ident.spread_scan import SpreadScan
from skin_ident.thesis_spread import thesis_scan
from skin_models.tables.units import FORCE


def spoilt(kind, seed):
    scan = making.make(None, seed=seed)[0][0]
    f, rng = scan.force.copy(), np.random.default_rng(seed)
    d, j = int(rng.integers(2, f.shape[0] - 1)), int(rng.integers(0, 5))
    if kind == "copied row":
        f[d] = f[d - 1]
    if kind == "half a row copied":
        f[d, :6] = f[d - 2, :6]
    if kind == "copied column":
        f[:, j + 1] = f[:, j]
    if kind == "row in kgf":
        f[d] /= 9.80665
    if kind == "row in mN":
        f[d] *= 1e3
    if kind == "column tenfold":
        f[:, j] *= 10
    if kind == "exchanged columns":
        f[:, [j, j + 2]] = f[:, [j + 2, j]]
    if kind == "exchanged rows":
        f[[d, d - 2]] = f[[d - 2, d]]
    if kind == "point slipped":
        f[d, 0] *= 10
    return SpreadScan(scan.depth, scan.distance, np.round(f, 4), name="scan.csv"), scan.depth[d], scan.distance[j]


KINDS = ["copied row", "half a row copied", "copied column", "row in kgf", "row in mN", "column tenfold"]
KINDS += ["exchanged columns", "exchanged rows", "point slipped"]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_a_slip_is_a_data_error_that_names_its_place(kind, seed):
    scan, depth, distance = spoilt(kind, seed)
    faults = look([scan], [""], Declared()).faults
    assert {f.cause for f in faults} == {"data_error"}
    place = distance if "column" in kind else depth
    assert any(np.isclose(p["value"], place) for f in faults for p in f.parameters.values())


@pytest.mark.parametrize("unit", ["n", "mn", "kgf", "gf", "lbf"])
def test_the_last_decimal_is_that_of_the_unit_it_was_written_in(unit):
    written = np.round(np.random.default_rng(1).uniform(0.0, 2.0, 130), 3)
    assert resolution(FORCE[unit] * written) == pytest.approx(1e-3 * FORCE[unit])


@pytest.mark.parametrize("unit", ["n", "kgf", "lbf"])
def test_readings_that_are_equal_far_from_the_taxel_are_no_copies_in_any_unit(unit):
    depth, distance = np.arange(1, 11) * 1e-4, np.linspace(0.0, 12e-3, 13)
    for seed in range(3):
        noise = 0.004 * np.random.default_rng(seed).normal(size=(10, 13))
        force = making.plain(depth[:, None], distance, 8e3, 3e-3) + noise
        written = np.round(force / FORCE[unit], 2 if unit == "n" else 3)
        assert not look([SpreadScan(depth, distance, FORCE[unit] * written)], [""], Declared()).faults


@pytest.mark.parametrize("noise", making.NOISES)
def test_clean_tables_have_no_faults(noise):
    for seed in range(3):
        scans = making.make(None, seed=seed, noise=noise, two_sided=seed == 1, both=seed == 2)[0]
        assert not look(scans, ["x", "y"][: len(scans)], Declared()).faults


def test_single_readings_far_off_are_outliers_and_left_out():
    """Two readings that a description good to 3 % of the force would forgive, and that alone double the scatter of the table."""
    rng = np.random.default_rng(3)
    depth, distance = np.arange(1, 11) * 1e-4, np.arange(13) * 1e-3
    clean = making.plain(depth[:, None], distance, 9619.0, 5.25e-3)
    force = clean + 0.04 * rng.normal(size=clean.shape)
    force[4, 3] += 1.0
    force[7, 8] -= 1.0
    outcome = diagnose_scans([SpreadScan(depth, distance, np.round(force / 0.098) * 0.098, name="scan.csv")])
    (found,) = outcome.findings["findings"]
    assert (found["cause"], found["where"]) == ("outliers", "taxel")
    told = sorted([c[key]["value"] for key in ("depth", "distance", "expected")] for c in found["evidence"]["cells"])
    assert np.allclose([t[:2] for t in told], [(depth[4], distance[3]), (depth[7], distance[8])])
    assert np.allclose([t[2] for t in told], [clean[4, 3], clean[7, 8]], atol=0.1)
    assert outcome.findings["noise_floor"]["taxel_0"]["rms"] < 1.3 * np.hypot(0.04, 0.098 / np.sqrt(12.0))
    assert outcome.findings["verdict"] == "explained"


def test_a_slip_does_not_spoil_the_rest():
    scan, *_ = spoilt("copied row", 4)
    findings = diagnose_scans([scan]).findings
    assert [f["cause"] for f in findings["findings"]] == ["data_error"] and findings["verdict"] == "explained"


def test_the_copied_thesis_table_is_recognised_alone():
    faults = look([thesis_scan("4-11")], [""], Declared()).faults
    assert [f.cause for f in faults] == ["data_error"] and "4 of 5 rows" in faults[0].why and "0.2, 0.3, 0.4, 0.5 mm" in faults[0].why
    assert not look([thesis_scan("4-10")], [""], Declared()).faults  # the table itself is no copy of itself


def test_a_scan_that_is_mostly_copied_is_not_fitted():
    findings = diagnose_scans([thesis_scan("4-11")]).findings
    assert [f["cause"] for f in findings["findings"]] == ["data_error"]
    because = {e["cause"]: e["because"] for e in findings["untestable"]}
    assert "too little" in because["spread_shape"] and "no time" in because["lag"]
    assert "too few" in because["outliers"] and "outliers" not in {e["cause"] for e in findings["excluded"]}
    assert any("12 of 60 readings" in w for w in findings["warnings"])


def in_units(*factors):
    """Scans of like skins, named 0, 1 ..., whose readings are in units of 1 / factor N."""
    scans = [making.make(None, seed=11)[0][0] for _ in factors]
    more = [np.random.default_rng(i).normal(0, 0.03, s.force.shape) for i, s in enumerate(scans)]
    every = enumerate(zip(factors, scans, more, strict=True))
    return [SpreadScan(s.depth, s.distance, f * (s.force + e), name=f"{i}") for i, (f, s, e) in every]


@pytest.mark.parametrize(("factors", "odd"), [((1, 1, 1e3), 2), ((1e3, 1, 1), 0), ((1, 9.80665, 1, 1), 1), ((9.80665, 1, 1, 1), 0)])
def test_the_scan_that_differs_from_most_is_in_another_unit_wherever_it_stands(factors, odd):
    (fault,) = [f for f in look(in_units(*factors), [""] * len(factors), Declared()).faults if "factor that only a unit has" in f.why]
    assert f"the force over depth of {odd} is" in fault.why and "may as well" not in fault.why
    assert fault.parameters["factor"]["value"] == pytest.approx(factors[odd], rel=0.03)
    assert fault.bad.sum() == fault.bad.size / len(factors)


def test_of_two_scans_in_different_units_either_may_be_wrong():
    (fault,) = look(in_units(1, 1e3), ["", ""], Declared()).faults
    assert "of 1 is" in fault.why and "times that of 0" in fault.why and "may as well be" in fault.why


def part_of(scan, rows, columns):
    return SpreadScan(scan.depth[rows], scan.distance[columns], scan.force[rows, columns], name="part.csv")


ONE_ROW, THREE_BY_THREE, TWO_ROWS = (slice(9, None), slice(None)), (slice(0, 9, 4), slice(0, 9, 3)), (slice(3, 9, 5), slice(0, 9, 2))


@pytest.mark.parametrize(("rows", "columns"), [ONE_ROW, THREE_BY_THREE, TWO_ROWS])
def test_a_scan_too_small_to_be_judged_is_refused(rows, columns):
    with pytest.raises(DiagnosisError, match="too few"):
        diagnose_scans([part_of(making.make(None, seed=1)[0][0], rows, columns)])


def test_two_rows_are_fitted_but_not_searched_for_slips():
    findings = diagnose_scans([part_of(making.make(None, seed=1)[0][0], slice(3, 9, 5), slice(None))]).findings
    because = {e["cause"]: e["because"] for e in findings["untestable"]}
    assert all("too few" in because[cause] for cause in ("outliers", "data_error"))
    assert "dead_taxel" in {e["cause"] for e in findings["excluded"]}


def test_levels_of_a_converter():
    rng = np.random.default_rng(0)
    y = rng.uniform(0, 10, 150)
    assert find_levels(y) is None and find_levels(np.round(y, 3)) is None
    assert find_levels(np.round(y / 0.25) * 0.25).step == pytest.approx(0.25)
    assert find_levels(thesis_scan("4-10").force.ravel()).step == pytest.approx(0.1, abs=0.005)


def test_steps_are_held_against_what_is_declared():
    scans = making.make(None, seed=1, noise="coarse")[0]
    coarse = look(scans, [""], Declared(taxel_step_n=(0.1,))).faults
    assert [f.cause for f in coarse] == ["quantization"] and coarse[0].parameters["step"]["value"] == pytest.approx(0.4)
    looked = look(scans, [""], Declared())
    assert not looked.faults and "0.4 N apart" in looked.known["quantization"]


def test_a_taxel_that_does_not_answer():
    scan = thesis_scan("4-10")
    noise = np.round(np.random.default_rng(2).normal(0.1, 0.05, scan.force.shape), 2)
    for silent in (noise, np.full(scan.force.shape, 0.3)):
        findings = diagnose_scans([SpreadScan(scan.depth, scan.distance, silent, name="silent.csv")]).findings
        assert [f["cause"] for f in findings["findings"]] == ["dead_taxel"]


@pytest.mark.parametrize("zero", [-4.0, -10.0, 10.0])
def test_a_taxel_that_was_not_tared_answers_all_the_same(zero):
    (scan,) = making.make(None, seed=1)[0]
    (found,) = diagnose_scans([SpreadScan(scan.depth, scan.distance, scan.force + zero, name="scan.csv")]).findings["findings"]
    assert (found["cause"], found["where"]) == ("force_offset", "taxel")
    assert found["parameters"]["offset"]["value"] == pytest.approx(zero, abs=0.1)


def test_pressing_must_not_make_readings_negative():
    scan = thesis_scan("4-10")
    with pytest.raises(DiagnosisError, match="negative"):
        diagnose_scans([SpreadScan(scan.depth, scan.distance, -scan.force)])


@pytest.mark.parametrize(("name", "says"), [("scan_x.csv", "x"), ("2-y.tsv", "y"), ("xy.csv", ""), ("x_and_y.csv", ""), ("a.csv", "")])
def test_a_file_name_may_say_the_direction(name, says):
    scan = thesis_scan("4-10")
    assert direction(SpreadScan(scan.depth, scan.distance, scan.force, name=name)) == says
