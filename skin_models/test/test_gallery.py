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
