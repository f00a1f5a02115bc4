"""Recordings with many taxels: some are chosen by name, and too many are refused before memory is."""

import json

import numpy as np
import pytest

from skin_ident.cli.diagnose import main
from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.size import check_size
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


def test_too_many_taxels_are_refused_in_a_sentence():
    check_size([many(8)])
    with pytest.raises(DiagnosisError, match="name those of interest with --taxels"):
        check_size([many(64)] * 10)


def test_the_command_says_which_taxel_is_which(tmp_path, capsys):
    r = many(12)
    columns = {"t_s": r.t, "force_n": r.force} | {f"taxel_{i}_n": y for i, y in enumerate(r.taxels)}
    np.savetxt(tmp_path / "a.csv", np.column_stack(list(columns.values())), "%.6g", ",", header=",".join(columns), comments="")
    assert main([str(tmp_path / "a.csv"), "--taxels", "11", "3", "--out", str(tmp_path / "out")]) == 0
    assert "taxel_0 is taxel_11, taxel_1 is taxel_3" in capsys.readouterr().out
    findings = json.loads((tmp_path / "out" / "findings.json").read_text())
    assert list(findings["baseline"]["rmse"]) == ["taxel_0", "taxel_1"] and findings["taxels"]["taxel_0"] == "taxel_11"
