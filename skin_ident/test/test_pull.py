"""A pull on release is found from the moments that the rest of the comparison leaves out."""

from dataclasses import replace

import numpy as np
import pytest
from hide_and_seek import seek
from rows import rows

from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.telemetry.faults import effect_of
from skin_ident.criticism.telemetry.pull import find_pull, is_pulled
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.effects.adhesion import Adhesion
from skin_models.model import Model
from skin_models.signals import motion


@pytest.mark.parametrize("form", rows(["pull_off", "jkr"], 0))
def test_a_skin_that_holds_on_is_found(tmp_path, form):
    found = seek(tmp_path, "adhesion", where="skin", form=form, size=1.0, seed=41)
    assert ("adhesion", "skin") in found.names, found.names


@pytest.mark.parametrize(("cause", "where"), rows([("stress_relaxation", "skin"), ("hysteresis", "load_cell")], 0))
def test_what_looks_like_a_pull_is_none(tmp_path, cause, where):
    assert "adhesion" not in [c for c, _ in seek(tmp_path, cause, where=where, size=2.0, seed=43).names]


def test_a_pull_that_is_not_like_the_simulated_one_is_named_and_not_simulated():
    rng, t = np.random.default_rng(0), np.arange(12000) / 250.0
    skin = Dispersion(m=0.0, b1=1.0, k1=900.0, b2=1.0, k2=600.0)
    x = 1e-3 * np.maximum(1.5 * np.sin(1.6 * t), -0.5)
    x[(t > 13.0) & (t < 17.0)] = 4e-5  # a rest at the surface, where the simulated skin would hold on all the time
    plain = Recording("a", t, x, 1500.0 * np.maximum(x, 0.0), 900.0 * np.maximum(x, 0.0)[None])
    brief = np.where((np.diff(x, append=x[-1]) < 0.0) & (x < 0.0) & (x > -1e-4), -0.8, 0.0)
    noise = rng.normal(0.0, 0.01, (2, t.size))
    sessions = [prepare(replace(plain, force=plain.force + brief + noise[0], taxels=plain.taxels + 0.6 * brief + noise[1:]))]
    (found,) = find_pull(Model(skin, shares=(1.0,)), sessions)
    assert found.evidence["unlike_simulated"] and effect_of(found) is None


@pytest.mark.parametrize("pull", [0.0, 0.12])
def test_a_load_cell_too_noisy_for_a_single_leaving_agrees_with_its_taxel_over_all(pull):
    rng, t = np.random.default_rng(2), np.arange(12000) / 250.0
    skin = Dispersion(m=0.0, b1=1.0, k1=900.0, b2=1.0, k2=600.0)
    x = 1e-3 * np.maximum(1.5 * np.sin(1.6 * t), -0.5)
    brief = np.where((np.diff(x, append=x[-1]) < 0.0) & (x < 0.0) & (x > -2e-4), -1.0, 0.0)
    force = 1500.0 * np.maximum(x, 0.0) + pull * brief + rng.normal(0.0, 0.1, t.size)
    taxel = 900.0 * np.maximum(x, 0.0) + 0.12 * brief + rng.normal(0.0, 0.01, t.size)
    found = find_pull(Model(skin, shares=(1.0,)), [prepare(Recording("a", t, x, force, taxel[None]))])
    assert [s.channels for s in found] == ([("force", "taxel_0")] if pull else [])  # what the load cell does not feel is a taxel's fault


