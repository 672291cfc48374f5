# SPDX-License-Identifier: BSD-3-Clause
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voice_assist.config import load_voice_config
from voice_assist.intent.mapper import Mapper
from voice_assist.text.normalize import normalize
from voice_assist.text.spoken_reply import LEFT_ALONE, spoken_reply
from voice_assist.types import NoMatch

COMMANDS = load_voice_config().commands
WORDS = {w for p in COMMANDS.phrases for w in normalize(p) if len(w) >= LEFT_ALONE}


@pytest.mark.parametrize(
    ("message", "said"),
    [
        ("reaches, grasps and pulls to 2.00 N", "reaches, grasps and draws to 2.00 newton"),
        ("pulls less: 2.50 N to 2.00 N", "draws back: 2.50 newton to 2.00 newton"),
        ('stops and holds; say "hey robot" to go on', "halts and holds"),
        ('halted (stop was said); say "hey robot" to go on', "halted"),
        (
            'nothing grasped; "pull more" needs tissue between the jaws',
            "nothing grasped; needs tissue between the jaws",
        ),
        ("unknown command 'more light'; say one of: hey robot, stop", "unknown command"),
        ("pulled 12.0 mm, allowed 10 N", "drawn 12.0 millimetres, allowed 10 newton"),
        ("the robot doesn't answer", "the arm doesn't answer"),
        ("pull more?", "draws further?"),
        ("stop", "halts"),
        ('say "hey robot"', ""),
        ("", ""),
    ],
)
def test_replies_are_said_without_commands(message, said):
    assert spoken_reply(message, COMMANDS.phrases) == said


@given(st.lists(st.sampled_from([*sorted(WORDS), "to", "N", "2.0", "(", ")", '"', "'", ";", "is"])))
def test_no_word_of_a_command_is_ever_left(words):
    said = spoken_reply(" ".join(words), COMMANDS.phrases)
    assert not WORDS & set(normalize(said))
    assert isinstance(Mapper(COMMANDS)(said), NoMatch)


@given(st.text())
def test_any_text_is_taken(text):
    assert not WORDS & set(normalize(spoken_reply(text, COMMANDS.phrases)))


def test_words_of_a_labs_own_commands_are_left_out():
    assert spoken_reply("the suction is on", ("suction on",)) == "the is on"
