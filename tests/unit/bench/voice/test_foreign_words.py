# SPDX-License-Identifier: BSD-3-Clause
"""Words of other languages that measure are none that train."""

from bench.voice.material.foreign_words import LANGUAGES, NAMED
from voice_assist.training.data import texts
from voice_assist.training.data.foreign_words import WORDS
from voice_assist.training.data.texts import phrases


def measured():
    parts = (part for one in LANGUAGES.values() for part in (one.near, one.words, one.talk))
    return {text for part in parts for text in part.split("|")}


def test_no_word_is_in_both_lists():
    assert measured().isdisjoint(word for words in WORDS.values() for word in phrases(words))


def test_no_word_is_a_command():
    every = measured().union(*map(phrases, WORDS.values()))
    assert every.isdisjoint(texts.COMMANDS) and "" not in every


def test_the_words_of_the_requirement_are_measured_in_their_language():
    for voice, word in NAMED:
        assert any(one.voice == voice and word in one.near.split("|") for one in LANGUAGES.values())
