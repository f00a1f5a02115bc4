"""The report of every sort of outcome: complete, offline, small, honest about numbers, and written whole or not at all."""

import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
import report_examples as examples

from skin_ident.cli import report as command
from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.report import ReportError, load_outcome, load_traces, save_traces, write_report

VOID = {"meta", "br", "img", "col", "input"}


class Reader(HTMLParser):
    """Checks nesting; collects text, and everything that would be fetched."""

    def __init__(self):
        super().__init__()
        self.open, self.words, self.fetched = [], [], []

    def handle_starttag(self, tag, attributes):
        self.fetched += [v for k, v in attributes if k in ("src", "srcset", "data") or (k == "href" and tag == "link")]
        self.fetched += [v for k, v in attributes if k == "href" and not v.startswith("#")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("style", "script"):
            self.words.append(data)


def read(path) -> Reader:
    reader = Reader()
    reader.feed(path.read_text(encoding="utf-8"))
    assert reader.open == []
    return reader


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    """Every example, written once: name -> (outcome, directory)."""
    made = {}
    for name, example in examples.EXAMPLES.items():
        directory = tmp_path_factory.mktemp(name)
        made[name] = (example(), directory)
        write_report(*made[name])
    return made


@pytest.mark.parametrize("name", examples.EXAMPLES)
def test_page_is_one_small_file_that_fetches_nothing(rendered, name):
    page = rendered[name][1] / "report.html"
    assert page.stat().st_size < 3e6
    assert read(page).fetched == []
    assert "http" not in page.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", examples.EXAMPLES)
def test_no_nan_no_none_no_code_names_reach_the_reader(rendered, name):
    directory = rendered[name][1]
    words = " ".join(read(directory / "report.html").words)
    for told in (words, (directory / "report.md").read_text(encoding="utf-8")):
        assert not re.search(r"\b(nan|NaN|inf|Infinity|None|null|True|False)\b", told)
    assert "stress_relaxation" not in words.replace("stress_relaxation.skin", "")


@pytest.mark.parametrize("name", examples.EXAMPLES)
def test_every_verdict_and_finding_is_said_on_page_and_in_markdown(rendered, name):
    outcome, directory = rendered[name]
    told = [" ".join(read(directory / "report.html").words), (directory / "report.md").read_text(encoding="utf-8")]
    for f in outcome.findings["findings"]:
        assert all(f["cause"].replace("_", " ") in text.lower() for text in told)
    for entry in outcome.findings["excluded"] + outcome.findings["untestable"]:
        assert all(entry["cause"].replace("_", " ") in text.lower() for text in told)
    assert "before_after.png" in told[1]
    assert (directory / "before_after.png").stat().st_size > 20_000
    assert not list(directory.glob("*.partial"))


def test_first_screen_answers_in_numbers(rendered):
    text = (rendered["explained"][1] / "report.md").read_text(encoding="utf-8")
    error = rendered["explained"][0].findings["extended"]["rmse"]["force"]["held_out"]
    assert "# Explained: stress relaxation in the skin" in text
    assert f"{error:.4f}\u00a0N after" in text
    assert "relaxation time 800" in text or "relaxation time 0.800" in text
    assert "**No**, because the skin behaves like this" in text


def test_rivals_stand_beside_the_name_with_the_experiment_that_parts_them(rendered):
    text = (rendered["ambiguous"][1] / "report.md").read_text(encoding="utf-8")
    assert "hysteresis in the skin, stress relaxation in the skin or lag in the taxel" in text
    assert "hold at 0.8 mm for 10 s" in text
    assert "Not before the next experiment" in text  # one rival would be the sensor's fault


def test_one_session_is_called_unproven(rendered):
    text = (rendered["one_session_material_test"][1] / "report.md").read_text(encoding="utf-8")
    assert "**Not proven.**" in text and "second session" in text and "on the data it was fitted to" in text


def test_dead_taxel_asks_for_a_rebuild_and_markup_in_names_stays_text(rendered):
    directory = rendered["six_findings"][1]
    assert "**Yes**, because taxel 3 no longer answers" in (directory / "report.md").read_text(encoding="utf-8")
    assert "<b>not markup</b>" in " ".join(read(directory / "report.html").words)


def test_traces_survive_being_kept(rendered, tmp_path):
    outcome, _ = rendered["six_findings"]
    save_traces(outcome, tmp_path)
    traces, scans, rounds = load_traces(tmp_path)
    assert scans == () and rounds == outcome.rounds
    for kept, was in zip(traces, outcome.traces, strict=True):
        assert (kept.session, kept.held_out, kept.channels) == (was.session, was.held_out, was.channels)
        assert np.allclose(kept.measured, was.measured, rtol=1e-6, atol=1e-6) and np.array_equal(kept.t, was.t)


@pytest.mark.parametrize("name", ["explained", "spread_scan"])
def test_report_renders_the_same_page_again_from_its_directory(rendered, tmp_path, name, capsys):
    outcome, first = rendered[name]
    save_traces(outcome, tmp_path)
    (tmp_path / "findings.json").write_text(json.dumps(outcome.findings), encoding="utf-8")
    assert command.report([str(tmp_path)]) == 0
    assert capsys.readouterr().out.strip().endswith("report.html")
    assert (tmp_path / "report.md").read_text(encoding="utf-8") == (first / "report.md").read_text(encoding="utf-8")


def test_a_report_written_elsewhere_names_the_folder_of_the_diagnosis(rendered, tmp_path):
    (tmp_path / "findings.json").write_text(json.dumps(rendered["ambiguous"][0].findings), encoding="utf-8")
    assert command.report([str(tmp_path), "--out", str(tmp_path / "rr")]) == 0
    words = " ".join(read(tmp_path / "rr" / "report.html").words)
    assert f"Load model.yaml, in {tmp_path.resolve()}, into" in words and f"In {tmp_path.resolve()}: findings.json" in words
    assert "Beside this file: report.md and pictures (for a mail)." in words and "beside this report" not in words


def test_findings_without_curves_still_make_a_report(rendered, tmp_path):
    (tmp_path / "findings.json").write_text(json.dumps(rendered["explained"][0].findings), encoding="utf-8")
    (tmp_path / "before_after.png").write_bytes(b"of an earlier report")
    write_report(load_outcome(tmp_path), tmp_path)
    read(tmp_path / "report.html")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["findings.json", "report.html", "report.md"]


@pytest.mark.parametrize(
    "content",
    ["", "[]", "{}", '{"schema": 2, "verdict": "explained"}', '{"schema": 1, "verdict": "explained", "findings": "x"}', "\udcff"],
)
def test_unusable_directories_get_one_sentence_and_status_2(tmp_path, monkeypatch, capsys, content):
    if content:
        (tmp_path / "findings.json").write_bytes(content.encode("utf-8", "surrogateescape"))
    monkeypatch.setattr("sys.argv", ["report", str(tmp_path)])
    assert command.main() == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ") and said.count("\n") == 1
    assert {p.name for p in tmp_path.iterdir()} <= {"findings.json"}


@pytest.mark.parametrize("damage", [b"", b"not a zip", "cut"])
def test_damaged_curves_get_one_sentence(rendered, tmp_path, damage):
    outcome, _ = rendered["spread_scan"]
    path = save_traces(outcome, tmp_path)
    path.write_bytes(path.read_bytes()[:700] if damage == "cut" else damage)
    (tmp_path / "findings.json").write_text(json.dumps(outcome.findings), encoding="utf-8")
    with pytest.raises(ReportError, match=r"traces\.npz"):
        load_outcome(tmp_path)


@pytest.mark.parametrize("other", [{"format": 2}, {"rounds": [3]}, "rounds", "format"])
def test_curves_of_another_version_get_one_sentence(rendered, tmp_path, other):
    path = save_traces(rendered["explained"][0], tmp_path)
    with np.load(path) as held:
        arrays = dict(held)
    content = json.loads(str(arrays["_content"]))
    content = {k: v for k, v in content.items() if k != other} | (other if isinstance(other, dict) else {})
    np.savez(path, **arrays | {"_content": np.array(json.dumps(content))})
    with pytest.raises(ReportError, match="damaged or of another version"):
        load_traces(tmp_path)


def test_nothing_is_left_behind_when_drawing_fails(rendered, tmp_path):
    outcome, _ = rendered["spread_scan"]
    (tmp_path / "report.html.partial").mkdir()  # cannot be opened for writing
    with pytest.raises(ReportError, match="cannot write the report"):
        write_report(outcome, tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["report.html.partial"]


SPARSE = [
    {"schema": 1, "verdict": "nothing_wrong"},
    {"schema": 1, "verdict": "something_new", "findings": [{}], "baseline": None, "excluded": [{}], "untestable": [{}], "recordings": None},
    {
        "schema": 1, "verdict": "explained",
        "findings": [
            {"cause": "future_cause", "where": "moon", "parameters": {"q": 1.0, "r": {"value": float("nan")}},
             "gain": {"held_out_rmse_before": 0.0, "held_out_rmse_after": float("inf"), "ci95": [None, None]},
             "alternatives": ["lag"], "separating_experiment": {"profile": "hold", "depth_mm": 0.8}},
        ],
    },
]  # fmt: skip


@pytest.mark.parametrize("findings", SPARSE)
def test_sparse_and_unheard_of_findings_are_reported_without_a_crash(tmp_path, findings):
    write_report(Outcome(findings), tmp_path)
    words = " ".join(read(tmp_path / "report.html").words)
    assert not re.search(r"\b(nan|inf|None)\b", words)


def test_faults_of_the_record_are_said_to_need_no_model(rendered):
    text = (rendered["seen_in_the_record"][1] / "report.md").read_text(encoding="utf-8")
    assert "**Seen directly in the record.**" in text and "**No change** the named faults are in the record" in text
    assert "Taxel 1 holds one value throughout." in text and "dead taxel 1 and quantization in the load cell" in text
    assert "41.0\u00a0N/m – stiffness of the relaxing arm (felt by taxels), at relaxation time 0.500\u00a0s" in text
