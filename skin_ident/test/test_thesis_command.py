"""The thesis read closely, for anyone who asks on a command line."""

import json

from skin_ident.cli.thesis import main


def test_the_mass_of_table_4_4_is_called_what_it_is(tmp_path, capsys):
    assert main(["--runs", "2", "--out", str(tmp_path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "m = 0.269 kg (thesis 0.27), the skin's own 216 mg" in said and "stands for a constant force of -2.64 N" in said
    assert "thesis 6.28 %" in said and "speed^2.24" in said and "nan" not in said
    found = json.loads((tmp_path / "thesis.json").read_text())
    for mm in ("2mm", "4mm", "6mm"):
        free, rows = found["table_4_4"][mm], found["table_4_5"][mm]
        assert free["verdict"] == "not identifiable" and free["mass_kg"] > 300 * free["mass_of_the_skin_kg"]
        assert abs(free["fall_of_k2"] / free["fall_of_k2_in_the_thesis"] - 1) < 0.03
        assert abs(rows["k1"]["value"] / rows["k1"]["specimen"] - 1) < 1e-3 and abs(rows["b1"]["value"] / rows["b1"]["specimen"] - 1) < 0.03
        assert max(found["validation"][mm]["same_sample"]) < 0.01
    assert found["frubber"]["relative_mse"]["slower"] > 10 * found["frubber"]["relative_mse"]["same_speed"]
    assert [f["cause"] for f in found["table_4_10"]["findings"]] == ["nonlinear_stiffness", "spread_shape"]
    assert "spread_shape (the spread is not a Gaussian)" in said and "RMSE 0.163 to 0.131 N" in said
    assert "Table 4-11, 2.5 mm, all distances" in said and len(found["data_error"]) == 25
