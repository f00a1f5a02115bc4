"""A depth whose zero is far from the surface: no small offset shows the way to a large one."""

from dataclasses import replace

import numpy as np
import pytest
from making import response
from rows import rows

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.sessions.surface import surface_of
from skin_ident.recordings.recording import Recording

DT = 0.01


def session(seed: int, offset: float) -> Recording:
    """Presses of several depths out of the air; the tip is `offset` m deeper than the encoder says."""
    rng, t = np.random.default_rng(seed), np.arange(5000) * DT
    w, phase = 2.0 * np.pi * np.array([0.2, 0.53, 1.1]), rng.uniform(0.0, 2.0 * np.pi, (3, 1))
    size, angle = np.array([[0.5e-3], [0.25e-3], [0.06e-3]]), np.outer(w, t) + phase
    x = 0.35e-3 + np.sum(size * np.sin(angle), axis=0)
    v, a = np.sum(size * w[:, None] * np.cos(angle), axis=0), -np.sum(size * w[:, None] ** 2 * np.sin(angle), axis=0)
    force, taxels = response((x, v, a), shares=(1.0, 0.4), dt=DT)
    noise = 0.01 * rng.standard_normal((3, t.size))
    read = np.round((x - offset) / 1e-6) * 1e-6
    return Recording(f"session_{seed}", t, read, force + noise[0], taxels + noise[1:])


@pytest.mark.parametrize("offset", rows([-0.2e-3, -0.1e-3, -0.5e-3, 0.2e-3, 0.3e-3], 0))
def test_an_offset_of_tenths_of_a_millimetre_is_no_curved_skin(offset):
    sessions = [session(seed, offset) for seed in range(3)]
    (found,) = diagnose(sessions[:2], sessions[2:]).findings["findings"]
    assert (found["cause"], found["where"]) == ("position_offset", "rig")
    assert found["parameters"]["offset"]["value"] == pytest.approx(offset, abs=4e-6)


@pytest.mark.parametrize("offset", [-0.4e-3, -0.1e-3, 0.2e-3])
def test_the_force_begins_where_the_encoder_reads_the_offset_the_other_way_round(offset):
    taxels_alone = [replace(session(seed, offset), force=None) for seed in range(2)]
    for sessions in ([session(0, offset)], taxels_alone):
        assert surface_of([prepare(s) for s in sessions]) == pytest.approx(-offset, abs=5e-6)


def test_a_surface_near_the_zero_of_the_encoder_is_that_and_a_driving_force_has_none():
    assert surface_of([prepare(session(0, offset)) for offset in (0.0, 1e-6)]) == 0.0
    assert surface_of([prepare(replace(session(0, -0.4e-3), depth=None))]) == 0.0
