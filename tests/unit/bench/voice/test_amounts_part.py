# SPDX-License-Identifier: BSD-3-Clause
"""How the bench of amounts counts: what is wrong, what is right, what is asked for."""

from bench.voice import amounts
from bench.voice.material.held_out_voices import SyntheticVoice
from voice_assist.config import load_voice_config
from voice_assist.intent.mapper import Mapper
from voice_assist.types import Match

TWO, THREE = "pull two millimetres more", "pull three millimetres more"
TEN = "pull ten millimetres more"


def clip(text, taken):
    return amounts.HeardClip(text, "espeak:en-us", text, taken, 0.5, 2.0)


def test_near_misses_are_no_commands_even_where_they_are_heard_to_the_letter():
    mapper = Mapper(load_voice_config(commands__amounts=True).commands)
    for text in amounts.NEAR:
        assert not isinstance(mapper(text), Match), text
    assert {phrase for phrase in amounts.texts().values() if phrase} >= {TWO, THREE}


def test_a_wrong_amount_is_wrong_though_it_is_only_asked_for():
    assert amounts.is_wrong(TWO, f"{amounts.LARGEST} {THREE}") and amounts.is_wrong("", TWO)
    assert not amounts.is_wrong(THREE, f"{amounts.LARGEST} {THREE}")
    assert not amounts.is_wrong(TWO, "") and not amounts.is_wrong(TWO, "stop")


def test_shares_are_counted_by_what_was_said():
    heard = [(TWO, TWO), (TWO, ""), (THREE, f"{amounts.LARGEST} {THREE}"), (TWO, THREE)]
    heard += [(TEN, ""), (TEN, TWO), (TEN, "pull more")]
    clips = [clip(text, taken) for text, taken in heard]
    *found, cost = amounts.figures(clips)
    counts = [figure.note.split(";")[0] for figure in found]
    assert counts == ["2 of 7", "1 of 3", "2 of 4", "1 of 2", "1 of 7"]
    assert (cost.value, cost.unit, cost.note) == (0.5, "s", "of 2.0 s of sound")
    odd = amounts.wrong_or_taken(clips)
    assert odd == {f"{TWO} -> {THREE}": 1, f"{TEN} -> {TWO}": 1, f"{TEN} -> pull more": 1}


def test_every_piece_holds_as_many_near_misses_as_amounts_and_none_twice():
    blocks = amounts.plan([SyntheticVoice("espeak", name) for name in ("one", "two")])
    assert sum(map(len, blocks)) <= amounts.COUNT and len({p for b in blocks for p in b}) > 0
    for block in blocks[:-1]:
        said = sum(bool(amounts.texts()[prompt.text]) for prompt in block)
        assert (said, len(block)) == (amounts.BLOCK // 2, amounts.BLOCK)
    every = [prompt for block in blocks for prompt in block]
    assert len(set(every)) == len(every)
