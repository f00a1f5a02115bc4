"""The clock: stamps that repeat or come out of order. Loading mends them and says so; here it becomes a finding."""

import re

from skin_ident.criticism.telemetry.symptom import Symptom, quantity

FAULTS = (r"(\d+) repeated time stamps? dropped", r"(\d+) samples? out of order")


def find_clock_faults(recordings: list) -> list[Symptom]:
    """One symptom for all sessions, from the warnings that loading left."""
    told = {(r.name, m[0]): int(m[1]) for r in recordings for w in r.warnings for f in FAULTS for m in [re.search(f, w)] if m}
    if not told:
        return []
    why = "the stamps do not rise evenly: " + "; ".join(f"{name}: {said}" for name, said in told)
    return [Symptom("data_error", "clock", ("time",), {"samples": quantity(sum(told.values()), "1")}, {"why": why, "kind": "broken time"})]
