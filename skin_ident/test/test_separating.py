"""The separating experiment tells rivals apart: computed from recordings that cannot, recorded, and criticised."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
import yaml
from rows import rows

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.many import renamed
from skin_ident.criticism.search.growing import grow
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.search.rivals import REACH, Rival
from skin_ident.criticism.search.survey import survey
from skin_ident.criticism.sessions.cutoff import Common
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.vocabulary import BY_NAME
from skin_ident.hiding.simulated_rig import SimulatedRig, varied
from skin_ident.recordings.mass import known_mass
from skin_ident.recordings.recording import Recording
from skin_ident.separating.by_hand import MORE_THAN_A_MOTION, shown_by_hand
from skin_ident.separating.candidates import candidates
from skin_ident.separating.choose import Experiment, _Option, _text, as_criticised, separating_experiment
from skin_ident.separating.contest import Contest, rehearsed
from skin_ident.separating.unrecorded import holds, unrecorded
from skin_models.catalogue import effect_class
from skin_models.materials import material
from skin_models.model import Model
from skin_models.signals import motion
from skin_motion_profiles.picture import motions_of
from skin_motion_profiles.profile_file import entry_from_text, entry_from_words

AIR = "{type: free_air, duration_s: 1}"
TRIANGLES = f"{{type: battery, profiles: [{AIR}, {{type: constant_rate_loops, depths_mm: 1, speeds_mm_s: 1, cycles: 5}}, {AIR}]}}"
SINE = "{type: sine, amplitude_mm: 0.2, offset_mm: 0.6, frequency_hz: 0.5, periods: 6}"
RAMPS = "{type: random_ramps, seed: 1, shallowest_mm: 0.3, deepest_mm: 0.9, count: 14, slowest_mm_s: 0.3, fastest_mm_s: 2}"


@dataclass(frozen=True)
class Pair:
    """Two rivals at their places, with what to hide of each, and a battery that cannot tell them apart (from second `begins` on)."""

    rivals: dict
    battery: str
    begins: float


PAIRS = {
    "memory": Pair({("hysteresis", "skin"): {"threshold": 4e-4}, ("stress_relaxation", "skin"): {}}, TRIANGLES, 0.0),
    "zero": Pair({("force_offset", "load_cell"): {"offset": 0.1}, ("position_offset", "rig"): {"offset": 1.5e-5}}, RAMPS, 2.0),
    "delay": Pair({("lag", "load_cell"): {}, ("time_shift", "clock"): {}}, SINE, 2.0),
}
CASES = [(name, truth) for name, pair in PAIRS.items() for truth in pair.rivals]


def specimen(pair: Pair, truth, seed: int) -> Model:
    cause, where = truth
    return varied(material("silicone_4mm").model, seed).extended(effect_class(cause, where).typical(where, **pair.rivals[truth]))


def recorded(model: Model, battery, seeds, begins: float = 0.0) -> list:
    rig = SimulatedRig()
    whole = [rig.record(model, battery, seed) for seed in seeds]
    return [r.part(int(begins * rig.rate), len(r)) for r in whole]


def experiment(pair: Pair, recordings: list) -> Experiment:
    """What the criticism would compute if it had found the recordings unable to tell the pair apart."""
    sessions = [prepare(r) for r in recordings]
    which = directions(sessions[0])
    start = dispersion_start(sessions, known_mass(recordings[0].declared).kg)
    first = survey(start, sessions, which)
    before = fit(start, sessions, first.noise)
    ranked = {(r.cause, r.where): r for r in survey(before.model, sessions, which, first.noise).ranked}
    models = {rival: grow(before, ranked[rival], sessions, which, first.noise)[0].model for rival in pair.rivals}
    (one, other), gain = pair.rivals, Gain("force", ("force",), 1.0, 1.0, (0.0, 0.0), 0.0, 0.0, "")
    named = Named(*one, gain, 0.0, (Rival(*other, 0.0, models[other]),), before.model, models[one])
    return separating_experiment(named, sessions, first.noise, directions(sessions[0]))


def names_left(pair: Pair, truth, seed: int) -> tuple[Experiment, set]:
    """The experiment, and which of the pair are still named once it is recorded; both, where nothing helps and so nothing is recorded."""
    model = specimen(pair, truth, seed)
    poor = recorded(model, entry_from_text(pair.battery), [100 * seed, 100 * seed + 1], pair.begins)
    found = experiment(pair, poor)
    if not found.helps:
        return found, set(pair.rivals)
    rich = recorded(model, entry_from_text(found.text), [100 * seed + i for i in (2, 3)])
    sessions = [replace(r, name=str(i)) for i, r in enumerate((poor[0], rich[0], poor[1], rich[1]))]
    findings = diagnose(sessions[:2], sessions[2:]).findings["findings"]
    said = {(e["cause"], e["where"]) for f in findings for e in (f, *f["alternatives"])}
    return found, said & set(pair.rivals)


@pytest.mark.parametrize(("name", "truth"), rows(CASES, 0), ids=lambda x: x if isinstance(x, str) else x[0])
def test_recording_it_leaves_the_truth_alone(name, truth):
    found, left = names_left(PAIRS[name], truth, seed=1)
    assert truth in left, found.sentence("separating.yaml")
    assert left == {truth} or not found.decides, found.sentence("separating.yaml")
    assert found.evidence > found.recorded


@pytest.mark.campaign
def test_campaign_of_seeds(capsys):
    results = [(*names_left(PAIRS[name], truth, seed), truth) for name, truth in CASES for seed in range(2, 7)]
    alone, sure = [left == {truth} for _, left, truth in results], [found.helps and found.decides for found, _, _ in results]
    with capsys.disabled():
        print(f"\none name left, the right one: {sum(alone)} of {len(alone)}; where expected: {sum(map(min, alone, sure))} of {sum(sure)}")
    assert np.mean(alone) > 0.7


def test_candidates_stay_within_depth_and_rig():
    found = candidates(0.6e-3, 0.01)
    assert len(found) > 25 and len({c.name for c in found}) == len(found)
    for c in found:
        assert c.motion.x.max() < 0.602e-3 and np.abs(c.motion.v).max() < 20.1e-3


@pytest.mark.parametrize("spread", [None, np.array([0.8])])
def test_a_motion_is_rehearsed_with_the_taxels_and_the_mass_of_the_record(spread):
    """Where sessions press at several places, each has shares of its own, which are fitted to what it reads."""
    t = np.arange(2000) / 100.0
    x = 5e-4 * (1.0 - np.cos(0.9 * t))
    model = material("silicone_4mm").model
    truth = model.simulate(motion(t, x))
    session = replace(prepare(Recording("made", t, x, truth.force, truth.taxels)), spread=spread, heaviest=1e-3)
    again = rehearsed(motion(t, x), session, model)
    assert again.heaviest == session.heaviest
    assert simulated(model, again)[1:] == pytest.approx((1.0 if spread is None else 0.8) * truth.taxels, abs=1e-9)


def test_a_motion_is_rehearsed_in_the_band_in_which_it_will_be_compared():
    """Taxels that are read every 50 ms narrow the band of records with ten times as many rows."""
    (recording,) = recorded(material("silicone_4mm").model, entry_from_text(SINE), [1])
    session = prepare(recording, common=Common(slowest=0.05))
    motion = candidates(1e-3, recording.dt)[0].motion
    band = rehearsed(motion, session, dispersion_start([session])).band
    assert band.edge == session.band.edge == pytest.approx(4.0)
    assert band.spacing == pytest.approx(session.band.spacing)


def test_the_battery_is_one_that_the_server_reads(tmp_path):
    pair = PAIRS["delay"]
    model = specimen(pair, ("lag", "load_cell"), 1)
    found = experiment(pair, recorded(model, entry_from_text(pair.battery), [1], pair.begins))
    (tmp_path / "separating.yaml").write_text(found.text)
    battery = entry_from_words(str(tmp_path / "separating.yaml"))
    assert battery.kind == "battery" and battery.about == found.name
    assert found.seconds == pytest.approx(sum(m.trajectory.duration for m in motions_of(battery, 0.0)))  # as `plot` shows
    sentence = found.sentence("separating.yaml")
    assert sentence.startswith("record separating.yaml (") and "tell lag from time shift" in sentence and "e+" not in sentence


def test_of_two_motions_in_one_session_the_second_needs_no_wait_of_its_own():
    stair, ramps = (next(k for k in candidates(1e-3, 0.01) if word in k.name) for word in ("stair", "random ramps"))
    content = yaml.safe_load(_text(_Option((stair, ramps, ramps), None)))
    kinds = [p["type"] for p in content["profiles"]]
    assert kinds == ["free_air", "ramp_list", "free_air", "random_ramps", "free_air", "random_ramps", "free_air"]
    assert content["about"] == "a stair of holds down and up and random ramps at 2 mm/s at most, 2 times"


def test_what_an_experiment_decides_is_said_in_words_and_its_numbers_are_for_programs():
    found = Experiment("sine", "", 20.0, 4.09e3, 0.15, ("lag", "time shift"), (), ("drift in taxel 1",))
    assert found.sentence("a.yaml") == (
        "record a.yaml (sine; 20 s): it would clearly tell lag from time shift, which what was recorded cannot; "
        "it says nothing of drift in taxel 1"
    )
    assert found.numbers == {"expected": 4.09e3, "recorded": 0.15}
    unsure = replace(found, together=(("lag", "time shift"),), unasked=()).sentence("a.yaml")
    assert "does most to tell lag from time shift, though it may leave lag with time shift" in unsure
    several = replace(found, rivals=("a", "b", "c"), together=(("a", "b"), ("a", "c")), unasked=())
    assert several.sentence("a.yaml").endswith("it would clearly tell b from c; it may not tell a from b or c")
    none = replace(several, hopeless=True).sentence("a.yaml")
    assert none.endswith("it would clearly tell b from c; no motion that was tried in simulation tells a from b or c")
    nearer = replace(several, known=(("b", "c"),)).sentence("a.yaml")  # no merit of the experiment
    assert nearer.endswith("it does most to tell a, b and c apart, though it may leave a with b and a with c")
    four = replace(several, rivals=tuple("abcd"), together=(("a", "b"), ("c", "d"))).sentence("a.yaml")
    assert four.endswith("tell a from c, and a from d, and b from c, and b from d; it may not tell a from b, or c from d")
    assert renamed(found.sentence("a.yaml"), [4, 7]).endswith("drift in taxel 7")


def test_a_motion_that_was_recorded_is_not_proposed_again():
    every = {k.name: k for k in candidates(1e-3, 0.01)}
    (stair, *_), (ramps, *_) = ([k for name, k in every.items() if begins in name] for begins in ("triangles to 1 mm at 3", "random ramps"))
    model = material("silicone_4mm").model
    sessions = [prepare(SimulatedRig().record(model, entry_from_text(k.text), i)) for i, k in enumerate((stair, ramps))]
    left = {k.name: k for k in unrecorded(1e-3, 0.01, sessions)}
    assert set(every) - set(left) == {stair.name}
    assert [name for name, k in left.items() if k.text != every[name].text] == [ramps.name] and "seed: 1" in left[ramps.name].text
    assert not holds(sessions[0].motion, ramps.motion) and holds(sessions[1].motion, ramps.motion)


def test_what_the_criticism_left_together_is_not_counted_as_told_apart():
    gain = Gain("force", ("force",), 1.0, 1.0, (0.0, 0.0), 0.0, 0.0, "")
    model = material("silicone_4mm").model
    named = Named("lag", "load_cell", gain, 1000.0, (Rival("stress_relaxation", "skin", 20.0, model),), model, model)
    seen = as_criticised(Contest(np.array([[0.0, 7e4], [6e4, 0.0]]), np.array([5e4, 4e4])), named)
    assert np.allclose(seen.distance, [[0.0, 1e3], [8e2, 0.0]]) and seen.margin(100.0, REACH)[0, 1] < 1.0


def test_where_no_motion_helps_none_is_proposed():
    none = Experiment("", "", 0.0, 2.0, 1.0, ("lag", "time shift"), (("lag", "time shift"),), apart=False)
    assert none.sentence("") == "no motion that was tried in simulation tells them apart clearly better than what was recorded"
    assert "another skin" in replace(none, apart=True).sentence("")


def test_for_what_no_motion_tells_apart_the_test_is_said_that_is_more_than_a_motion():
    causes = ("nonlinear_stiffness", "mount_compliance", "hysteresis", "mount_compliance")
    (test,) = shown_by_hand(causes)
    assert test.startswith("a press on a rigid target")
    left = Experiment("sine", "", 20.0, 4e3, 0.1, ("a", "b", "c"), (("a", "b"),), hopeless=True, by_hand=(test,))
    said = left.sentence("a.yaml")
    assert said.endswith(f"no motion that was tried in simulation tells a from b; what would tell them apart: {test}")
    assert replace(left, name="").sentence("").endswith(f"what was recorded; what would tell them apart: {test}")
    assert set(MORE_THAN_A_MOTION) <= set(BY_NAME)
