"""What counts as a rival of a cause, and what speaks for one of two names: the encoder's noise, and what is believed beside them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from skin_ident.criticism.baseline.fitting import cost_of, fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.gates.blurred import blurred
from skin_ident.criticism.noise.whitening import fit_whitener
from skin_ident.criticism.search.exchange import _as_good_with
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.search.rivals import Rival
from skin_ident.criticism.search.search import _beside_dropped
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.tared import beside_zeros
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.effects.lag import Lag
from skin_models.effects.mount_compliance import DampedMount
from skin_models.effects.nonlinear_stiffness import PowerStiffness
from skin_models.effects.nonlinearity import Nonlinearity
from skin_models.effects.rate_dependence import PowerDamping
from skin_models.effects.time_shift import TimeShift
from skin_models.model import Model
from skin_models.signals import motion

T = np.arange(6000) / 100.0
DEPTH = 0.5e-3 + 0.3e-3 * np.sin(0.4 * T) + 0.05e-3 * np.sin(2.1 * T)
PLAIN = Model(Dispersion(m=0.0, b1=900.0, k1=9000.0, b2=600.0, k2=3000.0), shares=(1.0,))
ROOT = PLAIN.extended(PowerDamping("skin", force_sensed=0.3, force_dispersed=0.3, exponent=0.4))


def recorded(model: Model, read: np.ndarray, seed: int = 0, noise: float = 0.01) -> Recording:
    """Channels of `model` at the true depth, which an encoder `read` otherwise."""
    rng, truth = np.random.default_rng(seed), model.simulate(motion(T, DEPTH))
    y = np.vstack([truth.force, truth.taxels]) + noise * rng.standard_normal((2, T.size))
    return Recording(f"made_{seed}", T, read, y[0], y[1:])


def with_error_added(read: np.ndarray, noisy: np.ndarray, seed: int) -> tuple[float, float]:
    """The cost of a record of a root of the speed with the model that made it, and what noise of the encoder is said to have added to that;
    the errors are those of a `noisy` depth."""
    session = prepare(recorded(ROOT, read, seed))
    noise = fit_whitener([residual(ROOT, prepare(recorded(ROOT, noisy, seed)))], [session])
    return cost_of(ROOT, [session], noise), blurred(ROOT, [session], noise)


@pytest.mark.parametrize("seed", range(3))
def test_noise_of_the_encoder_adds_to_the_error_of_a_root_of_the_speed_no_less_than_is_told(seed):
    """Of damping that changes most where the plunger turns; without noise of the depth nothing is added."""
    read = DEPTH + 4e-6 * np.random.default_rng(seed).standard_normal(T.size)
    clear, nothing = with_error_added(DEPTH, read, seed)
    noisy, more = with_error_added(read, read, seed)
    assert nothing < 1e-9
    assert 0.1 * (noisy - clear) < more < noisy - clear


def test_a_mount_that_smooths_the_depth_feels_less_of_its_noise_than_a_clock_that_is_as_late():
    read = DEPTH + 4e-6 * np.random.default_rng(0).standard_normal(T.size)
    session = prepare(recorded(PLAIN, read))
    noise = fit_whitener([residual(PLAIN, session)], [session])
    mount, clock = (PLAIN.extended(e) for e in (DampedMount("rig", late=0.02), TimeShift("clock_depth", delay=0.02)))
    assert blurred(mount, [session], noise) < 0.9 * blurred(clock, [session], noise)


@pytest.mark.parametrize("true", ["finding", "rival"])
def test_what_is_believed_beside_a_rival_speaks_for_it_unless_it_is_as_good_beside_the_finding(true):
    """A taxel that is late, beside skin that stiffens or a taxel that bends."""
    stiffens, late = PowerStiffness("skin", force_sensed=0.8, force_dispersed=0.3), Lag("taxel", tau=0.05)
    bends = Nonlinearity("taxel", deviation=0.03, capacity=20.0)
    truth = PLAIN.extended(stiffens if true == "finding" else bends)
    session = prepare(recorded(replace(truth, effects=(*truth.effects, late)), DEPTH))
    noise = fit_whitener([residual(truth, session)], [session])
    search = Search([session], [], directions(session), lambda stage: None)
    search.noise, search.present = noise, fit(PLAIN.extended(stiffens), [session], noise)
    after = fit(replace(PLAIN, effects=(bends, late)), [session], noise)
    finding = Named(stiffens.cause, "skin", None, 0.0, ())
    assert _as_good_with(search, search, finding, Rival(bends.cause, "taxel", 0.0), after) is (true == "finding")


def found(cause: str, where: str, explains: float) -> Named:
    return Named(cause, where, None, explains, ())


def test_what_zeros_were_taken_for_stays_a_rival_of_less_in_the_same_sensor():
    """A zero that jumps within sessions: tares explain most of it, and what is left looks like a loop."""
    yielded = [found("drift", "load_cell", 500.0), found("force_offset", "load_cell", 700.0), found("lag", "taxel", 900.0)]
    search = SimpleNamespace(yielded=yielded)
    assert [a.key for a in beside_zeros(search, found("hysteresis", "load_cell", 300.0)).alternatives] == [("drift", "load_cell")]
    assert beside_zeros(search, found("hysteresis", "load_cell", 800.0)).alternatives == ()


@pytest.mark.parametrize(("score", "rivals"), [(420.0, [("time_shift", "clock")]), (200.0, [])])
def test_what_was_taken_out_again_is_a_rival_where_it_would_explain_as_much(score, rivals):
    """It is not asked a second time, and what is asked in its place must not be the only name."""
    ranked = {("time_shift", "clock"): score, ("lag", "load_cell"): 300.0}
    last = SimpleNamespace(ranked=[SimpleNamespace(key=key, score=s) for key, s in ranked.items()])
    search = SimpleNamespace(dropped={("time_shift", "clock"), ("drift", "taxel")})
    assert [a.key for a in _beside_dropped(search, last, found("lag", "load_cell", 310.0)).alternatives] == rivals
