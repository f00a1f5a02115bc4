"""Tests that a force drives, with a load cell that was not tared: it is named, and nothing else, for the force is put right."""

from dataclasses import replace

import numpy as np
import pytest
from rows import rows
from world import make_sessions, write_case

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telemetry.untared import tared
from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import Recording
from skin_ident.report.page import page
from skin_ident.report.story import tell


def driven(folder, zeros, taxels=1, seed=302):
    """Sessions of our own world without their depth, whose load cell reads so much of nothing, N."""
    write_case(make_sessions([], seed=seed, n_sessions=3, n_taxels=taxels)[0], folder)
    return [replace(r, depth=None, force=r.force + zero) for r, zero in zip(load(folder), zeros, strict=True)]


@pytest.mark.parametrize("zero", rows([5.0, -0.5, -20.0, 1.0], 1))
def test_it_is_named_alone(tmp_path, zero):
    recordings = driven(tmp_path, [zero] * 3)
    found = diagnose(recordings[:2], recordings[2:]).findings
    (said,) = found["findings"]
    assert (said["cause"], said["where"]) == ("force_offset", "load_cell") and "force_offset" in {a["cause"] for a in said["alternatives"]}
    assert said["parameters"]["offset"]["value"] == pytest.approx(zero, abs=0.05)
    assert said["evidence"]["put_right"] and "taken out of the record" in said["evidence"]["simulated"]
    story = tell(Outcome(found)).story
    assert "The fault is in the record itself" in story.headline.line and "taken out before anything was compared" in page(
        tell(Outcome(found))
    )


def test_of_one_session_that_was_not_tared_the_others_are_not_lowered(tmp_path):
    recordings = driven(tmp_path, [0.0, 3.0, 0.0], taxels=2)
    right, (said,) = tared(recordings)
    assert [r is before for r, before in zip(right, recordings, strict=True)] == [True, False, True]
    assert said.evidence["only_in"] == [recordings[1].name] and {a[1] for a in said.alternatives} == {"taxel_0", "taxel_1"}
    assert abs(np.percentile(right[1].force, 2)) < 0.1 and right[1].step("force") == pytest.approx(recordings[1].step("force"))


@pytest.mark.parametrize(
    "name", ["tared", "a depth", "a preload", "a preload that is held", "one force throughout", "an upside-down load cell"]
)
def test_what_was_tared_stays_as_it_is(tmp_path, name):
    """Nor is a true preload taken for a zero, of which the taxels feel their share."""
    rng, t = np.random.default_rng(4), np.arange(6000) * 0.01
    waves = 2.0 * np.sin(2 * np.pi * 0.3 * t) * np.sin(2 * np.pi * 0.03 * t)
    load_of = {
        "tared": np.maximum(4.0 * waves, 0.0),
        "a depth": np.maximum(4.0 * waves, 0.0) + 5.0,
        "a preload": 10.0 + waves,
        "a preload that is held": 0.5 + np.maximum(4.0 * waves, 0.0),
        "one force throughout": np.full(t.size, 5.0),
        "an upside-down load cell": np.maximum(4.0 * waves, 0.0),
    }[name]
    force = np.round((load_of + 0.01 * rng.standard_normal(t.size)) / 0.005) * 0.005
    taxel = np.round((0.5 * load_of + 0.01 * rng.standard_normal(t.size)) / 0.005) * 0.005
    depth = load_of / 5e3 if name == "a depth" else None
    recording = Recording(name, t, depth=depth, force=-force if name.startswith("an upside") else force, taxels=taxel[None])
    assert tared([recording]) == ([recording], ())
