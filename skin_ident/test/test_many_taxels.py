"""Recordings with many taxels: some are chosen by name, and all of them are searched, a few together and the others in groups."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from rows import rows

from skin_ident import criticism
from skin_ident.cli.diagnose import main
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.many import Rest, loaded_most, renamed, some, symptom_of_all, with_rest
from skin_ident.criticism.search.size import affordable
from skin_ident.criticism.telemetry.dead import find_dead_taxels
from skin_ident.recordings.chosen import only_taxels
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.recording import Recording

T = np.arange(3000) / 100.0
LOAD = 2.0 + np.sin(0.9 * T) + 0.5 * np.sin(5.1 * T)


def many(count):
    rng = np.random.default_rng(0)
    shares = np.linspace(0.9, 0.1, count)
    taxels = shares[:, None] * LOAD + 0.02 * rng.standard_normal((count, T.size))
    declared = Declared(taxel_noise_n=tuple(shares), taxel_positions_mm=tuple((float(i), 0.0) for i in range(count)), taxel_step_n=(0.1,))
    return Recording("many", T, None, LOAD, taxels, declared=declared)


def test_chosen_taxels_keep_what_is_declared_for_them():
    (r,) = only_taxels([many(10)], ["7", "taxel_2"])
    assert r.taxel_names == ("taxel_7", "taxel_2") and np.array_equal(r.taxels[1], many(10).taxels[2])
    assert r.declared.taxel_positions_mm == ((7.0, 0.0), (2.0, 0.0)) and r.declared.taxel_step_n == (0.1,)
    assert r.declared.taxel_noise_n == tuple(np.linspace(0.9, 0.1, 10)[[7, 2]])


@pytest.mark.parametrize(("names", "word"), [(["12"], "has no taxel_12"), (["1", "1"], "twice")])
def test_names_that_are_not_there(names, word):
    with pytest.raises(RecordingError, match=word):
        only_taxels([many(10)], names)


def test_a_search_takes_what_memory_has_and_refuses_in_a_sentence():
    assert affordable([many(12)], 6) == 6 and affordable([many(64)] * 12, 6) < 6
    with pytest.raises(DiagnosisError, match="name two taxels of interest with --taxels"):
        affordable([many(64)] * 400, 6)


def grid(seed, spoil=lambda taxels: taxels, count=25):
    """A record of as many taxels on a grid, 5 mm apart, on silicone."""
    rng = np.random.default_rng(seed)
    places = np.array([(5.0 * (i % 5) - 10.0, 5.0 * (i // 5) - 10.0) for i in range(count)])
    shares = np.exp(-((places**2).sum(axis=1) / 6.0**2)) * (1.0 + 0.01 * np.random.default_rng(0).standard_normal(count))
    depth = 1e-4 * np.convolve(np.interp(T, np.arange(0.0, 31.0, 0.7), rng.uniform(1.0, 8.0, 45)), np.hanning(31) / 15.0, "same")
    sensed = 9619.0 * depth + 939.5 * np.gradient(depth, 0.01)
    force = sensed * 1.29 + 0.02 * rng.standard_normal(T.size)
    taxels = spoil(shares[:, None] * sensed) + 0.02 * rng.standard_normal((count, T.size))
    declared = Declared(taxel_positions_mm=tuple(map(tuple, places.tolist())), spread_width_mm=6.0)
    return Recording(f"grid_{seed}", T, depth, force, taxels, declared=declared)


def clipped(taxels):
    out = taxels.copy()
    out[7] = np.minimum(out[7], 0.6 * out[7].max())
    return out


def lagging(taxels):
    out = taxels.copy()
    for n in range(1, T.size):
        out[2, n] = out[2, n - 1] + 0.05 * (taxels[2, n] - out[2, n - 1])
    return out


COUNTED = "taxels are counted from 0: taxel_0 is taxel_1, taxel_5 is taxel_6"  # said in reading, of all taxels


@pytest.mark.parametrize(("spoil", "expected"), rows([(lagging, ("lag", "taxel_2")), (clipped, ("saturation", "taxel_7"))], 0))
def test_what_a_taxel_has_of_its_own_is_found_among_many(spoil, expected):
    recordings = [grid(i, spoil).warned(COUNTED) for i in range(2)]
    few = loaded_most(recordings)
    assert 12 in few and len(few) <= 6
    outcome = diagnose(recordings)
    assert expected in [(f["cause"], f["where"]) for f in outcome.findings["findings"]]
    assert len(outcome.model.shares) == 25 and outcome.model.shares[13] == pytest.approx(np.exp(-25 / 36), rel=0.05)
    assert "the others, in groups" in outcome.findings["warnings"][0] and "taxel_12" in outcome.findings["baseline"]["rmse"]
    assert outcome.findings["warnings"][1] == f"every session: {COUNTED}"
    assert all(COUNTED in r["warnings"] for r in outcome.findings["recordings"])


def test_numbers_are_those_of_all_taxels():
    said = {"taxel_1": ["share_0 of taxel_2", 3], "taxel_10": ("taxel_1", "b")}
    assert renamed(said, [4, 7, 9]) == {"taxel_7": ["share_4 of taxel_9", 3], "taxel_10": ("taxel_7", "b")}


def silent_between(count, taxel, declared):
    """As many taxels in a row, of which one reads noise alone between two that feel the load, far from the contact."""
    rng, shares = np.random.default_rng(0), np.full(count, 0.3)
    shares[taxel] = 0.0
    places = tuple((5.0 * i, 0.0) for i in range(count)) if declared else ()
    taxels = shares[:, None] * LOAD + 0.01 * rng.standard_normal((count, T.size))
    return Recording("row", T, None, LOAD, taxels, declared=Declared(taxel_positions_mm=places))


def test_a_taxel_that_others_promise_a_reading_is_told_with_their_numbers_among_all():
    among = [6, 8, 9]
    row = silent_between(12, 8, declared=True)
    (found,) = find_dead_taxels(some([row], among))
    told = symptom_of_all(found, among)
    assert told.where == "taxel_8" and "though taxel_6 and taxel_9 on both sides of it say" in told.evidence["why"]
    (alone,) = find_dead_taxels([row])
    assert alone.where == "taxel_8" and "though taxel_0 and taxel_11 on" in alone.evidence["why"]


def test_three_chosen_out_of_more_are_no_row():
    """Without a layout the second of three lies between the others, unless they are some of many that were numbered together."""
    assert [s.where for s in find_dead_taxels([silent_between(3, 1, declared=False)])] == ["taxel_1"]
    assert not find_dead_taxels(some([silent_between(12, 4, declared=False)], [0, 4, 11]))


def test_every_sentence_names_a_taxel_as_its_channel():
    """So that it can be told under another number: `taxels 0 and 2` could not."""
    sources = Path(criticism.__file__).parent.rglob("*.py")
    assert not [path.name for path in sources if re.search(r"taxels [{\d]", path.read_text(encoding="utf-8"))]


def test_names_of_files_are_no_numbers_of_taxels():
    """A recording may be called after a taxel: its name stays, wherever it stands, and a taxel beside it is renumbered."""
    why = "taxel_0.csv: taxel_0 holds one value, as in old taxel 1.csv"
    said = {
        "recordings": [{"name": "taxel_0.csv", "warnings": [why]}, {"name": "old taxel 1.csv"}, {"name": "taxel_1"}],
        "findings": [{"where": "taxel_1", "evidence": {"held_out": "taxel_1", "sessions": {"taxel_0.csv": [1.0]}, "why": why}}],
    }
    told = why.replace("taxel_0 holds", "taxel_4 holds")
    assert renamed(said, [4, 7]) == {
        "recordings": [{"name": "taxel_0.csv", "warnings": [told]}, {"name": "old taxel 1.csv"}, {"name": "taxel_1"}],
        "findings": [{"where": "taxel_7", "evidence": {"held_out": "taxel_1", "sessions": {"taxel_0.csv": [1.0]}, "why": told}}],
    }


def test_a_doubt_about_another_taxel_outlives_a_finding_of_the_same_cause():
    found = {"cause": "lag", "where": "taxel_9", "alternatives": [{"cause": "dead_zone", "where": "taxel_9"}]}
    doubts = [{"cause": "lag", "where": f"taxel_{i}", "because": "half of the data", "in_doubt": True} for i in (9, 8)]
    reasons = [{"cause": "lag", "because": "slow"}, doubts[0] | {"cause": "dead_zone"}]
    joint = {"findings": [], "excluded": [], "untestable": [reasons[0]], "verdict": "nothing_wrong", "warnings": []}
    findings = with_rest(joint, (), Rest((), (found,), (*doubts, reasons[1]), (), (), {}), [0, 1], 12)
    assert findings["untestable"] == [doubts[1], reasons[1]]


def test_what_good_hardware_does_in_the_others_is_said():
    said = {"cause": "saturation", "where": "taxel_9", "because": "a converter may do it", "needs": "finer steps"}
    joint = {"findings": [], "excluded": [], "untestable": [], "verdict": "nothing_wrong", "warnings": []}
    findings = with_rest(joint, (), Rest((), (), (said,), (), (), {}), [0, 1], 12)
    assert findings["untestable"] == [said] and findings["verdict"] == "nothing_wrong"


def test_the_command_says_which_taxel_is_which(tmp_path, capsys):
    r = many(12)
    columns = {"t_s": r.t, "force_n": r.force} | {f"taxel_{i}_n": y for i, y in enumerate(r.taxels)}
    np.savetxt(tmp_path / "a.csv", np.column_stack(list(columns.values())), "%.6g", ",", header=",".join(columns), comments="")
    assert main([str(tmp_path / "a.csv"), "--taxels", "11", "3", "--out", str(tmp_path / "out")]) == 0
    assert "taxel_0 is taxel_11, taxel_1 is taxel_3" in capsys.readouterr().out
    findings = json.loads((tmp_path / "out" / "findings.json").read_text())
    assert list(findings["baseline"]["rmse"]) == ["taxel_0", "taxel_1"] and findings["taxels"]["taxel_0"] == "taxel_11"
