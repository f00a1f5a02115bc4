"""An encoder that lags behind the tip: its reading loses depth at every reversal, which had passed for a late clock, for damping that does
not follow the speed, and for loops of the sensors."""

import pytest
from hide_and_seek import seek
from rows import rows
from world.hidden import Hide

LAGS = [("slack_encoder", 7001, 2), ("dragged_encoder", 7004, 2), ("slack_encoder", 7002, 3), ("dragged_encoder", 7005, 3)]


@pytest.mark.parametrize(("form", "seed", "taxels"), rows(LAGS, 1))
def test_it_is_named_and_nothing_else(tmp_path, form, seed, taxels):
    found = seek(tmp_path, [Hide("backlash", "rig", form, 1.0)], taxels=taxels, seed=seed)
    assert found.names == [("backlash", "rig")]


@pytest.mark.slow
@pytest.mark.parametrize(("form", "seed"), [("slack_encoder", 7011), ("dragged_encoder", 7012)])
def test_less_than_a_step_of_it_is_what_encoders_do(tmp_path, form, seed):
    found = seek(tmp_path, [Hide("backlash", "rig", form, 1.0)], taxels=2, seed=seed, encoder_step_um=20.0)
    assert found.names == []
