"""Frozen samples are found; a force that stands still with the plunger, by play in the drive, has none."""

import numpy as np
import pytest
from world import make_sessions, write_case

from skin_ident.criticism.record import inspect
from skin_ident.criticism.telemetry.outliers import find_outliers
from skin_ident.recordings.load import load


@pytest.mark.parametrize("taxels", [1, 3])
def test_frozen_runs_are_found(tmp_path, taxels):
    sessions, _ = make_sessions("outliers", "load_cell", "frozen", size=2.0, seed=1, n_sessions=2, n_taxels=taxels, noise="white")
    write_case(sessions, tmp_path)
    assert [(s.cause, s.where) for s in inspect(load(tmp_path)).symptoms] == [("outliers", "load_cell")]


@pytest.mark.parametrize("taxels", [1, 3])
def test_a_plunger_with_play_freezes_nothing(taxels):
    """Triangles of 2 s, at whose reversals the plunger rests for 0.1 s; the simulation knows of no play. Steps of 0.07 N hide the noise."""
    rng, t = np.random.default_rng(2), np.arange(6000) * 0.01
    way = 15.0 - 10.0 * np.abs(t % 2.0 - 1.0)
    rests = np.maximum.accumulate(np.where((t % 1.0 > 0.1) | (t < 1.0), np.arange(t.size), 0))
    share = np.array([1.0, 0.4, 0.3, 0.2])[: taxels + 1, None]
    raw = 0.07 * np.round((share * way[rests] + 0.01 * rng.standard_normal((taxels + 1, t.size))) / 0.07)
    channels = ("force", *(f"taxel_{i}" for i in range(taxels)))
    assert not find_outliers(["a"], channels, [raw - share * way], [raw], [np.zeros(t.size, bool)], taxels, 0.01)
