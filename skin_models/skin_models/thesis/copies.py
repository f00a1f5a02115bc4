"""Rows of one table that stand, digit by digit, in another: a record that cannot be what it says."""

from skin_models.thesis.comparison import Disagreement
from skin_models.thesis.tables import Table, table


def copied_rows() -> list[Disagreement]:
    """The rows of Table 4-11 (Frubber) that repeat rows of Table 4-10 (silicone), although their columns stand at other distances."""
    silicone, frubber = table("4-10"), table("4-11")
    twins = [(row, _twin(cells, silicone)) for row, cells in frubber.rows.items()]
    return [_copied(row, twin, frubber) for row, twin in twins if twin is not None]


def _twin(cells: dict, other: Table) -> str | None:
    return next((row for row, others in other.rows.items() if list(others.values()) == list(cells.values())), None)


def _copied(row: str, twin: str, frubber: Table) -> Disagreement:
    n = len(frubber.columns)
    why = f"all {n} numbers equal Table 4-10's row of {twin} mm silicone, whose columns skip 2 mm and end at 12 mm: copied, not measured"
    return Disagreement("4-11", f"{row} mm, all distances", " ".join(str(c) for c in frubber.rows[row].values()), "unknown", why, False)
