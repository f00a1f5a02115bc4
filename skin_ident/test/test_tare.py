"""Zeros of all channels and sessions at once, as tares leave them, and where they are taken for that."""

from dataclasses import replace

import numpy as np
import pytest
from gate_records import DEPTH, PLAIN, QUICK, recorded

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.courses.course import added
from skin_ident.criticism.courses.tare import added_by, zeros
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.gates.resolution import RESOLVED
from skin_ident.criticism.noise.whitening import fit_whitener
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.tared import settle_zeros, take_zeros, untared
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.telling.leftover import Rest
from skin_models.effects.lag import Lag

STEP, OFF = 0.02, ((0.012, -0.007), (-0.009, 0.011), (0.008, -0.012))  # N


def sessions(scale: float = 1.0) -> list:
    """Recordings whose channels are read in steps of `STEP`, with zeros of `scale` times `OFF`."""
    made = (recorded(PLAIN, DEPTH + 0.1e-3 * i, 0.02, seed=i) for i in range(3))
    return [_read(r, scale * np.array(off), f"session_{i}") for i, (r, off) in enumerate(zip(made, OFF, strict=True))]


def _read(r, off: np.ndarray, name: str):
    force, taxel = (STEP * np.round((y + zero) / STEP) for y, zero in zip((r.force, r.taxels[0]), off, strict=True))
    return replace(r, name=name, force=force, taxels=taxel[None])


def test_zeros_within_a_step_are_found():
    whole = [prepare(r) for r in sessions()]
    noise = fit_whitener([residual(PLAIN, s) for s in whole], whole)
    found, fall = zeros(PLAIN, whole, noise, free=False)
    assert fall > 30.0 and np.allclose(shifts(found, whole), OFF, atol=0.004)
    beside, less = zeros(fit(PLAIN, whole, noise).model, whole, noise, free=True)
    assert 30.0 < less <= fall and all(np.all(np.abs(z[:-1]) <= 1.05 * STEP) for z in beside.values())


def test_zeros_of_depth_within_a_step_of_the_encoder_are_found():
    off = np.array([4e-6, -3e-6, 2e-6])
    whole = [prepare(replace(r, depth=r.depth + x)) for r, x in zip(sessions(scale=0.0), off, strict=True)]
    noise = fit_whitener([residual(PLAIN, s) for s in whole], whole)
    found, fall = zeros(PLAIN, whole, noise, encoder_step=5e-6, free=False)
    k = PLAIN.dispersion
    assert fall > 30.0 and np.allclose(shifts(found, whole), -np.outer(off, [k.k1 + k.k2, k.k1]), atol=0.006)


def shifts(found, whole):
    """By how much zeros move the channels of each session, N on average."""
    moved = added_by(found, PLAIN, whole)
    return [moved[s.name].mean(axis=1) for s in whole]


def test_larger_zeros_are_no_tare():
    sound, whole = ([prepare(r) for r in sessions(scale)] for scale in (0.0, 4.0))
    noise = fit_whitener([residual(PLAIN, s) for s in sound], sound)  # zeros that the noise held would be noise that wanders
    found, fall = zeros(PLAIN, whole, noise, free=False)
    assert fall == 0.0 and not any(z.any() for z in found.values())


def _searched() -> Search:
    """A search that has taken the zeros of `sessions`, the third of which is held out."""
    whole, sound = ([prepare(r) for r in sessions(scale)] for scale in (1.6, 0.0))
    search = Search(whole[:2], whole[2:], (), lambda stage: None)
    search.noise = fit_whitener([residual(PLAIN, s) for s in sound], sound)
    search.present = fit(PLAIN, search.train, search.noise)
    assert take_zeros(search) and not take_zeros(search) and not settle_zeros(search)
    return search


def test_zeros_are_asked_for_again_beside_what_was_named_since():
    """Such as a gain that steps: they had taken up a part of it."""
    search = _searched()
    taken_up = {
        s.name: 0.008 * sign * np.array([[0.0], [1.0]]) * np.ones(s.motion.t.size) for s, sign in zip(search.train, (1, -1), strict=True)
    }
    search.train = added(search.train, taken_up)
    search.named.append(Named("gain_error", "taxel", QUICK, 100.0, ()))
    assert settle_zeros(search) and not settle_zeros(search)
    left = [residual(search.present.model, s)[1].mean() for s in search.train]
    assert np.ptp(left) < 0.004  # 16 mN before


def test_a_course_of_a_held_out_session_is_fitted_without_its_zeros():
    search = _searched()
    (held,), (bare,) = search.held, untared(search)
    model = search.present.model
    assert np.abs(residual(model, held).mean(axis=1)).max() < 0.005
    assert np.allclose(residual(model, bare).mean(axis=1), 1.6 * np.array(OFF[2]), atol=0.006)
    assert untared(search) is search.held  # they are taken back once


@pytest.mark.slow
def test_zeros_within_a_step_are_nothing_wrong():
    made = sessions()
    findings = diagnose(made[:2], made[2:]).findings
    assert findings["findings"] == []


def test_a_zero_that_a_tare_leaves_in_all_fitted_sessions_alone_is_nothing_wrong():
    """It had been named with the sessions that have it, which the held-out one lacks."""
    made = [_read(r, np.array([0.0, zero]), r.name) for r, zero in zip(sessions(scale=0.0), (0.012, 0.012, 0.0), strict=True)]
    assert diagnose(made[:2], made[2:]).findings["findings"] == []


def test_what_is_left_within_half_a_step_is_no_riddle():
    """As much as is left of a load cell read in steps of 19 mN may be its tare, and is none of one read in steps of 5 mN."""
    told = Rest(fall=0.19, lower=0.1, before=9.8e-3, after=8.6e-3, resolution=RESOLVED * 19e-3, seconds=26.0)
    assert not told.is_systematic(0.0) and replace(told, resolution=RESOLVED * 5e-3).is_systematic(0.0)


def test_the_zero_of_a_held_out_session_is_no_gain_of_a_cause():
    """The model without the cause gets it, too."""
    lagging = PLAIN.extended(Lag("taxel", tau=0.02))
    made = [replace(recorded(lagging, DEPTH + 0.1e-3 * i, 0.02, seed=i), name=f"session_{i}") for i in range(3)]
    gains = []
    for zero in (0.0, 0.016):
        read = [_read(r, np.array([0.0, off]), r.name) for r, off in zip(made, (0.0, 0.0, zero), strict=True)]
        (finding,) = diagnose(read[:2], read[2:]).findings["findings"]
        assert finding["cause"] == "lag"
        gains.append([finding["gain"][f"held_out_rmse_{when}"] for when in ("before", "after")])
    assert np.allclose(*gains, rtol=0.0, atol=5e-4)  # 4 mN before
