"""A block that one channel repeats digit for digit was copied; what a coarse converter reads twice of the same motion was not."""

from dataclasses import replace

import numpy as np
import pytest
from test_faults import session

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telemetry.copied import find_copies
from skin_ident.criticism.telemetry.repeats import repeats_of
from skin_ident.recordings.recording import Recording

STEP = 0.002


def read(r, force_step=STEP):
    """As a converter of these steps reads it."""
    return replace(r, force=np.round(r.force / force_step) * force_step, taxels=np.round(r.taxels / STEP) * STEP)


def with_block(r, channel: str, start: int, length: int, back: int):
    """`length` samples of one channel once more, `back` samples later than they were."""
    rows = {"force": r.force.copy(), "taxels": r.taxels.copy()}
    row = rows["force"] if channel == "force" else rows["taxels"][int(channel[-1])]
    row[start : start + length] = row[start - back : start - back + length]
    return replace(r, **rows)


@pytest.mark.parametrize(("channel", "where"), [("force", "load_cell"), ("taxel_1", "taxel_1")])
@pytest.mark.parametrize("length", [30, 60, 300])
def test_a_block_that_one_channel_repeats_is_a_data_error(channel, where, length):
    recordings = [with_block(read(session(i)), channel, 1500 + 300 * i, length, 350) for i in range(3)]
    (found,) = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert (found["cause"], found["where"]) == ("data_error", where)
    assert f"{channel} alone" in found["evidence"]["why"]


def test_every_sample_of_the_block_is_left_out():
    recordings = [with_block(read(session(i)), "force", 1500, 300, 350) if i == 1 else read(session(i)) for i in range(3)]
    (symptom,) = find_copies(recordings)
    assert list(symptom.bad) == [(recordings[1].name, "force")]
    assert np.array_equal(np.flatnonzero(symptom.bad[recordings[1].name, "force"]), np.arange(1500, 1800))


@pytest.mark.parametrize("seed", range(5))
def test_sound_recordings_repeat_nothing(seed):
    assert find_copies([read(session(10 * seed + i)) for i in range(3)]) == []


def test_the_same_motion_read_in_coarse_steps_is_no_copy():
    """Three sessions of one motion, with noise far below the steps of the load cell."""
    once = read(session(3, noise=0.0005), force_step=0.1)
    rng = np.random.default_rng(0)
    again = [replace(once, name=f"again_{i}", taxels=once.taxels + 0.03 * rng.standard_normal(once.taxels.shape)) for i in range(2)]
    assert find_copies([once, *again]) == []


def test_a_repeat_is_told_by_where_it_is_and_where_it_was():
    rng = np.random.default_rng(1)
    rows = [rng.integers(0, 500, (800, 1)).astype(float) for _ in range(2)]
    rows[1][400:500] = rows[0][100:200]
    (r,) = repeats_of(rows)
    assert (r.at, r.start, r.source, r.origin, r.length) == (1, 400, 0, 100, 100)


def test_the_same_ramp_read_in_whole_steps_is_no_copy():
    """Two presses from different heights in the air, then one reading more with every sample."""
    x = np.concatenate([np.zeros(40), 1e-5 * np.arange(60), 6e-4 * np.ones(400)])
    rng = np.random.default_rng(0)

    def press(name, height):
        depth = np.where(x > 0.0, x, -height * np.linspace(1.0, 0.0, x.size))
        force = np.round(1e4 * x / 0.1 + 0.1 * rng.standard_normal(x.size)) * 0.1
        force[:100] = np.round(1e4 * x[:100] / 0.1) * 0.1
        return Recording(name, 0.01 * np.arange(x.size), depth, force, (5e3 * x + 0.01 * rng.standard_normal(x.size))[None])

    assert find_copies([press("one", 1e-4), press("other", 8e-4)]) == []
