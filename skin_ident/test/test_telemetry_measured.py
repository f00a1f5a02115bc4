"""The detectors on data that others measured: which faults are truly there. Left out where the data are not at hand."""

import os
from pathlib import Path

import numpy as np
import pytest

from skin_ident.criticism.telemetry.copied import find_copies
from skin_ident.criticism.telemetry.dead import find_dead_taxels
from skin_ident.recordings.levels import step_of
from skin_ident.recordings.recording import Recording

PLACES = [Path(os.environ.get("SKIN_MEASURED", "/nowhere")), *(q / "shared/measured" for q in Path(__file__).resolve().parents)]
HERE = next((p for p in PLACES if p.is_dir()), None)
pytestmark = pytest.mark.skipif(HERE is None, reason="the measured data are not at hand: set SKIN_MEASURED to their folder")


def insole(name):
    io = pytest.importorskip("scipy.io")
    e = io.loadmat(HERE / "iit_capacitive_skin" / f"{name}.mat", squeeze_me=True, struct_as_record=False)["experiment"]
    counts, pressure = np.asarray(e.C, float)[:, 2:], np.asarray(e.P, float)
    n = min(len(counts), len(pressure))
    return Recording(name, np.arange(n) * 0.0204, force=pressure[:n], taxels=240.0 - counts[:n].T)


@pytest.mark.parametrize(("name", "dead"), [("experiment_Inf_15September_dynamic_1", 31), ("validation_dataset_3", 12)])
def test_constant_taxels_among_280_are_dead(name, dead):
    r = insole(name)
    stuck = [s for s in find_dead_taxels([r]) if s.evidence["kind"] == "stuck"]
    assert len(stuck) == dead == int(np.sum(np.ptp(r.taxels, axis=1) == 0.0))


@pytest.mark.parametrize("name", ["experiment_Inf_15September_dynamic_1", "validation_dataset_3"])
def test_counts_are_whole_numbers(name):
    assert step_of(insole(name).taxels[0]) == 1.0


@pytest.mark.parametrize("name", ["10mm", "30mm", "50mm", "nowater"])
def test_the_fluid_skins_converter_has_12_bits_over_10_volts_and_nothing_was_copied(name):
    t, *volts = np.genfromtxt(HERE / "sdu_fluid_skin" / f"1D_underwater_{name}.csv", delimiter=",", skip_header=1).T
    r = Recording(name, t, force=volts[0], taxels=np.array(volts[1:]))
    assert not find_copies([r])
    assert step_of(volts[0]) == pytest.approx(2.55e-3, rel=0.01)
