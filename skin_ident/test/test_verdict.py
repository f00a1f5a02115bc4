"""The verdict never contradicts what is left: clearly more than noise is unexplained, whatever the search could name."""

from dataclasses import replace

import numpy as np
import pytest
from test_faults import session

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.declared import Declared


def bent(r, power):
    """A taxel that follows another power of the load in every session, which no form of the catalogue does."""
    first, second, third = r.taxels
    return replace(r, taxels=np.array([first, 2.0 * np.sign(second) * np.abs(second / 2.0) ** power, third]))


def late(r, samples):
    first, second, third = r.taxels
    return replace(r, taxels=np.array([first, np.roll(second, samples), third]))


@pytest.mark.parametrize(("spoil", "by"), [(bent, (1.0, 1.6, 0.6)), (late, (0, 40, -40))])
def test_a_taxel_that_is_another_one_in_each_session_is_not_nothing(spoil, by):
    findings = diagnose([spoil(session(i), q) for i, q in enumerate(by)]).findings
    assert findings["verdict"] == ("partly_explained" if findings["findings"] else "unexplained")
    assert any(w.startswith("taxel_1: what is left") for w in findings["warnings"])
    assert findings["gain_by_channel"]["taxel_1"]["held_out_rmse_after"] > 1.5 * findings["gain_by_channel"]["taxel_1"]["noise_floor"]


def coarse(r):
    return replace(r, depth=np.round(r.depth / 10e-6) * 10e-6, declared=Declared(encoder_step_um=10.0))


def heavy_tailed(r):
    rng = np.random.default_rng(len(r.name))
    return replace(r, force=r.force + 0.03 * rng.standard_t(3, r.t.size), taxels=r.taxels + 0.03 * rng.standard_t(3, r.taxels.shape))


def grows(r):
    return replace(r, force=r.force + 0.02 * r.force * np.random.default_rng(5).standard_normal(r.t.size))


@pytest.mark.parametrize("spoil", [coarse, heavy_tailed, grows])
def test_noise_of_any_kind_is_nothing_wrong(spoil):
    findings = diagnose([spoil(session(i)) for i in (11, 12, 13)]).findings
    assert findings["verdict"] == "nothing_wrong" and not findings["warnings"]
