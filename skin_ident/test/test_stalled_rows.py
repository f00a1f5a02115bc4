"""A logger that writes one row again and again is told where the plunger went on meanwhile, and a plunger at rest is not."""

from dataclasses import replace

import numpy as np
import pytest
from world import make_sessions, write_case

from skin_ident.criticism.record import inspect
from skin_ident.criticism.telemetry.stalled import find_stalled
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import Recording

T = np.arange(4000) / 100.0


def stalled(session, start: int, length: int):
    """The session with row `start` in the place of so many that follow."""
    rows = {name: getattr(session, name).copy() for name in ("x", "force", "taxels")}
    for row in rows.values():
        row[start : start + length] = row[start]
    return replace(session, **rows)


@pytest.mark.parametrize("length", [40, 150])
def test_rows_that_stand_while_the_plunger_moves_are_told_and_not_believed(tmp_path, length):
    sessions = make_sessions("null", seed=31, n_sessions=2, n_taxels=2)[0]
    x = sessions[1].x
    start = int(np.argmax(np.abs(x[length:] - x[:-length])))
    write_case([sessions[0], stalled(sessions[1], start, length)], tmp_path)
    recordings = load(tmp_path)
    (symptom,) = inspect(recordings).symptoms
    assert (symptom.cause, symptom.where, symptom.evidence["kind"]) == ("data_error", "clock", "repeated rows")
    assert np.flatnonzero(symptom.bad[recordings[1].name, "force"]) == pytest.approx(np.arange(start + 1, start + length))
    assert not find_stalled(recordings[:1])
    (later,) = find_stalled([replace(r, t=r.t + 1000.0) for r in recordings])
    since = later.parameters["from"]["value"]
    assert since == pytest.approx(1000.0 + (start + 1) * recordings[1].dt) and f"from {since:.2f} s on" in later.evidence["why"]


def test_a_plunger_that_rests_without_noise_is_no_logger_that_stands():
    depth = 1e-3 * np.interp(T, [0.0, 5.0, 20.0, 22.0, 30.0, 31.0, 40.0], [0.0, 0.4, 0.4, 0.9, 0.9, 0.1, 0.1])
    assert not find_stalled([Recording("rests", T, depth, 1e4 * depth, 5e3 * depth[None])])
