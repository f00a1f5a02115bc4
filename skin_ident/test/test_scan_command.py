"""Scans through the command line: files in, findings, model and report out."""

import json
from importlib.resources import files

import pytest
import scan_making as making

from skin_ident.cli.diagnose import main
from skin_models.model_file import load_model
from skin_models.spread.noted import kernel_of
from skin_models.spread.tabulated import Tabulated

TABLE = files("skin_models") / "data" / "thesis" / "table_4_10.csv"


def write(scan, path):
    head = ",".join(["depth_mm", *(f"f_{1e3 * d:g}mm_n" for d in scan.distance)])
    rows = [",".join(f"{v:.6g}" for v in (1e3 * z, *f)) for z, f in zip(scan.depth, scan.force, strict=True)]
    path.write_text("\n".join([head, *rows]) + "\n")
    return str(path)


def test_a_table_becomes_findings_a_model_and_a_report(tmp_path, capsys):
    scans, _ = making.make("flat_ball", 3.0, seed=2)
    (tmp_path / "rig.yaml").write_text("taxel_step_n: 0.1\n")
    assert main([write(scans[0], tmp_path / "scan.csv"), "--out", str(tmp_path / "out")]) == 0
    findings = json.loads((tmp_path / "out" / "findings.json").read_text())
    assert findings["schema"] == 1 and findings["findings"][0]["cause"] == "spread_shape"
    assert "quantization" in {e["cause"] for e in findings["excluded"]}
    assert isinstance(kernel_of(load_model(tmp_path / "out" / "model.yaml").notes), Tabulated)
    assert load_model(tmp_path / "out" / "baseline.yaml").dispersion.k1 > 0.0
    assert (tmp_path / "out" / "report.html").stat().st_size > 10_000 and (tmp_path / "out" / "before_after.png").exists()
    assert "spread_shape" in capsys.readouterr().out


def test_scans_in_x_and_y_are_told_by_their_names(tmp_path):
    scans, _ = making.make("oval", 2.0, seed=1)
    paths = [write(s, tmp_path / s.name) for s in scans]
    assert main([*paths, "--out", str(tmp_path / "out")]) == 0
    findings = json.loads((tmp_path / "out" / "findings.json").read_text())
    assert [f["cause"] for f in findings["findings"]] == ["anisotropy"]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("depth_mm,f_0mm_n,f_1mm_n,f_3mm_n,f_5mm_n\n" + "".join(f"{z},{-9 * z},{-8 * z},{-5 * z},{-z}\n" for z in (1, 2, 3)), "negative"),
        ("depth_mm,f_0mm_n,f_1mm_n\n0.1,1,0.5\n", "3 or more distances"),
        ("depth_mm,f_0mm,f_1mm,f_2mm\n0.1,1,0.5,0.2\n", "unit of force"),
    ],
)
def test_scans_that_cannot_be_used_are_refused_in_one_line(tmp_path, capsys, content, says):
    (tmp_path / "scan.csv").write_text(content)
    assert main([str(tmp_path / "scan.csv"), "--out", str(tmp_path / "out")]) == 2
    error = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error")]
    assert len(error) == 1 and says in error[0] and not (tmp_path / "out" / "findings.json").exists()


def test_a_scan_beside_a_session_is_refused(tmp_path, capsys):
    write(making.make(None, seed=1)[0][0], tmp_path / "scan.csv")
    (tmp_path / "session.tsv").write_text("t_s\tx_mm\tforce_n\n" + "".join(f"{0.01 * i}\t{0.01 * i}\t{0.1 * i}\n" for i in range(200)))
    assert main([str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    assert "diagnosed separately" in capsys.readouterr().err


@pytest.mark.parametrize("kept", [[], ["again.csv"]])
def test_taxels_of_scans_are_no_choice(tmp_path, capsys, kept):
    scan = making.make(None, seed=1)[0][0]
    write(scan, tmp_path / "scan.csv"), write(scan, tmp_path / "again.csv")
    held = ["--hold-out", *(str(tmp_path / name) for name in kept)] if kept else []
    assert main([str(tmp_path / "scan.csv"), *held, "--taxels", "0", "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "error: scan.csv is a static spread scan, of one taxel: leave --taxels out" in said and "looking at the tables" not in said
    assert not (tmp_path / "out").exists()
