"""The shipped parameter file fits the node."""

from dataclasses import fields
from pathlib import Path

import pytest
import yaml

pytest.importorskip("rclpy")

from skin_models.ros.skin_settings import SkinSettings

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
