"""The noise model against noise whose spectrum is known."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.signal import freqz, lfilter

from skin_ident.criticism.noise.estimate import noise_model
from skin_ident.criticism.noise.in_blocks import AT_ONCE, BLOCK, InBlocks
from skin_ident.criticism.noise.predictor import AVERAGING, MEMORIES, whole
from skin_ident.criticism.noise.taken import taken
from skin_ident.criticism.noise.whitening import Stacked, fit_whitener, order_for, with_growth
from skin_ident.criticism.sessions.load import load_of


@dataclass(frozen=True)
class Seen:
    """All that a noise model looks at in a session."""

    weight: np.ndarray
    load: np.ndarray


def seen(weight: np.ndarray, load: np.ndarray | None = None) -> Seen:
    return Seen(weight, np.zeros_like(weight) if load is None else load)


def halved(weight: np.ndarray, halves: list[slice]) -> list[Seen]:
    return [seen(weight[:, half]) for half in halves]


def test_whitening_makes_coloured_and_common_noise_white_and_independent():
    rng = np.random.default_rng(1)
    common = lfilter([1.0], [1.0, -0.95], rng.standard_normal(20_000))
    e = np.array([common + 0.5 * rng.standard_normal(20_000), 0.7 * common + 0.2 * rng.standard_normal(20_000)])
    noise = fit_whitener([e], [seen(np.ones_like(e))])
    w = noise.apply(e, seen(np.ones_like(e)))[:, 50:]
    assert np.allclose(np.cov(w), np.eye(2), atol=0.05)
    assert np.all(np.abs([np.corrcoef(row[1:], row[:-1])[0, 1] for row in w]) < 0.05)


@pytest.mark.parametrize("pole", [0.0, 0.9, 0.98])
def test_noise_is_as_loud_at_its_slowest_as_it_was_before_directions_took_it(pole):
    """A minute of wandering noise, from which all that is slow may be taken: what whitens offsets and drifts is right nevertheless."""
    n, radians, ratios, bare = 1500, 0.005, [], []
    slow = np.cos(np.pi * np.arange(10)[:, None] * np.linspace(0.0, 1.0, n // 2))[:, None]  # each session's own
    halves = [slice(0, n // 2), slice(n // 2, n)]
    bank = [np.concatenate([(i == j) * slow for j in range(2)]) for i in range(2)]
    wave = np.exp(1j * radians * np.arange(6000))
    true = abs(1.0 - pole * np.exp(-1j * radians)) / np.sqrt(1.0 - pole**2)
    for seed in range(12):
        rng = np.random.default_rng(seed)
        e = lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], rng.standard_normal((1, n + 500)), axis=1)[:, 500:]
        sessions, own = halved(np.ones((1, n)), halves), [np.concatenate([b, np.zeros((0, 1, n // 2))]) for b in bank]
        found = noise_model([e[:, h] for h in halves], Stacked(own, sessions), len(own[0]))
        left = [e[:, h] - np.linalg.lstsq(slow[:, 0].T, e[0, h], rcond=None)[0] @ slow[:, 0] for h in halves]
        naive = fit_whitener(left, sessions)
        for noise, into in ((found, ratios), (naive, bare)):
            told = [noise.apply(part[None], seen(np.ones((1, wave.size))))[0, 3000:] for part in (wave.real, wave.imag)]
            into.append(np.sqrt(np.mean(np.square(told)) * 2.0) / true)
    assert 0.7 < np.median(ratios) < 4.0 and np.max(ratios) < 6.0  # where noise grows below what is seen of it, more than one
    assert np.median(bare) > 2.0 * np.median(ratios)  # which would make every offset certain


def test_what_directions_take_is_counted_by_channel_and_frequency():
    n = 1000
    t = np.linspace(0.0, 1.0, n)
    offset, quick, shared = np.zeros((3, 2, n))
    offset[0], quick[1], shared[:] = 1.0, np.sin(900.0 * t), np.cos(np.pi * t)
    ones = np.ones((2, n))
    freedom, slow = taken([np.array([offset, quick, shared, 2.0 * offset - shared])], [ones], [ones])
    assert np.allclose(freedom, 1.5, atol=0.02)  # the last one is nothing new, and the third is in both
    assert 1.0 < slow[0] < 1.5 and 0.2 < slow[1] < 0.5  # all but the quick one, and what spreads from their ends
    assert not taken([np.zeros((0, 2, n))], [ones], [ones]).any()


def test_noise_is_not_learnt_from_samples_of_which_nothing_was_asked():
    """Directions that go astray where no sample is believed, as between touches, leave the noise what it is."""
    rng, n = np.random.default_rng(5), 3000
    e = lfilter([1.0], [1.0, -0.5], rng.standard_normal((2, n)), axis=1)
    weight = np.ones((2, n))
    for at in range(200, n, 300):
        weight[:, at : at + 30] = 0.0
    wild = np.zeros((40, 2, n))
    for k, row in enumerate(wild):  # nothing to speak of where it is believed, and very much in the eight samples behind a gap
        row[k % 2] = 0.2 * rng.standard_normal(n)
        for at in range(200, n, 300):
            row[:, at : at + 38] = 50.0
    e += 3.0 * wild[:12].sum(axis=0) * (weight > 0.0) * (np.abs(wild[:12].sum(axis=0)) < 40.0)
    halves = [slice(0, n // 2), slice(n // 2, n)]
    found = noise_model([e[:, h] for h in halves], Stacked([wild[..., h] for h in halves], halved(weight, halves)), 0)
    assert np.allclose(found.filters[:, 1], -0.5, atol=0.1)
    assert np.allclose(np.diag(found.root), 1.0, rtol=0.05)


@pytest.mark.parametrize("seed", range(4))
def test_short_pieces_bear_filters_of_a_low_order(seed):
    """Of pieces of a dozen samples a filter of order eight leaves a few, which it then explains all but entirely."""
    rng = np.random.default_rng(seed)

    def sessions() -> list[np.ndarray]:
        return [lfilter([1.0], [1.0, -0.8], rng.standard_normal((2, 200)), axis=1) for _ in range(2)]

    pieces = [seen(np.tile(np.arange(200) % 16 > 0, (2, 1)).astype(float))] * 2
    noise = fit_whitener(sessions(), pieces)
    assert 0 < noise.order < 8
    others = np.concatenate([noise.apply(e, s) for _ in range(20) for e, s in zip(sessions(), pieces, strict=True)], axis=1)
    assert np.all(np.std(others[:, others.any(axis=0)], axis=1) < 1.5)  # other noise of the same kind is as large as it was said to be
    assert order_for([np.ones((2, 30))]) == 0


@pytest.mark.parametrize("kind", ["normal", "heavy-tailed"])
@pytest.mark.parametrize("grows", [0.0, 1.0, 3.0])
def test_noise_that_grows_with_the_load_is_told_from_steady_noise(kind, grows):
    """Where one channel's noise grows and the other's does not; samples get the weight that they deserve, and it takes fewer words."""
    found = []
    for seed in range(10):
        rng, n = np.random.default_rng(seed), 4000
        load = 5.0 * np.maximum(np.sin(2e-3 * np.arange(n) * [[1.0], [1.3]]), 0.0)
        raw = rng.standard_normal((2, n)) if kind == "normal" else rng.standard_t(3, (2, n))
        e = lfilter([1.0], [1.0, -0.7], raw, axis=1) * (1.0 + np.array([[grows], [0.0]]) * load / 5.0)
        session = seen(np.ones((2, n)), load)
        steady = fit_whitener([e], [session])
        noise = with_growth(steady, [e], [session])
        found.append(noise.growth.more)
        assert noise.words([session]) <= steady.words([session])
        w = noise.apply(e, session)
        loud, quiet = w[:, (load > 3.0).all(axis=0)], w[:, (load < 0.5).all(axis=0)]
        assert np.all(np.abs(np.log(np.mean(np.abs(loud), axis=1) / np.mean(np.abs(quiet), axis=1))) < np.log(1.4))
    assert np.median(found, axis=0) == pytest.approx([grows, 0.0], abs=0.51)
    assert np.max(np.array(found)[:, 1]) <= 0.5


@pytest.mark.parametrize("zero", [0.0, 2.0, -2.5, 10.0])
def test_load_is_what_a_channel_reads_beyond_its_zero(zero):
    depth = np.maximum(np.sin(2e-3 * np.arange(4000)), 0.0)
    noise = 0.01 * np.random.default_rng(1).standard_normal((1, depth.size))
    assert load_of(zero + 5.0 * depth[None] + noise, depth, 0.04) == pytest.approx(5.0 * depth[None], abs=0.03)


def test_noise_that_wanders_is_no_load_of_a_channel_that_feels_none():
    """A taxel at the rim reads its own noise; it would seem to grow with what it reads."""
    n = 2400
    depth = np.maximum(np.sin(0.02 * np.arange(n)), 0.0)
    wanders = [lfilter([0.2], [1.0, -0.98], np.random.default_rng(seed).standard_normal(n)) for seed in range(2)]
    load = load_of(np.array([5.0 * depth + wanders[0], 0.05 * depth + wanders[1]]), depth, 0.04)
    assert np.max(load[0]) > 4.0 and not load[1].any()


def test_no_mixture_of_channels_is_taken_to_be_silent_at_its_slowest():
    """Of several channels that one mixture has the least noise left from which slow directions happened to take most of it."""
    n, deepest = 700, []
    slow = np.cos(np.pi * np.arange(12)[:, None] * np.linspace(0.0, 1.0, n))
    bank = np.array([np.eye(5)[c][:, None] * row for c in range(5) for row in slow])
    for seed in range(6):
        e = np.random.default_rng(seed).standard_normal((5, n))
        noise = noise_model([e], Stacked([bank], [seen(np.ones_like(e))]), 0)
        for c in range(5):
            gains = (np.abs(freqz(*noise.predictor(c), np.pi * w)[1]) ** 2 for w in (np.arange(1, 4) / n, np.linspace(0.03, 0.3)))
            deepest.append(np.divide(*map(np.mean, gains)))
    assert np.max(deepest) < 16.0  # noise of a fifth of the power would be 5; without what is given back it is 51


@pytest.mark.parametrize("order", [0, 2, 8])
@pytest.mark.parametrize("n", [1, 7, BLOCK, 5 * BLOCK + 3, (AT_ONCE + 1) * BLOCK + 3])
def test_blocks_leave_what_a_filter_that_runs_leaves(order, n):
    rng = np.random.default_rng(order + n)
    f, c = np.concatenate([[1.0], 0.2 * rng.standard_normal(order)]), 0.1 * rng.standard_normal(MEMORIES.size)
    rows = rng.standard_normal((3, 2, n))
    np.testing.assert_allclose(InBlocks(f, c).apply(rows), lfilter(whole(f, c), AVERAGING, rows, axis=-1), atol=1e-7)
