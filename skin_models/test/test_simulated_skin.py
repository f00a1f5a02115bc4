from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skin_models.catalogue import effects
from skin_models.column import at_rest, press, skin_of
from skin_models.dispersion import Dispersion
from skin_models.effect import Place
from skin_models.effects.force_offset import ForceOffset
from skin_models.effects.gain_error import GainError
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.errors import ModelError
from skin_models.layout import grid, row
from skin_models.materials import material
from skin_models.model import Model
from skin_models.model_file import load_model
from skin_models.signals import motion
from skin_models.simulated_skin import MEMORY, Presses, SimulatedSkin, spread_width

SILICONE = material("silicone_4mm").model
RELAXING = SILICONE.extended(StressRelaxation(where="skin", k_sensed=3000.0, k_dispersed=1000.0, tau=0.5))
DT = 0.01


def presses(force=(), depth=(), at=None, key=None):
    n = max(len(force), len(depth))
    nan = [np.nan] * n
    position = np.zeros((n, 3)) if at is None else np.array(at, float)
    keys = tuple(key or (f"c{i}" for i in range(n)))
    return Presses(keys, position, np.array(force or nan, float), np.array(depth or nan, float), np.zeros(n))


def run(skin, inputs, seed=None):
    state, readings = skin.initial(seed), []
    for p in inputs:
        state, reading = skin.step(state, p)
        readings.append(reading)
    return readings


def test_one_taxel_under_a_depth_is_the_model_itself():
    t = np.arange(200) * DT
    x = np.maximum(0.6e-3 * np.sin(2 * t) ** 2 - 1e-4, 0.0)
    got = run(SimulatedSkin(RELAXING, row(1, 1.0), DT), [presses(depth=[d]) for d in x])
    v = np.diff(x, prepend=0.0) / DT
    expected = RELAXING.simulate(motion(t, x, v, np.diff(v, prepend=0.0) / DT))
    assert [r.taxels[0] for r in got] == pytest.approx(expected.taxels_truth[0], abs=1e-9)
    assert [r.force for r in got] == pytest.approx(expected.force_truth, abs=1e-9)


def test_force_and_depth_tell_the_same_story():
    """The forces that a depth gives, put in as forces, give the taxel that the depth gave (as long as they touch)."""
    x = 0.5e-3 * (1.2 - np.cos(np.arange(200) * 0.03))
    by_depth = run(SimulatedSkin(RELAXING, row(1, 1.0), DT), [presses(depth=[d]) for d in x])
    by_force = run(SimulatedSkin(RELAXING, row(1, 1.0), DT), [presses(force=[r.force]) for r in by_depth])
    touching = [i for i, r in enumerate(by_depth) if r.force > 0.0]
    assert 100 < len(touching) < len(x)
    assert [by_force[i].taxels[0] for i in touching] == pytest.approx([by_depth[i].taxels[0] for i in touching], abs=1e-6)


def test_without_effects_the_transfer_function_agrees_with_the_column_it_stands_for():
    """Eq 32 against the search for the depth: two roads to one answer, apart by the first-order difference that the column takes."""
    model, t = Model(Dispersion(b1=900.0, k1=9000.0, b2=600.0, k2=3000.0)), np.arange(400) * 1e-3
    force = 4 * np.sin(8 * t) ** 2
    filtered = [r.taxels[0] for r in run(SimulatedSkin(model, row(1, 1.0), 1e-3), [presses(force=[f]) for f in force])]
    columns, searched = at_rest(skin_of(model), ("a",), 1e-3), []
    for time, f in zip(t, force, strict=True):
        columns, _, sensed = press(skin_of(model), columns, np.array([f]), np.array([np.nan]), time, 1e-3)
        searched.append(sensed[0])
    assert filtered == pytest.approx(searched, abs=0.02)


SKIN_EFFECTS = [c for c in effects() if any(c.places[w] in (Place.SKIN, Place.SURFACE) for w in c.places if w == "skin")]


