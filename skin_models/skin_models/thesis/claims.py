"""Statements of the running text that a table of the same thesis contradicts."""

from skin_models.thesis.comparison import Disagreement
from skin_models.thesis.tables import table, transfer_functions


def contradicted() -> list[Disagreement]:
    """Contradictions between text and tables, each checked against the table's numbers."""
    return _validation_speed() + _plunger_size()


def _validation_speed() -> list[Disagreement]:
    at_1mm_s = [name for name, t in zip(table("4-7").rows, transfer_functions(), strict=True) if t.speed == 1e-3]
    if at_1mm_s == ["1", "2"]:
        return []
    why = "section 4.3.2 averages `experiments 1 and 2` because they ran at 1 mm/s; Table 4-7 has 0.25 mm/s for experiment 1"
    return [Disagreement("text", "experiments at 1 mm/s", "1 and 2", " and ".join(at_1mm_s), why, False)]


def _plunger_size() -> list[Disagreement]:
    said = table("text")
    plunger, taxel = said.cell("plunger_diameter", "value"), said.cell("taxel_diameter", "value")
    if plunger.agrees(taxel.value):
        return []
    why = "section 3.3.3 turns the plunger `to be the same size as the sensing area of the taxels`, which section 3.3.1 gives as 9.53 mm"
    return [Disagreement("text", "plunger diameter, mm", str(plunger), str(taxel), why, False)]
