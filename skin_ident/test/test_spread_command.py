"""`fit` on static spread scans, and the spread that the shares of an array draw."""

import json
import re

import numpy as np
import pytest
from making import SILICONE, recording, write_table

from skin_ident.cli.fit import main
from skin_ident.spread_fit import fit_gaussian
from skin_ident.spread_plane import fit_plane
from skin_ident.thesis_spread import thesis_scan


def write_scan(path, scan):
    head = ",".join(["depth_mm", *(f"f_{1e3 * x:g}mm_n" for x in scan.distance)])
    rows = [",".join([f"{1e3 * d:g}", *(f"{f:g}" for f in force)]) for d, force in zip(scan.depth, scan.force, strict=True)]
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def test_the_thesis_own_scan_is_fitted(tmp_path, capsys):
    path = write_scan(tmp_path / "scan.csv", thesis_scan("4-10"))
    (tmp_path / "rig.yaml").write_text("taxel_step_n: 0.107\n")
    assert main([str(path), "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "converter steps of 0.107 N" in said and "10 depths" in said
    rows = json.loads((tmp_path / "out" / "fit.json").read_text())["scans"]["scan.csv"]
    deepest = rows[-1]
    assert deepest["a_n"]["value"] == pytest.approx(10.45, abs=0.01) and deepest["c_mm"]["value"] == pytest.approx(5.245, abs=0.01)


def test_scans_of_one_name_in_two_folders_are_both_kept(tmp_path):
    paths = []
    for day, table in (("monday", "4-10"), ("tuesday", "4-11")):
        (tmp_path / day).mkdir()
        paths.append(str(write_scan(tmp_path / day / "scan.csv", thesis_scan(table))))
    assert main([*paths, "--out", str(tmp_path / "out")]) == 0
    scans = json.loads((tmp_path / "out" / "fit.json").read_text())["scans"]
    assert list(scans) == ["scan.csv (1)", "scan.csv (2)"] and scans["scan.csv (1)"] != scans["scan.csv (2)"]


def test_a_scan_of_nothing_is_refused(tmp_path, capsys):
    path = tmp_path / "scan.csv"
    path.write_text("depth_mm,f_0mm_n,f_1mm_n,f_2mm_n,f_3mm_n\n0.1,1,1,1,1\n0.2,1,1,1,1\n")
    assert main([str(path)]) == 2 and "does not fall with distance" in capsys.readouterr().err


def test_readings_on_a_grid_are_not_believed_beyond_it():
    x = np.linspace(0.0, 14e-3, 8)
    y = 0.3 * np.exp(-((x / 5e-3) ** 2))
    fits = [fit_gaussian(x, np.rint(y / 0.107 + p) * 0.107 - p * 0.107, step=0.107) for p in np.linspace(0, 0.9, 10)]
    z = [(f.c - 5e-3) / f.c_std for f in fits if not f.reason]
    assert np.sqrt(np.mean(np.square(z))) < 1.6 and min(f.a_std for f in fits if not f.reason) > 0.01


def test_a_plane_of_taxels():
    rng = np.random.default_rng(0)
    places = np.array([(x, y) for x in range(-8, 9, 4) for y in range(-8, 9, 4)]) * 1e-3
    true = np.exp(-np.sum((places - (1e-3, -0.5e-3)) ** 2, axis=1) / 5e-3**2)
    z = []
    for _ in range(60):
        fit = fit_plane(places, true + 0.01 * rng.normal(size=25), np.full(25, 0.01))
        z.append((np.array([fit.bx - 1e-3, fit.by + 0.5e-3, fit.c - 5e-3])) / np.array(fit.std[1:]))
    assert np.all((np.std(z, axis=0) > 0.7) & (np.std(z, axis=0) < 1.3))
    assert "line" in fit_plane(places[:5], true[:5], np.full(5, 0.01)).reason


def test_shares_of_an_array_draw_its_spread(tmp_path, capsys):
    places = [(x, y) for x in (-4, 0, 4) for y in (-4, 0, 4)]
    shares = [np.exp(-((x - 1) ** 2 + y**2) / 25) for x, y in places]
    write_table(tmp_path / "a.csv", recording(0, shares=tuple(np.array(shares) / max(shares)), n=1500))
    (tmp_path / "rig.yaml").write_text(f"taxel_positions_mm: {[list(p) for p in places]}\nmoving_mass_kg: {SILICONE[4][0]}\n")
    assert main([str(tmp_path / "a.csv"), "--out", str(tmp_path / "out")]) == 0
    centre = re.search(r"spread over the taxels: centre \((\S+) ± ", capsys.readouterr().out)
    assert float(centre[1]) == pytest.approx(1.0, abs=0.05)
    spread = json.loads((tmp_path / "out" / "fit.json").read_text())["notes"]["spread"]
    assert spread["x_mm"]["value"] == pytest.approx(1.0, abs=0.05) and spread["c_mm"]["value"] == pytest.approx(5.0, rel=0.02)
