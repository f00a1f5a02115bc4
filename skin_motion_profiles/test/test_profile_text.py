"""What a person writes: read, written back, and refused with one sentence."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import profiles

from skin_motion_profiles.battery_file import battery_names
from skin_motion_profiles.catalogue import entry_from_dict
from skin_motion_profiles.entry import leaves
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.expressions import evaluate
from skin_motion_profiles.profile_file import entry_from_text, entry_from_words, entry_to_text
from skin_motion_profiles.profiles.battery import Battery


@settings(deadline=None, max_examples=100)
@given(profiles())
def test_a_profile_survives_being_written(profile):
    assert entry_from_text(entry_to_text(profile)) == profile


@settings(deadline=None, max_examples=30)
@given(st.lists(profiles(), min_size=1, max_size=4), st.floats(0.0, 2.0))
def test_a_battery_survives_being_written(parts, rest):
    battery = Battery(profiles=tuple(parts), rest_s=rest, name="some")
    assert entry_from_text(entry_to_text(battery)) == battery


@pytest.mark.parametrize("name", sorted(battery_names()))
def test_a_named_battery_is_written_out(name):
    battery = entry_from_dict({"battery": name})
    text = entry_to_text(battery)
    assert "battery:" not in text and "*" not in text
    assert list(leaves(entry_from_text(text))) == list(leaves(battery))


@pytest.mark.parametrize("text", ["{type: step, depth_mm: -1, base_mm: -2}", "{type: step, depth_mm: -0.5, base_mm: 0.5}"])
def test_a_motion_in_the_air_and_one_that_lets_go_are_no_mistakes(text):
    assert entry_from_text(text).duration > 0.0


REFUSED = {
    "": "must be a mapping",
    "[1, 2]": "must be a mapping",
    "{type: sine": "is not YAML",
    "{depth_mm: 1}": "needs a type, one of battery, constant_rate_loops",
    "{type: sin}": "did you mean sine",
    "{type: xyzzy}": "there are battery",
    "{type: step}": "step lacks depth_mm (mm, depth of the step)",
    "{type: step, depth: 1}": "did you mean depth_mm",
    "{type: step, depth_mm: 1, colour: red}": "it takes",
    "{type: step, depth_mm: deep}": "deep is not an argument",
    "{type: step, depth_mm: true}": "must be a number",
    "{type: step, depth_mm: .nan}": "must be a number",
    "{type: step, depth_mm: [1]}": "must be a number",
    "{type: step, depth_mm: 1, hold_s: -1}": "must lie between 0",
    "{type: step, depth_mm: 1, name: 3}": "must be text",
    "{type: step, depth_mm: -1}": "step: depth_mm = -1 lies in the air, above base_mm = 0: depths are positive into the skin",
    "{type: repeated_step, depth_mm: -1}": "lies in the air",
    "{type: stair_step, depth_mm: -1, base_mm: -0.5}": "lies in the air, above base_mm = -0.5",
    "{type: minor_loops, depth_mm: -1, returns_mm: -0.5}": "lies in the air",
    "{type: constant_rate_loops, depths_mm: [1, -1], speeds_mm_s: 1}": "depths_mm = -1 lies in the air",
    "{type: constant_strain_hold, depths_mm: -1}": "lies in the air",
    "{type: stair_step, depth_mm: 1, steps: 2.5}": "must be a whole number",
    "{type: stair_step, depth_mm: 1, steps: 0}": "must lie between 1",
    "{type: ramp_list, depths_mm: []}": "must not be empty",
    "{type: ramp_list, depths_mm: 1}": "at least two",
    "{type: straight_line}": "either to_mm",
    "{type: straight_line, to_mm: 1, by_mm: 1}": "not both",
    "{type: random_ramps, seed: 1, deepest_mm: -1}": "must exceed shallowest_mm",
    "{type: random_ramps, seed: 1, deepest_mm: 1, fastest_mm_s: 0.1}": "less than slowest_mm_s",
    "{type: multisine, seed: 1, amplitude_mm: 0.1, base_frequency_hz: 1, highest_hz: 2}": "raise highest_hz",
    "{type: constant_strain_hold, strains: 0.1}": "belong together",
    "{type: constant_strain_hold}": "either depths_mm or strains",
    "{type: lateral_scan, offsets_mm: 1}": "either depth_mm or a profile",
    "{type: lateral_scan, offsets_mm: 1, profile: {type: stp}}": "did you mean step",
    "{type: battery, profiles: []}": "at least one profile",
    "{type: battery, profiles: 3}": "must be a list",
    "{type: battery, profiles: [3]}": "entry 1: a profile must be a mapping",
    "{type: battery, profiles: [{type: zero}, {type: step}]}": "entry 2: step lacks depth_mm",
    "{type: battery, arguments: 3, profiles: [{type: zero}]}": "arguments must be a mapping",
    "{type: battery, arguments: {a: x}, profiles: [{type: zero}]}": "x is not an argument",
    "{type: battery, arguments: {a: true}, profiles: [{type: zero}]}": "must be a number",
    "{type: battery, arguments: {a: 1}, profiles: [{type: step, depth_mm: 2*b}]}": "b is not an argument; there are a",
    "{battery: nosuch}": "there is no battery 'nosuch'",
    "{battery: nosuch.yaml}": "cannot read nosuch.yaml",
    "{battery: full, deep_mm: 1}": "has no argument 'deep_mm'",
}


@pytest.mark.parametrize("text", REFUSED)
def test_a_mistake_is_one_sentence(text):
    with pytest.raises(ProfileError) as caught:
        entry_from_text(text)
    assert REFUSED[text] in str(caught.value) and "\n" not in str(caught.value)


def test_a_battery_within_itself_is_refused(tmp_path):
    file = tmp_path / "mirror.yaml"
    file.write_text(f"type: battery\nprofiles: [{{battery: {file}}}]\n")
    with pytest.raises(ProfileError, match="does one contain itself"):
        entry_from_words(str(file))


SUMS = [("0.3*d", 0.6), ("-d/4 + 1", 0.5), ("(d + 1) % 2", 1), ("1e-3", 1e-3), (7, 7), (["d", "1"], [2, 1])]
NO_SUMS = ["__import__('os')", "d.real", "d**9**9", "[d]", "d if d else d", "", "d +", "'a'", "d/0", "1e400*d*0", "True"]


@pytest.mark.parametrize("text, value", SUMS)
def test_expressions(text, value):
    assert evaluate(text, {"d": 2.0}, "it") == pytest.approx(value)


@pytest.mark.parametrize("text", NO_SUMS)
def test_an_expression_is_arithmetic_and_nothing_else(text):
    with pytest.raises(ProfileError):
        entry_from_text(f'{{type: battery, arguments: {{d: 1}}, profiles: [{{type: step, depth_mm: "{text}"}}]}}')


def test_an_expression_that_is_too_long_is_refused_and_not_cut():
    assert evaluate("1" + 99 * "+1", {}, "it") == 100.0
    with pytest.raises(ProfileError, match="it: an expression has at most 200 characters, this one 203"):
        evaluate("1" + 101 * "+1", {}, "it")


def test_words_of_a_command_line(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("type: step\ndepth_mm: 1\n")
    assert entry_from_words(str(file), ["hold_s=3"]) == entry_from_words("{type: step, depth_mm: 1}", ["hold_s=3.0"])
    assert entry_from_words("demo", ["depth_mm=0.5"]) == entry_from_words("{battery: demo}", ["depth_mm=0.5"])
    with pytest.raises(ProfileError, match="has no argument 'deep'"):
        entry_from_words("demo", ["deep=0.5"])
    with pytest.raises(ProfileError, match="key=value"):
        entry_from_words("demo", ["0.5"])
    assert entry_from_words("step", ["depth_mm=1"]) == entry_from_words("{type: step, depth_mm: 1}")
    with pytest.raises(ProfileError, match="did you mean step"):
        entry_from_words("stepp", ["depth_mm=1"])
    with pytest.raises(ProfileError, match="no YAML file: execute --list"):
        entry_from_words("xyz")
