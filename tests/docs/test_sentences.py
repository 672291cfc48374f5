# SPDX-License-Identifier: BSD-3-Clause
"""The command that reports long sentences finds them, and only them."""

import pytest

from support.documents.sentences import main, sentences, too_long

LONG = "Word " + "word " * 24 + "end."


def test_a_sentence_of_26_words_is_too_long_and_one_of_25_is_not():
    assert [words for words, _ in too_long(f"Short. {LONG} Short.")] == [26]
    assert not too_long("Word " + "word " * 23 + "end.")


def test_code_headings_generated_parts_and_cells_do_not_count_as_sentences():
    text = f"# {LONG}\n```\n{LONG}\n```\n<!-- generated: a -->\n{LONG}\n<!-- end of generated -->\n"
    assert not too_long(text)
    assert list(sentences("| one | two, [three](x.md) |\n|---|---|\n")) == ["one", "two, three"]


def test_items_of_a_list_are_sentences_of_their_own():
    assert list(sentences("A list:\n\n- one\n- two\n1. three")) == [
        "A list:",
        "one",
        "two",
        "three",
    ]


def test_the_command_names_page_words_and_beginning(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("support.documents.sentences.ROOT", tmp_path)
    (tmp_path / "page.md").write_text(LONG)
    assert main([str(tmp_path / "page.md")]) == 1
    shown = capsys.readouterr().out
    assert shown.startswith("page.md: 26 words: Word word")
    assert shown.endswith("1 sentences have more than 25 words\n")


def test_it_says_how_it_is_used(capsys):
    with pytest.raises(SystemExit, match="0"):
        main(["--help"])
    assert "[PAGE ...]" in capsys.readouterr().out
