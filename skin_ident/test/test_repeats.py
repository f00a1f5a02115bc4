"""A block that one channel repeats digit for digit was copied; what a coarse converter reads twice of the same motion was not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from making import write_bag
from test_faults import session
from world import make_sessions, write_case

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telemetry.copied import find_copies
from skin_ident.criticism.telemetry.repeats import repeats_of
from skin_ident.recordings.chosen import only_taxels
from skin_ident.recordings.load import load
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


def at_rest(r, start: int, length: int):
    """The recording with its plunger held still from `start` on, in noise of six steps."""
    part, rng = slice(start, start + length), np.random.default_rng(3)
    depth, force, taxels = r.depth.copy(), r.force.copy(), r.taxels.copy()
    depth[part] = depth[start]
    force[part] = force[start] + 6.0 * STEP * rng.standard_normal(length)
    taxels[:, part] = taxels[:, start : start + 1] + 6.0 * STEP * rng.standard_normal((len(taxels), length))
    return replace(r, depth=depth, force=force, taxels=taxels)


@pytest.mark.parametrize("length", [40, 120])
def test_a_block_sent_twice_in_a_hold_is_a_data_error_where_noise_would_have_changed_it(length):
    """The depth does not tell then, but noise of several steps does not repeat."""
    still = [read(at_rest(session(i), 1500, 500)) for i in range(2)]
    (symptom,) = find_copies([with_block(still[0], "force", 1800, length, length), still[1]])
    assert symptom.where == "load_cell" and f"{length} samples" in symptom.evidence["why"]
    assert find_copies(still) == []


def test_every_sample_of_the_block_is_left_out():
    recordings = [with_block(read(session(i)), "force", 1500, 300, 350) if i == 1 else read(session(i)) for i in range(3)]
    (symptom,) = find_copies(recordings)
    assert list(symptom.bad) == [(recordings[1].name, "force")]
    assert np.array_equal(np.flatnonzero(symptom.bad[recordings[1].name, "force"]), np.arange(1500, 1800))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_many_short_blocks_do_not_make_long_ones_look_like_chance(seed):
    """Blocks of 12 to 60 samples, each sent twice in a row while the plunger moves, in noise of several steps of the converter."""
    rng = np.random.default_rng(seed)
    r = read(session(seed, noise=4.0 * STEP), force_step=STEP)
    force, moving = r.force.copy(), np.flatnonzero(np.abs(np.gradient(r.depth, r.dt)) > 2e-4)
    for start in rng.choice(moving[(moving > 100) & (moving < len(r) - 100)], 25, replace=False):
        n = int(rng.integers(12, 60))
        force[start : start + n] = force[start - n : start]
    (symptom,) = find_copies([replace(r, force=force)])
    assert symptom.where == "load_cell" and np.count_nonzero(symptom.bad[r.name, "force"]) > 300
    assert find_copies([r]) == []


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("length", [9, 12, 16])
@pytest.mark.parametrize("which", ["force", "every channel"])
def test_a_packet_sent_twice_is_found_though_it_is_short(which, length, seed):
    """Three packets, each followed by itself, in noise of four steps of the converter."""
    rng = np.random.default_rng(seed)
    sound = read(session(seed, noise=4.0 * STEP))
    force, taxels, starts = sound.force.copy(), sound.taxels.copy(), 500 + 700 * np.arange(3) + rng.integers(0, 300, 3)
    for start in starts:
        force[start : start + length] = force[start - length : start]
        if which != "force":
            taxels[:, start : start + length] = taxels[:, start - length : start]
    (symptom,) = find_copies([replace(sound, force=force, taxels=taxels)])
    assert (len(symptom.channels) > 1) == (which != "force") and "so do 2 more" in symptom.evidence["why"]
    assert all(symptom.bad[sound.name, "force"][start : start + length].all() for start in starts)
    assert find_copies([sound]) == []


@pytest.mark.parametrize("step", [0.002, 0.01, 0.05])
@pytest.mark.parametrize("hertz", [50.0, 25.0, 10.0])
def test_a_line_whose_period_is_a_whole_number_of_samples_is_no_packet_sent_twice(hertz, step):
    r = session(1, noise=0.004)
    line = 0.1 * np.sin(2.0 * np.pi * hertz * r.t) * (np.sin(0.3 * r.t) > 0.0)  # at times it is off
    assert find_copies([read(replace(r, force=r.force + line), force_step=step)]) == []


@pytest.mark.parametrize("seed", [0, 2])
@pytest.mark.parametrize("hertz", [49.95, 49.7])
def test_hum_near_half_the_sampling_rate_that_comes_in_bursts_is_no_packet_sent_twice(hertz, seed):
    """In a hold it lets a coarse converter alternate between two readings, for as long as the burst lasts."""
    rng = np.random.default_rng([3, seed])
    r = at_rest(session(1 + seed, noise=0.02), 1500, 700)
    on = np.repeat(rng.random(-(-len(r.t) // 80)) < 0.4, 80)[: len(r.t)]
    assert find_copies([read(replace(r, force=r.force + 0.1 * on * np.sin(2.0 * np.pi * hertz * r.t)), force_step=0.068)]) == []


def test_a_sensor_that_stands_still_repeats_no_packets():
    assert repeats_of([np.full((4000, 1), 0.5)]) == []


def tabled(folder, r, late) -> Path:
    """A table of the recording, each stamp as `late` as it says, s."""
    rows = np.array([r.t + late, 1e3 * r.depth, r.force, *r.taxels]).T
    names = ",".join(f"taxel_{i}_n" for i in range(len(r.taxels)))
    np.savetxt(folder / f"{r.name}.csv", rows, "%.9g", ",", header=f"t_s,x_mm,force_n,{names}", comments="")
    return folder / f"{r.name}.csv"


@pytest.mark.parametrize("jitter", [0.0, 0.03, 0.2])
def test_a_block_is_found_though_stamps_are_uneven(tmp_path, jitter):
    """Samples are interpolated there, and repeat no longer: their digits are kept beside them."""
    rng, made = np.random.default_rng(1), [read(session(i)) for i in range(2)]
    made[1] = with_block(made[1], "taxel_1", 1500, 300, 350)
    late = [jitter * r.dt * rng.uniform(-1.0, 1.0, len(r)) for r in made]
    recordings = [one for r, off in zip(made, late, strict=True) for one in load(tabled(tmp_path, r, off))]
    assert [bool(r.digits) for r in recordings] == [jitter > 0.0] * 2
    (symptom,) = find_copies(recordings)
    assert symptom.where == "taxel_1" and np.flatnonzero(symptom.bad[recordings[1].name, "taxel_1"]) == pytest.approx(np.arange(1500, 1800))


@pytest.mark.parametrize("periods", [0.3, 0.5])
def test_a_block_is_found_in_a_topic_that_has_stamps_of_its_own(tmp_path, periods):
    """Half a period late either neighbour is as near, and stamps tremble."""
    rng = np.random.default_rng(1)

    def late(store, i, message):
        if "TaxelArray" in type(message).__name__:
            stamp = message.header.stamp
            stamp.nanosec += round(1e7 * (periods + 0.05 * rng.uniform(-1.0, 1.0)))
            stamp.sec, stamp.nanosec = stamp.sec + stamp.nanosec // 10**9, stamp.nanosec % 10**9
        return message

    (r,) = load(write_bag(tmp_path / "bag", with_block(read(session(0)), "taxel_1", 1500, 300, 350), change=late))
    (symptom,) = find_copies([r])
    assert symptom.where == "taxel_1" and "300 samples" in symptom.evidence["why"]


def test_digits_go_with_their_taxels(tmp_path):
    """Chosen, or in another order: of a table with uneven stamps, and of steps that the others do not have."""
    made, rng = with_block(read(session(0)), "taxel_1", 1500, 300, 350), np.random.default_rng(1)
    table = tabled(tmp_path, replace(made, taxels=made.taxels * [[1.0], [1.0], [3.0]]), 0.03 * made.dt * rng.uniform(-1.0, 1.0, len(made)))
    (chosen,) = only_taxels(load(table), ["2", "1"])
    assert [chosen.step(c) for c in ("taxel_0", "taxel_1")] == pytest.approx([3.0 * STEP, STEP])
    (symptom,) = find_copies([chosen])
    assert symptom.where == "taxel_1"
    assert find_copies(only_taxels(load(table), ["0", "2"])) == []


def test_digits_are_those_of_the_samples(tmp_path):
    """Another row has none of the one in whose place it is; turned round, it is the same row; of a few samples that were bridged, too."""
    made, rng = with_block(read(session(0)), "taxel_1", 1500, 300, 350), np.random.default_rng(1)
    (r,) = load(tabled(tmp_path, made, 0.03 * made.dt * rng.uniform(-1.0, 1.0, len(made))))
    few = np.where(np.arange(len(r)) < 20, 0.0, r.taxels[1])
    assert find_copies([r.with_channels({"taxel_1": rng.standard_normal(len(r))})]) == []
    assert [len(find_copies([q])) for q in (r.scaled({"taxel_1": -2.0}), r.with_channels({"taxel_1": few}))] == [1, 1]


@pytest.mark.parametrize("seed", range(5))
def test_sound_recordings_repeat_nothing(seed):
    assert find_copies([read(session(10 * seed + i)) for i in range(3)]) == []


def test_the_same_motion_read_in_coarse_steps_is_no_copy():
    """Three sessions of one motion, with noise far below the steps of the load cell."""
    once = read(session(3, noise=0.0005), force_step=0.1)
    rng = np.random.default_rng(0)
    again = [replace(once, name=f"again_{i}", taxels=once.taxels + 0.03 * rng.standard_normal(once.taxels.shape)) for i in range(2)]
    assert find_copies([once, *again]) == []


def test_a_rest_makes_no_longer_copy_of_a_quick_movement_after_it(tmp_path):
    """Noise far below the steps of converters and encoder: half a second of rest, and a dozen samples of one and the same way out."""
    sessions, _ = make_sessions(None, n_sessions=3, n_taxels=1, seed=796685523, protocol="full", encoder_step_um=10.0)
    write_case(sessions, tmp_path)
    assert find_copies(load(tmp_path)) == []


def test_a_repeat_is_told_by_where_it_is_and_where_it_was():
    rng = np.random.default_rng(1)
    rows = [rng.integers(0, 500, (800, 1)).astype(float) for _ in range(2)]
    rows[1][400:500] = rows[0][100:200]
    (r,) = repeats_of(rows)
    assert (r.at, r.start, r.source, r.origin, r.length) == (1, 400, 0, 100, 100)


def test_the_times_of_a_block_are_those_of_the_record():
    r = with_block(read(session(0)), "force", 1500, 300, 350)
    (symptom,) = find_copies([replace(r, t=r.t + 1000.0)])
    start = 1000.0 + 1500 * r.dt
    assert symptom.parameters["from"]["value"] == pytest.approx(start)
    assert f"from {start:.2f} s on repeat {r.name} from {start - 350 * r.dt:.2f} s on" in symptom.evidence["why"]


def test_a_session_that_is_a_copy_does_not_hide_a_block_in_another():
    first, third = read(session(0)), read(session(1))
    second = replace(first, name="second")
    rows = {c: third.channels[c].copy() for c in third.channels}
    for c in rows:
        rows[c][1000:1400] = first.channels[c][300:700]
    depth = third.depth.copy()
    depth[1000:1400] = first.depth[300:700]
    third = replace(third, name="third", depth=depth, force=rows["force"], taxels=np.array([rows[c] for c in rows if c != "force"]))
    copied, block = sorted(find_copies([first, second, third]), key=lambda s: s.evidence["session"])
    assert copied.evidence["kind"] == "copied session" and not copied.bad
    assert block.evidence["session"] == "third" and all(np.count_nonzero(m) >= 380 for m in block.bad.values())


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
