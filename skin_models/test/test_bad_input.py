"""What cannot be used is refused with one sentence that says what and where; what is odd but possible behaves as stated."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from skin_models.dispersion import Dispersion
from skin_models.effects.gain_error import GainError
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.errors import ModelError
from skin_models.layout import grid
from skin_models.materials import material
from skin_models.model import Model
from skin_models.model_file import load_model, model_to_dict
from skin_models.signals import Sample, motion
from skin_models.simulated_skin import Presses, SimulatedSkin
from skin_models.spread.contacts import ContactError

SILICONE = material("silicone_4mm").model
RELAXING = SILICONE.extended(StressRelaxation.typical("skin"))


def changed(*path, to):
    """The relaxing silicone as a dictionary, with one entry changed; None takes it out."""
    content = model_to_dict(RELAXING)
    *way, last = path
    inner = content
    for key in way:
        inner = inner[key]
    if to is None:
        del inner[last]
    else:
        inner[last] = to
    return yaml.safe_dump(content)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (changed("dispersion", "k1", "value", to=-9619.0), r"k1 = -9619 N/m is outside \[0"),
        (changed("dispersion", "m", "value", to=-1e-3), r"m = -0.001 kg is outside"),
        (changed("dispersion", "k1", "value", to=float("nan")), "k1 must be a number"),
        (changed("dispersion", "k1", "value", to="stiff"), "must have a number"),
        (changed("dispersion", "k1", "unit", to="N/mm"), "is in 'N/mm', but must be in 'N/m'"),
        (changed("dispersion", "k1", to=9619.0), "must be written as"),
        (changed("dispersion", "k2", to=None), "lacks k2"),
        (changed("dispersion", to=None), "must be a mapping"),
        (changed("dispersion", "k3", to={"value": 1.0, "unit": "N/m"}), "unknown entry 'k3'"),
        (changed("schema", to=None), "does not say schema: 1"),
        (changed("schema", to=2), "schema is 2; this version reads schema 1"),
        (changed("shares", to=["one"]), "list of numbers"),
        (changed("shares", to=[-0.5]), r"not negative, not \[-0\.5\]"),
        (changed("shares", to=[float("inf")]), "must be finite"),
        (changed("effects", 0, "cause", to="magic"), "no effect models 'magic'"),
        (changed("effects", 0, "where", to="moon"), "no effect models .* in 'moon'"),
        (changed("effects", 0, "where", to=None), "has no 'where'"),
        (changed("effects", 0, "parameters", "tau", "value", to=0.0), "tau = 0 s is outside"),
        (changed("effects", 0, "parameters", "tau", to=None), "lacks tau"),
        (changed("effects", 0, "parameters", "tau", "sdt", to=0.1), "unknown entry 'sdt'"),
        (changed("effects", to=5), "effects must be a list"),
        (changed("effects", to={"cause": "lag"}), "effects must be a list"),
        (changed("positions", to={"value": [[0.0, 0.0]], "unit": "mm"}), "unit: m"),
        (changed("shares", to=[1.0, 0.5]).replace("effects:", "positions: {value: [[0, 0], [0, 0]], unit: m}\neffects:"), "same place"),
        (changed("notes", "spread_width", "value", to=-5e-3), "skin.yaml: notes.spread_width must be a positive length"),
        (changed("notes", "spread_width", to=5e-3), "skin.yaml: notes.spread_width must be written as"),
        (changed("name", to="twice") + "name: again\n", "'name' stands twice in one mapping"),
        (changed("dispersion", "k1", "value", to="NUMBER").replace("NUMBER", "1e-3 N"), "must have a number"),
        ("- a list", "must be a mapping"),
        ("{", "is not YAML"),
        ("", "must be a mapping"),
        ("\x00\x01", "is not YAML"),
    ],
)
def test_a_model_file_is_refused_by_name_with_what_is_wrong(tmp_path, text, says):
    path = tmp_path / "skin.yaml"
    path.write_text(text)
    with pytest.raises(ModelError, match=says) as error:
        load_model(path)
    assert "skin.yaml" in str(error.value) and "\n" not in str(error.value)


def test_a_model_file_that_is_not_there_or_is_no_text(tmp_path):
    (tmp_path / "binary.yaml").write_bytes(bytes(range(128, 256)))
    for path in (tmp_path / "missing.yaml", tmp_path, tmp_path / "binary.yaml"):
        with pytest.raises(ModelError, match="cannot read the model"):
            load_model(path)


def test_numbers_may_be_written_without_a_point_and_the_unit_one_bare(tmp_path):
    content = model_to_dict(SILICONE.extended(GainError(where="taxel_0", gain=0.125)))
    path = tmp_path / "skin.yaml"
    path.write_text(yaml.safe_dump(content).replace("0.000432", "432e-6").replace("0.125", "125E-3").replace("unit: '1'", "unit: 1"))
    assert load_model(path).effects[0].gain == 0.125 and load_model(path).dispersion.m == 432e-6


def test_an_unknown_material_is_named_with_those_there_are():
    with pytest.raises(ModelError, match=r"no material is called 'rubber'; known are frubber_4mm, silicone_2mm"):
        material("rubber")


def presses(**wrong):
    given = {"key": ("a", "b"), "position": np.zeros((2, 3)), "force": np.ones(2), "depth": np.full(2, np.nan), "radius": np.zeros(2)}
    return Presses(**{**given, **wrong})


@pytest.mark.parametrize(
    "wrong",
    [
        {"key": ("a",)},
        {"position": np.zeros((2, 2))},
        {"position": np.array([[0.0, np.nan, 0.0], [0.0, 0.0, 0.0]])},
        {"force": np.ones(3)},
        {"force": np.array([1.0, np.nan])},
        {"force": np.array([1.0, np.inf])},
        {"force": np.full(2, np.nan), "depth": np.array([1e-3, np.inf])},
        {"radius": np.array([1e-3, -1e-3])},
        {"radius": np.array([1e-3, np.nan])},
        {"radius": np.array([1e-3, np.inf])},
        {"depth": np.array([np.nan, np.inf])},
        {"depth": np.array([np.nan, 1.0])},
        {"force": np.array([1.0, 1e7])},
        {"key": ("a", "a")},
    ],
    ids=str,
)
def test_contacts_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ContactError, match="contact"):
        presses(**wrong)


@pytest.mark.parametrize("dt", [0.0, -0.01, float("nan"), float("inf")])
def test_time_must_advance(dt):
    with pytest.raises(ModelError, match="sample"):
        SimulatedSkin(RELAXING, grid(2, 2, 5e-3), dt)
    if dt != float("inf"):
        with pytest.raises(ModelError, match="later"):
            RELAXING.step(RELAXING.initial(), Sample(0.0, 1e-3, 0.0, 0.0), dt)


@pytest.mark.parametrize("odd", [{"v": np.zeros(4)}, {"v": np.full(5, np.nan)}, {"a": np.full(5, np.inf)}], ids=str)
def test_a_motion_has_as_many_speeds_as_depths(odd):
    with pytest.raises(ModelError, match="as many as the 5 depths"):
        motion(np.arange(5) * 0.01, np.zeros(5), **odd)


@pytest.mark.parametrize("model", [SILICONE, RELAXING], ids=["filter", "column"])
@pytest.mark.parametrize("fast", [False, True])
def test_a_contact_far_outside_is_counted_and_felt_by_nobody(model, fast):
    skin = SimulatedSkin(model, grid(4, 4, 5e-3), 0.01, fast=fast)
    there = presses(position=np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]), force=np.array([2.0, 7.0]))
    near, state = presses(force=np.array([2.0, 0.0])), skin.initial()
    for _ in range(300):
        state, far = skin.step(state, there)
    state = skin.initial()
    for _ in range(300):
        state, alone = skin.step(state, near)
    assert far.outside == 1 and far.truth == pytest.approx(alone.truth, abs=1e-6) and far.force == pytest.approx(9.0, rel=1e-6)


@pytest.mark.parametrize("fast", [False, True])
def test_the_number_of_contacts_may_change_and_that_of_taxels_does_not(fast):
    skin = SimulatedSkin(RELAXING, grid(4, 4, 5e-3), 0.01, fast=fast)
    state, sizes = skin.initial(), []
    for count in (0, 3, 40, 1, 0, 2):
        many = Presses(
            tuple(f"{len(sizes)}/{i}" for i in range(count)), np.zeros((count, 3)), np.ones(count), np.full(count, np.nan), np.zeros(count)
        )
        state, reading = skin.step(state, many)
        sizes.append(reading.taxels.size)
        assert reading.force == pytest.approx(count) and np.isfinite(reading.taxels).all()
    assert sizes == [16] * 6


@pytest.mark.parametrize("model", [SILICONE, RELAXING], ids=["filter", "column"])
@pytest.mark.parametrize("fast", [False, True])
def test_a_contact_that_pulls_does_not_press(model, fast):
    skin = SimulatedSkin(model, grid(4, 4, 5e-3), 0.01, fast=fast)
    reading = skin.step(skin.initial(), presses(force=np.array([-3.0, 0.0])))[1]
    assert not reading.truth.any() and reading.force == 0.0


def test_a_skin_that_disperses_a_negative_force_makes_none():
    """Such numbers come out of a fit to a taxel that reads too much: the model under its plunger follows them, a patch conserves force."""
    odd = Model(Dispersion(b1=900.0, k1=9600.0, b2=0.0, k2=-900.0))
    skin = SimulatedSkin(odd, grid(6, 6, 5e-3), 0.01)
    state = skin.initial()
    for _ in range(300):
        state, reading = skin.step(state, presses())
    assert reading.truth.sum() <= 2.0 * (1.0 + 1e-9)


def test_a_model_without_taxels_is_a_material_test():
    alone = replace(SILICONE, shares=())
    _, response = alone.step(alone.initial(), Sample(0.0, 1e-3, 0.0, 0.0), 0.01)
    assert response.taxels.shape == (0,) and response.force > 0.0
