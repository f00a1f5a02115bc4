"""Two columns of an array that are exchanged in all sessions are found and put right; no other cause in the ratios is taken for that."""

from dataclasses import replace

import numpy as np
import pytest
from array_making import Spread, found, names, record, record_at

from skin_ident.criticism.array.exchanged import put_right
from skin_ident.criticism.array.layout import layout_of

ALONG = ((0, 0), (4, 0), (-4, 0))
SHORT = {"protocol": "pyramid", "noise": "white", "thickness_mm": 4, "layout": "row_5mm"}


def exchanged(recordings, i=0, j=1):
    order = np.arange(len(recordings[0].taxels))
    order[[i, j]] = j, i
    return [replace(r, taxels=r.taxels[order]) for r in recordings]


def asked(recordings):
    return put_right(recordings, layout_of(recordings))


@pytest.mark.parametrize(("taxels", "pair"), [(3, (0, 1)), (4, (1, 3))])
@pytest.mark.parametrize("contacts", [ALONG, ((1, 0),) * 3], ids=["several", "one"])
def test_exchanged_columns_are_put_right(tmp_path, taxels, pair, contacts):
    recordings = record_at(tmp_path, contacts, seed=3, taxels=taxels, **SHORT)
    right, (symptom,) = asked(exchanged(recordings, *pair))
    assert (symptom.cause, symptom.where, symptom.channels) == ("data_error", "taxel", tuple(f"taxel_{i}" for i in pair))
    assert all(np.array_equal(a.taxels, b.taxels) for a, b in zip(right, recordings, strict=True))


@pytest.mark.parametrize("session", [0, 2])
def test_columns_that_are_exchanged_in_one_session_of_several_places_are_put_right(tmp_path, session):
    recordings = record_at(tmp_path, ALONG, seed=3, taxels=3, **SHORT)
    mixed = [exchanged([r], 0, 2)[0] if i == session else r for i, r in enumerate(recordings)]
    right, (symptom,) = asked(mixed)
    assert symptom.channels == ("taxel_0", "taxel_2")
    assert symptom.evidence["session"] == recordings[session].name
    assert all(np.array_equal(a.taxels, b.taxels) for a, b in zip(right, recordings, strict=True))


@pytest.mark.parametrize(
    ("cause", "form", "where", "size"),
    [
        (None, None, None, 1.0),
        ("off_centre", "shift", None, 8.0),
        ("gain_error", "static", "taxel_0", 20.0),
        ("crosstalk", "neighbour", "taxel", 8.0),
        ("crosstalk", "common", "taxel", 8.0),
    ],
)
def test_no_other_cause_is_taken_for_an_exchange(tmp_path, cause, form, where, size):
    for seed in range(2):
        for name, contacts in (("several", ALONG), ("one", ((0, 0),) * 2)):
            recordings = record_at(tmp_path / f"{name}_{seed}", contacts, cause, form, where, size, seed, **SHORT)
            assert not asked(recordings)[1]


@pytest.mark.parametrize("layout", ["row_5mm", "aside"])
def test_taxels_that_were_not_tared_are_not_taken_for_exchanged_ones(tmp_path, layout):
    recordings = record(tmp_path, seed=500, protocol="full", layout=layout)
    zeros = np.array([-1.92, -2.08, 1.85])[:, None]
    assert not asked([replace(r, taxels=r.taxels + zeros) for r in recordings])[1]


@pytest.mark.slow
def test_neither_are_silent_taxels_gains_or_a_spread_of_another_shape(tmp_path):
    recordings = record_at(tmp_path / "plain", ALONG, seed=1, taxels=4, **SHORT)
    for gains in ((1.0, 0.0, 1.0, 1.0), (0.0, 1.0, 1.0, 1.0), (1.0, 1.0, 0.4, 1.0), (3.0, 1.0, 1.0, 1.0)):
        assert not asked([replace(r, taxels=np.array(gains)[:, None] * r.taxels) for r in recordings])[1]
    for kind in ("wider", "flat"):
        assert not asked(record_at(tmp_path / kind, ALONG, seed=1, also=[(Spread(kind), 0.4)], **SHORT))[1]


def test_it_is_the_finding_and_the_rest_of_the_array_is_judged_put_right(tmp_path):
    findings = found(exchanged(record(tmp_path, seed=4, **SHORT)))
    assert names(findings) == [("data_error", "taxel")] and findings["verdict"] == "explained"
    assert "taxel_0 and taxel_1 are exchanged" in findings["findings"][0]["evidence"]["why"]
    assert ("off_centre", "rig") in {(e["cause"], e.get("where")) for e in findings["excluded"]}
