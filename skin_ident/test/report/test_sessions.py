"""Sessions are told from each other: a table of what each says by itself, what stands out, and where most is left."""

import numpy as np
import pytest
import report_examples as examples
from test_faults import session

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telling.by_session import louder_than_others, most_left, standing_out
from skin_ident.report.appendix import bound
from skin_ident.report.markdown import markdown
from skin_ident.report.page import page
from skin_ident.report.sessions import by_session
from skin_ident.report.story import tell

NAMES = ("day10.csv", "day2.csv", "day5.csv", "day7.csv", "day12.csv")


def entry(k: float, error: float, *, held=False, out=()) -> dict:
    own = {"stiffness": {"force": {"value": k, "unit": "N/m", "std": 2.0}}, "recovery": {}, "zero": {"force": q(1e-3)}}
    return {
        "samples": 10, "held_out": held, "by_itself": own, "rmse": {"force": {"baseline": 0.05, "extended": error, "unit": "N"}},
        "stands_out": list(out),
    }  # fmt: skip


def q(value: float) -> dict:
    return {"value": value, "unit": "N", "std": 5e-4}


def told(verdict: str, rows: list[dict]):
    outcome = examples.unexplained()
    rows = [{"name": n, **r} for n, r in zip(NAMES, rows, strict=True)]
    rest = {"systematic_rest": most_left({r["name"]: r for r in rows if "rmse" in r}), "verdict": verdict}
    return tell(examples.replace(outcome, findings={**outcome.findings, "recordings": rows, **rest}))


def test_sessions_stand_in_their_order_and_what_stands_out_is_marked():
    rows = [entry(5000.0, 0.002), entry(5001.0, 0.002), entry(5000.0, 0.002, out=["stiffness.force"]), entry(4999.0, 0.002)]
    all_ = told("nothing_wrong", [*rows, entry(5000.0, 0.002, held=True)])
    table = by_session(all_.view)
    assert table.names == ("day2.csv", "day5.csv", "day7.csv", "day10.csv", "day12.csv") and not table.said
    html, text = page(all_), markdown(all_)
    assert '<section id="sessions">' in html and '<b class="odd">5000' in html and "| day12.csv (held out) |" in text
    assert "by itself" not in html.lower() and "Most of what is left" not in text  # nor among what else a recording is said to have


def test_sessions_without_numbers_are_reported_all_the_same():
    rows = [entry(5000.0, 0.002), entry(5001.0, 0.002), entry(5002.0, 0.002), entry(5000.0, 0.002), entry(5000.0, 0.002)]
    for row in rows:
        row["by_itself"]["zero"]["force"] = q(None)
    rows[0]["by_itself"]["stiffness"]["force"]["value"] = None
    del rows[1]["rmse"]
    rows[2]["rmse"] = {}
    text = markdown(told("explained", rows))
    assert [column.head for column in by_session(told("explained", rows).view).own] == ["stiffness of the force, N/m"]
    assert "| day5.csv | 5002" in text and "None" not in text and "nan" not in text


def test_how_a_number_goes_from_session_to_session_is_said_below_the_table():
    rows = [entry(k, 0.002) for k in (5100.0, 5000.0, 5001.0, 5100.0, 5101.0)]
    said = by_session(told("explained", rows).view).said
    assert said == ("The stiffness of the force steps by +2.0 % at day7, from −2.0 % to +0.0 % of its median.",)


def both(k: float, taxel: float) -> dict:
    """A session in which force and taxel are so stiff, N/m."""
    row = entry(k, 0.002)
    numbers = {"force": k, "taxel_0": taxel}
    row["by_itself"]["stiffness"] = {c: {"value": x, "unit": "N/m", "std": 1.0} for c, x in numbers.items()}
    return {**row, "by_itself": {**row["by_itself"], "ratio": {"taxel_0": {"value": k / taxel, "unit": "1", "std": 1e-3}}}}


def test_what_changes_from_session_to_session_is_on_the_first_screen_where_no_finding_says_it():
    """A force that is read too large is told from a skin that is stiffer."""

    def said(rows) -> str:
        return " ".join(w.means for w in told("nothing_wrong", rows).story.wrong if w.name == "From session to session")

    days = (1.03, 1.0, 1.0, 1.03, 1.03)
    gain = said([both(5000.0 * x, 2500.0) for x in days])
    assert gain.startswith("The force over taxel 0 steps by +2.9 % at day7") and "the gain of one of the two" in gain
    skin = said([both(5000.0 * x, 2500.0 * x) for x in days])
    assert skin.startswith("The stiffness of the force steps by +2.9 % at day7") and "no gain" in skin
    assert said([both(5000.0, 2500.0 + x) for x in days]) == ""
    story = told("nothing_wrong", [both(5000.0 * x, 2500.0) for x in days]).story
    assert "change from session to session" in story.headline.line and "Nothing else" in story.wrong[-2].means


@pytest.mark.parametrize("verdict", ["unexplained", "partly_explained", "explained"])
def test_the_first_screen_names_the_sessions_in_which_most_is_left(verdict):
    rows = [entry(5000.0, error) for error in (0.0095, 0.003, 0.003, 0.003, 0.003)]
    said = " ".join(w.means for w in told(verdict, rows).story.wrong)
    what = "Most of what is left of the force is in day10: 3.2 times as much as in the other sessions."
    assert (what in said) == (verdict != "explained")


