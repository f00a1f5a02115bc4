"""The shipped parameter file fits the node."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import yaml

pytest.importorskip("rclpy")

from skin_models.layout import A201_AREA
from skin_models.materials import material
from skin_models.model_file import save_model
from skin_models.ros.skin_settings import SkinSettings
from skin_models.spread.kernels import Gaussian

CONFIG = Path(__file__).parents[1] / "config" / "skin.yaml"


def test_every_parameter_of_the_file_is_one_of_the_node_and_usable():
    values = yaml.safe_load(CONFIG.read_text())["/**"]["ros__parameters"]
    types = {f.name: f.type for f in fields(SkinSettings)}
    assert {name: type(value) for name, value in values.items()} == {name: types[name] for name in values}
    settings = SkinSettings(**values)
    model = settings.make_model()
    assert len(settings.make_layout(model)) == 81 and settings.make_kernel(model).width == 5.25e-3


@pytest.mark.parametrize("kernel", ["gaussian", "generalised_gaussian", "heavy_tail"])
@pytest.mark.parametrize("layout", ["model", "row", "grid", "hexagonal"])
def test_every_choice_makes_something(layout, kernel):
    settings = SkinSettings(layout=layout, spread_kernel=kernel)
    model = settings.make_model()
    assert len(settings.make_layout(model)) >= 1 and settings.make_kernel(model).area > 0


def test_a_model_that_knows_where_its_taxels_are_is_laid_out_so(tmp_path):
    positions = ((0.0, 0.0), (5e-3, 1e-3))
    save_model(replace(material("silicone_4mm").model, shares=(1.0, 0.4), positions=positions), tmp_path / "m.yaml")
    settings = SkinSettings(model=str(tmp_path / "m.yaml"))
    layout = settings.make_layout(settings.make_model())
    assert layout.positions[:, :2] == pytest.approx(np.array(positions)) and layout.area[0] == A201_AREA


def test_a_setting_of_the_node_goes_before_the_notes_of_its_model():
    model = replace(material("silicone_4mm").model, notes={"spread_width": {"value": 5e-3, "unit": "m"}})
    assert SkinSettings(spread_width=4e-3).make_kernel(model) == Gaussian(width=4e-3)
    assert SkinSettings().make_kernel(model) == Gaussian(width=5e-3)
