"""What telemetry finds is in the extended model, bends the search no more, and says what it had been hiding in."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.record import inspect
from skin_ident.criticism.telemetry.faults import effect_of
from skin_ident.criticism.telemetry.quantization import find_quantization
from skin_ident.criticism.telemetry.symptom import Symptom, quantity
from skin_ident.criticism.telling.alike import in_all_taxels, one_each
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.digits import digits_at
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.model_file import load_model, save_model
from skin_models.signals import motion

SKIN = Model(Dispersion(m=0.000432, b1=939.5, k1=9619.0, b2=629.2, k2=2766.0), shares=(1.0, 0.4, 0.2))
T = np.arange(4000) / 100.0
NOISE = 0.03


def session(seed, change=lambda taxels, rng: taxels, declared=None, noise=NOISE):
    rng = np.random.default_rng(seed)
    depth = np.convolve(np.interp(T, np.linspace(0, T[-1], 90), np.repeat(rng.uniform(0.1e-3, 0.9e-3, 45), 2)), np.hanning(41) / 20, "same")
    out = SKIN.simulate(motion(T, depth))
    force, taxels = (y + noise * rng.standard_normal(y.shape) for y in (out.force, out.taxels))
    return Recording(f"session_{seed}", T, depth, force, change(taxels, rng), declared=declared or Declared())


def diagnosed(change, **more):
    recordings = [session(i, change, **more) for i in range(3)]
    return diagnose(recordings[:2], recordings[2:])


def entries(outcome):
    return [(f["cause"], f["where"]) for f in outcome.findings["findings"]]


def test_a_silent_taxel_bends_nothing_and_is_simulated_silent():
    outcome = diagnosed(lambda y, rng: np.vstack([y[0], np.full(y.shape[1], 2.5), y[2]]))
    finding = outcome.findings["findings"][0]
    assert entries(outcome) == [("dead_taxel", "taxel_1")] and outcome.findings["verdict"] == "explained"
    assert finding["gain"]["held_out_rmse_after"] < 1e-9 < 1.0 < finding["gain"]["held_out_rmse_before"]
    extended = outcome.findings["extended"]["parameters"]
    assert extended["k1"]["value"] == pytest.approx(9619.0, rel=0.01)
    assert np.allclose(outcome.model.simulate(motion(T, 1e-4 * np.ones(T.size))).taxels[1], 2.5)


@pytest.mark.filterwarnings("error")
def test_of_a_last_session_whose_only_channel_is_dead_nothing_is_asked():
    def one_taxel(r, times):
        return replace(r, force=None, taxels=times * r.taxels[:1], taxel_names=("taxel_0",), taxel_units=("N",))

    outcome = diagnose([one_taxel(session(i), times) for i, times in enumerate((1.0, 1.0, 0.0))])
    assert entries(outcome) == [("dead_taxel", "taxel")] and outcome.findings["verdict"] == "explained"


def test_a_clipped_taxel_is_cut_and_what_the_baseline_hid_it_in_is_said(tmp_path):
    outcome = diagnosed(lambda y, rng: np.minimum(y, np.array([[5.0], [9.0], [9.0]])))
    assert entries(outcome) == [("saturation", "taxel_0")]
    finding, worth = outcome.findings["findings"][0], outcome.findings["gain_by_channel"]["taxel_0"]
    assert finding["hid_in"]["k1"]["before"] < 0.97 * 9619.0 and finding["hid_in"]["k1"]["after"] == pytest.approx(9619.0, rel=0.01)
    assert worth["held_out_rmse_after"] < 1.2 * worth["noise_floor"] and worth["ci95"][0] > 0.0
    save_model(outcome.model, tmp_path / "model.yaml", outcome.std)
    assert load_model(tmp_path / "model.yaml").simulate(motion(T, 8e-4 * np.ones(T.size))).taxels[0].max() == pytest.approx(5.0, abs=0.05)


def test_what_comes_at_random_is_simulated_and_claims_no_gain():
    def spoil(y, rng):
        y = y + 0.3 * np.sin(2 * np.pi * 31.0 * T + rng.uniform(0, 6)) * np.array([[0.0], [1.0], [0.0]])
        y[0] += 3.0 * rng.standard_normal(T.size) * (rng.random(T.size) < 0.006)
        return y

    outcome = diagnosed(spoil)
    assert set(entries(outcome)) == {("interference", "taxel_1"), ("outliers", "taxel_0")}
    for f in outcome.findings["findings"]:
        assert f["gain"]["ci95"] is None and f["evidence"]["in_model"] and f["evidence"]["predicts_nothing_for"]
    one = outcome.model.simulate(motion(T, np.full(T.size, 4e-4)), seed=1).taxels
    assert np.std(one[1]) == pytest.approx(0.3 / np.sqrt(2), rel=0.15) and np.abs(one[0] - np.median(one[0])).max() > 1.0


@pytest.mark.parametrize("drops_to_nothing", [True, False])
def test_few_drops_stand_out_of_heavy_tails_where_all_end_at_one_reading(drops_to_nothing):
    """Three a session, none farther than noise of three degrees of freedom goes in ten: of the same size but in all directions they are
    taken for it."""

    def change(y, rng):
        y = y + 0.15 * rng.standard_t(3, y.shape)
        for at in 500 + 900 * np.arange(3) + rng.integers(300, size=3):
            size = 0.0 if drops_to_nothing else y[0, at] + rng.choice([-1, 1]) * rng.uniform(2.5, 6.0)
            y[0, at : at + 2] = size
        return 0.05 * np.round(y / 0.05)

    found = [s for s in inspect([session(i, change) for i in range(3)]).symptoms if s.cause == "outliers"]
    assert [s.channels for s in found] == [("taxel_0",)] * drops_to_nothing
    if found:
        assert found[0].evidence["count"] == pytest.approx(18, abs=3)


def test_noise_that_is_not_as_declared_is_told_in_newtons_and_simulated():
    outcome = diagnosed(lambda y, rng: y, declared=Declared(force_noise_n=0.01))
    finding = outcome.findings["findings"][0]
    assert entries(outcome) == [("noise", "load_cell")] and "times what is expected" in finding["evidence"]["why"]
    assert finding["parameters"]["times_expected"]["value"] == pytest.approx(3.0, rel=0.15)  # what all channels share is the encoder's
    noisy = outcome.model.simulate(motion(T, np.full(T.size, 4e-4)), seed=1).force
    assert np.std(noisy) == pytest.approx(NOISE, rel=0.15)


def test_one_taxel_with_steps_unlike_the_others_needs_no_declaration():
    steps = np.array([[0.05], [0.2], [0.06]])
    made = [session(i, lambda y, rng: steps * np.round(y / steps)) for i in range(2)]
    (found,) = find_quantization(made)
    assert (found.where, found.parameters["step"]["value"]) == ("taxel_1", pytest.approx(0.2))
    assert "the other taxels" in found.evidence["why"]
    two = [replace(r, taxels=r.taxels[:2], taxel_names=(), taxel_units=()) for r in made]
    assert not find_quantization(two)


def test_a_taxel_of_a_wider_range_has_larger_steps_and_as_much_more_noise():
    def wider(y, rng):
        wide = y[0] + 0.3 * rng.standard_normal(y.shape[1])
        return np.array([0.1 * np.round(wide / 0.1), *(0.01 * np.round(row / 0.01) for row in y[1:])])

    assert not [s for s in inspect([session(i, wider) for i in range(3)]).symptoms if s.cause == "quantization"]


@pytest.mark.parametrize(("times", "told"), [(1.4, True), (1.1, False)])
def test_levels_a_third_further_apart_than_declared_are_seen(times, told):
    made = [
        session(i, lambda y, rng: times * 0.05 * np.round(y / (times * 0.05)), declared=Declared(taxel_step_n=(0.05,))) for i in range(2)
    ]
    found = find_quantization(made)
    assert {s.where for s in found} == ({"taxel_0", "taxel_1", "taxel_2"} if told else set())
    assert all("1.4 times as far apart as rig.yaml declares" in s.evidence["why"] for s in found)


def companded(y, rng):
    """Steps that grow with the reading, from 0.04 to 0.2 N."""
    edges = np.cumsum(np.linspace(0.04, 0.2, 120))
    return edges[np.searchsorted(edges, np.clip(y + 1.0, 0.0, edges[-2]))] - 1.0


def rounded_unevenly(y, rng):
    """The same to the nearest."""
    levels = np.cumsum(np.linspace(0.04, 0.2, 120)) - 1.0
    return levels[np.searchsorted(0.5 * (levels[1:] + levels[:-1]), y)]


def with_missing_codes(y, rng):
    """Most codes never come, and what lies there goes to the next."""
    codes = np.cumsum(np.random.default_rng(7).integers(2, 6, 400)) * 0.02 - 1.0
    return codes[np.searchsorted(codes, y)]


@pytest.mark.parametrize("change", [companded, with_missing_codes])
def test_steps_of_a_converter_that_are_uneven_are_told_beside_what_is_declared(change):
    made = [session(i, lambda y, rng: 0.02 * np.round(change(y, rng) / 0.02), Declared(taxel_step_n=(0.02,))) for i in range(2)]
    found = find_quantization(made)
    assert {s.where for s in found} == {"taxel_0", "taxel_1", "taxel_2"}
    assert all("unevenly" in s.evidence["why"] for s in found)


def test_uneven_steps_are_told_though_stamps_tremble_and_nothing_else_is_made_of_them():
    """What was interpolated lies between the levels; the topmost of them is no ceiling, and steps that grow are no noise that does."""
    rng, made = np.random.default_rng(3), []
    for i in range(3):
        s = session(i, rounded_unevenly, Declared(taxel_step_n=(0.02,), taxel_noise_n=(0.02,)))
        t = s.t + rng.uniform(-0.2, 0.2, s.t.size) * s.dt
        taxels = np.array([np.interp(s.t, t, row) for row in s.taxels])
        digits = {f"taxel_{k}": digits_at(s.t, t, s.taxels)[k] for k in range(3)}
        made.append(replace(s, taxels=taxels, digits=digits))
    content = diagnose(made[:2], made[2:]).findings
    assert {f["cause"] for f in content["findings"]} == {"quantization"}


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.02, 0.06])
@pytest.mark.parametrize("depths", [5, 40])
def test_few_depths_and_a_converter_as_declared_have_no_uneven_steps(noise, depths):
    """Between the levels of a hold and those of the next there are many that nothing rests on."""
    made = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        held = 5.0 * rng.uniform(size=depths)[np.minimum(np.arange(4000) * depths // 4000, depths - 1)]
        y = 0.02 * np.round((np.vstack([held, 0.4 * held, 0.2 * held]) + noise * rng.standard_normal((3, 4000))) / 0.02)
        made.append(Recording(f"session_{seed}", T, 1e-4 * held, held, y, declared=Declared(taxel_step_n=(0.02,))))
    assert [s for r in made for s in find_quantization([r])] == []


def test_how_much_was_compared_is_said():
    content = diagnosed(lambda y, rng: y).findings
    assert content["verdict"] == "nothing_wrong"
    for r in content["recordings"]:
        assert r["compared"]["samples"] > 500 and r["compared"]["left_out"] >= 0


@pytest.mark.parametrize("symptom", [
    Symptom("outliers", "rig", ("depth",), {"rate": quantity(1, "1/s"), "size": quantity(1e-5, "m")}, {}),
    Symptom("data_error", "load_cell", ("force",), {}, {}),
    Symptom("quantization", "rig", ("depth",), {"step": quantity(1e-5, "m")}, {}),
])  # fmt: skip
def test_what_has_no_place_in_the_chain_has_no_effect(symptom):
    assert effect_of(symptom) is None


@pytest.mark.parametrize("level", [3.5, 6.0, 8.0])
def test_a_taxel_that_clips_is_named_once_and_wins_by_it(level):
    outcome = diagnosed(lambda y, rng: np.minimum(y, np.array([[level], [99.0], [99.0]])))
    (finding,) = outcome.findings["findings"]
    assert (finding["cause"], finding["where"]) == ("saturation", "taxel_0")
    assert finding["gain"]["held_out_rmse_after"] < 0.7 * finding["gain"]["held_out_rmse_before"]


def test_what_stays_at_its_greatest_reading_because_the_plunger_does_is_not_clipped():
    """Presses that all stop at one depth, read in steps much coarser than the noise."""
    depth = np.convolve(np.repeat(np.tile([0.1e-3, 0.8e-3], 20), T.size // 40), np.hanning(21) / 10.0, "same")
    step = 0.05
    recordings = []
    for i in range(2):
        out, rng = SKIN.simulate(motion(T, depth)), np.random.default_rng(i)
        force, taxels = (np.round((y + 0.1 * step * rng.standard_normal(y.shape)) / step) * step for y in (out.force, out.taxels))
        recordings.append(Recording(f"held_{i}", T, depth, force, taxels))
    assert not [s for s in inspect(recordings).symptoms if s.cause == "saturation"]


def test_a_plunger_that_the_skin_cannot_follow_is_refused_in_a_sentence():
    depths = [0.5e-3 + 0.3e-3 * np.sin(2.0 * np.pi * frequency * T) for frequency in (5.0, 5.2)]
    shaken = [(depth, SKIN.simulate(motion(T, depth))) for depth in depths]
    recordings = [Recording(f"shaken_{i}", T, depth, out.force, out.taxels) for i, (depth, out) in enumerate(shaken)]
    with pytest.raises(DiagnosisError, match="press more slowly"):
        diagnose(recordings[:1], recordings[1:])


@pytest.mark.parametrize(("tail", "told"), [("normal", True), ("t", False)])
def test_few_far_spikes_stand_out_of_noise_whose_tail_is_seen_to_be_short(tail, told):
    """One a session at twenty widths: more than a tail as steep as that of normal noise leaves there, no more than one that is heavy."""

    def change(y, rng):
        y = y + 0.02 * (rng.standard_normal(y.shape) if tail == "normal" else rng.standard_t(3, y.shape))
        y[0, rng.integers(500, 3500)] += rng.choice([-1, 1]) * 1.0
        return y

    found = [s for s in inspect([session(i, change) for i in range(3)]).symptoms if s.cause == "outliers"]
    assert [s.channels for s in found] == [("taxel_0",)] * told


@pytest.mark.parametrize("rho", [0.5, 0.85])
def test_noise_that_wanders_in_leaps_has_no_discharges(rho):
    """A leap of a heavy tail dies away as a discharge does; there are no more than that tail has, though it grows with the load."""

    def change(y, rng):
        leaps = lfilter([np.sqrt(1.0 - rho**2)], [1.0, -rho], rng.standard_t(3, y.shape))
        return y + 0.03 * (1.0 + 2.0 * y / y.max()) * leaps

    told = [s.cause for seed in range(10) for s in inspect([session(10 * seed + i, change) for i in range(3)]).symptoms]
    assert "outliers" not in told


def test_noise_that_is_read_in_steps_wider_than_itself_is_the_steps():
    """It comes through them now as nothing, now as a whole step, which neither grows with the load nor is too quiet."""
    declared = Declared(taxel_noise_n=(0.018,), taxel_step_n=(0.02,), force_noise_n=0.018)
    outcome = diagnosed(lambda y, rng: 0.065 * np.round(y / 0.065), declared=declared, noise=0.018)
    assert entries(outcome) == [("quantization", "taxel")]  # one converter reads them all


def test_what_some_taxels_have_or_each_in_another_way_is_told_of_each():
    def entry(i, hertz):
        evidence, gain = {"why": f"a line in taxel_{i}"}, {"held_out_rmse_before": None, "held_out_rmse_after": None}
        parameters = {"frequency": {"value": hertz, "unit": "Hz"}, "amplitude": {"value": 0.01 * (i + 1), "unit": "N"}}
        where = {"where": f"taxel_{i}", "channels": [f"taxel_{i}"]}
        return {"cause": "interference", **where, "parameters": parameters, "evidence": evidence, "gain": gain}

    alike, others = [entry(i, 13.7) for i in range(3)], [entry(i, 13.7 + i) for i in range(3)]
    assert in_all_taxels(alike, 4) == alike and in_all_taxels(others, 3) == others
    (one,) = in_all_taxels(alike, 3)
    alike[0]["parameters"]["in_bursts"] = {"value": 0.2, "unit": "N"}  # of one of them alone
    assert set(in_all_taxels(alike, 3)[0]["parameters"]) == {"frequency", "amplitude"}
    assert (one["where"], one["channels"]) == ("taxel", ["taxel_0", "taxel_1", "taxel_2"])
    assert one["parameters"]["amplitude"]["value"] == 0.02 and set(one["evidence"]["of_each_taxel"]) == set(one["channels"])


@pytest.mark.parametrize(("times", "together"), [((1.6, 1.4, 1.5), True), ((1.6, 3.0, 1.5), False)])
def test_taxels_that_are_about_as_loud_are_one_finding(times, together):
    gain = {"held_out_rmse_before": None, "held_out_rmse_after": None}
    loud = [
        {"cause": "noise", "where": f"taxel_{i}", "channels": [f"taxel_{i}"], "parameters": {"times_expected": {"value": n, "unit": "1"}},
         "evidence": {"why": "loud"}, "gain": gain}
        for i, n in enumerate(times)
    ]  # fmt: skip
    assert [e["where"] for e in in_all_taxels(loud, 3)] == (["taxel"] if together else ["taxel_0", "taxel_1", "taxel_2"])


def test_columns_that_are_exchanged_in_several_sessions_are_one_finding():
    def entry(session, channels=("taxel_0", "taxel_2")):
        pieces = [{"session": session, "start": 0.0, "seconds": 12.0}]
        evidence = {"why": "", "kind": "exchanged columns", "pieces": pieces}
        return {"cause": "data_error", "where": "taxel", "channels": list(channels), "parameters": {}, "evidence": evidence}

    days = [f"day{i}" for i in (1, 4, 9, 12)]
    both, other = one_each([entry("day9"), entry("day12"), entry("day4", ("taxel_0", "taxel_1"))], days)
    assert both["evidence"]["pattern"] == "from day9 on" and both["parameters"]["lasts"]["value"] == 24.0
    assert [p["session"] for p in both["evidence"]["pieces"]] == ["day9", "day12"] and "in day9 from 0.0 s" in both["evidence"]["why"]
    assert other["evidence"]["only_in"] == ["day4"] and other["evidence"]["not_in"] == ["day1", "day9", "day12"]
    assert "only_in" not in one_each([entry("day1")], ["day1"])[0]["evidence"]


def test_a_unit_that_its_steps_show_as_well_is_one_finding():
    def entry(kind, factor, why, **more):
        numbers = {"factor": {"value": factor, "unit": "1"}}
        return {"cause": "data_error", "channels": ["force"], "parameters": numbers, "evidence": {"why": why, "kind": kind, **more}}

    odd = entry("unit factor", 1 / 4.44822, "", session="b")
    steps = entry("unit change", 4.44822, "", session="b")
    assert [e["evidence"]["kind"] for e in one_each([odd, steps], ["a", "b"])] == ["unit factor"]
    later = entry("unit change", 4.44822, "")
    assert len(one_each([odd, later], ["a", "b"])) == len(one_each([odd, {**steps, "channels": ["taxel_0"]}], ["a", "b"])) == 2