@pytest.mark.parametrize(("pull", "spikes", "step"), [(0.105, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.5, 0.07)])
def test_noise_of_the_encoder_is_not_in_the_air_where_a_pull_shows(pull, spikes, step):
    rng, t = np.random.default_rng(4), np.arange(12000) / 100.0
    skin = Dispersion(m=0.0, b1=20.0, k1=6000.0, b2=20.0, k2=6000.0)
    x = 1e-3 * np.maximum(1.5 * np.sin(1.6 * t), -0.5)
    brief = np.where((np.diff(x, append=x[-1]) < 0.0) & (x < 0.0) & (x > -1e-4), -pull, 0.0)
    plain = 12000.0 * np.maximum(x, 0.0) + brief + rng.normal(0.0, 0.02, t.size) + spikes * (rng.random(t.size) < 0.01)
    force = np.round(plain / step) * step if step else plain
    taxel = 6000.0 * np.maximum(x, 0.0) + rng.normal(0.0, 0.02, t.size)
    read = x + rng.normal(0.0, 10e-6, t.size)
    found = find_pull(Model(skin, shares=(1.0,)), [prepare(Recording("a", t, read, force, taxel[None]))])
    assert [s.channels for s in found] == ([("force",)] if pull else [])


@pytest.mark.parametrize("pull", [0.0, 0.1])
def test_spikes_to_one_side_are_no_pull(pull):
    rng, t = np.random.default_rng(8), np.arange(24000) / 200.0
    x = 1e-3 * np.maximum(1.5 * np.sin(1.6 * t), -0.5)
    brief = np.where((np.diff(x, append=x[-1]) < 0.0) & (x < 0.0) & (x > -3e-4), -pull, 0.0)
    spikes = -0.08 * (rng.random(t.size) < 0.08)
    force = 12000.0 * np.maximum(x, 0.0) + brief + rng.normal(0.0, 0.01, t.size) + spikes
    skin = Dispersion(m=0.0, b1=20.0, k1=6000.0, b2=20.0, k2=6000.0)
    found = find_pull(Model(skin, shares=()), [prepare(Recording("a", t, x, force, np.empty((0, t.size))))])
    assert [s.channels for s in found] == ([("force",)] if pull else [])


@pytest.mark.parametrize("pull", [0.0, 0.2])
def test_a_slow_plunger_is_followed_until_the_skin_lets_go(pull):
    """The skin follows for 90 um, a second long, and pulls most where it snaps off."""
    rng, t = np.random.default_rng(3), np.arange(14000) / 100.0
    skin = Dispersion(m=0.0, b1=1.0, k1=900.0, b2=1.0, k2=600.0)
    x = 1e-3 * np.maximum(0.4 * np.sin(0.25 * t), -0.3)
    held = (np.gradient(x) < 0.0) & (x < 0.0) & (x > -9e-5)
    follows = np.where(held, (x / 9e-5) ** 3, 0.0)
    force = 1500.0 * np.maximum(x, 0.0) + pull * follows + rng.normal(0.0, 0.02, t.size)
    taxel = 900.0 * np.maximum(x, 0.0) + 0.6 * pull * follows + rng.normal(0.0, 0.02, t.size)
    found = find_pull(Model(skin, shares=(1.0,)), [prepare(Recording("a", t, x, force, taxel[None]))])
    assert [s.channels for s in found] == ([("force", "taxel_0")] if pull else [])


def test_beside_a_taxel_that_feels_nothing_the_pull_is_what_does_not_reach_it():
    rng, t = np.random.default_rng(1), np.arange(12000) / 250.0
    skin = Dispersion(m=0.0, b1=1.0, k1=900.0, b2=1.0, k2=600.0)
    x = 1e-3 * np.maximum(1.5 * np.sin(1.6 * t), -0.5)
    brief = np.where((np.diff(x, append=x[-1]) < 0.0) & (x < 0.0) & (x > -1e-4), -0.8, 0.0)
    force = 1500.0 * np.maximum(x, 0.0) + brief + rng.normal(0.0, 0.01, t.size)
    dead = Recording("a", t, x, force, rng.normal(0.0, 0.01, (1, t.size)))
    (found,) = find_pull(Model(skin, shares=(0.0,)), [prepare(dead)])
    assert found.channels == ("force",)
    assert found.parameters["pull_sensed"]["value"] == 0.0
    assert found.parameters["pull_dispersed"]["value"] == pytest.approx(0.8, abs=0.3)


