"""Taxels that answer nothing, always or on and off, are named where something promises them a reading, and not where they may lie apart."""

from dataclasses import replace

import array_making
import numpy as np
import pytest
from world import make_sessions, write_case

from skin_ident.criticism.array.layout import layout_of
from skin_ident.criticism.array.spreading import with_spread
from skin_ident.criticism.courses.kinds import courses
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.record import inspect
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.telemetry.dead import apart, find_dead_taxels
from skin_ident.criticism.telemetry.loose import contact_of
from skin_ident.criticism.telling.untold import beside_silence
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import Recording
from skin_ident.report.appendix import untestable_rows
from skin_ident.report.reading import view


def three(layout, taxels=3, seed=6):
    return make_sessions("null", seed=seed, n_sessions=2, n_taxels=taxels, layout=layout, noise="white")[0]


def spoilt(sessions, taxel, change, declared=True):
    """The same with one taxel changed by `change(y, rng)`, and its layout left out of what is declared."""
    rng, out = np.random.default_rng(5), []
    for s in sessions:
        taxels = s.taxels.copy()
        taxels[:, taxel] = change(taxels[:, taxel], rng)
        rig = s.rig if declared else {k: v for k, v in s.rig.items() if k != "taxel_positions_mm"}
        out.append(replace(s, taxels=taxels, rig=rig))
    return out


def named(folder, sessions):
    write_case(sessions, folder)
    return inspect(load(folder)).symptoms


def noisy(y, rng):
    return 0.05 * rng.standard_normal(y.size)


def test_an_open_taxel_that_may_lie_apart_is_not_ruled_out(tmp_path):
    """Of three in a row the last need not be reached; that it is not dead nobody can say either."""
    sessions = spoilt(three(None), 2, noisy, declared=False)
    assert not [s for s in named(tmp_path / "open", sessions) if s.cause == "dead_taxel"]
    assert apart(load(tmp_path / "open")) == ["taxel_2"]
    write_case(three(None), tmp_path / "sound")
    assert not apart(load(tmp_path / "sound"))
    findings = diagnose(load(tmp_path / "open")).findings
    assert [u["where"] for u in findings["untestable"] if u["cause"] == "dead_taxel"] == ["taxel_2"]
    assert "dead_taxel" not in {e["cause"] for e in findings["excluded"]}


@pytest.mark.parametrize(("rms", "open_"), [(1.0, False), (0.1, True)])
def test_a_taxel_that_lies_apart_has_its_noise_and_an_open_one_has_not(tmp_path, rms, open_):
    sound = three(None)
    level = float(np.std(np.diff(sound[0].taxels[:100], axis=0)) / np.sqrt(2.0))  # in the air
    quiet = spoilt(sound, 2, lambda y, rng: rms * level * rng.standard_normal(y.size), declared=False)
    made = [replace(s, rig={**s.rig, "taxel_noise_n": level}) for s in quiet]
    dead = [s for s in named(tmp_path, made) if s.cause == "dead_taxel"]
    assert [s.where for s in dead] == ["taxel_2"] * open_ and apart(load(tmp_path)) == ["taxel_2"] * (not open_)
    assert all("nor has it the noise of a taxel" in s.evidence["why"] for s in dead)


