"""Evenly spaced records are read many at a time, and give what reading them one by one gives."""

import numpy as np
import pytest
from making import recording, write_mcap

from skin_ident.recordings.gather import Gatherer
from skin_ident.recordings.load import load

SMALL, LARGE = recording(n=1200, shares=(1.0, 0.4)), recording(n=1200, shares=tuple(np.linspace(1, 0.1, 48)))


def both_ways(path, monkeypatch):
    """The recording read in runs and one by one, and what was accepted as runs."""
    accepted, plain = [], Gatherer.add_runs

    def watched(self, channel, runs):
        accepted.append(plain(self, channel, runs))
        return accepted[-1]

    with monkeypatch.context() as patch:
        patch.setattr(Gatherer, "add_runs", watched)
        quick = load(path)[0]
    with monkeypatch.context() as patch:
        patch.setattr(Gatherer, "add_runs", lambda self, channel, runs: False)
        return quick, load(path)[0], accepted


def same(a, b):
    rows = all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("t", "depth", "force", "taxels"))
    return rows and a.warnings == b.warnings


@pytest.mark.parametrize("r", [SMALL, LARGE], ids=["few numbers", "many numbers"])
@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
def test_runs_give_what_single_messages_give(tmp_path, monkeypatch, r, compression):
    quick, slow, accepted = both_ways(write_mcap(tmp_path / "a.mcap", r, compression), monkeypatch)
    assert same(quick, slow) and np.array_equal(quick.taxels, r.taxels) and np.mean(accepted) > 0.5


@pytest.mark.parametrize("field", ["frame", "name", "length"])
@pytest.mark.parametrize("r", [SMALL, LARGE], ids=["few numbers", "many numbers"])
def test_a_message_of_another_form_is_not_taken_for_one_of_them(tmp_path, monkeypatch, r, field):
    def odd(store, i, message):
        if i == 700 and field == "frame":
            message.header.frame_id = "elsewhere"  # another length: everything behind it moves
        if i == 700 and field == "name" and hasattr(message, "position"):
            message.name = ["indentatiom"]  # the same length: only the checked bytes tell
        if i == 700 and field == "length" and hasattr(message, "status"):
            message.status = message.status[:-1]
        return message

    path = write_mcap(tmp_path / "a.mcap", r, change=odd)
    quick, slow, accepted = both_ways(path, monkeypatch)
    assert same(quick, slow) and any(accepted) and (field != "name" or not all(accepted[3:]))
    assert field != "name" or any("could not be decoded" in w or "interpolated" in w for w in quick.warnings)


def test_a_damaged_index_costs_nothing_but_time(tmp_path, monkeypatch):
    path = write_mcap(tmp_path / "a.mcap", SMALL)
    data = bytearray(path.read_bytes())
    at = [
        i for i in range(len(data) - 60) if data[i] == 7 and data[i + 2 : i + 9] == bytes(7) and data[i + 9 : i + 11] in (b"\1\0", b"\2\0")
    ]
    for i in at[10:13]:
        data[i + 39] ^= 0x10  # the offset of a second message
    path.write_bytes(data)
    quick, slow, _ = both_ways(path, monkeypatch)
    assert same(quick, slow) and np.allclose(quick.force, SMALL.force)
