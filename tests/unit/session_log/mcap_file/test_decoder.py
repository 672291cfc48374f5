# SPDX-License-Identifier: BSD-3-Clause
import pytest

from session_log.mcap_file.decoder import Decoder, Undecodable
from session_log.types import Message, MessageSource
from support.message_classes import class_of, serialise, source_of


def test_a_message_is_decoded_by_the_definition_in_the_file():
    made = class_of("voice_assist/Utterance")(phrases=["stop", "tense"], wer=[0.0, 1.0])
    made.speech_end.secs = 5
    source = source_of("/u", "voice_assist/Utterance")
    found = Decoder().decode(Message(source, serialise(made), 1, 1))
    assert (found.phrases, list(found.wer), found.speech_end.secs) == (["stop", "tense"], [0, 1], 5)


@pytest.mark.parametrize(
    ("definition", "data"),
    [("float64 x", b"\xff\0"), ("float64[] x", b"\xff\0\0\0short"), ("no definition", b"")],
)
def test_what_does_not_fit_its_definition_is_named(definition, data):
    message = Message(MessageSource("/odd", "odd_msgs/Odd", "", definition), data, 1, 1)
    with pytest.raises(Undecodable, match="/odd: not a odd_msgs/Odd"):
        Decoder().decode(message)


def test_a_message_of_another_encoding_is_not_taken_for_one_of_ros_1():
    source = MessageSource("/t", "std_msgs/String", "", "string data", message_encoding="cdr")
    with pytest.raises(Undecodable, match="'cdr' with schema 'ros1msg', only 'ros1' with"):
        Decoder().decode(Message(source, b"\1\0\0\0x", 1, 1))
