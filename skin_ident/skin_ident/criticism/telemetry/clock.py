"""The clock: time stamps that repeat or are out of order. Loading repairs and counts them; here they become a finding."""

from skin_ident.criticism.telemetry.symptom import Symptom, quantity
from skin_models.tables.order import Mended
from skin_models.words import counted


def find_clock_faults(recordings: list) -> list[Symptom]:
    """One symptom for all sessions, from what loading repaired. Topics that lost the same number of stamps are taken to have lost the same
    ones and count once."""
    told = dict.fromkeys((r.name, *fault) for r in recordings for m in r.mended for fault in _faults(m))
    if not told:
        return []
    why = "the stamps do not rise evenly: " + "; ".join(f"{name}: {said}" for name, said, _ in told)
    samples = sum(count for _, _, count in told)
    return [Symptom("data_error", "clock", ("time",), {"samples": quantity(samples, "1")}, {"why": why, "kind": "broken time"})]


def _faults(m: Mended) -> list[tuple[str, int]]:
    """The faults of one repair, in words and numbers. Samples without any stamp are not counted: they are no fault of the clock."""
    said = [(f"{counted(m.late, 'sample')} out of order", m.late), (f"{counted(m.repeated, 'repeated time stamp')} dropped", m.repeated)]
    return [fault for fault in said if fault[1]]
