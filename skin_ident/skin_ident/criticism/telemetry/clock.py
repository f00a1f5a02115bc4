"""The clock: stamps that repeat or come out of order. Loading mends them and counts them; here it becomes a finding."""

from skin_ident.criticism.telemetry.symptom import Symptom, quantity
from skin_models.tables.order import Mended
from skin_models.words import counted


def find_clock_faults(recordings: list) -> list[Symptom]:
    """One symptom for all sessions, from what loading put right. Topics that lost as many stamps lost the same ones: they count once."""
    told = dict.fromkeys((r.name, *fault) for r in recordings for m in r.mended for fault in _faults(m))
    if not told:
        return []
    why = "the stamps do not rise evenly: " + "; ".join(f"{name}: {said}" for name, said, _ in told)
    samples = sum(count for _, _, count in told)
    return [Symptom("data_error", "clock", ("time",), {"samples": quantity(samples, "1")}, {"why": why, "kind": "broken time"})]


def _faults(m: Mended) -> list[tuple[str, int]]:
    """In words and numbers; a sample without any stamp says nothing of the clock."""
    said = [(f"{counted(m.late, 'sample')} out of order", m.late), (f"{counted(m.repeated, 'repeated time stamp')} dropped", m.repeated)]
    return [fault for fault in said if fault[1]]