@pytest.mark.parametrize("cls", SKIN_EFFECTS, ids=lambda c: c.__name__)
@given(forces=st.lists(st.one_of(st.just(0.0), st.floats(1e-3, 50.0)), min_size=3, max_size=3), share=st.floats(0.0, 0.9))
@settings(max_examples=12, deadline=None)
def test_the_depths_that_give_forces_are_found(cls, forces, share):
    """Many contacts at once, from any depth: each gets its force, and just what it gets alone; none where the force would jump past it."""
    skin, force, nothing = skin_of(SILICONE.extended(cls.typical("skin"))), np.array(forces), np.full(3, np.nan)
    start = share * np.maximum(force, 1.0) / 12385.0 / 2
    columns, _, _ = press(skin, at_rest(skin, ("a", "b", "c"), DT), nothing, start, 0.0, DT)
    after, applied, sensed = press(skin, columns, force, nothing, DT, DT)
    alone = [press(skin, columns.of(skin, (key,), DT), force[[i]], nothing[[i]], DT, DT) for i, key in enumerate("abc")]
    assert applied == pytest.approx([a[1][0] for a in alone], abs=1e-4) and sensed == pytest.approx([a[2][0] for a in alone], abs=1e-4)
    assert after.x == pytest.approx([a[0].x[0] for a in alone], abs=1e-12)
    missed = (np.abs(applied - force) > 1e-4) & (force > 0.0)  # N: a power of the speed is infinitely steep at rest; what adheres hangs on
    assert np.all(applied[missed] <= force[missed])
    if missed.any():
        beyond = np.where(missed, after.x + 1e-9, after.x)
        assert np.all(press(skin, columns, nothing, beyond, DT, DT)[1][missed] > force[missed])


def test_force_and_depth_driven_contacts_mix_without_a_trace_in_each_other():
    skin, nan = SimulatedSkin(RELAXING, row(1, 1.0), DT), float("nan")
    parts = {"a": (3.0, nan), "b": (nan, 4e-4), "c": (2.0, nan), "d": (nan, 2e-4)}

    def some(keys):
        return presses(force=[parts[k][0] for k in keys], depth=[parts[k][1] for k in keys], key=list(keys))

    story = ["abcd"] * 20 + ["ab"] * 10 + ["dba"] * 10 + ["b"] * 5 + ["a"] * 5
    whole = run(skin, [some(keys) for keys in story])
    alone = [run(skin, [some([k] if k in keys else []) for keys in story]) for k in parts]
    for i, reading in enumerate(whole):
        assert reading.truth == pytest.approx(sum(r[i].truth for r in alone), abs=1e-9), i
        assert reading.force == pytest.approx(sum(r[i].force for r in alone), abs=1e-9), i


def test_contacts_come_and_go_without_a_trace_in_the_others():
    skin = SimulatedSkin(RELAXING, row(1, 1.0), DT)
    both = [presses(force=[2.0, 5.0], key=["a", "b"])] * 20 + [presses(force=[5.0], key=["b"])] * 20
    both += [presses(force=[1.0, 5.0, 2.0], key=["c", "b", "a"])] * 20
    alone = run(skin, [presses(force=[2.0], key=["a"])] * 20 + [presses()] * 20 + [presses(force=[2.0], key=["a"])] * 20)
    rest = run(skin, [presses(force=[5.0], key=["b"])] * 60)
    fresh = run(skin, [presses(force=[1.0], key=["c"])] * 20)
    whole = run(skin, both)
    assert whole[10].truth == pytest.approx(alone[10].truth + rest[10].truth)
    assert whole[30].truth == pytest.approx(rest[30].truth)
    assert whole[50].truth == pytest.approx(alone[50].truth + rest[50].truth + fresh[10].truth)


@pytest.mark.parametrize("model", [SILICONE, RELAXING], ids=["filter", "column"])
def test_statically_force_is_conserved_and_nothing_is_created(model):
    skin = SimulatedSkin(model, grid(12, 12, 5e-3), DT)
    still = presses(force=[3.0, 5.0], at=[[1e-3, 0, 0], [20e-3, 20e-3, 0]])
    last = run(skin, [still] * 900)[-1]
    assert last.force == pytest.approx(8.0) and last.truth.sum() + last.dispersed == pytest.approx(8.0, rel=1e-9)
    assert 0.0 < last.dispersed < 2.0 and np.all(last.truth >= 0.0)


