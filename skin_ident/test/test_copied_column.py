"""A column that repeats another is named once, and what it is called after is judged no further."""

from dataclasses import replace

import numpy as np
import pytest
from test_faults import session

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.record import inspect


def sessions(count=3, taxels=1, source="force", depth=True):
    """Sessions whose first taxel repeats `source`, with steps of 2 mN."""

    def one(r):
        rows = np.round(r.taxels[:taxels] / 0.002) * 0.002
        force = np.round(r.force / 0.002) * 0.002
        rows[0] = force if source == "force" else rows[int(source[-1])]
        return replace(r, depth=r.depth if depth else None, force=force, taxels=rows, taxel_names=(), taxel_units=())

    return [one(session(i)) for i in range(count)]


def test_a_copy_of_the_load_cell_is_all_that_is_said_of_the_taxel():
    recordings = sessions()
    findings = diagnose(recordings[:2], recordings[2:]).findings
    assert [(f["cause"], f["where"]) for f in findings["findings"]] == [("data_error", "taxel")] and findings["verdict"] == "explained"
    told = [*findings["excluded"], *findings["untestable"]]
    assert not [e for e in told if str(e.get("where", "")).startswith("taxel")]
    skin = findings["extended"]["parameters"]
    assert skin["k2"]["value"] == pytest.approx(9619.0 + 2766.0, rel=0.01) and "k1" not in skin  # the load cell knows the sum alone


def test_of_two_equal_taxels_the_second_is_not_judged():
    looked = inspect(sessions(2, 3, "taxel_1"))
    assert [s.channels for s in looked.symptoms] == [("taxel_0", "taxel_1")]
    assert set(looked.sessions[0].stuck) == {"taxel_1"}


def test_the_force_that_drives_a_test_leaves_its_copy():
    looked = inspect(sessions(2, 1, "force", depth=False))
    assert [s.cause for s in looked.symptoms] == ["data_error"] and not looked.sessions[0].stuck


def test_a_copy_in_all_but_few_samples_is_a_copy():
    first, *others = sessions()
    force = first.force.copy()
    force[np.argmin(force)] = 1.1 * force.max()
    looked = inspect([replace(first, force=force), *others])
    assert [(s.cause, s.channels) for s in looked.symptoms if s.cause == "data_error"] == [("data_error", ("force", "taxel_0"))]
