"""Dead taxels: one that never moves while the load does, or that says nothing where the only taxel should."""

import numpy as np

from skin_ident.criticism.telemetry.symptom import Symptom, place_of

SILENT = 0.02  # of the applied force that a taxel under the plunger would feel at the very least


def find_dead_taxels(recordings: list) -> list[Symptom]:
    """Taxels that are stuck (the same value throughout) or, where there is but one, open (no relation to depth or force)."""
    n = len(recordings[0].taxels)
    found = []
    for i in range(n):
        rows = [r.taxels[i] for r in recordings]
        stuck = all(np.ptp(row) == 0.0 for row in rows)
        if stuck or (n == 1 and all(_silent(r, row) for r, row in zip(recordings, rows, strict=True))):
            why = f"taxel_{i} holds one value throughout" if stuck else f"taxel_{i} does not follow the load"
            found.append(Symptom("dead_taxel", place_of(f"taxel_{i}", n), (f"taxel_{i}",), {}, {"why": why, "stuck": bool(stuck)}))
    return found


def _silent(recording, row: np.ndarray) -> bool:
    load = recording.force if recording.force is not None else recording.depth
    if load is None or np.ptp(load) == 0.0:
        return False
    load = load - load.mean()
    slope = float(load @ (row - row.mean()) / (load @ load))
    correlation = slope * np.std(load) / max(np.std(row), 1e-300)
    return abs(correlation) < 0.2 and (recording.force is None or abs(slope) < SILENT)
