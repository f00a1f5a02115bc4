"""Faults of the record: found where they are, marked for what they are, and nothing raised over sound recordings or other causes."""

from dataclasses import replace

import numpy as np
import pytest
from making import recording, write_table
from scipy.signal import lfilter
from world import make_sessions, write_case

from skin_ident.criticism.record import inspect
from skin_ident.criticism.telemetry.clock import find_clock_faults
from skin_ident.criticism.telemetry.encoder import find_encoder_faults
from skin_ident.criticism.telemetry.grid import factor_of
from skin_ident.criticism.telemetry.outliers import Said, find_outliers
from skin_ident.criticism.telemetry.units import FACTORS
from skin_ident.recordings.load import load
from skin_models.tables.order import Mended

FAULTS = [
    ("outliers", "load_cell", "spikes"), ("outliers", "rig", "spikes"), ("outliers", "rig", "frozen"), ("outliers", "taxel_0", "dropouts"),
    ("quantization", "load_cell", "cut"), ("quantization", "rig", "round"), ("interference", "load_cell", "mains"),
    ("dead_taxel", "taxel_0", "stuck"), ("dead_taxel", "taxel_0", "dies"),
    ("data_error", None, "repeated_block"), ("data_error", None, "swapped_columns"), ("data_error", None, "unit_factor"),
    ("data_error", None, "unit_change"), ("data_error", None, "broken_time"), ("data_error", None, "copied_session"),
]  # fmt: skip


def looked(folder, cause, where=None, form=None, size=1.0, seed=0, taxels=1, noise="white"):
    sessions, _ = make_sessions(cause, where, form, size, seed, "full", 2, taxels, noise)
    write_case(sessions, folder)
    return inspect(load(folder))


@pytest.mark.parametrize(("cause", "where", "form"), FAULTS)
def test_a_fault_is_found_and_explained(tmp_path, cause, where, form):
    symptoms = [s for s in looked(tmp_path, cause, where, form, 2.0, 41).symptoms if s.cause == cause]
    assert symptoms
    assert any(c.isdigit() for c in symptoms[0].evidence["why"]) and "\n" not in symptoms[0].evidence["why"]


@pytest.mark.parametrize(("seed", "noise"), [(20, "ar_t3"), (35, "t3"), (3, "hetero"), (9, "ar")])
def test_sound_recordings_raise_nothing(tmp_path, seed, noise):
    assert not looked(tmp_path, "null", seed=seed, noise=noise).symptoms


@pytest.mark.parametrize("cause", ["inertia", "adhesion", "friction", "position_offset"])
def test_contacts_and_reversals_are_no_outliers(tmp_path, cause):
    assert not looked(tmp_path, cause, size=2.0, seed=102).symptoms


@pytest.mark.parametrize("seed", range(3))
def test_an_encoder_whose_noise_is_wider_than_its_step_has_no_outliers(tmp_path, seed):
    """Forces know nothing of its noise, and in forty thousand samples some of it is far out. Spikes are told beside it."""
    write_case(make_sessions([], seed=seed, n_taxels=2, noise="white", encoder_noise_um=8.0)[0], tmp_path / "sound")
    assert not inspect(load(tmp_path / "sound")).symptoms
    spiky, _ = make_sessions("outliers", "rig", "spikes", 6.0, seed, n_taxels=2, noise="white", encoder_noise_um=8.0)
    write_case(spiky, tmp_path / "spiky")
    assert [(s.cause, s.where) for s in inspect(load(tmp_path / "spiky")).symptoms] == [("outliers", "rig")]


