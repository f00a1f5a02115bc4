"""The gallery: every effect has a picture in which it does something, and a bad place to write it is one sentence."""

import html.parser

import numpy as np
import pytest

from skin_models.catalogue import effects
from skin_models.gallery.__main__ import main
from skin_models.gallery.drawing import png
from skin_models.gallery.page import page
from skin_models.gallery.scene import pictures


@pytest.fixture(scope="module")
def shown():
    return list(pictures())


def test_every_effect_is_seen_to_do_something(shown):
    assert [type(p.effect) for p in shown] == list(effects())
    for p in shown:
        change = np.abs(p.with_it - p.without)[p.seen].max()
        assert np.isfinite(change) and change > 0.02, p.effect


def test_a_picture_is_a_png(shown):
    assert png(shown[0]).startswith(b"\x89PNG")


def test_the_page_names_what_it_shows_and_needs_nothing_else(shown):
    text = page(shown[:3])
    html.parser.HTMLParser().feed(text)
    assert all(p.effect.cause in text for p in shown[:3])
    assert "http" not in text.replace("http-equiv", "") and text.count("<img") == 4


@pytest.mark.parametrize("out", ["nowhere/page.html", "."])
def test_a_place_that_cannot_be_written_is_one_sentence_and_status_2(out, tmp_path, capsys):
    assert main([str(tmp_path / out)]) == 2
    assert capsys.readouterr().err.count("\n") == 1 and not any(tmp_path.iterdir())


@pytest.mark.parametrize(("name", "kept"), [("session_1.csv", "t_s,x_mm\n0,1\n"), ("report.html", "<title>Robot skin</title>")])
def test_only_an_earlier_gallery_is_overwritten(name, kept, tmp_path, capsys):
    (tmp_path / name).write_text(kept)
    assert main([str(tmp_path / name)]) == 2
    assert capsys.readouterr().err.count("\n") == 1 and (tmp_path / name).read_text() == kept


def test_a_gallery_is_drawn_again_over_an_earlier_one(tmp_path, monkeypatch, shown):
    monkeypatch.setattr("skin_models.gallery.scene.pictures", lambda say: iter(shown[:2]))
    assert [main([str(tmp_path / "a.html")]) for _ in range(2)] == [0, 0]


@pytest.mark.parametrize("terminal", [True, False])
def test_the_wait_is_told_of_on_stderr(tmp_path, monkeypatch, shown, capsys, terminal):
    monkeypatch.setattr("sys.stderr.isatty", lambda: terminal)
    monkeypatch.setattr("skin_models.gallery.scene._channel", lambda model, e, s: shown[0].without)
    monkeypatch.setattr("skin_models.gallery.page.png", lambda p: b"")
    monkeypatch.setattr("skin_models.gallery.page.overview", lambda shown: b"")
    assert main([str(tmp_path / "a.html")]) == 0
    said = capsys.readouterr()
    count = len(effects())
    assert f"simulating 1 of {count} effects: " in said.err
    if terminal:  # one line, which is written again and again, and is gone at the end
        assert f"simulating {count} of {count}" in said.err and "drawing 2 of" in said.err
        assert "\n" not in said.err and said.err.endswith("\r\033[K")
    else:
        assert 1 <= said.err.count("\n") <= 3 and "\r" not in said.err
    assert said.out == f"wrote {tmp_path / 'a.html'}\n"
