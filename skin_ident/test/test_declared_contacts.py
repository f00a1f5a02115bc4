"""Where each recording presses, as rig.yaml says it by name: with or without the suffix, and never silently passed over. And what it
says of nothing."""

import numpy as np
import pytest

from skin_ident.recordings.declared import declared_from
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.load import load

T = np.arange(400) / 100.0


@pytest.fixture
def folder(tmp_path):
    for name in ("session_0.tsv", "session_1.tsv"):
        table = np.column_stack([T, 0.5 + 0.3 * np.sin(T), 5.0 + np.sin(T), 3.0 + np.sin(T)])
        np.savetxt(tmp_path / name, table, "%.6g", "\t", header="t_s\tx_mm\tforce_n\ttaxel_0_n", comments="")
    return tmp_path


def loaded(folder, rig):
    (folder / "rig.yaml").write_text(rig)
    return load(folder)


def contacts(recordings):
    return [r.declared.contact_of(r.name) for r in recordings]


@pytest.mark.parametrize("suffix", ["", ".tsv"])
def test_a_table_is_called_with_or_without_its_suffix(folder, suffix):
    found = loaded(folder, f"contact_position_mm: {{session_0{suffix}: [1, 2], session_1{suffix}: [5, 0]}}")
    assert contacts(found) == [(1.0, 2.0), (5.0, 0.0)] and not any(r.declared.warnings for r in found)


def test_a_recording_without_a_place_of_its_own_is_warned_of(folder):
    first, second = loaded(folder, "contact_position_mm: {session_0: [1, 2], sesion_1: [5, 0]}")
    assert contacts([first, second]) == [(1.0, 2.0), (0.0, 0.0)]
    assert not first.declared.warnings and [w for w in second.declared.warnings if "session_0, sesion_1), not this one" in w]


def test_places_of_recordings_that_lie_elsewhere_are_nobodys_fault(folder):
    """One rig.yaml may be copied beside those that are held out."""
    found = loaded(folder, "contact_position_mm: {session_0: [1, 2], session_1: [5, 0], session_2: [3, 0]}")
    assert not any(r.declared.warnings for r in found)


def test_one_place_is_everybodys(folder):
    assert contacts(loaded(folder, "contact_position_mm: [1, 2]")) == [(1.0, 2.0)] * 2


def test_several_places_have_the_names_of_recordings(folder):
    with pytest.raises(RecordingError, match=r"name the recordings, as in \{session_1: \[0, 0\]"):
        loaded(folder, "contact_position_mm: [[1, 2], [5, 0]]")


@pytest.mark.parametrize(("thick", "asked"), [("400", True), ("4", False), ("", False)])
def test_a_skin_that_is_hardly_so_thick_is_asked_about(thick, asked):
    assert any("is it in millimetres" in w for w in declared_from(f"skin_thickness_mm: {thick}\n").warnings) is asked


def test_steps_and_noise_of_zero_are_taken_as_unknown():
    found = declared_from("encoder_noise_um: 0.0\ntaxel_step_n: [0, 0]\nforce_noise_n: 0.02\n")
    assert (found.encoder_noise_um, found.taxel_step_n, found.force_noise_n) == (None, (), 0.02)
    said = "{} in rig.yaml is 0, which no reading has: taken as unknown"
    assert set(found.warnings) == {said.format("encoder_noise_um"), said.format("taxel_step_n")}
