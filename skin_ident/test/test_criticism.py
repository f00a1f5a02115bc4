"""The criticism finds what is hidden, says where, and is silent when nothing is hidden.

The recordings come from `world`: another integrator, other functional forms, noise, quantization and unit-to-unit variation of its own.
A handful of cases run here; the campaign runs them all and prints the rates.
"""

import json
from pathlib import Path

import pytest
from hide_and_seek import seek
from rows import rows

from skin_ident.criticism.vocabulary import CAUSES
from skin_models.catalogue import effects

FOUND = [
    ("stress_relaxation", "skin", "prony2"),
    ("lag", "taxel_0", "one_pole"),
    ("dead_zone", "taxel_0", "gradual"),
    ("nonlinear_stiffness", "skin", "fung"),
    ("backlash", "rig", "play"),
    ("drift", "load_cell", "creep_under_load"),
    ("stress_relaxation", "skin", "stretched"),
    ("rate_dependence", "skin", "hunt_crossley"),
    ("hysteresis", "skin", "bouc_wen"),
    ("position_offset", "rig", "constant"),
    ("position_offset", "rig", "warming"),
    ("force_offset", "taxel_0", "constant"),
    ("lag", "taxel_0", "two_pole"),
    ("backlash", "rig", "zeroed"),
]


def test_every_effect_that_may_be_proposed_has_a_cause_with_words():
    assert {e.cause for e in effects() if e.proposed} <= {c.name for c in CAUSES}


@pytest.mark.parametrize(("cause", "where", "form"), rows(FOUND, 2), ids=lambda x: x)
def test_a_hidden_effect_of_the_size_of_the_noise_is_named_at_its_place(tmp_path, cause, where, form):
    found = seek(tmp_path, cause, where=where, form=form, size=1.0, seed=31)
    assert found.right, found.names
    gain = found.findings["findings"][0]["gain"]
    assert gain["held_out_rmse_after"] < gain["held_out_rmse_before"]


def test_a_part_that_lags_is_found_where_damping_takes_what_a_plain_lag_would_explain(tmp_path):
    found = seek(tmp_path, "lag", where="taxel_0", form="partial", size=0.5, seed=706488426)
    assert found.names == [("lag", "taxel")]


@pytest.mark.parametrize("seed", rows(range(6), 2))
def test_silence_when_nothing_is_hidden(tmp_path, seed):
    found = seek(tmp_path, None, seed=500 + seed)
    assert found.names == [] and found.findings["verdict"] == "nothing_wrong", found.names


SLOW_OR_COARSE = [
    ("steps", 897884335, 2, 1.0),  # skin that is left behind presses on its taxels while it recovers
    ("single_sine", 2053141653, 1, 5.0),  # steps of the encoder, passed slowly, under noise that wanders
    ("single_sine", 1532488530, 2, 1.0),
    ("pyramid", 1118048486, 3, 20.0),  # few depths, each off by its own rounding, come back in every session
    ("holds_only", 1820992172, 1, 10.0),
    ("multisine_only", 242645654, 1, 1.0),  # heavy tails
]


@pytest.mark.parametrize(("protocol", "seed", "taxels", "step"), rows(SLOW_OR_COARSE, 2))
def test_silence_on_poor_protocols_too(tmp_path, protocol, seed, taxels, step):
    found = seek(tmp_path, None, seed=seed, protocol=protocol, taxels=taxels, encoder_step_um=step)
    assert found.names == [] and found.findings["verdict"] == "nothing_wrong", found.names


def test_every_cause_is_found_excluded_or_untestable(tmp_path):
    findings = seek(tmp_path, None, seed=3).findings
    said = [e["cause"] for part in ("findings", "excluded", "untestable") for e in findings[part]]
    assert set(said) == {c.name for c in CAUSES}
    json.dumps(findings, allow_nan=False)


def test_a_constant_gain_is_not_excluded_by_one_that_changes_part_way(tmp_path):
    findings = seek(tmp_path, "gain_error", where="load_cell", form="static", size=1.0, seed=3).findings
    bounds = [e for e in findings["excluded"] if (e["cause"], e.get("where")) == ("gain_error", "load_cell")]
    assert bounds and all("after" in e["at"] for e in bounds)
    because = {(e["cause"], e["where"]): e["because"] for e in findings["untestable"] if "where" in e}
    assert "the model's own parameters" in because["gain_error", "load_cell"]


@pytest.mark.campaign
def test_campaign_over_all_causes(tmp_path: Path, capsys):
    """Every cause at the size of the noise: rates with their counts, and most are right."""
    from world.hidden import PLACES

    judged = []
    for cause in PLACES:
        for seed in range(5):
            case = seek(tmp_path / f"{cause}_{seed}", cause, size=1.0, seed=seed, taxels=3 if cause in ("off_centre", "crosstalk") else 1)
            judged.append((cause, case.right, case.extra))
    with capsys.disabled():
        for cause in PLACES:
            own = [r for r in judged if r[0] == cause]
            print(f"{cause:22} found {sum(r[1] for r in own)} of {len(own)}; extra names in {sum(bool(r[2]) for r in own)}")
    assert sum(right for _, right, _ in judged) > 0.6 * len(judged)
