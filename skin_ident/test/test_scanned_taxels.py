"""Taxels that a multiplexer reads one after the other, under one time stamp."""

from dataclasses import replace

import numpy as np
import pytest
from rows import rows
from world import make_sessions, write_case

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.load import load


def scanned(session, samples: int, order: list[int]):
    """The session with every taxel so many samples later than the one that is read before it."""
    taxels = np.stack([np.roll(session.taxels[:, i], samples * turn) for i, turn in enumerate(order)], axis=1)
    return replace(session, **{name: getattr(session, name)[60:] for name in ("t", "x", "force")}, taxels=taxels[60:])


@pytest.mark.parametrize(("order", "sign"), rows([([0, 1, 2], 1.0), ([2, 1, 0], -1.0)], 0))
def test_taxels_that_are_read_in_turn_are_one_late_clock_and_not_a_lag_of_each(tmp_path, order, sign):
    sessions = make_sessions("null", seed=71, n_sessions=3, n_taxels=3)[0]
    write_case([scanned(s, 2, order) for s in sessions], tmp_path)
    recordings = load(tmp_path)
    findings = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert [(f["cause"], f["where"]) for f in findings] == [("time_shift", "clock")]
    later = [q["value"] for name, q in findings[0]["parameters"].items() if name.startswith("per_taxel")]
    assert later == [pytest.approx(sign * 2.0 * recordings[0].dt, rel=0.1)]