@pytest.mark.parametrize("louder", ["with the load", "in bursts"])
@pytest.mark.parametrize("seed", range(3))
def test_noise_of_the_encoder_that_is_louder_at_times_is_no_outlier(seed, louder):
    """Five steps of its noise where it is loudest reach far beyond its noise at rest. Spikes are told beside it."""
    rng, step = np.random.default_rng(seed), 1e-6
    r = recording(seed, sigma=0.002, offset=0.25e-3, dt=0.005)
    level = np.clip(r.depth / r.depth.max(), 0.0, 1.0) if louder == "with the load" else np.repeat(rng.random(40) < 0.15, len(r) // 40)
    noisy = step * np.round((r.depth + 3.0 * step * level * rng.standard_normal(len(r))) / step)
    assert find_encoder_faults([replace(r, depth=noisy)]) == []
    spiky = noisy + np.where(np.isin(np.arange(len(r)), rng.choice(np.flatnonzero(r.depth > 0.0), 6)), 60.0 * step, 0.0)
    assert [s.where for s in find_encoder_faults([replace(r, depth=spiky)])] == ["rig"]


def test_bad_samples_have_no_weight_and_are_bridged(tmp_path):
    found = looked(tmp_path, "outliers", "load_cell", "spikes", 2.0, 41)
    bad = {k: m for s in found.symptoms for k, m in s.bad.items()}
    assert bad
    row = found.sessions[0].channels.index("force")
    assert np.any(found.sessions[0].weight[row] == 0.0)
    assert np.all(found.sessions[0].weight[found.sessions[0].channels.index("taxel_0")] == 1.0)


def test_spikes_of_nine_standard_deviations_stand_apart_and_heavy_tails_do_not():
    """Of 60 such records 59 were found, and none of 60 without spikes in noise with the tails of t with 3 degrees of freedom."""
    slow = np.sin(np.arange(20_000) / 300.0)
    seen, false = [], 0

    def found(e):
        return find_outliers(("force",), [Said("a", e[None], slow[None] + e[None], np.zeros(slow.size, bool))], 0.01)

    for seed in range(20):
        rng = np.random.default_rng(seed)
        spikes = np.zeros(slow.size)
        spikes[rng.choice(slow.size, 40, replace=False)] = 9.0 * rng.choice([-1.0, 1.0], 40)
        seen += [s.evidence["excursions"] for s in found(spikes + rng.standard_normal(slow.size))]
        false += len(found(rng.standard_t(3, slow.size)))
    assert len(seen) >= 18 and false == 0
    assert min(seen) >= 20 and max(seen) <= 42


SKEWED = {
    "exponential": lambda rng, n: rng.exponential(size=n) - 1.0,
    "gamma": lambda rng, n: (rng.gamma(4.0, size=n) - 4.0) / 2.0,
    "log-normal": lambda rng, n: np.exp(0.3 * rng.normal(size=n)),
    "wandering": lambda rng, n: lfilter([1.0], [1.0, -0.9], rng.exponential(size=n) - 1.0),
}


@pytest.mark.parametrize("noise", SKEWED)
def test_spikes_to_one_side_need_not_reach_beyond_the_noise_and_skewed_noise_has_none(noise):
    """Spikes of six standard deviations, between 3 and 9, in six samples of a thousand."""
    slow = np.sin(np.arange(18_000) / 300.0)
    seen, false = [], 0

    def found(e):
        return find_outliers(("force",), [Said("a", e[None], slow[None] + e[None], np.zeros(slow.size, bool))], 0.01)

    for seed in range(10):
        rng = np.random.default_rng(seed)
        spikes = 6.0 * rng.uniform(0.5, 1.5, slow.size) * (rng.random(slow.size) < 0.006)
        seen += [s.evidence["excursions"] for s in found(rng.standard_normal(slow.size) - spikes)]
        false += len(found(SKEWED[noise](rng, slow.size)))
    assert len(seen) >= 9 and false == 0
    assert min(seen) > 40 and max(seen) < 120


@pytest.mark.parametrize(("kind", "rivals"), [("loud at times", (("noise", "load_cell"),)), ("garbage of one sign", ()), ("spikes", ())])
def test_a_sensor_that_is_loud_at_times_may_be_noisy_as_well_as_have_outliers(kind, rivals):
    rng, slow = np.random.default_rng(4), 20.0 * np.sin(np.arange(12_000) / 300.0)
    e, starts = rng.standard_normal(slow.size), rng.choice(slow.size // 60, 40, replace=False) * 60 + 10
    for at in starts:
        n = {"loud at times": 30, "garbage of one sign": 5, "spikes": 1}[kind]
        e[at : at + n] += 12.0 * (rng.standard_normal(n) if kind == "loud at times" else 3.0 + 0.1 * rng.standard_normal(n))
    (found,) = find_outliers(("force",), [Said("a", e[None], (slow + e)[None], np.zeros(slow.size, bool))], 0.01)
    assert found.alternatives == rivals


def test_heavy_tails_in_coarse_steps_are_no_outliers(tmp_path):
    """Steps larger than the noise round what goes beyond a level up to the next one: here 50 samples go beyond, and 24 were expected."""
    sessions, _ = make_sessions([], seed=1013840389, n_taxels=3, protocol="full", encoder_step_um=10.0)
    write_case(sessions, tmp_path)
    assert not inspect(load(tmp_path)).symptoms


def test_samples_that_were_lost_are_no_other_unit():
    """Interpolated ones lie between levels, as may a median; and what was worked out differs in its last digits."""
    rng = np.random.default_rng(5)
    for _ in range(50):
        step = 10.0 ** rng.uniform(-4.0, -1.0)
        y = step * np.round(np.cumsum(rng.standard_normal(2000)))
        lost = rng.integers(1, 1999, 8)
        y[lost] = 0.5 * (y[lost - 1] + y[lost + 1])
        y = np.append(y * (1.0 + 1e-15 * rng.standard_normal(y.size)), 0.5 * step + np.median(np.round(y / step) * step))
        assert factor_of(y, step, FACTORS) == 1.0
        assert factor_of(1e-3 * y, step, FACTORS) == 1e-3


@pytest.mark.parametrize("lost", [0.0, 0.005, 0.02])
def test_readings_lost_to_nothing_hide_no_unit(lost):
    rng, step = np.random.default_rng(0), 3e-3
    y = step * (np.round(3.0 * np.abs(np.sin(np.arange(8001) / 300.0)) / step) + 0.37)  # a tare between two steps
    y[rng.random(y.size) < lost] = 0.0
    assert factor_of(y, step, FACTORS) == 1.0 and factor_of(1e-3 * y, step, FACTORS) == 1e-3


@pytest.mark.parametrize("seed", range(4))
def test_noise_that_seldom_carries_a_reading_to_the_next_level_is_no_outlier_though_stamps_are_uneven(tmp_path, seed):
    """Between uneven stamps readings are interpolated, so that the levels no longer show in what is compared."""
    rng = np.random.default_rng(seed)
    for k in range(2):
        t = np.arange(0.0, 40.0, 0.01) + rng.uniform(-2e-3, 2e-3, 4000)
        x = 0.5e-3 * np.minimum(1.0, np.maximum(0.0, t - 1.0) / 3.0)
        noise = lfilter([1.0], [1.0, -0.98], 1.4e-3 * rng.standard_normal(t.size)) + 1.5e-3 * rng.standard_normal(t.size)
        force, taxel = 5e3 * x + 0.01 * rng.standard_normal(t.size), np.round((3e3 * x + noise) / 0.015) * 0.015
        rows = "".join(f"{a:.6f},{1e3 * b:.6f},{c:.5f},{d:.4f}\n" for a, b, c, d in zip(t, x, force, taxel, strict=True))
        (tmp_path / f"session_{k}.csv").write_text("t_s,x_mm,force_n,taxel_0_n\n" + rows)
    assert not [s for s in inspect(load(tmp_path)).symptoms if s.cause == "outliers"]


def test_readings_that_are_alike_between_two_spikes_of_heavy_tailed_noise_are_no_outliers():
    """It is the two beside them that lie apart, and such noise has spikes."""
    rng = np.random.default_rng(1)
    y = 0.048 * np.round((2.45 + 0.05 * rng.standard_normal(4000)) / 0.048)
    y[2000], y[2001:2005], y[2005] = 2.45 - 0.42, 0.048 * 51, 2.45 - 0.6
    assert not found_in(y)
    y[2001:2005], y[2000], y[2005] = 2.45 - 0.6, y[1999], y[2006]
    assert found_in(y)[0].evidence["count"] == 4


@pytest.mark.parametrize("pole", [0.0, 0.95])
def test_noise_that_wanders_in_jumps_comes_back_now_and_then(pole):
    """And repeats one reading meanwhile, in steps of a converter; white noise does not stand still far away."""
    rng = np.random.default_rng(4)
    noise = lfilter([1.0], [1.0, -pole], 0.02 * rng.standard_normal(4000))
    noise[2000:2005] += np.sign(noise[2000]) * 0.45 - noise[2000:2005] + noise[2000]
    y = 0.048 * np.round((2.45 + noise) / 0.048)
    assert np.ptp(y[2000:2005]) == 0.0 and bool(found_in(y)) is not bool(pole)


def found_in(y):
    return find_outliers(("force",), [Said("a", y[None] - 2.45, y[None], np.zeros(y.size, bool))], 0.01)


def test_what_is_wrong_with_the_clock_is_counted_and_not_read_from_what_is_said_of_it(tmp_path):
    r = recording(n=300)
    lines = write_table(tmp_path / "a.csv", r).read_text().splitlines()
    lines[50] = lines[51]
    lines[150], lines[151] = lines[151], lines[150]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    (found,) = find_clock_faults(load(tmp_path / "a.csv"))
    assert found.evidence["why"].endswith("evenly: a.csv: 1 sample out of order; a.csv: 1 repeated time stamp dropped")
    assert found.parameters["samples"]["value"] == 2.0
    assert find_clock_faults([r.warned("3 repeated time stamps dropped, the first sample of each kept")]) == []


def test_topics_that_lost_the_same_stamps_lost_them_once():
    topics = (Mended(repeated=3), Mended(repeated=3), Mended(unstamped=1), Mended(late=2))
    (found,) = find_clock_faults([replace(recording(n=300), mended=topics)])
    assert found.parameters["samples"]["value"] == 5.0