def on_and_off(y, rng):
    return np.where(np.repeat(rng.random(y.size // 300 + 1) > 0.4, 300)[: y.size], y, 0.0)


@pytest.mark.parametrize("declared", [True, False])
def test_an_open_taxel_between_loaded_ones_is_dead(tmp_path, declared):
    symptoms = named(tmp_path, spoilt(three("row_5mm"), 1, noisy, declared))
    assert [(s.cause, s.where, s.evidence["kind"]) for s in symptoms] == [("dead_taxel", "taxel_1", "open")]


def test_nothing_else_is_asked_of_a_taxel_that_is_dead(tmp_path):
    write_case(spoilt(three("row_5mm"), 1, noisy), tmp_path)
    session = inspect(load(tmp_path)).sessions[0]
    asked = {q.where for q in (*courses(session), *directions(session))}
    assert {"taxel_0", "taxel_2", "taxel", "skin", "load_cell"} <= asked
    assert "taxel_1" not in asked


@pytest.mark.parametrize(("taxels", "which"), [(3, 2), (3, 0), (4, 1), (6, 2)])
def test_one_that_may_lie_apart_is_not(tmp_path, taxels, which):
    assert not named(tmp_path, spoilt(three("row_5mm", taxels), which, noisy, declared=False))


def test_one_that_lies_apart_between_silent_neighbours_is_not(tmp_path):
    assert not named(tmp_path, spoilt(three("row_14mm", 5), 3, noisy))


@pytest.mark.parametrize("taxels", [1, 3])
def test_one_that_comes_and_goes_is_dead_for_so_long(tmp_path, taxels):
    sessions = three("row_5mm", taxels)
    symptoms = named(tmp_path, spoilt(sessions, 0, on_and_off))
    assert [(s.cause, s.channels[0], s.evidence["kind"]) for s in symptoms] == [("dead_taxel", "taxel_0", "intermittent")]
    loaded = np.concatenate([s.taxels[:, 0] > 1.0 for s in sessions])
    open_then = np.concatenate([s.taxels[:, 0] == 0.0 for s in spoilt(sessions, 0, on_and_off)])
    marked = np.concatenate(list(symptoms[0].bad.values()))
    assert np.mean(marked[loaded & open_then]) > 0.7
    assert not np.any(marked[loaded & ~open_then])


def test_a_stuck_taxel_says_nothing_of_the_encoder(tmp_path):
    sessions = make_sessions("dead_taxel", "taxel_0", "stuck", seed=2108696762, n_sessions=3, n_taxels=3)[0]
    assert {(s.cause, s.where) for s in named(tmp_path, sessions)} == {("dead_taxel", "taxel_0")}


@pytest.mark.parametrize("spoil", ["on and off", "dies"])
def test_its_share_at_every_place_is_that_of_the_samples_in_which_it_lives(tmp_path, spoil):
    rng = np.random.default_rng(4)
    clean = array_making.record_at(tmp_path, [(0, 0), (5, 0), (-5, 0)], taxels=3, layout="row_5mm", noise="white")
    broken = []
    for i, r in enumerate(clean):
        taxels = r.taxels.copy()
        alive = np.arange(len(r)) < (0.4 if i == 1 else 1.0) * len(r)
        taxels[1] = on_and_off(taxels[1], rng) if spoil == "on and off" else np.where(alive, taxels[1], 0.3)
        broken.append(replace(r, taxels=taxels))
    true, raw = (np.array([r.spread for r in with_spread(rs, layout_of(clean))]) for rs in (clean, broken))
    looked = inspect(with_spread(broken, layout_of(broken)))
    assert [(s.cause, s.where) for s in looked.symptoms] == [("dead_taxel", "taxel_1")]
    found = np.array([s.spread for s in looked.sessions])
    assert np.abs(found / true - 1.0).max() < 0.02 < np.abs(raw / true - 1.0).max()


def test_a_kick_of_noise_at_rest_is_no_loose_contact():
    """The reading jumps away and comes back to what it ought to be: neither side of the kick is silent."""
    rng, at = np.random.default_rng(0), [300, 900, 1500, 2100]
    load = np.where(np.arange(3000) % 600 < 500, 1.0, 3.0)
    reading = load + 0.01 * rng.standard_normal(load.size)
    reading[at] += 0.8
    assert contact_of([reading], [load], 0.01) is None
    open_now = np.zeros(load.size, bool)
    for k in at:
        open_now[k : k + 60] = True
    assert contact_of([np.where(open_now, 0.0, reading)], [load], 0.01).level == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize("seed", range(6))
def test_one_that_dies_while_the_plunger_rests_is_dead_from_then_on(tmp_path, seed):
    """Four holds, of which two or three are left when it dies: few pieces of a session in which the load moves."""
    sessions, _ = make_sessions("dead_taxel", "taxel_0", "dies", seed=seed, n_sessions=3, protocol="holds_only", noise="white")
    symptoms = named(tmp_path, sessions)
    assert [(s.cause, s.where, s.evidence["kind"]) for s in symptoms] == [("dead_taxel", "taxel", "dies")]


@pytest.mark.parametrize("by_depth", [True, False])
@pytest.mark.parametrize("share", [0.05, 1.0, 5.0])
def test_one_that_dies_at_once_is_dead_from_then_on_whatever_its_slope(share, by_depth):
    """It lives in the first of the pieces alone, whose own slope says what living is."""
    t = np.arange(3000) / 100.0
    load = 2.0 + np.sin(7.0 * t) + 0.5 * np.sin(17.0 * t)
    dying = np.where(t < 1.795, share * load, 0.3 * share) + 2e-3 * share * np.random.default_rng(0).standard_normal(t.size)
    depth, force = (1e-4 * load, None) if by_depth else (None, load)
    (symptom,) = find_dead_taxels([Recording("early", t, depth, force, np.array([dying, share * load]))])
    assert symptom.where == "taxel_0" and symptom.parameters["since"]["value"] == pytest.approx(1.8, abs=0.02)


@pytest.mark.parametrize("dies", [True, False])
@pytest.mark.parametrize("seed", range(6))
def test_one_that_feels_little_more_than_its_noise_is_dead_from_where_it_holds_one_reading(seed, dies):
    t, rng = np.arange(6000) / 100.0, np.random.default_rng(seed)
    load = 2.0 + np.sin(1.3 * t) + 0.5 * np.sin(3.7 * t)
    faint = 0.01 * load + 8e-3 * rng.standard_normal(t.size)
    reads = np.where(t < 33.0, faint, 0.0) if dies else faint
    found = find_dead_taxels([Recording("faint", t, None, load, np.array([reads, load]))])
    assert [(s.where, s.evidence["kind"]) for s in found] == ([("taxel_0", "dies")] if dies else [])
    assert not dies or found[0].parameters["since"]["value"] == pytest.approx(33.0, abs=1.5)


@pytest.mark.parametrize("seed", range(6))
def test_sound_ones_under_a_plunger_that_rests_are_alive(tmp_path, seed):
    assert named(tmp_path, make_sessions("null", seed=seed, n_sessions=3, n_taxels=2, protocol="holds_only")[0]) == ()


def faded(sessions, taxel, others=None):
    """The taxel fades through the first session and holds zero throughout the second; there others read so many times as much."""
    out = []
    for k, s in enumerate(sessions):
        taxels = s.taxels.copy()
        if k and others is not None:
            taxels *= others
        n = len(taxels)
        taxels[:, taxel] *= 0.0 if k else np.clip(1.0 - (np.arange(n) / n - 0.4) / 0.3, 0.0, 1.0)
        out.append(replace(s, taxels=taxels))
    return out


def test_a_taxel_that_fades_and_then_holds_one_reading_throughout_a_session_is_dead(tmp_path):
    (symptom,) = named(tmp_path, faded(three("row_5mm"), 0))
    assert (symptom.cause, symptom.where, symptom.evidence["kind"]) == ("dead_taxel", "taxel_0", "dies")
    shares = sorted(float(m.mean()) for m in symptom.bad.values())
    assert shares[1] == 1.0 and 0.3 < shares[0] < 0.65


def test_a_taxel_that_holds_one_reading_where_others_feel_another_place_is_not(tmp_path):
    elsewhere = faded(three("row_5mm"), 0, others=np.array([1.0, 3.0, 0.2]))
    assert not [s for s in named(tmp_path, elsewhere) if s.cause == "dead_taxel"]


def test_a_taxel_is_not_asked_what_a_mass_does_in_the_air():
    """A plunger that presses, and then is shaken above the skin: its mass pulls at the load cell, and no taxel can know of it."""
    rng, t = np.random.default_rng(7), np.arange(3000) / 200.0
    presses = t < 8.0
    depth = np.where(presses, 0.4e-3 - 0.6e-3 * np.cos(2.0 * t), -1.0e-3 + 0.3e-3 * np.cos(50.0 * t))
    pressed = 5e3 * np.maximum(depth, 0.0)
    shaken = np.where(presses, 0.0, 1.5 * np.cos(50.0 * t))
    taxel = 0.4 * pressed + 0.005 * rng.standard_normal(t.size)
    assert not find_dead_taxels([Recording("shaken", t, depth, pressed + shaken, np.array([taxel]))])
    dies = np.where(t > 4.0, 0.005 * rng.standard_normal(t.size), taxel)
    assert find_dead_taxels([Recording("dies", t, depth, pressed + shaken, np.array([dies]))])


@pytest.mark.parametrize("since", [0.5, 1.0])
@pytest.mark.parametrize("elsewhere", [False, True])
def test_one_that_is_open_throughout_a_session_is_dead_there_too(since, elsewhere):
    """After it died in the session before, or between the two; not where the other taxel feels that the plunger presses elsewhere."""
    rng, t = np.random.default_rng(8), np.arange(3000) / 200.0
    depth = 0.4e-3 - 0.6e-3 * np.cos(2.0 * t)
    pressed, living = 5e3 * np.maximum(depth, 0.0), t < since * 15.0

    def session(name, lives, other):
        taxels = np.array([0.3 * other * pressed, 0.4 * pressed * lives]) + 0.005 * rng.standard_normal((2, t.size))
        return Recording(name, t, depth, pressed + 0.005 * rng.standard_normal(t.size), taxels)

    made = [session("a", 1.0, 1.0), session("b", living, 1.0), session("c", 0.0, 2.0 if elsewhere else 1.0)]
    found = {name: float(m.mean()) for s in find_dead_taxels(made) for (name, _), m in s.bad.items()}
    assert found == pytest.approx(({"c": 1.0} if not elsewhere else {}) | ({"b": 0.5} if since < 1.0 else {}), abs=0.02)
    if since < 1.0 and not elsewhere:
        (symptom,) = find_dead_taxels(made)
        assert "up to 7.5 s of b and not at all from there to the end, nor anywhere in c" in symptom.evidence["why"]
        assert symptom.evidence["only_in"] == ["b", "c"] and symptom.evidence["pattern"] == "from b on"
        assert symptom.evidence["dead_from_s"] == pytest.approx({"b": 7.5, "c": 0.0}, abs=0.2)
        (later,) = find_dead_taxels([replace(r, t=r.t + 1000.0) for r in made])
        assert "up to 1007.5 s of b and not at all from there to the end, nor anywhere in c" in later.evidence["why"]
        assert later.parameters["since"]["value"] == pytest.approx(1007.5, abs=0.2)


@pytest.mark.parametrize("seed", range(4))
def test_one_that_reads_noise_in_every_session_did_not_live_in_a_piece_of_one(seed):
    """It lies apart, and its noise follows the load for a moment, now and then."""
    rng, t = np.random.default_rng(seed), np.arange(6000) / 100.0
    pressed = 6.0 * np.maximum(np.sin(0.3 * t), 0.0)
    step = 0.05
    taxels = [np.array([0.5 * pressed, step * np.round(0.4 * rng.standard_normal(t.size))]) for _ in range(3)]
    assert not find_dead_taxels([Recording(f"s{i}", t, 1e-4 * pressed, pressed, y) for i, y in enumerate(taxels)])


def test_what_else_a_dead_taxel_has_is_untestable_and_one_row_of_the_report(tmp_path):
    sessions = make_sessions("dead_taxel", "taxel_0", "stuck", seed=11, n_sessions=2, n_taxels=3)[0]
    write_case(sessions, tmp_path)
    findings = diagnose(load(tmp_path)).findings
    silent = {u["cause"] for u in findings["untestable"] if u.get("where") == "taxel_0"}
    assert {"lag", "saturation", "hysteresis", "dead_zone", "gain_error", "force_offset", "drift", "noise"} <= silent
    assert not [e for e in findings["excluded"] if e.get("where") == "taxel_0"]
    rows = [names for names, *_ in untestable_rows(view(findings)) if "taxel 0" in names]
    assert rows == ["hysteresis, dead zone, gain error, force offset, drift, saturation, quantization, lag and noise in taxel 0"]


@pytest.mark.slow
def test_a_taxel_that_dies_early_does_not_silence_what_the_others_say(tmp_path):
    """Where one channel is not believed none is; of this taxel a third of one session is left, and of the load cell everything."""
    sessions = make_sessions("null", seed=23, n_sessions=3, n_taxels=2, noise="white")[0]
    broken = []
    for i, s in enumerate(sessions):
        taxels = s.taxels.copy()
        taxels[round(0.35 * len(s.t)) * (i == 0) :, 1] = 0.0
        broken.append(replace(s, taxels=taxels, force=s.force + 0.3 * (i > 0)))
    write_case(broken, tmp_path / "broken")
    write_case(sessions, tmp_path / "sound")
    outcome = diagnose(load(tmp_path / "broken"))
    found = {(f["cause"], f["where"]) for f in outcome.findings["findings"]}
    assert found == {("dead_taxel", "taxel_1"), ("force_offset", "load_cell")}
    assert ("lag", "taxel_1") in {(u["cause"], u.get("where")) for u in outcome.findings["untestable"]}
    (a, b), (c, d) = outcome.model.shares, diagnose(load(tmp_path / "sound")).model.shares
    assert b / a == pytest.approx(d / c, rel=0.03)


def pressed(shares, step, noise=0.004, depth=0.5e-3, **declared):
    """A minute of sines about a depth, or at rest in the air below zero, behind converters of one step."""
    rng, t = np.random.default_rng(0), np.arange(6000) * 0.01
    x = depth + 0.3e-3 * np.sin(0.5 * np.pi * t) * (depth > 0.0)
    force = 12000.0 * np.maximum(x, 0.0)
    taxels = np.array([np.round((s * force + noise * rng.standard_normal(t.size)) / step) * step for s in shares])
    name = f"at_{1e3 * depth:.1f}_mm"
    return Recording(name, t, np.round(x, 6), force + 0.02 * rng.standard_normal(t.size), taxels, declared=Declared(**declared))


@pytest.mark.parametrize(("far_mm", "noise", "dead"), [(20, 0.004, False), (20, 0.1, False), (2, 0.004, True)])
def test_a_taxel_too_far_away_for_its_converter_is_not_dead(far_mm, noise, dead):
    """It reads zero throughout; next to the plunger, that would be too little."""
    places = ((0, 0), (5, 0), (far_mm, 0))
    r = pressed([0.6, 0.25, 0.0 if dead else 3e-7], 0.05, noise, taxel_positions_mm=places, taxel_step_n=(0.05,))
    if dead:
        r.taxels[2] = 0.0
    assert [s.where for s in find_dead_taxels([r])] == ["taxel_2"] * dead
    assert dead or noise > 0.05 or apart([r]) == ["taxel_2"]


def test_a_taxel_whose_noise_ought_to_show_is_dead_wherever_it_lies():
    """In the air the converters of the others flicker."""
    places = ((0, 0), (5, 0), (20, 0))
    recordings = [pressed([0.6, 0.25, 0.0], 0.05, 0.1, depth, taxel_positions_mm=places, taxel_step_n=(0.05,)) for depth in (0.5e-3, -1e-3)]
    for r in recordings:
        r.taxels[2] = 0.0
    assert [s.where for s in find_dead_taxels(recordings)] == ["taxel_2"]


def test_a_taxel_that_dies_is_not_said_to_be_dead_in_a_session_in_the_air():
    dies, air = (pressed([0.6, 0.3], 0.05, 0.01, depth) for depth in (0.5e-3, -1e-3))
    dies.taxels[0, dies.t > 40.0] = 0.0
    (symptom,) = find_dead_taxels([air, dies])
    assert [session for session, _ in symptom.bad] == [dies.name] and "nor anywhere" not in symptom.evidence["why"]


@pytest.mark.parametrize("depth", [0.5e-3, -1e-3])
def test_an_array_that_was_unplugged_is_dead(depth):
    pressed_too = [pressed([0.6, 0.25, 0.1], 0.05, 0.01, d) for d in {0.5e-3, depth}]
    for r in pressed_too:
        r.taxels[:] = 0.0
    assert [s.where for s in find_dead_taxels(pressed_too)] == ["taxel_0", "taxel_1", "taxel_2"]


@pytest.mark.parametrize("cause", ["force_offset", "drift", "quantization"])
def test_a_zero_of_a_taxel_that_follows_nothing_may_be_an_open_channel(cause):
    t = np.arange(4000) * 0.01
    load, rng = 5.0 * np.clip(np.sin(t), 0.0, None), np.random.default_rng(4)
    hum = 0.009 * rng.standard_normal(t.size) - 2e-4 * load
    recordings = [Recording("a", t, 1e-3 * np.sin(t), load, np.stack([0.6 * load + 0.01 * rng.standard_normal(t.size), 0.02 + hum]))]
    assert apart(recordings) == ["taxel_1"]
    silent, alive = beside_silence([Named(cause, where, None, 1.0, ()) for where in ("taxel_1", "taxel_0")], recordings)
    assert [a.key for a in silent.alternatives] == [("dead_taxel", "taxel_1")] * (cause != "quantization") and not alive.alternatives