def test_without_numbers_of_sessions_nothing_is_said_of_them():
    all_ = told("unexplained", [{"samples": 10}] * 5)
    assert by_session(all_.view) is None and '<section id="sessions">' not in page(all_)


def test_a_gain_that_is_seen_at_any_scale_is_told_with_its_own_numbers():
    """Held-out sessions are stiffer by a factor: their plain error rises with the cause in the model, and falls at any scale."""
    outcome = examples.explained()
    content = outcome.findings
    finding = {**content["findings"][0], "evidence": {"held_out": "battery_3, at any scale"}}
    finding["gain"] = {
        "held_out_rmse_before": 0.6, "held_out_rmse_after": 0.06, "ci95": [0.5, 0.58], "channel": "force", "unit": "N",
    }  # fmt: skip
    raw = {"held_out_rmse_before": 0.62, "held_out_rmse_after": 0.99, "ci95": [-0.5, -0.2], "channel": "force", "unit": "N"}
    rmse = {"force": {"train": 0.6, "held_out": 0.62, "unit": "N"}}, {"force": {"train": 0.06, "held_out": 0.99, "unit": "N"}}
    models = {k: {**content[k], "rmse": r} for k, r in zip(("baseline", "extended"), rmse, strict=True)}
    content = {**content, "findings": [finding], **models, "gain_by_channel": {"force": {**raw, "tested_on": "battery_3"}}}
    all_ = tell(examples.replace(outcome, findings=content))
    told_ = all_.story.better
    assert told_.number == "90\u00a0%" and told_.caption.startswith("less error") and told_.caption.endswith("fitted to each session")
    assert "0.50 to 0.58" in told_.sentences[1] and "0.990\u00a0N after" in told_.sentences[2]
    assert "with a scale factor fitted to each session; those errors" in page(all_)
    plainly = {**raw, "held_out_rmse_after": 0.2, "ci95": [0.3, 0.5]}
    content["gain_by_channel"] = {"force": {**plainly, "tested_on": "battery_3"}}
    content["extended"]["rmse"] = {"force": {"train": 0.06, "held_out": 0.2, "unit": "N"}}
    assert "scale" not in tell(examples.replace(outcome, findings=content)).story.better.caption


def test_a_step_that_was_ruled_out_is_one_within_a_session():
    step = {"cause": "gain_error", "where": "load_cell", "parameter": "gain", "below": 0.0048, "unit": "1", "form": "step"}
    assert bound(step).startswith("0.00480 (a step within a session)") and "(leaky)" in bound({**step, "form": "leaky"})


def test_one_odd_number_stands_out_and_two_levels_do_not():
    std = np.full(6, 0.5)
    assert standing_out(np.array([100.0, 101.0, 99.0, 100.5, 120.0, 99.5]), std).tolist() == [False] * 4 + [True, False]
    assert not standing_out(np.array([100.0, 101.0, 99.0, 120.5, 120.0, 119.5]), std).any()
    assert not standing_out(np.array([100.0, 100.0, 120.0]), std[:3]).any()
    assert not standing_out(np.array([100.0, 100.1, 100.0, 100.0, 100.3, 100.0]), 0.01 * std, 0.005).any()


def test_most_is_left_in_some_sessions_only_where_clearly_more_is():
    assert list(louder_than_others({"a": 1.0, "b": 1.2, "c": 1.1, "d": 1.4})) == []
    ((names, times),) = louder_than_others({"a": 1.0, "b": 4.0, "c": 1.0, "d": 3.0})
    assert names == ["b", "d"] and times == pytest.approx(3.54, abs=0.01)


@pytest.mark.slow
def test_taxels_that_read_more_on_one_day_are_seen_in_what_it_says_by_itself():
    made = [session(i, lambda y, rng, i=i: y * (1.03 if i == 2 else 1.0)) for i in range(5)]
    told_ = {r["name"]: r for r in diagnose(made[:4], made[4:]).findings["recordings"]}
    stiff = {n: r["by_itself"]["stiffness"] for n, r in told_.items()}
    (taxel,) = (channel for channel in stiff["session_0"] if channel != "force")
    for channel, factor in (("force", 1.0), (taxel, 1.03)):
        others = [stiff[f"session_{i}"][channel]["value"] for i in (0, 1, 3, 4)]
        assert stiff["session_2"][channel]["value"] == pytest.approx(factor * np.median(others), rel=5e-3)
    assert [n for n, r in told_.items() if f"stiffness.{taxel}" in r["stands_out"]] == ["session_2"]
    assert all(abs(z["value"]) < 6.0 * z["std"] + 1e-3 for r in told_.values() for z in r["by_itself"]["zero"].values())


def test_a_session_whose_taxels_are_hardly_heard_says_what_its_force_does():
    def stuck(y, rng):
        return np.where(np.arange(y.shape[1]) > 0.2 * y.shape[1], y[:, :1], y)

    made = [session(i, *([stuck] if i == 1 else [])) for i in range(4)]
    told_ = {r["name"]: r for r in diagnose(made[:3], made[3:]).findings["recordings"]}
    assert list(told_["session_1"]["by_itself"]["stiffness"]) == ["force"]
    assert "force" in told_["session_0"]["by_itself"]["stiffness"] and len(told_["session_0"]["by_itself"]["stiffness"]) == 2
