"""Causes that are one and the same signal in these data are named together."""

from dataclasses import replace

import numpy as np
import pytest
from rows import rows
from scipy.integrate import solve_ivp

from skin_ident.criticism.baseline.fitting import Fit
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.search.by_nature import late_one_way, likelier_place, same_by_nature
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.search.ranking import Ranked
from skin_ident.criticism.search.survey import survey
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.sessions.one_rate import at_one_rate
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.effect import Effect
from skin_models.effects.hysteresis import LaggingHysteresis, SensorHysteresis
from skin_models.effects.nonlinear_stiffness import Densification
from skin_models.effects.position_offset import PositionOffset
from skin_models.effects.saturation import Saturation
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.model import Model

RATE = 100.0
K, B, SHARE = 12_000.0, 1_400.0, 0.7  # N/m, N s/m, and what a taxel has of the force


def through(corners: list[float], times: list[float]) -> tuple[np.ndarray, np.ndarray]:
    t = np.arange(0.0, times[-1], 1.0 / RATE)
    soft = np.hanning(9)
    return t, np.convolve(np.pad(np.interp(t, times, corners), 4, mode="edge"), soft / soft.sum(), "valid")


def triangles(speeds: list[float], hold: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    corners, times = [-1e-4, -1e-4], [0.0, 2.0]
    for i, v in enumerate(speeds):
        deep = (0.4e-3, 0.7e-3, 1e-3)[i % 3]
        corners += [deep, deep, -1e-4]
        times += [times[-1] + (deep + 1e-4) / v, times[-1] + (deep + 1e-4) / v + hold, times[-1] + 2 * (deep + 1e-4) / v + hold]
    return through(corners, times)


def recorded(
    name: str, t: np.ndarray, x: np.ndarray, tip: np.ndarray, arm: float = 0.0, tau: float = 1.0, noise: float = 0.02
) -> Recording:
    """Skin pressed to `tip` below the surface, with a Maxwell arm that is `arm` times as stiff; sampled with white noise."""
    rng = np.random.default_rng(ord(name[-1]))
    y = np.maximum(tip, 0.0)
    stretch = np.zeros(t.size)
    for n in range(1, t.size):
        stretch[n] = np.exp(-1.0 / (RATE * tau)) * (stretch[n - 1] + y[n] - y[n - 1])
    total = np.maximum((K * y + B * np.gradient(y, t) + arm * K * stretch) * (y > 0.0), 0.0)
    taxel = SHARE * total
    return Recording(name, t, x, total + noise * rng.standard_normal(t.size), (taxel + noise * rng.standard_normal(t.size))[None])


def behind_a_mount(t: np.ndarray, x: np.ndarray, compliance: float, settling: float) -> np.ndarray:
    """Depth of the tip behind a spring and a dashpot in parallel that carry the skin's force; settling is theirs, s."""
    k, c = 1.0 / compliance, settling / compliance
    speed = np.gradient(x, t)

    def rate(time, tip):
        at, v = np.interp(time, t, x), np.interp(time, t, speed)
        touched = tip[0] > 0.0
        return [(k * (at - tip[0]) + c * v - touched * K * tip[0]) / (c + touched * B)]

    return solve_ivp(rate, (t[0], t[-1]), [x[0]], t_eval=t, max_step=0.01, rtol=1e-6, atol=1e-9).y[0]


@pytest.mark.parametrize(("speeds", "hold", "one"), [([2e-4] * 6, 0.0, True), ([2e-4, 1e-3] * 3, 0.0, False), ([2e-4] * 6, 2.0, False)])
def test_a_record_at_one_rate_is_known(speeds, hold, one):
    t, x = triangles(speeds, hold)
    assert at_one_rate([prepare(recorded("a", t, x, x))]) is one


@pytest.mark.parametrize("tau", rows([0.5, 2.0], 0))
def test_at_one_rate_relaxation_is_hysteresis_as_well(tau):
    t, x = triangles([2e-4] * 9)
    recordings = [recorded(f"session_{i}", t, x, x, arm=0.15, tau=tau) for i in range(3)]
    (found,) = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    names = {(found["cause"], found["where"]), *((a["cause"], a["where"]) for a in found["alternatives"])}
    assert {("stress_relaxation", "skin"), ("hysteresis", "skin")} <= names


@pytest.mark.slow
def test_skin_with_a_fast_arm_and_a_mount_that_yields_are_named_together():
    recordings = []
    for i in range(3):
        t, x = triangles(list(np.random.default_rng(i).permutation([1e-4, 3e-4, 6e-4, 1e-3, 2e-3, 3e-3, 4e-3, 6e-3, 8e-3])), 1.0)
        recordings.append(recorded(f"session_{i}", t, x, behind_a_mount(t, x, 8e-6, 0.06), noise=0.01))
    (found,) = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    names = {(found["cause"], found["where"]), *((a["cause"], a["where"]) for a in found["alternatives"])}
    assert ("mount_compliance", "rig") in names, names


def tried(effect: Effect, score: float, std: float = 1.0) -> Trial:
    """A trial of one effect, its amplitudes known to a standard error `std`."""
    model = Model(Dispersion(m=0.0, b1=900.0, k1=9000.0, b2=600.0, k2=3000.0), shares=(SHARE,), effects=(effect,))
    errors = {model.listed_as(0, name): std for name in ("k_sensed", "k_dispersed")}
    ranked = Ranked(effect.cause, effect.where, score, score, (), np.zeros(0), None, 0.0, 0.0)
    return Trial(ranked, Fit(model, (), errors, 0.0, 1), score)


@pytest.mark.parametrize(
    ("sensed", "std", "load_cell", "first"),
    [(0.0, 1.0, 85.0, "load_cell"), (0.0, 1.0, 70.0, None), (0.0, 20.0, 85.0, None), (30.0, 1.0, 85.0, None)],
    ids=["no taxel feels it", "the load cell explains too little", "taxels cannot tell", "taxels feel it"],
)
def test_a_loop_that_no_taxel_feels_is_of_the_load_cell(sensed: float, std: float, load_cell: float, first: str | None):
    skin = tried(LaggingHysteresis("skin", k_sensed=sensed, k_dispersed=100.0), 100.0, std)
    sensor = tried(SensorHysteresis("load_cell", relative=0.01), load_cell)
    assert likelier_place([skin, sensor]) == ([sensor] if first else [])


@pytest.mark.parametrize(
    ("sensed", "std", "load_cell", "first"),
    [(0.0, 1.0, 92.0, True), (0.0, 1.0, 80.0, False), (0.0, 20.0, 92.0, False), (30.0, 1.0, 92.0, False)],
    ids=["no taxel feels it", "the load cell explains too little", "taxels cannot tell", "taxels feel it"],
)
def test_skin_that_softens_beside_its_taxels_is_a_ceiling_of_the_load_cell(sensed: float, std: float, load_cell: float, first: bool):
    skin = tried(Densification("skin", k_sensed=sensed, k_dispersed=-100.0, onset=2e-3), 100.0, std)
    sensor = tried(Saturation("load_cell", level=3.0), load_cell)
    assert likelier_place([skin, sensor]) == [sensor] * first


@pytest.mark.parametrize(
    ("onset", "zero", "first"),
    [(2e-5, 96.0, True), (2e-5, 80.0, False), (2e-4, 96.0, False)],
    ids=["at the surface", "a zero explains too little", "well below"],
)
def test_skin_that_has_stiffened_at_its_surface_is_a_zero_of_depth(onset: float, zero: float, first: bool):
    skin = tried(Densification("skin", k_sensed=-900.0, k_dispersed=-300.0, onset=onset), 100.0)
    offset = tried(PositionOffset("rig", offset=5e-6), zero)
    assert likelier_place([skin, offset]) == [offset] * first


@pytest.mark.parametrize(("form", "sensor"), [(LaggingHysteresis, ("hysteresis", "load_cell")), (StressRelaxation, ("drift", "load_cell"))])
@pytest.mark.parametrize(("sensed", "channels", "same"), [(5.0, "both", True), (30.0, "both", False), (5.0, "taxel", False)])
def test_memory_that_the_load_cell_alone_tells_may_be_its_own(form, sensor, sensed, channels, same):
    t, x = triangles([2e-4, 1e-3] * 3)  # not at one speed, where memory of time and of the path are the same
    r = recorded("a", t, x, x)
    session = prepare(r if channels == "both" else replace(r, force=None))
    skin = tried(form("skin", k_sensed=sensed, k_dispersed=100.0), 100.0)
    assert [rival.key for rival in same_by_nature(skin, [], set(), [session])] == [sensor] * same


@pytest.mark.parametrize(
    ("sensed", "dispersed", "late"), [(0.01, 1.0, ["load_cell"]), (-0.5, 0.5, ["taxel"]), (0.5, 0.5, []), (1.0, 0.0, [])]
)
def test_damping_of_one_way_that_one_kind_of_sensor_feels_may_be_its_lag(sensed, dispersed, late):
    """What the load cell alone feels is dispersed; what taxels alone feel is taken from there."""
    assert list(late_one_way(sensed, dispersed)) == [("lag", where) for where in late]


def test_a_tone_is_looked_for_at_full_rate_alone():
    """An alias of 50 Hz at 100 Hz is a constant here: it must not pass for an offset."""
    t, x = triangles([2e-4] * 3)
    s = prepare(recorded("a", t, x, x))
    start = dispersion_start([s])
    assert all(r.cause != "interference" for r in survey(start, [s], directions(s)).ranked)
