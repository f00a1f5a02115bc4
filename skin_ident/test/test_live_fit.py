"""The live estimator agrees with the truth, whatever size the blocks have and whatever is lost on the way."""

import numpy as np
import pytest
from making import SILICONE, recording

from skin_ident.estimators.live import LiveFit

R = recording(n=3000, shares=(1.0, 0.3), sigma=0.02)
TRUTH = [*SILICONE[4][1:], 1.0, 0.3]


def fed(r, block, lose=(), swap=False, nan=()):
    fit = LiveFit(30.0, 5.0, SILICONE[4][0])
    for i in range(len(r)):
        stamp = round(r.t[i] * 1e9) + 10**12
        if i not in lose:
            fit.offer("force", stamp, np.array([np.nan if i in nan else r.force[i]]))
        fit.offer("taxels", stamp, r.taxels[:, i])
        fit.offer("encoder", stamp, r.depth[i : i + 1])
        if i % block == block - 1:
            fit.update()
    return fit


@pytest.mark.parametrize("block", [7, 100, 1500])
def test_block_size_does_not_matter(block):
    fit = fed(R, block)
    assert fit.live.values == pytest.approx(TRUTH, rel=0.02)
    assert np.all(np.abs(fit.live.values - TRUTH) < 5 * fit.live.std + 1e-3 * np.abs(TRUTH))
    assert fit.health.rate == pytest.approx(100.0) and fit.health.jitter < 1e-6


def test_losses_are_bridged_and_counted():
    rng = np.random.default_rng(0)
    lose, nan = set(rng.choice(3000, 60, False).tolist()), set(rng.choice(3000, 30, False).tolist())
    fit = fed(R, 500, lose, nan=nan)
    assert fit.live.values == pytest.approx(TRUTH, rel=0.03)
    assert fit.health.alone > 0 and fit.health.invalid > 0


def test_pause_starts_the_filter_anew():
    fit = fed(R, 50, lose=set(range(1000, 1200)))
    assert fit.live.values == pytest.approx(TRUTH, rel=0.02)


def scores(rho, runs):
    """By how many of its standard errors each parameter misses, (runs, 5)."""
    out = []
    for seed in range(runs):
        r = recording(seed, n=4000, shares=(1.0, 0.3), rho=rho)
        live = fed(r, 200).live
        out.append(((live.values - TRUTH) / np.where(live.std > 0.0, live.std, 1.0))[[0, 1, 2, 3, 5]])
    return np.array(out)


def test_standard_errors_match_the_scatter():
    assert np.all(np.abs(np.std(scores(0.8, 24), axis=0) - 1.0) < 0.4)  # 2.7 standard errors of 24 runs


@pytest.mark.campaign
@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9, 0.97])
def test_intervals_cover(rho, capsys):
    shares = np.mean(np.abs(scores(rho, 400)) < 1.96, axis=0)
    with capsys.disabled():
        print(f"\nlive, rho {rho}: {shares}")
    assert np.all((shares >= 0.91) & (shares <= 0.98))


def offered(fit, rows, shift_ns=0, scale=1.0):
    for k, i in enumerate(rows):
        stamp = round(R.t[i] * 1e9) + 10**12 + shift_ns
        fit.offer("encoder", stamp, scale * R.depth[i : i + 1])
        fit.offer("force", stamp, R.force[i : i + 1])
        fit.offer("taxels", stamp, R.taxels[:, i])
        if k % 10 == 9:
            fit.update()


@pytest.mark.parametrize("back", [-10_000, 10_000_000])
def test_a_clock_that_is_set_back_stops_nobody(back):
    """A bag that is played again; and one sample from the far future, behind which all others seem old."""
    fit = LiveFit(30.0, 5.0, SILICONE[4][0])
    offered(fit, range(1000))
    if back > 0:
        offered(fit, range(1000, 1010), shift_ns=back * 10**9)
    offered(fit, range(1010, 3000), shift_ns=min(back, 0) * 10**9)
    assert fit.live.values == pytest.approx(TRUTH, rel=0.02)
    assert fit.health.used == 10 and fit.health.used_ever > 2900


def test_a_clock_that_is_set_back_to_samples_that_are_no_numbers_leaves_a_stamp_that_is_one():
    """The stamp of the newest sample is published, and one before the epoch is refused there; what is valid again is a new beginning."""
    fit = LiveFit(30.0, 5.0, SILICONE[4][0])
    offered(fit, range(1000))
    offered(fit, range(40), shift_ns=1 - 10**12, scale=np.nan)
    assert fit.newest == 0 and fit.health.invalid == 10
    offered(fit, range(40, 50), shift_ns=1 - 10**12)
    assert fit.newest == round(R.t[49] * 1e9) + 1 and fit.health.pauses == 1 and fit.health.used == 10


def test_absurd_values_are_left_out():
    fit = LiveFit(30.0, 5.0, SILICONE[4][0])
    offered(fit, range(1000))
    offered(fit, range(1000, 1010), scale=1e300)
    assert fit.health.invalid == 10
    offered(fit, range(1010, 3000))
    assert fit.live.values == pytest.approx(TRUTH, rel=0.02)


def test_an_array_of_another_size_is_learnt_anew():
    fit = LiveFit(30.0, 5.0, SILICONE[4][0])
    for i in range(len(R)):
        stamp = round(R.t[i] * 1e9) + 10**12
        fit.offer("encoder", stamp, R.depth[i : i + 1])
        fit.offer("taxels", stamp, R.taxels[:, i] if i > 100 else R.taxels[:1, i])
        if i % 10 == 9:
            fit.update()
    assert fit.live.values[[0, 1, 5]] == pytest.approx([*SILICONE[4][1:3], 0.3], rel=0.02)


def test_nothing_is_claimed_in_the_air():
    assert fed(recording(n=1000, offset=-1e-3), 50).live is None


def test_sums_of_a_stream_are_those_of_one_block():
    a, b = fed(R, 3000), fed(R, 10)
    assert np.allclose(a.live.values, b.live.values, rtol=5e-3)


@pytest.mark.parametrize("late", ["force", "taxels"])
def test_a_topic_that_is_discovered_late_is_taken_in(late):
    """The others are learnt without it first, as when a subscription takes its time."""
    fit = LiveFit(30.0, 5.0, SILICONE[4][0])
    for i in range(len(R)):
        stamp = round(R.t[i] * 1e9) + 10**12
        for role, values in (("encoder", R.depth[i : i + 1]), ("force", R.force[i : i + 1]), ("taxels", R.taxels[:, i])):
            if role != late or i > 200:
                fit.offer(role, stamp, values)
        if i % 10 == 9:
            fit.update()
    assert fit.live.values == pytest.approx(TRUTH, rel=0.02)


def test_a_dead_taxel_stops_nobody():
    fit = LiveFit(30.0, 5.0, SILICONE[4][0])
    for i in range(len(R)):
        stamp = round(R.t[i] * 1e9) + 10**12
        fit.offer("encoder", stamp, R.depth[i : i + 1])
        fit.offer("force", stamp, R.force[i : i + 1])
        fit.offer("taxels", stamp, np.array([R.taxels[0, i], np.nan]))
        if i % 50 == 49:
            fit.update()
    assert fit.live.values == pytest.approx([*SILICONE[4][1:], 1.0, 0.0], rel=0.02) and fit.health.silent == 1
