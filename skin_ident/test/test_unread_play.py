"""Play that the encoder is too coarse to read is no finding, and what it leaves is not given to other causes."""

import pytest
from hide_and_seek import seek
from rows import rows
from world.hidden import Hide

# What is hidden beside play of 9 to 10 µm, which an encoder reads in steps of 10 µm. Left out of the model, play had hidden the zero, and
# had passed for relaxation and damping beside the loop.
BESIDE = [(Hide("force_offset", None, None, 2.0), 1.0, 5006, 1), (Hide("hysteresis", None, None, 2.0), 2.0, 5004, 1)]


@pytest.mark.parametrize(("other", "size", "seed", "taxels"), rows(BESIDE, 0), ids=lambda x: getattr(x, "cause", ""))
def test_what_is_beside_it_is_named_alone(tmp_path, other, size, seed, taxels):
    play = Hide("backlash", "rig", None, size)
    found = seek(tmp_path, [play, other], taxels=taxels, seed=seed, encoder_step_um=10.0)
    assert found.names == [(found.truth.hidden[1].cause, "taxel")]
    told = [u for u in found.findings["untestable"] if (u["cause"], u.get("where")) == ("backlash", "rig")]
    assert "but the encoder reads no finer than" in told[0]["because"] and "the extended model holds it" in told[0]["because"]
    assert any(name.startswith("backlash.rig.") for name in found.findings["extended"]["parameters"])


@pytest.mark.slow
def test_alone_it_is_no_finding_and_no_part_of_the_model(tmp_path):
    found = seek(tmp_path, "backlash", where="rig", size=1.0, seed=5015, taxels=2, encoder_step_um=5.0)
    assert found.names == [] and found.findings["verdict"] == "nothing_wrong"
    assert found.findings["baseline"]["parameters"].keys() == found.findings["extended"]["parameters"].keys()
