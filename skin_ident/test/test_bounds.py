"""What is said to be excluded holds: a true effect that another one hides, or has taken the place of, is never excluded below its size."""

from types import SimpleNamespace

import numpy as np
import pytest
from world import make_sessions, write_case
from world.hidden import Hide

from skin_ident.criticism.baseline.fitting import Fit
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.noise.whitening import white
from skin_ident.criticism.projection import basis
from skin_ident.criticism.search.bounds import HOLLOW, _imitated, excluded_and_untestable, raised
from skin_ident.criticism.search.named import NotNamed
from skin_ident.criticism.search.proposals import Direction
from skin_ident.criticism.search.ranking import project, rank
from skin_ident.criticism.search.survey import Survey
from skin_ident.criticism.telemetry.quantization import no_finer
from skin_ident.criticism.telling.findings import _not_findings
from skin_ident.criticism.vocabulary import BY_NAME
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.effects.backlash import Backlash
from skin_models.effects.dead_zone import GradualTaxel, TaxelDeadZone
from skin_models.effects.inertia import Inertia
from skin_models.effects.lag import Lag
from skin_models.model import Model

SKIN = Model(Dispersion(m=0.0, b1=900.0, k1=9000.0, b2=600.0, k2=3000.0))
SIZES = {"backlash": 1e-3, "inertia": 1.0}  # m, kg
GAP, MASS = Direction(Backlash("rig"), "gap", SIZES["backlash"], 1), Direction(Inertia("rig"), "mass", SIZES["inertia"], 1)
ROWS = 4000


def surveyed(alike: float, gap: float, mass: float, seed: int = 0) -> Survey:
    """A survey of two directions of correlation `alike`, of which the residual holds `gap` and `mass` sizes, in unit noise."""
    rng = np.random.default_rng(seed)
    a, b = rng.standard_normal((2, ROWS))
    A = np.column_stack([a, alike * a + np.sqrt(1.0 - alike**2) * b])
    p = project((GAP, MASS), A, np.empty((ROWS, 0)), A @ [gap, mass] + rng.standard_normal(ROWS))
    return Survey(SKIN, white([np.ones((1, ROWS))]), p, tuple(rank(p)))


def below(last: Survey, rounds: tuple[Survey, ...] = ()) -> dict[str, float]:
    entries, _ = excluded_and_untestable(last, list(rounds), set(), {}, {}, {})
    return {e["cause"]: e["below"] / SIZES[e["cause"]] for e in entries if e["below"] is not None}


@pytest.mark.parametrize("seed", range(5))
def test_two_effects_that_hide_each_other_are_not_excluded_below_their_size(seed):
    said = below(surveyed(-0.9, 1.0, 0.9, seed))
    assert 1.0 < said["backlash"] < 1.4 and 0.9 < said["inertia"] < 1.3
    assert below(surveyed(0.0, 0.0, 0.0, seed))["backlash"] < 0.1  # and where nothing is hidden, the bound is as near as noise lets it


def test_what_has_taken_the_place_of_a_cause_does_not_exclude_it():
    before, after = surveyed(0.95, 1.0, 0.0), surveyed(0.95, 0.0, 0.0)
    assert below(after)["backlash"] < 0.1
    assert below(after, (before,))["backlash"] > 0.9


def test_a_cause_is_not_excluded_below_what_its_fit_came_to():
    """As of a delay that damping makes up for: a linear view leaves nothing of it, and a fit beside everything else any amount."""
    fitted = SKIN.extended(Backlash("rig", gap=2.0 * SIZES["backlash"]))
    grown = {GAP.key: Fit(fitted, (), {fitted.listed_as(0, "gap"): 0.1 * SIZES["backlash"]}, 0.0, ROWS)}
    entries, _ = excluded_and_untestable(surveyed(0.0, 0.0, 0.0), [], set(), {}, {}, grown)
    said = {e["cause"]: e["below"] / SIZES[e["cause"]] for e in entries if e["below"] is not None}
    assert said["backlash"] == pytest.approx(2.196) and said["inertia"] < 0.1


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("left", [0.01, 0.9])
def test_a_delay_that_damping_makes_up_for_is_not_excluded_below_its_size(left, seed):
    """Of a delay z, damping leaves what grows with its square; at the probed amount that is the share `left` of all its energy."""
    rng, late = np.random.default_rng(seed), Direction(Lag("taxel"), "tau", 0.05, 1)
    damping, a = rng.standard_normal((2, ROWS))
    column, z = 20.0 * (np.sqrt(1.0 - left) * damping + np.sqrt(left) * a), 0.03
    felt = 20.0 * np.sqrt(left) * a * (z**2 / late.probe if left < 0.1 else z) + rng.standard_normal(ROWS)
    p = project((late,), column[:, None], damping[:, None] / np.linalg.norm(damping), felt)
    entries, _ = excluded_and_untestable(Survey(SKIN, white([np.ones((1, ROWS))]), p, tuple(rank(p))), [], set(), {}, {}, {})
    (tau,) = (e["below"] for e in entries if e["cause"] == "lag")
    assert z * late.size < tau < 3.0 * z * late.size


def test_more_than_there_can_be_of_a_cause_excludes_nothing():
    last = surveyed(0.0, 6.0, 0.0)  # a gap of 6 mm is more than any drive has
    assert "backlash" not in below(last) and "inertia" in below(last)
    _, untestable = excluded_and_untestable(last, [], set(), {}, {}, {})
    assert any(u["cause"] == "backlash" and u.get("where") == "rig" and u["because"] == HOLLOW for u in untestable)


