"""Pieces of a record that only one channel knows of, hidden in recordings of the world."""

from dataclasses import replace

import numpy as np
import pytest
from world import make_sessions, write_table
from world.noise import Noise

from skin_ident.criticism.record import inspect
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.telemetry.other_units import in_other_units
from skin_ident.criticism.telemetry.peaks import Piece
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import Recording


def record(folder, spoil, seed: int, **how) -> list:
    """Three sessions of two taxels, of which `spoil(session, rng)` spoils the second."""
    sessions, _ = make_sessions(None, seed=seed, n_sessions=3, n_taxels=2, **how)
    rng = np.random.default_rng([seed, 5])
    for i, s in enumerate(sessions):
        write_table(spoil(s, rng) if i == 1 else s, folder / f"session_{i}.tsv")
    return load(folder)


def touched(s, rng):
    """A cable that is touched five times, 0.15 s each, in taxel 1."""
    y, n = s.taxels.copy(), s.force.size
    for at in rng.integers(n // 5, 4 * n // 5, 5):
        y[at : at + 15, 1] += 0.6 * np.ptp(y[:, 1])
    return replace(s, taxels=y)


def replayed(s, rng):
    """Three seconds of force that are those of another time."""
    y, n = s.force.copy(), s.force.size
    i = n // 2 + int(np.argmax(np.abs(y[n // 2 : -300] - y[n // 2 - 900 : -1200])))
    i = min(i, n - 300)
    y[i : i + 300] = y[i - 900 : i - 600] + 1e-6  # not to the last digit, which telemetry finds without a model
    return replace(s, force=y)


@pytest.mark.parametrize(("spoil", "where", "channel"), [(touched, "taxel_1", "taxel_1"), (replayed, "load_cell", "force")])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_piece_that_lasts_is_an_outlier_and_is_not_believed(tmp_path, spoil, where, channel, seed):
    looked = inspect(record(tmp_path, spoil, seed, noise="white"))
    found = [s for s in looked.symptoms if s.cause == "outliers"]
    assert [(s.where, s.channels) for s in found] == [(where, (channel,))]
    assert ("session_1.tsv", channel) in found[0].bad
    row = looked.sessions[1].channels.index(channel)
    assert looked.sessions[1].weight[row].mean() < looked.sessions[0].weight[row].mean()


def swallowed(s, rng):
    """A taxel that reads nothing below a threshold."""
    y = s.taxels.copy()
    y[:, 1] *= y[:, 1] > 0.1 * y[:, 1].max()
    return replace(s, taxels=y + 0.002 * rng.standard_normal(y.shape))


def dropped(s, rng):
    """A taxel that reads nothing five times, 0.3 s each."""
    y, n = s.taxels.copy(), s.force.size
    for at in rng.integers(n // 5, 4 * n // 5, 5):
        y[at : at + 30, 1] = 0.0
    return replace(s, taxels=y + 0.002 * rng.standard_normal(y.shape))


@pytest.mark.parametrize(("spoil", "told", "seed"), [(swallowed, False, 3), (swallowed, False, 4), (dropped, True, 3), (dropped, True, 4)])
def test_what_reads_nothing_whenever_it_should_read_little_has_a_threshold_and_drops_nothing(tmp_path, spoil, told, seed):
    sessions = [spoil(s, np.random.default_rng(seed)) for s in make_sessions(None, seed=seed, n_sessions=3, n_taxels=2, noise="white")[0]]
    for i, s in enumerate(sessions):
        write_table(s, tmp_path / f"session_{i}.tsv")
    faults = {(s.cause, s.where) for s in inspect(load(tmp_path)).symptoms} & {("outliers", "taxel_1"), ("dead_taxel", "taxel_1")}
    assert bool(faults) == told


@pytest.mark.parametrize("seed", range(4))
def test_heavy_tails_and_colour_are_no_pieces(tmp_path, seed):
    looked = inspect(record(tmp_path, lambda s, rng: s, 40 + seed, noise="ar_t3"))
    assert not [s for s in looked.symptoms if "pieces" in s.evidence]


@pytest.mark.parametrize("seed", [1, 2])
def test_one_kick_that_fades_as_the_noise_does_is_noise(tmp_path, seed):
    """A single innovation of 3 N, where the noise of a few hundredths has a memory of two seconds."""

    def kicked(s, rng):
        y, n = s.force.copy(), s.force.size
        at = n // 2
        y[at:] += 3.0 * 0.995 ** np.arange(n - at)
        return replace(s, force=y)

    looked = inspect(record(tmp_path, kicked, seed, noise=Noise("ar", 1.0, 0.995)))
    assert not [s for s in looked.symptoms if "pieces" in s.evidence]


def slipped(factor: float, share: float):
    """Taxel 1 times a factor, for a share of the session."""

    def spoil(s, rng):
        y, n = s.taxels.copy(), s.force.size
        y[int(0.4 * n) : int((0.4 + share) * n), 1] *= factor
        return replace(s, taxels=y)

    return spoil


@pytest.mark.parametrize(("factor", "share"), [(1.0 / 4.44822, 0.1), (1.0 / 4.44822, 0.2), (1.0 / 9.80665, 0.2)])
def test_a_stretch_in_other_units_is_told_however_long_it_is(tmp_path, factor, share):
    looked = inspect([replace(r, declared=Declared()) for r in record(tmp_path, slipped(factor, share), 3, noise="white")])
    (found,) = [s for s in looked.symptoms if "taxel_1" in s.channels]
    assert (found.cause, found.where, found.evidence["kind"]) == ("data_error", "taxel_1", "unit change")
    assert found.parameters["factor"]["value"] == pytest.approx(factor, rel=1e-3)
    assert found.bad["session_1.tsv", "taxel_1"].mean() == pytest.approx(share, abs=0.06)


def test_a_stretch_of_another_gain_is_no_matter_of_units(tmp_path):
    looked = inspect(record(tmp_path, slipped(0.45, 0.1), 3, noise="white"))
    assert not [s for s in looked.symptoms if s.cause == "data_error"]


@pytest.mark.parametrize("felt", [0.0, 1.0])
def test_a_stretch_in_which_nothing_is_read_is_in_no_other_unit(felt):
    """Of skin that is left a model may say a little where a taxel reads nothing, give or take a step; or it feels nothing by the model."""
    t = np.arange(4000) * 0.01
    x = 0.5e-3 + 0.5e-3 * np.sin(t)
    model = felt * 2.0 * np.exp(-((t - 20.0) ** 2))
    taxel = np.where(np.abs(t - 20.0) < 2.0, 2e-3 * (np.arange(t.size) % 7 == 0), model)
    session = prepare(Recording("a", t, x, 1e3 * x, taxel[None]))
    rest = [np.array([np.zeros(t.size), taxel - model])]
    assert in_other_units([Piece("a", "taxel_0", 18.5, 3.0, 1.0, True)], [session], rest) is None


def test_a_piece_too_short_to_be_a_stretch_is_in_no_other_unit():
    t = np.arange(4000) * 0.01
    x = 0.5e-3 + 0.4e-3 * np.sin(t)
    model = 2e3 * x
    taxel = np.where((t >= 20.0) & (t < 20.2), model / 4.44822, model)
    session = prepare(Recording("a", t, x, 1e3 * x, taxel[None]))
    rest = [np.array([np.zeros(t.size), taxel - model])]
    assert in_other_units([Piece("a", "taxel_0", 20.0, 0.2, 1.0, False)], [session], rest) is None


@pytest.mark.parametrize(("begin", "end"), [(0.5, 1.0), (0.2, 0.35), (0.6, 0.75)])
def test_columns_that_are_exchanged_for_a_stretch_are_told(tmp_path, begin, end):
    def crossed(s, rng):
        y, n = s.taxels.copy(), s.force.size
        at = slice(int(begin * n), int(end * n))
        y[at] = y[at, ::-1]
        return replace(s, taxels=y)

    looked = inspect(record(tmp_path, crossed, 3, noise="white"))
    (found,) = looked.symptoms
    assert (found.cause, found.where, found.evidence["kind"]) == ("data_error", "taxel", "exchanged columns")
    mask, other = (found.bad["session_1.tsv", c] for c in ("taxel_0", "taxel_1"))
    n = mask.size
    assert np.mean(mask[int(begin * n) : int(end * n)]) > 0.8  # but for its ends in the air, where both read nothing
    assert np.mean(mask) < 1.2 * (end - begin) and np.array_equal(mask, other)


def test_columns_that_are_exchanged_for_half_a_second_are_told(tmp_path):
    def crossed(s, rng):
        y = s.taxels.copy()
        loaded = np.convolve(np.abs(y[:, 0] - y[:, 1]), np.ones(50), mode="valid")
        at = slice(int(np.argmax(loaded)), int(np.argmax(loaded)) + 50)
        y[at] = y[at, ::-1]
        return replace(s, taxels=y)

    (found,) = inspect(record(tmp_path, crossed, 3, noise="white")).symptoms
    assert found.evidence["kind"] == "exchanged columns" and found.bad["session_1.tsv", "taxel_0"].sum() == pytest.approx(50, abs=5)


def test_two_gains_that_change_at_once_are_not_exchanged_columns(tmp_path):
    def other_gains(s, rng):
        y = s.taxels.copy()
        y[s.force.size // 2 :] *= (0.6, 1.5)
        return replace(s, taxels=y)

    looked = inspect(record(tmp_path, other_gains, 3, noise="white"))
    assert not [s for s in looked.symptoms if s.evidence.get("kind") == "exchanged columns"]
