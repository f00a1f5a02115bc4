"""One format, one reader: what the fit reads of a table the driver replays, and what one refuses the other refuses in the same words."""

import numpy as np
import pytest

from skin_ident.recordings.load import load
from skin_models.errors import SkinError
from skin_testbed_driver.rigs.table import read_table

ROWS = [["t_s", "x_mm", "force_n", "taxel_0_n"]]
ROWS += [[f"{0.01 * i:.2f}", f"{0.02 * i:.3f}", f"{0.3 * i + 0.1 * (i % 3):.2f}", f"{0.1 * i + 0.05 * (i % 2):.3f}"] for i in range(60)]


def table(mark=",", **cells):
    """The good table with other cells: `r5c1="one"` is row 5 (0 is the header), column 1."""
    rows = [list(row) for row in ROWS]
    for place, cell in cells.items():
        row, column = place[1:].split("c")
        rows[int(row)][int(column)] = cell
    return "\n".join(map(mark.join, rows)) + "\n"


def column_of(text, column=1, rows=range(1, 61)):
    return table(**{f"r{i}c{column}": text for i in rows})


ACCEPTED = {
    "commas": table(), "tabs": table("\t"), "semicolons": table(";"),
    "other units": table(r0c0="Time (ms)", r0c1="Position [um]", r0c2="F [mN]", r0c3="taxel 0 (N)"),
    "quotes": table(r5c1='"0.1"'), "comments": "# mine\n" + table(), "byte order mark": "\ufeff" + table(),
    "an empty cell": table(r5c1=""), "a cell of nan": table(r5c1="nan"), "a cell of n/a": table(r5c1="N/A"), "infinity": table(r5c3="inf"),
    "text in a cell": table(r5c1="one"), "a row cut short": table().rsplit(",", 1)[0],
    "a repeated stamp": table(r5c0=ROWS[4][0]), "a late sample": "\n".join(map(",".join, [*ROWS[:9], ROWS[10], ROWS[9], *ROWS[11:]])),
}  # fmt: skip
REFUSED = {
    "nothing": "", "comments alone": "# mine\n", "no header": "\n".join(table().splitlines()[1:]), "no rows": ",".join(ROWS[0]) + "\n",
    "text in a column": column_of("one"), "text in every fifth cell": column_of("one", rows=range(1, 61, 5)),
    "a column of no numbers": column_of(""), "rows cut short": "\n".join([",".join(ROWS[0]), *(",".join(r[:3]) for r in ROWS[1:])]),
    "spaces": table(" "), "decimal commas": table("\t").replace(".", ","), "no unit": table(r0c1="x"), "a wrong unit": table(r0c1="x_n"),
    "an unknown column": table(r0c3="banana"), "two depths": table(r0c3="depth_mm"), "two times": table(r0c3="time_ms"),
    "two columns of one name": table(r0c1="taxel_0_n"), "rows backwards": "\n".join(map(",".join, [ROWS[0], *reversed(ROWS[1:])])),
    "decimal commas between commas": ",".join(ROWS[0]) + "\n" + "\n".join(",".join(r).replace(".", ",") for r in ROWS[1:]),
    "a clock that steps back": "\n".join(map(",".join, [*ROWS, *ROWS[1:]])),
    "millimetres that are metres": table(r0c1="x_m"), "kilonewtons": table(r0c2="force_kn", r9c2="1e4"), "no time": table(r0c0="taxel_1_n"),
}  # fmt: skip


def both(path):
    """What the fit reads, and what the driver does: recordings or sentences."""
    for read in (lambda: load(path)[0], lambda: read_table(path)):
        try:
            yield read()
        except SkinError as error:
            yield str(error).replace(str(path), path.name)


@pytest.mark.parametrize("case", ACCEPTED)
def test_what_one_reads_the_other_reads(tmp_path, case):
    (tmp_path / "a.csv").write_text(ACCEPTED[case], encoding="utf-8")
    fitted, replayed = both(tmp_path / "a.csv")
    same = ~np.isnan(replayed.depth.values) & np.isfinite(replayed.taxels.values[:, 0])
    at = replayed.depth.t[same] - replayed.depth.t[0]
    for name, ours in (("depth", fitted.depth), ("force", fitted.force), ("taxels", fitted.taxels[0])):
        theirs = getattr(replayed, name).values.reshape(same.size, -1)[same, 0]
        assert np.allclose(np.interp(at, fitted.t - fitted.t[0], ours), theirs, atol=1e-9), name
    assert set(replayed.warnings) <= set(fitted.warnings)


@pytest.mark.parametrize("case", REFUSED)
def test_what_one_refuses_the_other_refuses_in_the_same_words(tmp_path, case):
    (tmp_path / "a.csv").write_text(REFUSED[case], encoding="utf-8")
    fitted, replayed = both(tmp_path / "a.csv")
    assert isinstance(fitted, str) and isinstance(replayed, str) and "\n" not in fitted
    assert fitted.replace(", or declare sample_rate_hz in rig.yaml", "").replace(str(tmp_path) + "/", "") == replayed


def test_text_among_numbers_is_quoted_not_called_missing(tmp_path):
    (tmp_path / "a.csv").write_text(ACCEPTED["text in a cell"])
    assert all("1 row with text in column x_mm ('one') dropped" in " ".join(r.warnings) for r in both(tmp_path / "a.csv"))
    (tmp_path / "a.csv").write_text(REFUSED["text in a column"])
    assert all("'one' in column x_mm is no number" in said for said in both(tmp_path / "a.csv"))


@pytest.mark.parametrize(
    ("case", "says"), [("rows backwards", "sort its rows by time"), ("decimal commas between commas", "write them with points")]
)
def test_what_to_do_is_said(tmp_path, case, says):
    (tmp_path / "a.csv").write_text(REFUSED[case])
    assert all(says in said for said in both(tmp_path / "a.csv"))


@pytest.mark.parametrize("taxels", [0, 1])
def test_what_was_imported_is_what_the_table_holds(tmp_path, taxels):
    pytest.importorskip("skin_testbed_msgs")
    from skin_testbed_driver.ros.import_table import import_table

    text = table() if taxels else "\n".join(line.rsplit(",", 1)[0] for line in table().splitlines())
    (tmp_path / "a.csv").write_text(text)
    import_table(tmp_path / "a.csv", tmp_path / "bag", start=1.7e9)
    (before,), (after,) = load(tmp_path / "a.csv"), load(tmp_path / "bag")
    assert after.kind == before.kind and len(after.taxels) == taxels
    assert np.allclose(after.depth, before.depth, atol=1e-12) and np.allclose(after.force, before.force) and not after.warnings


def test_an_infinite_number_is_said_to_be_infinite(tmp_path):
    (tmp_path / "a.csv").write_text(table(r5c2="inf"))
    said = "force: 1 infinite number, taken for missing"
    assert said in load(tmp_path / "a.csv")[0].warnings and said in read_table(tmp_path / "a.csv").warnings