@pytest.mark.parametrize(("damping", "mass", "follows"), [(200.0, 0.0, True), (20.0, 5e-3, True), (20.0, 20e-3, False)])
def test_equations_that_are_simulated_as_they_stand_pull_at_nothing(damping, mass, follows):
    """Above depth zero dashpots pull, where nobody has told them of contact, and the moving skin hangs on the load cell."""
    rng, t = np.random.default_rng(0), np.arange(12000) / 250.0
    x = 1e-3 * np.maximum(1.5 * np.sin(1.6 * t), -0.5)
    v = np.gradient(x, t)
    sensed, whole = (c * (1e3 * x + damping * v) for c in (0.6, 1.0))
    sensed, whole = ((y if follows else np.maximum(y, 0.0)) * (x > 0.0) for y in (sensed, whole))
    whole += mass * (np.gradient(v, t) - 9.81) * (x > 0.0)
    force, taxel = whole + rng.normal(0.0, 5e-3, t.size), sensed + rng.normal(0.0, 5e-3, t.size)
    skin = Dispersion(m=mass, b1=0.6 * damping, k1=600.0, b2=0.4 * damping, k2=400.0)
    assert find_pull(Model(skin, shares=(1.0,)), [prepare(Recording("a", t, x, force, taxel[None]))]) == []


def test_a_rig_that_drags_in_the_air_too_pulls_at_nothing():
    """Friction takes from the load cell on the way out, and adds as much on the way in: only skin that holds on does the one alone."""
    rng, t = np.random.default_rng(0), np.arange(12000) / 250.0
    skin = Dispersion(m=0.0, b1=1.0, k1=900.0, b2=1.0, k2=600.0)
    x = 1e-3 * np.clip(1.5 * np.sin(1.6 * t) + 0.3, -0.8, None)
    speed = np.gradient(x, t)
    noise = rng.normal(0.0, 0.01, (2, t.size))
    force, taxel = 1500.0 * np.maximum(x, 0.0) + noise[0], 900.0 * np.maximum(x, 0.0) + noise[1]
    drags, holds = 0.1 * np.tanh(speed / 1e-4), np.where((speed < 0.0) & (x < 0.0), -0.1, 0.0)
    for more, found in ((drags, []), (holds, ["adhesion"])):
        symptoms = find_pull(Model(skin, (1.0,)), [prepare(Recording("a", t, x, force + more, taxel[None]))])
        assert [s.cause for s in symptoms] == found


def test_a_model_that_pulls_where_nothing_does_is_seen_through():
    rng, t = np.random.default_rng(2), np.arange(12000) / 250.0
    plain = Model(Dispersion(m=0.0, b1=1.0, k1=900.0, b2=1.0, k2=600.0), shares=(1.0,))
    pulling = plain.extended(Adhesion("skin", pull_sensed=0.5, pull_dispersed=0.3, reach=1e-4))
    x = 1e-3 * np.maximum(1.5 * np.sin(1.6 * t), -0.5)
    for truth in (plain, pulling):
        y = truth.simulate(motion(t, x))
        force, taxels = (z + rng.normal(0.0, 0.01, z.shape) for z in (y.force, y.taxels))
        assert is_pulled(pulling, plain, [prepare(Recording("a", t, x, force, taxels))]) == (truth is pulling)


def test_of_many_samples_with_heavy_tails_some_are_low_by_themselves():
    """At 1 kHz six hundred samples are looked at about each leaving."""
    rng, t = np.random.default_rng(0), np.arange(48000) / 1000.0
    x = 1e-3 * np.maximum(1.5 * np.sin(1.6 * t), -0.5)
    force = 1500.0 * np.maximum(x, 0.0) + 0.01 * rng.standard_t(3, t.size)
    session = prepare(Recording("a", t, x, force, np.zeros((0, t.size))))
    assert not find_pull(Model(Dispersion(m=0.0, b1=1.0, k1=900.0, b2=1.0, k2=600.0)), [session])
