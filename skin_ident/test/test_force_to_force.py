"""A test that force drives, without depth: where its fit begins, and what noise of the driving force does to its taxels."""

from dataclasses import replace

import numpy as np
import pytest

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.courses.carriers import DRIVE, carried
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.telemetry.pile_up import find_saturated_drive
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.recording import Recording

DT, SHARE = 2e-3, 0.85
DECLARED = Declared(force_noise_n=0.03, taxel_noise_n=(0.004,))


def pressed_by_hand(seed: int, recovery: float, lead: float, noise: tuple[float, float] = (0.0, 0.0)) -> Recording:
    """Twenty seconds of presses by a hand, and what a taxel feels of them, recovery y' + y = share (F + lead F'), by Euler's steps of a
    fifth of a sample."""
    rng, t = np.random.default_rng(seed), DT * np.arange(10_000)
    knots = np.maximum(rng.normal(1.2, 1.0, 26), 0.0) * (np.arange(26) % 4 != 0)
    share = np.clip(np.arange(0.0, t[-1], DT / 5) / 0.8, 0.0, 24.99)
    left, within = share.astype(int), share % 1.0
    force = knots[left] + (knots[left + 1] - knots[left]) * within**3 * (10.0 - 15.0 * within + 6.0 * within**2)
    speed, y = np.gradient(force, DT / 5), np.zeros(force.size)
    for i in range(1, y.size):
        y[i] = y[i - 1] + DT / 5 / recovery * (SHARE * (force[i - 1] + lead * speed[i - 1]) - y[i - 1])
    force, y = force[::5][: t.size], y[::5][: t.size]
    n = force.size
    read = force + noise[0] * rng.standard_normal(n), y + noise[1] * rng.standard_normal(n)
    return Recording(f"session_{seed}", t[:n], None, read[0], read[1][None], declared=DECLARED)


@pytest.mark.parametrize(("recovery", "lead"), [(0.013, 0.010), (0.004, 0.002), (0.1, 0.12), (0.3, 0.1)])
def test_the_fit_begins_near_the_recovery_of_the_skin(recovery, lead):
    """A slow motion tells by how much the taxel lags, recovery less lead. From a tenth of a second, where all fits once began, one of a
    skin that is back in a hundredth never found there."""
    model = dispersion_start([prepare(pressed_by_hand(1, recovery, lead, (0.01, 0.005)))])
    lag = model.dispersion.recovery - model.dispersion.b1 / model.dispersion.k1
    assert lag == pytest.approx(recovery - lead, rel=0.2, abs=1e-3)
    assert model.dispersion.k1 / (model.dispersion.k1 + model.dispersion.k2) == pytest.approx(SHARE, rel=0.01)


def test_noise_of_the_driving_force_is_none_of_the_taxels():
    """The load cell's noise of 30 mN, as declared, is in what is simulated of a taxel whose own is 4 mN: it is coloured by the skin."""
    sessions = [pressed_by_hand(seed, 0.02, 0.01, (0.03, 0.004)) for seed in (1, 2, 3)]
    assert diagnose(sessions[:2], sessions[2:]).findings["verdict"] == "nothing_wrong"


def test_a_push_that_makes_a_contact_is_no_slope():
    """A sample whose driving force lies within a millinewton of leaving the skin jumps when it is pushed, by damping times speed."""
    session = prepare(pressed_by_hand(1, 0.02, 0.01, (0.03, 0.004)))
    model = dispersion_start([session])
    plain = simulated(model, session)
    share = model.dispersion.k1 / (model.dispersion.k1 + model.dispersion.k2)
    for of in (1e-3, 2e-3, 3e-3):  # of some such samples one is met by chance
        driven = replace(session, drive=session.drive - of)
        assert np.abs(carried(DRIVE, (), model, driven, simulated(model, driven))).max() < 1.1 * share
    assert carried(DRIVE, (), model, session, plain)[0, session.drive > 0.3] == pytest.approx(share, rel=1e-3)


def test_a_taxel_that_nothing_predicts_is_not_called_sound():
    """A loose contact that takes a fifth of the reading away, and gives it back, at random: many times louder than while nobody presses."""

    def loose(seed: int) -> Recording:
        r, rng = pressed_by_hand(seed, 0.02, 0.01, (0.005, 0.004)), np.random.default_rng([seed, 7])
        switched = np.cumsum(rng.random(r.t.size) < DT / 0.4) % 2
        return replace(r, taxels=r.taxels * (1.0 - 0.2 * switched), declared=Declared())

    found = diagnose([loose(1), loose(2)], [loose(3)]).findings
    assert found["verdict"] == "unexplained" or ("gain_error", "taxel") in {(f["cause"], f["where"]) for f in found["findings"]}


@pytest.mark.parametrize("clipped", [False, True])
def test_a_force_that_never_falls_far_below_its_peak_is_clipped_only_if_it_is(clipped):
    """Small sines about a preload of 10 N, read in steps of 5 mN."""

    def preloaded(seed: int) -> Recording:
        rng, t = np.random.default_rng(seed), 0.01 * np.arange(6000)
        force = 10.0 + 0.4 * np.sin(np.pi * t) * np.sin(0.2 * t + seed)
        read, taxel = np.array([force, 0.5 * force]) + 0.01 * rng.standard_normal((2, t.size))
        read = np.minimum(read, 10.3) if clipped else read
        y = 0.005 * np.round(np.array([read, taxel]) / 0.005)
        return Recording(f"preload_{seed}", t, None, y[0], y[1:])

    recordings = [preloaded(seed) for seed in range(3)]
    assert bool(find_saturated_drive(recordings, [r.force for r in recordings])) == clipped


def test_a_force_that_never_moves_is_not_clipped():
    t = 0.01 * np.arange(2000)
    held = Recording("held", t, None, np.full(t.size, 10.0), 5.0 + 0.01 * np.random.default_rng(0).standard_normal((1, t.size)))
    assert not find_saturated_drive([held], [held.force])