def test_the_taxel_under_the_contact_feels_the_share_of_the_model():
    from skin_models.layout import A201_AREA

    got = run(SimulatedSkin(SILICONE, grid(5, 5, 14e-3, A201_AREA), DT), [presses(force=[10.0])] * 400)[-1]
    centre, beside = got.taxels[12], got.taxels[13]
    assert centre == pytest.approx(10 * SILICONE.dispersion.sensed_share, rel=1e-6)
    assert beside / centre == pytest.approx(np.exp(-((14 / 5.25) ** 2)), rel=1e-6)


def test_sensor_effects_show_in_the_reading_and_not_in_the_truth():
    sensors = GainError(where="taxel_1", gain=0.25), ForceOffset(where="taxel_0", offset=0.5)
    model = Model(SILICONE.dispersion, (1.0, 0.2, 0.2), sensors)
    got = run(SimulatedSkin(model, row(3, 7e-3), DT), [presses(force=[5.0])] * 3)[-1]
    assert got.taxels - got.truth == pytest.approx([0.5, 0.25 * got.truth[1], 0.0])


def test_an_effect_on_a_missing_taxel_is_refused():
    model = Model(SILICONE.dispersion, shares=(1.0,) * 4, effects=(GainError(where="taxel_3", gain=0.1),))
    with pytest.raises(ModelError, match="3 taxels"):
        SimulatedSkin(model, row(3, 7e-3), DT)
    with pytest.raises(ModelError, match="the model has 1 taxel, counted"):
        Model(SILICONE.dispersion, effects=model.effects)


def test_memory_waits_in_the_air_for_its_contact():
    skin = SimulatedSkin(RELAXING, row(1, 1.0), DT)
    held, away = presses(depth=[1e-3], key=["finger"]), presses()
    readings = run(skin, [held] * 200 + [away] + [held])
    virgin = run(skin, [held])[0]
    unloaded = 3000.0 + 1000.0  # N/m of the arm, which had relaxed by almost 1 mm before the finger left
    assert readings[200].force == 0.0
    assert virgin.force - readings[-1].force == pytest.approx(unloaded * 1e-3, rel=0.1)


def test_columns_in_the_air_are_bounded():
    skin, state = SimulatedSkin(RELAXING, row(1, 1.0), DT), None
    state = skin.initial()
    for i in range(3 * MEMORY):
        state, _ = skin.step(state, presses(depth=[1e-4], key=[f"contact {i}"]))
    assert len(state.columns) <= MEMORY + 1


def test_nothing_touching_is_nothing_felt():
    reading = run(SimulatedSkin(SILICONE, grid(3, 3, 5e-3), DT), [presses()])[0]
    assert np.all(reading.taxels == 0.0) and reading.force == reading.dispersed == 0.0


def test_width_comes_from_the_models_notes():
    assert spread_width(SILICONE.notes) == 5.25e-3 and spread_width({}) == 5.25e-3
    with pytest.raises(ModelError, match="spread_width"):
        spread_width({"spread_width": {"value": 5.25, "unit": "mm"}})


def test_the_model_file_of_the_readme_loads(tmp_path):
    text = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    (tmp_path / "model.yaml").write_text(text.split("```yaml")[1].split("```")[0], encoding="utf-8")
    model = load_model(tmp_path / "model.yaml")
    assert model.dispersion == SILICONE.dispersion and model.shares == (1.0, 0.4) and [e.cause for e in model.effects] == ["lag"]


def test_the_example_of_the_readme_runs():
    text = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    names: dict = {}
    exec(text.split("```python")[1].split("```")[0], names)
    assert names["reading"].truth.sum() + names["reading"].dispersed == pytest.approx(5.0) and names["reading"].taxels.size == 81
