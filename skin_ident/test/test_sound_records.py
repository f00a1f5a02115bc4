"""Records in which nothing is wrong but that something is not known: a mass, a taxel's share, slow noise of short sessions. Written out as
forces here, not simulated by the model that is fitted."""

from dataclasses import replace

import numpy as np
import pytest
from rows import rows
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.recording import Recording

RATE = 100.0
K1, B1, K2, B2 = 9619.0, 939.5, 2766.0, 629.2  # thesis, Table 4-2, silicone of 4 mm
GRAVITY = 9.81
TAXELS_MM = ((0.0, 0.0), (7.0, 0.0), (14.0, 0.0))
WIDTH_MM = 5.25


def presses(seed: int, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Presses to many depths, in and out of the skin, with holds: time (s) and depth (m)."""
    rng = np.random.default_rng([seed, 1])
    corners, when = [-2e-4], [0.0]
    while when[-1] < seconds:
        deep = corners[-1] <= 0.0
        corners += 2 * [rng.uniform(0.3e-3, 1.2e-3) if deep else -2e-4]
        when += [when[-1] + rng.uniform(0.5, 1.5), when[-1] + rng.uniform(2.0, 3.0)]
    t = np.arange(0.0, seconds, 1.0 / RATE)
    x = np.interp(t, when, corners)
    soft = np.hanning(2 * int(0.1 * RATE) + 1)
    return t, np.convolve(np.pad(x, soft.size // 2, mode="edge"), soft / soft.sum(), "valid")


def branches(x: np.ndarray, damped: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sensed and dispersed force, N, and where plunger and skin touch; `damped` as much as silicone."""
    v = damped * np.gradient(x, 1.0 / RATE)
    touched = (x > 0.0) & (K1 * x + B1 * v + K2 * x + B2 * v > 0.0)
    return touched * (K1 * x + B1 * v), touched * (K2 * x + B2 * v), touched


def noise(rng: np.random.Generator, n: int, size: float, colour: float) -> np.ndarray:
    return size * np.sqrt(1.0 - colour**2) * lfilter([1.0], [1.0, -colour], rng.standard_normal(n))


def heavy(seed: int, mass: float, declared: Declared, size: float = 0.04, damped: float = 1.0) -> Recording:
    t, x = presses(seed, 60.0)
    rng, (sensed, dispersed, touched) = np.random.default_rng([seed, 2]), branches(x, damped)
    weight = touched * mass * (np.gradient(np.gradient(x, t), t) - GRAVITY)
    force = sensed + dispersed + weight + noise(rng, t.size, size, 0.8)
    return Recording(f"session_{seed}", t, x, force, (sensed + noise(rng, t.size, 0.03, 0.8))[None], declared=declared)


@pytest.mark.parametrize("mass", rows([0.243, 0.1], 0))
def test_a_mass_that_nobody_declared_is_no_fault_of_a_sensor(mass):
    """0.243 kg: thesis, Table 4-4."""
    outcome = diagnose([heavy(1, mass, Declared()), heavy(2, mass, Declared())], [heavy(3, mass, Declared())])
    assert outcome.findings["findings"] == [] and outcome.findings["verdict"] == "nothing_wrong"
    assert outcome.baseline.dispersion.m == pytest.approx(mass, rel=0.05)
    assert outcome.baseline.dispersion.k2 == pytest.approx(K2, rel=0.03)
    assert any("mass was fitted" in w for w in outcome.findings["warnings"])


@pytest.mark.parametrize("seed", rows([0, 10], 0))
def test_a_skin_that_weighs_less_than_the_one_of_the_thesis_is_not_bent(seed):
    """A load cell that is good for a millinewton reads the four that a skin of nothing takes less than one of 0.4 g."""
    first, second, third = (heavy(seed + i, 0.0, Declared(), 0.001, damped=0.01) for i in (1, 2, 3))
    outcome = diagnose([first, second], [third])
    assert outcome.findings["findings"] == [] and outcome.findings["verdict"] == "nothing_wrong"
    assert outcome.baseline.dispersion.m < 1e-4
    assert not any("mass" in w for w in outcome.findings["warnings"])


@pytest.mark.slow
def test_a_declared_mass_stays_as_it_is_and_a_light_skin_is_not_weighed():
    said = Declared(moving_mass_kg=0.243)
    sessions = [heavy(i, 0.243, said) for i in (1, 2, 3)]
    for recordings, mass in ((sessions, 0.243), ([heavy(i, 0.000432, Declared()) for i in (1, 2, 3)], 0.000432)):
        outcome = diagnose(recordings[:2], recordings[2:])
        assert outcome.findings["findings"] == [] and outcome.baseline.dispersion.m == pytest.approx(mass)
        assert not any("mass was fitted" in w for w in outcome.findings["warnings"])


def tared(seed: int, mass: float, size: float = 0.04) -> Recording:
    """A mass between load cell and skin, whose weight was tared away: its inertia alone is felt, in the air too."""
    t, x = presses(seed, 60.0)
    rng, (sensed, dispersed, _) = np.random.default_rng([seed, 4]), branches(x)
    force = sensed + dispersed + mass * np.gradient(np.gradient(x, t), t) + noise(rng, t.size, size, 0.8)
    said = Declared(moving_mass_kg=mass)
    return Recording(f"session_{seed}", t, x, force, (sensed + noise(rng, t.size, 0.03, 0.8))[None], declared=said)


@pytest.mark.parametrize("mass", rows([0.02, 0.08], 0))
def test_a_declared_mass_that_hangs_on_the_load_cell_is_no_fault(mass):
    outcome = diagnose([tared(1, mass), tared(2, mass)], [tared(3, mass)])
    assert outcome.findings["findings"] == [] and outcome.findings["verdict"] == "nothing_wrong"
    assert outcome.baseline.dispersion.m < 0.25 * mass
    assert [type(e).__name__ for e in outcome.baseline.effects] == ["Inertia"]
    assert any("tared with it" in w for w in outcome.findings["warnings"])


@pytest.mark.parametrize(("recorded", "mass", "threshold"), rows([(tared, 0.0066, 0.1), (tared, 0.03, 0.3), (heavy, 0.03, 0.3)], 0))
def test_a_declared_mass_is_what_it_is_beside_a_threshold_of_the_taxel(recorded, mass, threshold):
    """Whether it hangs or leans. A curvature of the skin would explain the missing weight and the threshold at once. `threshold` is N."""

    def answering_late(seed: int) -> Recording:
        r = recorded(seed, mass) if recorded is tared else recorded(seed, mass, Declared(moving_mass_kg=mass))
        lost = threshold * np.tanh(np.maximum(r.taxels, 0.0) / threshold)
        return replace(r, taxels=r.taxels - lost)

    outcome = diagnose([answering_late(1)], [answering_late(2)])
    assert [(f["cause"], f["where"]) for f in outcome.findings["findings"]] == [("dead_zone", "taxel")]
    assert (outcome.baseline.dispersion.m < 0.25 * mass) == (recorded is tared)


@pytest.mark.slow
def test_inertia_beyond_that_of_a_declared_mass_is_found_where_that_hangs():
    """What hangs is known, so that it takes up nothing of what is hidden."""
    sessions = [tared(seed, 0.8, 0.004) for seed in (1, 2)]
    train, held = ([replace(r, declared=Declared(moving_mass_kg=0.03))] for r in sessions)
    (found,) = diagnose(train, held).findings["findings"]
    assert (found["cause"], found["where"]) == ("inertia", "rig")
    assert found["parameters"]["mass"]["value"] == pytest.approx(0.77, rel=0.1)


def tared_in_steps(seed: int, zero: float) -> Recording:
    """A converter with steps of the noise's size, and a taxel whose zero is off by `zero` steps."""
    t, x = presses(seed, 60.0)
    rng, (sensed, dispersed, _), q = np.random.default_rng([seed, 5]), branches(x), 0.02
    rows = [y + noise(rng, t.size, q, 0.5) for y in (sensed + dispersed, sensed + zero * q)]
    force, taxel = (q * np.round(y / q) for y in rows)
    return Recording(f"session_{seed}", t, x, force, taxel[None])


@pytest.mark.parametrize(("zeros", "named"), rows([((0.6, -0.7, 0.8), set()), ((4.0, -5.0, 5.0), {("force_offset", "taxel")})], 0))
def test_a_zero_that_a_tare_in_steps_leaves_is_no_finding(zeros, named):
    """An effect of less than a step, in the noise's size nearly, is there and is said; one of several steps is named."""
    sessions = [tared_in_steps(seed, zero) for seed, zero in zip((1, 2, 3), zeros, strict=True)]
    findings = diagnose(sessions[:2], sessions[2:]).findings
    assert {(f["cause"], f["where"]) for f in findings["findings"]} == named
    assert named or any(u.get("own_zero") and "tare" in u["because"] for u in findings["untestable"])


@pytest.mark.parametrize(("zero", "named"), rows([(0.4, []), (4.0, [("force_offset", "taxel")])], 1))
def test_a_zero_that_all_sessions_share_may_be_a_tare_too(zero, named):
    """Or the one of a session that is alone: within half a step it is said, and beyond a step named."""
    sessions = [tared_in_steps(seed, zero) for seed in (1, 2)]
    for held in (sessions[1:], []):
        findings = diagnose(sessions[:1], held).findings
        assert [(f["cause"], f["where"]) for f in findings["findings"]] == named
        assert named or any(u.get("own_zero") and "tare" in u["because"] for u in findings["untestable"])


def in_a_row(seed: int, place_mm: float, seconds: float = 60.0, size: float = 0.02, colour: float = 0.8) -> Recording:
    t, x = presses(seed, seconds)
    rng, (sensed, dispersed, _) = np.random.default_rng([seed, 3]), branches(x)
    shares = np.exp(-0.5 * ((np.array(TAXELS_MM)[:, 0] - place_mm) / WIDTH_MM) ** 2)
    taxels = np.array([share * sensed + noise(rng, t.size, size, colour) for share in shares])
    said = Declared(taxel_positions_mm=TAXELS_MM, contact_position_mm={"": (place_mm, 0.0)})
    return Recording(f"session_{seed}", t, x, sensed + dispersed + noise(rng, t.size, size, colour), taxels, declared=said)


@pytest.mark.parametrize("seed", rows([10, 20], 1))
def test_a_taxel_that_only_the_held_out_session_loads_has_no_error(seed):
    """Training knows next to nothing of its share; what it reads is then news, and no fault."""
    outcome = diagnose([in_a_row(seed, 0.0), in_a_row(seed + 1, -4.0)], [in_a_row(seed + 2, 14.0)])
    assert outcome.findings["findings"] == [] and outcome.findings["verdict"] == "nothing_wrong"


@pytest.mark.parametrize("seed", rows([30, 40, 50, 60], 1))
def test_noise_that_wanders_through_half_a_minute_has_no_name(seed):
    outcome = diagnose([in_a_row(seed, 7.0, 35.0, 0.07, 0.97), in_a_row(seed + 1, 7.0, 35.0, 0.07, 0.97)])
    assert outcome.findings["findings"] == []


@pytest.mark.parametrize("seed", rows([70, 80, 90], 1))
def test_wandering_noise_that_once_jumps_for_good_is_no_step_of_a_sensor(seed):
    """Noise of long memory with heavy tails: one of its innovations is fifty of the others, and what follows forgets it slowly."""

    def jumping(seed: int, jump: float) -> Recording:
        sound = in_a_row(seed, 7.0, 30.0, 0.1, 0.995)
        t, taxels = sound.t, sound.taxels.copy()
        at = int(np.argmax(taxels[1] > 0.5 * taxels[1].max()) + 0.7 * RATE)
        taxels[1, at:] += jump * 0.995 ** np.arange(t.size - at)
        return replace(sound, taxels=taxels)

    outcome = diagnose([jumping(seed, 0.0), jumping(seed + 1, 0.5)], [jumping(seed + 2, 0.0)])
    assert outcome.findings["findings"] == []


COARSE = 20e-6  # m, of the encoder


def steps(seed: int, deep: float, k: tuple[float, float], b: tuple[float, float]) -> Recording:
    """Steps of depth between air and one depth, read coarsely: at rest the stage trembles across the edge of a step."""
    rng = np.random.default_rng([seed, 3])
    until = np.cumsum(np.column_stack([rng.uniform(0.9, 1.6, 9), np.full(9, 0.12), rng.uniform(0.9, 1.6, 9), np.full(9, 0.12)]).ravel())
    t = np.arange(0.0, until[-1], 1.0 / RATE)
    x = np.interp(t, np.concatenate([[0.0], until]), np.concatenate([[-1e-5], np.tile([-1e-5, deep, deep, -1e-5], 9)]))
    x = x + noise(rng, t.size, 1e-6, 0.9)
    v = np.gradient(x, t)
    sensed, dispersed = ((x > 0.0) * np.maximum(k_i * x + b_i * v, 0.0) for k_i, b_i in zip(k, b, strict=True))
    force, taxel = sensed + dispersed + noise(rng, t.size, 0.1, 0.97), sensed + noise(rng, t.size, 0.1, 0.97)
    declared = Declared(encoder_step_um=1e6 * COARSE, force_step_n=0.07, taxel_step_n=(0.05,))
    grid = [np.round(y / step) * step for y, step in ((x, COARSE), (force, 0.07), (taxel, 0.05))]
    return Recording(f"steps_{seed}", t, grid[0], grid[1], grid[2][None], declared=declared)


@pytest.mark.parametrize("seed", rows([112, 120, 136, *range(140, 168, 4)], 2))
def test_what_an_encoder_cannot_read_of_a_stage_at_rest_is_nothing_wrong(seed):
    """Play swallows the steps to and fro that a coarse encoder reads at rest, and so does a curvature the error at each depth."""
    skin = {"deep": 0.27e-3 + 1e-6 * (seed % 7), "k": (26.5e3, 1.8e3), "b": (1357.0, 737.0)}
    outcome = diagnose([steps(seed, **skin), steps(seed + 1, **skin)], [steps(seed + 2, **skin)])
    assert outcome.findings["verdict"] == "nothing_wrong", outcome.findings["findings"]
    assert outcome.baseline.dispersion.b1 == pytest.approx(1357.0, rel=0.1)


def apart(seed: int, late: float, drift: float = 0.0) -> Recording:
    """A quiet record whose depth acts `late`, s; the load cell's zero creeps by `drift`, N. Forces are made at forty times the sampling
    rate."""
    t, x = presses(seed, 60.0)
    path, finely = CubicSpline(t, x), np.arange(0.0, t[-1], 1.0 / (40.0 * RATE))
    y, v = path(finely - late), path(finely - late, 1)
    sensed, dispersed = K1 * y + B1 * v, K2 * y + B2 * v
    touched = (y > 0.0) & (sensed + dispersed > 0.0)
    force, taxel = (np.interp(t, finely, touched * f) for f in (sensed + dispersed, sensed))
    rng = np.random.default_rng([seed, 6])
    force, taxel = (f + noise(rng, t.size, 0.004, 0.5) for f in (force + drift * -np.expm1(-t / 15.0), taxel))
    return Recording(f"session_{seed}", t, x, force, taxel[None], declared=Declared())


@pytest.mark.parametrize("late", rows([2.5e-4, -2.5e-4, 1e-4], 1))
def test_depth_and_forces_that_are_apart_as_good_hardware_is_are_no_finding(late):
    """Nor is anything else that looks like it. It is said where it matters, and taken into account."""
    findings = diagnose([apart(1, late), apart(2, late)], [apart(3, late)]).findings
    assert findings["findings"] == [] and findings["verdict"] == "nothing_wrong"
    said = [u["because"] for u in findings["untestable"] if u["cause"] == "time_shift" and "apart by" in u["because"]]
    times = [float(because.partition("apart by ")[2].partition(" ms")[0]) for because in said]
    assert times == [pytest.approx(1e3 * late, rel=0.2)] if abs(late) > 2e-4 else times == []


@pytest.mark.slow
def test_what_is_wrong_beside_that_delay_is_named():
    findings = diagnose([apart(seed, 2.5e-4, 0.03) for seed in (1, 2)], [apart(3, 2.5e-4, 0.03)]).findings
    assert [(f["cause"], f["where"]) for f in findings["findings"]] == [("drift", "load_cell")]


@pytest.mark.slow
def test_a_delay_beyond_that_is_named():
    (found,) = diagnose([apart(1, 2e-3), apart(2, 2e-3)], [apart(3, 2e-3)]).findings["findings"]
    assert "time_shift" in {found["cause"], *(a["cause"] for a in found["alternatives"])}
