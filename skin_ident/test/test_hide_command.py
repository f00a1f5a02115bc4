"""`hide` puts an effect of the size asked for into any recording, keeps the truth apart, and refuses with one sentence."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from skin_ident.cli import common
from skin_ident.cli.common import refusal
from skin_ident.cli.hide import main
from skin_ident.criticism.sessions.session import prepare
from skin_ident.hiding.campaign import Case, recordings
from skin_ident.hiding.drawing import draw, hideable
from skin_ident.hiding.errors import HidingError
from skin_ident.hiding.ground import ground
from skin_ident.hiding.hide import hide
from skin_ident.hiding.writing import write_recordings
from skin_ident.recordings.load import load

BASE = recordings(Case("null", 0.0, 1, "demo", taxels=2))[:2]
ALONE = ("dead_taxel", "quantization", "saturation")  # whose size is what it is, or falls in steps


@pytest.fixture(scope="module")
def on():
    return ground(BASE)


@pytest.fixture
def command(capsys):
    def run(*arguments):
        status = main([str(a) for a in arguments])
        return SimpleNamespace(status=status, err=capsys.readouterr().err)

    return run


@pytest.fixture
def base(tmp_path):
    write_recordings([r.part(0, 1500) for r in BASE], tmp_path / "base")
    return tmp_path / "base"


def test_every_cause_has_the_size_asked_for(on):
    for cause in hideable(on.sessions[0]):
        changed, hidden = hide(BASE, cause, size=2.0, seed=3, on=on)
        assert hidden.effect.cause == cause and len(changed) == len(BASE)
        if cause not in ALONE:
            assert hidden.size == pytest.approx(2.0, rel=0.15), cause
            assert max((hidden.change if hidden.imitated else hidden.visible).values()) == pytest.approx(hidden.size)


def test_what_changes_is_what_the_place_says(on):
    for cause, where in (("lag", "load_cell"), ("drift", "taxel_1"), ("hysteresis", "skin")):
        (after, _), _ = hide(BASE, cause, where, 1.0, 0, on)
        moved = {c for c, y in after.channels.items() if not np.array_equal(y, BASE[0].channels[c])}
        assert moved == {"load_cell": {"force"}, "taxel_1": {"taxel_1"}, "skin": {"force", "taxel_0", "taxel_1"}}[where]
        assert np.array_equal(after.depth, BASE[0].depth)
        steps = after.force / after.declared.force_step_n
        assert np.allclose(steps, np.round(steps), atol=1e-6)


def test_an_error_of_the_encoder_counts_by_the_stiffness_that_each_channel_feels(on):
    """A load cell feels the whole skin, a taxel its share of what is sensed."""
    change = hide(BASE, "quantization", "rig", 2.0, 0, on)[1].change
    skin, shares = on.model.dispersion, on.model.shares
    felt = {"force": skin.k1 + skin.k2, "taxel_0": shares[0] * skin.k1, "taxel_1": shares[1] * skin.k1}
    steps = [change[c] * noise / felt[c] for c, noise in zip(on.sessions[0].channels, on.noise, strict=True)]
    assert steps == pytest.approx([steps[0]] * 3, rel=0.02) and 1e-6 < steps[0] < 1e-4  # m


def test_equal_seeds_hide_equal_things(on):
    (one, _), truth = hide(BASE, size=1.0, seed=7, on=on)
    (other, _), again = hide(BASE, size=1.0, seed=7, on=on)
    assert truth == again and np.array_equal(one.force, other.force) and np.array_equal(one.taxels, other.taxels)


def test_a_lone_gain_is_said_to_be_imitated(on):
    drawn = (hide(BASE, "mount_compliance", size=1.0, seed=seed, on=on)[1] for seed in range(10))
    hidden = next(h for h in drawn if not h.effect.form)  # a mount that follows at once; one that follows late can be told
    assert hidden.imitated and max(hidden.visible.values()) < 0.1


def test_it_is_warned_of_what_a_fit_takes_up(command, tmp_path):
    alone = recordings(Case("null", 0.0, 1, "demo", taxels=1))[:1]
    write_recordings([r.part(0, 1500) for r in alone], tmp_path / "base")
    done = command(tmp_path / "base", "--cause", "gain_error", "--size", 4, "--seed", 1, "--out", tmp_path / "out")
    truth = json.loads((tmp_path / "out_truth.json").read_text())["hidden"][0]
    assert max(truth["visible_over_noise"].values()) < 0.1 * truth["size"]
    assert "warning: of its 4 times the noise only" in done.err.replace("3.99", "4").replace("4.01", "4")
    seen = command(tmp_path / "base", "--cause", "friction", "--size", 3, "--out", tmp_path / "seen")
    assert "warning" not in seen.err


def test_the_truth_lies_apart_and_the_data_are_read_again(command, base, tmp_path):
    done = command(base, "--cause", "friction", "--size", 3, "--out", tmp_path / "out")
    assert done.status == 0, done.err
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["rig.yaml", "session_1.csv", "session_2.csv"]
    truth = json.loads((tmp_path / "out_truth.json").read_text())["hidden"][0]
    assert truth["cause"] == "friction" and truth["parameters"]["force"]["unit"] == "N"
    read = load(tmp_path / "out")
    assert [len(r) for r in read] == [1500, 1500] and read[0].declared.force_step_n == pytest.approx(0.0678)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--cause", "witchcraft"], "choose from adhesion"),
        (["--cause", "backlsh"], "did you mean backlash?"),
        (["--cause", "parameters"], "cannot be hidden; choose from adhesion"),
        (["--cause", "lag", "--where", "skin"], "choose from load_cell"),
        (["--cause", "null"], "challenge --causes null and identify --cause none"),
        (["--cause", "none"], "challenge --causes null and identify --cause none"),
        (["--size", "-1"], "positive"),
        (["--size", "1e6"], "below 10000"),
        (["--seed", "-3"], "--seed"),
        (["--where", "nowhere"], "choose from clock"),
        (["--cause", "lag", "--size", "5000"], "cannot be made 5000 times"),
        (["--truth", "OUT/truth.json"], "beside the data"),
    ],
)
def test_bad_input_is_one_sentence_and_writes_nothing(command, base, tmp_path, arguments, word):
    out = tmp_path / "out"
    done = command(base, *(a.replace("OUT", str(out)) for a in arguments), "--out", out)
    assert done.status == 2 and word in done.err and "Traceback" not in done.err
    assert not out.exists() and not (tmp_path / "out_truth.json").exists()


@pytest.mark.parametrize("arguments", [["--cause", "witchcraft"], ["--size", "-1"]])
def test_wrong_arguments_are_said_before_anything_is_read(command, tmp_path, arguments):
    done = command(tmp_path / "nowhere", *arguments, "--out", tmp_path / "out")
    assert done.status == 2 and "nowhere" not in done.err and done.err.count("\n") == 1


@pytest.mark.parametrize(
    ("given", "word"),
    [
        (("session_1.csv", "session_1.csv"), "given twice"),
        (("session_1.csv", "copy.csv"), "copy.csv hold the same"),
        (("session_1.csv", "other/session_1.csv"), "base/other/session_1.csv hold the same"),
    ],
)
def test_the_same_recording_twice_is_refused(command, base, tmp_path, given, word):
    (base / "other").mkdir()
    for copy in ("copy.csv", "other/session_1.csv"):
        (base / copy).write_bytes((base / "session_1.csv").read_bytes())
    done = command(*(base / name for name in given), "--out", tmp_path / "out")
    assert done.status == 2 and word in done.err and done.err.count("\n") == 1 and not (tmp_path / "out").exists()


def test_a_full_disk_is_said_with_the_file(tmp_path, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savetxt", full)
    with pytest.raises(OSError, match="No space") as error:
        write_recordings(BASE[:1], tmp_path)
    assert refusal(error.value) == f"No space left on device ({tmp_path / 'session_1.csv'})" and not list(tmp_path.iterdir())


@pytest.mark.parametrize("rigs", ["one rig", "two rigs"])
@pytest.mark.parametrize("failure", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_half_a_set_of_tables_is_not_left(tmp_path, monkeypatch, rigs, failure):
    sessions = [r.part(0, 300) for r in BASE]
    if rigs == "two rigs":
        sessions[1] = replace(sessions[1], declared=replace(sessions[1].declared, skin_thickness_mm=4.0))
    write, done = np.savetxt, []

    def full(*given, **how):
        done.append(given)
        if len(done) == 2:
            raise failure
        write(*given, **how)

    monkeypatch.setattr(np, "savetxt", full)
    with pytest.raises(type(failure)):
        write_recordings(sessions, tmp_path)
    assert not list(tmp_path.iterdir())
    assert [r.name for r in load(write_recordings(sessions, tmp_path))] == ["session_1.csv", "session_2.csv"]


def test_without_the_truth_no_table_is_left(command, base, tmp_path, monkeypatch):
    def stopped(*given):
        raise KeyboardInterrupt

    arguments = (base, "--cause", "friction", "--size", 3, "--out", tmp_path / "out")
    (tmp_path / "out").mkdir()
    with monkeypatch.context() as truth:
        truth.setattr(common, "write_json", stopped)
        assert command(*arguments).status == 130
    assert not list((tmp_path / "out").iterdir()) and command(*arguments).status == 0


def test_nothing_of_somebody_elses_is_overwritten(command, base, tmp_path):
    own = tmp_path / "own"
    own.mkdir()
    (own / "rig.yaml").write_text("sample_rate_hz: 100  # precious\n")
    done = command(base, "--cause", "friction", "--out", own)
    assert done.status == 2 and "rig.yaml" in done.err and "another folder" in done.err
    assert [p.read_text() for p in own.iterdir()] == ["sample_rate_hz: 100  # precious\n"]


@pytest.mark.parametrize("more", [[], ["--truth", "OWN"]])
def test_no_file_gives_way_to_the_truth(command, base, tmp_path, more):
    """Nor a recording that is read, nor the truth of an earlier hiding."""
    own = base / "session_1.csv" if more else tmp_path / "out_truth.json"
    own.touch()
    before = own.read_bytes()
    done = command(base, "--cause", "friction", *(a.replace("OWN", str(own)) for a in more), "--out", tmp_path / "out")
    assert done.status == 2 and "nothing is overwritten" in done.err and done.err.count("\n") == 1  # not even that it hides something
    assert own.read_bytes() == before and not (tmp_path / "out").exists()


def test_the_root_of_all_folders_is_refused(command, base):
    """There is no place beside it for the truth."""
    done = command(base, "--cause", "friction", "--out", "/")
    assert done.status == 2 and done.err.startswith("error: ") and done.err.count("\n") == 1


@pytest.mark.parametrize("size", [0.5, 3.0])
def test_what_leaks_from_taxel_to_taxel_adds_to_it_and_is_the_smaller_part(on, size):
    shares = [hide(BASE, "crosstalk", size=size, seed=seed, on=on)[1].effect.share for seed in range(6)]
    assert all(0.0 < share <= 0.5 for share in shares)


def test_more_than_can_leak_is_refused(on):
    with pytest.raises(HidingError, match=r"crosstalk cannot be made 3000 times .* physically possible"):
        hide(BASE, "crosstalk", size=3000.0, on=on)


@pytest.mark.parametrize(("where", "seed"), [(w, s) for w in ("taxel", "load_cell", "skin") for s in range(3)])
def test_a_place_alone_draws_a_cause_that_can_sit_there(where, seed):
    assert draw(prepare(BASE[0]), "any", where, np.random.default_rng(seed)).where == where


def test_recordings_of_a_force_driven_test(on):
    driven = [replace(r.part(0, 1500), depth=None) for r in BASE]
    changed, hidden = hide(driven, "lag", "taxel_0", 1.0, 0)
    assert hidden.size == pytest.approx(1.0, rel=0.1) and np.array_equal(changed[0].force, driven[0].force)
    with pytest.raises(HidingError, match="backlash"):
        hide(driven, "backlash")
