import numpy as np
import pytest

from skin_models.errors import ModelError
from skin_models.layout import row
from skin_models.materials import material
from skin_models.model import Model
from skin_models.model_file import load_model, save_model
from skin_models.simulated_skin import Presses, SimulatedSkin
from skin_models.spread.kernels import Anisotropic, DepthWidth, Gaussian
from skin_models.spread.noted import kernel_of
from skin_models.spread.tabulated import Tabulated

SILICONE = material("silicone_4mm").model
U = np.linspace(0.0, 4.0, 400)


def tabled(**more):
    table = {"at": U.tolist(), "shares": np.exp(-(U**2)).tolist()}
    return Model(SILICONE.dispersion, notes={"spread_width": {"value": 5e-3, "unit": "m"}, "spread": {"table": table, **more}})


def test_a_table_of_a_gaussian_is_that_gaussian():
    r = np.linspace(0.0, 15e-3, 50)
    kernel, plain = kernel_of(tabled().notes), Gaussian(width=5e-3)
    assert np.max(np.abs(kernel.shape(r) - plain.shape(r))) < 1e-4
    assert kernel.area == pytest.approx(plain.area, rel=1e-3) and kernel.reach(1e-3) == pytest.approx(plain.reach(1e-3), rel=0.02)


def test_notes_reach_the_simulated_skin_through_a_file(tmp_path):
    growth, ratio = {"value": 100.0, "unit": "1/m"}, {"value": 1.2, "unit": "1"}
    save_model(tabled(growth=growth, ratio=ratio), tmp_path / "m.yaml")
    kernel = kernel_of(load_model(tmp_path / "m.yaml").notes)
    assert isinstance(kernel, Anisotropic) and isinstance(kernel.kernel, DepthWidth) and isinstance(kernel.kernel.kernel, Tabulated)
    skin = SimulatedSkin(load_model(tmp_path / "m.yaml"), row(3, 5e-3), 0.01)
    where = Presses(("a",), np.zeros((1, 3)), np.array([np.nan]), np.array([1e-3]), np.zeros(1))
    state, reading = skin.initial(), None
    for _ in range(5):
        state, reading = skin.step(state, where)
    beside, under = reading.truth[0], reading.truth[1]
    assert 0.3 < beside / under < 0.6  # exp(-(5 / 5.5 / sqrt(1.2))^2) = 0.50


def test_a_model_without_notes_has_the_width_of_the_thesis():
    assert kernel_of({}) == Gaussian(width=5.25e-3)


@pytest.mark.parametrize(("value", "unit"), [(1.2, 1), (1.2, "1"), (2, "1")])
def test_whole_numbers_and_a_bare_unit_of_one_are_as_good(value, unit):
    assert kernel_of({"spread": {"ratio": {"value": value, "unit": unit}}}).ratio == value


@pytest.mark.parametrize(
    ("spread", "says"),
    [
        ({"tabel": {}}, "may hold"),
        ({"table": {"at": [0.0, 1.0]}}, "lists"),
        ({"table": {"at": [0.0, "far"], "shares": [1.0, 0.5]}}, "numbers"),
        ({"table": {"at": [0.0, 1.0], "shares": [0.9, 0.5]}}, "share 1"),
        ({"table": {"at": [0.0, 1.0, 1.0], "shares": [1.0, 0.5, 0.4]}}, "increase"),
        ({"table": {"at": [0.0], "shares": [1.0]}}, "two or more"),
        ({"growth": {"value": 1.0, "unit": "1/mm"}}, "growth"),
    ],
)
def test_refuses_notes_that_make_no_sense(spread, says):
    with pytest.raises(ModelError, match=says):
        kernel_of({"spread": spread})
