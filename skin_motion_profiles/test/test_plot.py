"""Pictures and descriptions of profiles, without ROS."""

import subprocess
import sys

import pytest

from skin_motion_profiles.catalogue import entries, entry_from_dict
from skin_motion_profiles.describe import description, overview
from skin_motion_profiles.fields import declared


def plot(*arguments, cwd):
    return subprocess.run([sys.executable, "-m", "skin_motion_profiles.cli.plot", *arguments], cwd=cwd, capture_output=True, text=True)


@pytest.mark.parametrize(
    "arguments", [[], ["demo", "depth_mm=0.7", "--out", "demo.svg"], ["{type: step, depth_mm: 1}", "--out", "step.png"]]
)
def test_a_picture_is_written(arguments, tmp_path):
    ran = plot(*arguments, cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / ran.stdout.strip()).stat().st_size > 5000


@pytest.mark.parametrize("arguments, sentence", [
    (["nosuch"], "no YAML file"),
    (["demo", "--out", "demo.txt"], "must end in .png"),
    (["demo", "--out", "nowhere/demo.png"], "cannot write nowhere/demo.png"),
    (["{type: zero}"], "zero does not move"),
    (["step", "depth_mm=1", "depth_mm=2"], "depth_mm is given twice, as 1 and as 2"),
    (["{type: step, depth_mm: 1, depth_mm: 2}"], "'depth_mm' stands twice"),
    (["demo", "seed=1", "depth_mm=1", "seed=1"], "seed is given twice"),
    ([""], "no YAML file"),
    (["demo", "--out", ""], "must end in .png"),
])  # fmt: skip
def test_what_cannot_be_drawn_is_2_and_one_sentence(arguments, sentence, tmp_path):
    ran = plot(*arguments, cwd=tmp_path)
    assert ran.returncode == 2 and sentence in ran.stderr and ran.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", entries())
def test_every_kind_has_an_example_and_tells_its_parameters(kind):
    cls = entries()[kind]
    assert entry_from_dict({"type": kind, **cls.example}).kind == kind
    assert kind in overview()
    assert all(f.name in description(kind) for f in declared(cls))
