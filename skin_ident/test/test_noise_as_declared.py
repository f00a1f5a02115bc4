"""A declared level is held against the noise that is there; its colour and its growth with the load against other channels."""

import numpy as np
import pytest
from scipy.signal import lfilter

from skin_ident.criticism.telemetry.noise_level import find_noise
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.recording import Recording

T = np.arange(6000) / 100.0
LOAD = np.array([8.0, 3.0, 2.0, 1.0])[:, None] * np.clip(np.sin(0.5 * T), 0.0, None)
CHANNELS = ("force", "taxel_0", "taxel_1", "taxel_2")
LEVEL = 0.03


def wandering(rng, pole: float, level: float = LEVEL) -> np.ndarray:
    """AR(1) noise with this standard deviation in all."""
    return lfilter([level * np.sqrt(1.0 - pole**2)], [1.0, -pole], rng.standard_normal(T.size + 2000))[2000:]


def told(noise: list[np.ndarray], load: np.ndarray = LOAD, unread: float = 0.0) -> list[tuple[str, str]]:
    """Where and in what the noise (N,) of the four channels is not as declared. `unread` N is the simulation's error from the depth."""
    declared = Declared(force_noise_n=LEVEL, taxel_noise_n=(LEVEL,))
    y = load + noise
    r = Recording("a", T, 1e-3 * np.sin(0.5 * T), y[0], y[1:], declared=declared)
    found = find_noise([r], CHANNELS, [y - load], [np.ones(y.shape, bool)], lambda: np.full(4, unread))
    return [(s.where, s.evidence["kind"]) for s in found]


@pytest.mark.parametrize("pole", [0.0, 0.5, 0.8, 0.9, 0.97, 0.99, 0.995])
def test_a_level_that_was_measured_in_the_air_is_true_of_noise_of_any_colour(pole):
    rng = np.random.default_rng(1)
    assert told([wandering(rng, pole) for _ in CHANNELS]) == []


@pytest.mark.parametrize(("times", "too_loud"), [((1.6, 1.4, 1.6), (0, 1, 2)), ((1.6, 1.2, 1.6), (0, 2)), ((1.4, 1.4, 1.4), ())])
def test_a_taxel_nearly_too_loud_is_told_with_most_of_the_others(times, too_loud):
    rng = np.random.default_rng(9)
    noise = [LEVEL * n * rng.standard_normal(T.size) for n in (1.4, *times)]
    assert told(noise) == [(f"taxel_{i}", "level") for i in too_loud]


@pytest.mark.parametrize("odd", range(4))
def test_one_channel_that_wanders_among_white_ones_is_odd(odd):
    rng = np.random.default_rng(2)
    noise = [wandering(rng, 0.97 if c == odd else 0.0) for c in range(4)]
    assert told(noise) == [("load_cell" if odd == 0 else f"taxel_{odd - 1}", "correlation")]


@pytest.mark.parametrize(
    ("white", "slow", "everywhere", "is_told"), [(1.0, 1.2, True, True), (1.0, 1.2, False, False), (0.7, 0.7, True, False)]
)
@pytest.mark.parametrize("odd", range(4))
def test_a_slow_part_beside_white_noise_is_odd_where_it_is_there_in_the_air(white, slow, everywhere, is_told, odd):
    """Not where it is there under load alone, as what a model lacks would be, nor where both together are as loud as was declared."""
    rng = np.random.default_rng(13)
    noise = [LEVEL * rng.standard_normal(T.size) for _ in range(4)]
    noise[odd] = white * noise[odd] + wandering(rng, 0.98, slow * LEVEL) * (True if everywhere else LOAD[odd] > 0.0)
    assert told(noise) == [("load_cell" if odd == 0 else f"taxel_{odd - 1}", "correlation")] * is_told


@pytest.mark.parametrize("odd", range(4))
@pytest.mark.parametrize(("times", "is_told"), [(2.2, True), (1.2, False)])
def test_what_steps_of_the_encoder_drown_under_load_is_heard_in_the_air(odd, times, is_told):
    rng = np.random.default_rng(21)
    drowning = 4.0 * LEVEL * rng.standard_normal(T.size) * (LOAD > 0.0)
    noise = LEVEL * rng.standard_normal((4, T.size))
    noise[odd] *= times
    assert told(list(noise + drowning), unread=4.0 * LEVEL) == [("load_cell" if odd == 0 else f"taxel_{odd - 1}", "level")] * is_told


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("way", "is_told"), [("wander", True), ("trend", False), ("under load", False), ("in all", False)])
def test_noise_that_wanders_over_seconds_is_odd_unless_it_may_be_drift_or_the_models_error(way, is_told, seed):
    rng = np.random.default_rng(30 + seed)
    noise, slow = LEVEL * rng.standard_normal((4, T.size)), wandering(rng, 0.998, 2.0 * LEVEL)
    if way == "in all":
        noise += np.stack([wandering(rng, 0.998, 2.0 * LEVEL) for _ in CHANNELS])
        assert ("taxel_1", "slow") not in told(list(noise))
        return
    noise[2] += 4.0 * LEVEL * (T / T[-1] - 0.5) if way == "trend" else slow * (LOAD[2] > 0.0) if way == "under load" else slow
    assert ("taxel_1" in dict(told(list(noise)))) is is_told


@pytest.mark.parametrize("odd", range(4))
@pytest.mark.parametrize("times", [1.0, 1.25])
def test_the_low_pass_of_one_amplifier_is_not_odd(odd, times):
    rng = np.random.default_rng(6)
    assert told([wandering(rng, 0.8, times * LEVEL) if c == odd else wandering(rng, 0.0) for c in range(4)]) == []


def test_taxels_may_all_wander_beside_a_load_cell_that_does_not():
    rng = np.random.default_rng(3)
    assert told([wandering(rng, 0.97 if c else 0.0) for c in range(4)]) == []


@pytest.mark.parametrize("carried", [1.0, 0.1])
def test_channels_that_carry_no_load_do_not_tell_that_noise_does_not_grow(carried):
    """Under a plunger over taxel 0 the others carry little, and little noise."""
    rng = np.random.default_rng(11)
    load = LOAD[:1] * np.array([carried, 1.0, 0.02, 0.01])[:, None]
    odd = [np.ones(T.size), 1.0 + 2.0 * load[1] / load[1].max(), np.ones(T.size), np.ones(T.size)]
    noise = [LEVEL * rng.standard_normal(T.size) * grown for grown in odd]
    assert (("taxel_0", "growth") in told(noise, load)) is (carried == 1.0)


@pytest.mark.parametrize("every", [True, False])
def test_noise_that_grows_with_the_load_is_odd_in_one_channel(every):
    rng = np.random.default_rng(4)
    grown = 1.0 + 2.0 * LOAD / LOAD.max(axis=1, keepdims=True)
    noise = [LEVEL * rng.standard_normal(T.size) * (grown[c] if every or c == 1 else 1.0) for c in range(4)]
    kinds = {"level"} if every else {"growth"}
    assert {kind for _, kind in told(noise)} == kinds


@pytest.mark.parametrize(("times", "is_told"), [(0.4, True), (0.8, False), (1.0, False), (1.2, False), (2.0, True)])
@pytest.mark.parametrize("pole", [0.0, 0.9])
def test_another_level_is_told_of_any_colour(times, is_told, pole):
    rng = np.random.default_rng(5)
    found = told([wandering(rng, pole, times * LEVEL if c == 0 else LEVEL) for c in range(4)])
    assert found == [("load_cell", "level")] * is_told
