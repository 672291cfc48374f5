# SPDX-License-Identifier: BSD-3-Clause
"""Words in figures: Japanese ones have a font, or a word about it where none is installed."""

import logging
import warnings
from types import SimpleNamespace

import pytest
from matplotlib import font_manager

from session_log.report.figures import fonts
from session_log.report.figures.drawing import draw
from session_log.report.figures.style import new_figure

STOP = "\u6b62\u307e\u308c"


class Words:
    """A figure of some words."""

    name, title = "words", "Words"

    def __init__(self, words):
        self.words = words

    def can_draw(self, material):
        return True

    def caption(self, material):
        return ""

    def draw(self, material, layout):
        figure = new_figure(layout, 1.0)
        figure.text(0.1, 0.5, self.words)
        return figure


@pytest.fixture(autouse=True)
def unsaid(monkeypatch):
    monkeypatch.setattr(fonts, "_said", set())
    fonts.families.cache_clear()
    yield
    fonts.families.cache_clear()


@pytest.fixture
def without_japanese(monkeypatch):
    usual = [font for font in font_manager.fontManager.ttflist if font.name == fonts.USUAL]
    monkeypatch.setattr(font_manager.fontManager, "ttflist", usual)
    monkeypatch.setattr(font_manager, "findSystemFonts", lambda: [])


def drawn(words, tmp_path, config, caplog):
    with warnings.catch_warnings(record=True) as shown, caplog.at_level(logging.WARNING):
        warnings.simplefilter("always")
        draw([Words(words)], None, tmp_path, config)
    assert not shown
    return caplog.messages


def test_japanese_words_have_an_installed_font(tmp_path, report_config, caplog):
    if len(fonts.families()) == 1:
        pytest.skip("no Japanese font: apt install fonts-ipafont-gothic")
    assert fonts.families()[0] == fonts.USUAL and fonts.families()[1] in fonts.JAPANESE
    assert not drawn(STOP, tmp_path, report_config, caplog)


@pytest.mark.usefixtures("without_japanese")
def test_without_a_font_the_package_is_named_once(tmp_path, report_config, caplog):
    assert fonts.families() == [fonts.USUAL]
    for _ in range(2):
        (line,) = drawn(STOP, tmp_path, report_config, caplog)
    assert "fonts-ipafont-gothic" in line and STOP[0] in line


@pytest.mark.usefixtures("without_japanese")
def test_words_that_have_a_font_need_no_word_about_it(tmp_path, report_config, caplog):
    assert not drawn("pr\u00eat, \u00fcber", tmp_path, report_config, caplog)


def test_a_character_of_no_font_is_named_without_a_package(tmp_path, report_config, caplog):
    (line,) = drawn("\U00013080", tmp_path, report_config, caplog)
    assert "\U00013080" in line and "package" not in line


def test_a_font_that_came_after_the_list_of_fonts_is_found(monkeypatch):
    files = ["/fonts/x.ttf", "/fonts/TakaoGothic.ttf"]
    added = []
    manager = SimpleNamespace(ttflist=[], addfont=added.append)
    monkeypatch.setattr(font_manager, "fontManager", manager)
    monkeypatch.setattr(font_manager, "findSystemFonts", lambda: files)
    assert fonts.families() == [fonts.USUAL, "TakaoGothic"] and added == files[1:]
    manager.ttflist = [SimpleNamespace(name="TakaoGothic"), SimpleNamespace(name="IPAGothic")]
    fonts.families.cache_clear()
    assert fonts.families() == [fonts.USUAL, "IPAGothic"]


def test_other_warnings_are_passed_on():
    with pytest.warns(UserWarning, match="another"), fonts.glyphs_named_once():
        warnings.warn("another", UserWarning, stacklevel=1)