def test_every_clock_is_a_clock_to_the_reader_and_none_is_in_doubt_that_is_named():
    doubts = {
        ("time_shift", place): NotNamed(1e-3, "half of the data speak for it", doubt=True) for place in ("clock_depth", "clock_taxels")
    }
    record = Recording("a", np.arange(500) / 100.0, None, np.zeros(500), np.zeros((0, 500)))
    c = SimpleNamespace(not_named=doubts, extended=SimpleNamespace(model=None))
    _, said = excluded_and_untestable(surveyed(0.0, 0.0, 0.0), [], set(), {}, _not_findings(c, [record], set()), {})
    clocks = [(u["where"], u["channel_clock"]) for u in said if u["cause"] == "time_shift"]
    assert clocks == [("clock", "depth"), ("clock", "taxels")]
    assert "time_shift" not in _not_findings(c, [record], {("time_shift", "clock")})


def test_what_a_converter_may_do_itself_is_not_called_tested(tmp_path):
    """A toe of half the noise and a fifth of a step: neither named, nor excluded below a size that it may have."""
    sessions, _ = make_sessions([Hide("nonlinear_stiffness", "skin", "fung", 0.5)], seed=1624127525, n_taxels=1, protocol="full")
    write_case(sessions, tmp_path)
    recordings = load(tmp_path)
    said = diagnose(recordings[:2], recordings[2:]).findings
    assert said["verdict"] == "nothing_wrong" and not said["findings"]
    entry = next(u for u in said["untestable"] if u["cause"] == "nonlinear_stiffness")
    assert entry["where"] == "skin" and "a converter with steps of" in entry["because"] and "finer steps" in entry["needs"]
    assert entry["hardware"] and "own_zero" not in entry
    assert not any(e["cause"] == "nonlinear_stiffness" for e in said["excluded"])


@pytest.mark.slow
def test_what_is_the_same_as_what_a_converter_may_do_is_left_open_too(tmp_path):
    """The skin swallows a little of what it hands on: so do its taxels, where there is one, and its converter may do as much."""
    sessions, _ = make_sessions([Hide("dead_zone", "skin", "gap", 0.5)], seed=907200330, n_taxels=1, protocol="full")
    write_case(sessions, tmp_path)
    recordings = load(tmp_path)
    findings = diagnose(recordings[:2], recordings[2:]).findings
    assert not findings["findings"]
    left = {u["where"]: u["because"] for u in findings["untestable"] if u["cause"] == "dead_zone"}
    assert set(left) == {"skin", "taxel"} and "a converter with steps of" in left["taxel"]
    assert left["skin"].startswith("it cannot be told from dead_zone in the taxel: it would explain")


def test_steps_are_excluded_from_where_their_levels_tell():
    t = np.arange(500) / 100.0
    declared = Declared(force_step_n=0.07, encoder_step_um=1.0)
    record = Recording("a", t, 1e-4 * t, np.round(t / 0.07) * 0.07, np.zeros((0, 500)), declared=declared)
    entries = [
        {"cause": c, "where": w, "below": 1e-7} for c, w in (("quantization", "load_cell"), ("quantization", "rig"), ("drift", "load_cell"))
    ]
    assert [e["below"] for e in no_finer(entries, [record])] == pytest.approx([1.25 * 0.07, 1.25e-6, 1e-7])


@pytest.mark.parametrize(("floor", "below", "least"), [(0.5, 9.0, 1.0), (2.0, 9.0, 2.0), (10.0, 10.0, None)])
def test_what_raises_a_bound_raises_the_smallest_one_too(floor, below, least):
    said = raised({"below": 9.0, "least": {"below": 1.0, "at": {}}}, floor)
    assert said["below"] == below and said.get("least", {}).get("below") == least


def test_every_form_that_the_model_imitates_is_left_open():
    """Two forms of a dead zone look like the model itself: both are said, not the last one alone."""
    forms = [Direction(e("taxel"), "threshold", 1.0, 1) for e in (TaxelDeadZone, GradualTaxel)]
    other = Direction(Backlash("rig"), "gap", SIZES["backlash"], 1)
    rng = np.random.default_rng(0)
    J, free = rng.standard_normal((2, ROWS, 1))
    p = project((*forms, other), np.hstack([J + 1e-4 * free, J - 1e-4 * free, free]), basis(J), rng.standard_normal(ROWS))
    said = _imitated(p, BY_NAME["dead_zone"], [{"where": "taxel"}])
    assert [entry["form"] for entry in said] == ["", "gradual"]


@pytest.mark.parametrize("seed", range(8))
def test_a_form_that_the_model_imitates_to_the_last_digit_is_left_open_too(seed):
    """Rounding decides whether nothing or next to nothing of it is left."""
    form, other = Direction(TaxelDeadZone("taxel"), "threshold", 1.0, 1), Direction(Backlash("rig"), "gap", SIZES["backlash"], 1)
    rng = np.random.default_rng(seed)
    J, free = rng.standard_normal((2, ROWS, 1))
    p = project((form, other), np.hstack([J, free]), basis(J), rng.standard_normal(ROWS))
    assert _imitated(p, BY_NAME["dead_zone"], [{"where": "taxel"}])
    silent = project((form, other), np.hstack([0.0 * J, free]), basis(J), rng.standard_normal(ROWS))
    assert not _imitated(silent, BY_NAME["dead_zone"], [{"where": "taxel"}])
