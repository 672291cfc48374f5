# SPDX-License-Identifier: BSD-3-Clause
"""What is fuzzed: functions of any bytes that raise only where something is wrong with our code.

Each has an exact statement of what must hold beside "it does not crash". The tests run them, too,
with random bytes and with every input that ever broke one.
"""

import logging
import math
import socket
import struct
from contextlib import suppress
from io import BytesIO

import numpy as np
import rosgraph.network
from actionlib_msgs.msg import GoalID
from genpy import DeserializationError, SerializationError
from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_pubsub import TCPROSSub
from rospy.impl.tcpros_service import TCPService
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Empty, String, Time
from std_srvs.srv import TriggerRequest

from rst_control.admission.callers import MAX_CALLERS, CallLimiter
from rst_control.admission.command_queue import CommandQueue
from rst_control.commands.parser import MAX_LENGTH, is_stop, read_command, unknown
from rst_control.commands.table import COMMANDS
from rst_control.config.callers import CallersConfig
from rst_control.msg import AssistActionGoal, ControllerState, Event
from rst_control.ros.common.serialization import BadMessage, JointStateReader, read_force
from rst_control.ros.controller.services.command_service import WordsCommand
from rst_control.ros.rospy_patches.message_framing import has_whole_header, split_messages
from rst_control.ros.rospy_patches.message_limits import _read_messages
from rst_control.srv import CommandRequest, FitTrocarRequest, SetTrocarRequest
from rst_control.types import JOINTS
from tests.fuzz.names import NAMES
from tests.support.null_executor import Nobody
from typed_config.node_names import MAX_NAME, caller_name
from voice_assist.audio.source import FRAME, Framer
from voice_assist.config import TopicConfig, load_voice_config
from voice_assist.intent.mapper import Mapper
from voice_assist.msg import AudioChunk
from voice_assist.ros.messages import pcm
from voice_assist.ros.topic_source import TopicSource
from voice_assist.text.normalize import foreign, normalize
from voice_assist.types import Match

logging.getLogger("rosout.rst_control.intake").setLevel(logging.CRITICAL)

MESSAGES = (
    *(JointState, AudioChunk, Event, ControllerState, AssistActionGoal, GoalID, String, Time),
    *(Empty, Bool, CommandRequest, SetTrocarRequest, FitTrocarRequest, TriggerRequest),
)
SPOKEN = load_voice_config().commands
MAPPER = Mapper(SPOKEN)
HALTS = {command.phrase for command in SPOKEN.commands if command.is_halt}


def fuzz_joint_states(data):
    """Joint states are read as finite numbers, or refused with a reason."""
    with suppress(BadMessage):
        sample = JointStateReader(JOINTS)(data)
        assert sample.position.shape == sample.velocity.shape == (len(JOINTS),)
        assert np.isfinite(sample.position).all() and np.isfinite(sample.velocity).all()
        assert math.isfinite(sample.stamp)


def fuzz_tension(data):
    """A force is finite, or refused with a reason."""
    with suppress(BadMessage):
        assert np.isfinite(read_force(data)).all()


def fuzz_messages(data):
    """Generated classes read any bytes or say that they cannot, and take no more than was sent."""
    kind = MESSAGES[data[0] % len(MESSAGES)] if data else Empty
    try:
        message = kind().deserialize(data[1:])
    except DeserializationError:
        return
    if isinstance(message, CommandRequest):
        _text_is_safe(message.command)
    again = BytesIO()
    with suppress(SerializationError):  # a stamp whose nanoseconds carry it beyond 32 bits
        message.serialize(again)
    assert len(again.getvalue()) <= 4 * len(data) + 64


class Silent(socket.socket):
    """A peer that hangs up when more is asked of it."""

    def recv_into(self, *_):
        return 0


def fuzz_stream(data):
    """A connection's bytes become messages, or are refused; nothing is lost between two of them."""
    whole, rest = split_messages(data)
    assert sum(len(message) + 4 for message in whole) + len(rest) == len(data)
    is_service, data = bool(data) and data[0] % 2 == 1, data[1:]
    protocol = (
        TCPService("command", WordsCommand)
        if is_service
        else TCPROSSub("fault", String, queue_size=1)
    )
    buffer, messages = BytesIO(), []
    buffer.write(data)
    with suppress(TransportTerminated):
        _read_messages(protocol, buffer, messages, SILENT)
        assert buffer.tell() <= len(data)
    assert len(messages) <= 1


def fuzz_handshake(data):
    """What is let through to rospy is a header or raises at once; the rest is never waited for."""
    if has_whole_header(data):
        with suppress(rosgraph.network.ROSHandshakeException, ValueError, struct.error):
            rosgraph.network.decode_ros_handshake_header(data)  # rospy hangs up at any of these


def fuzz_queue(data):
    """Only a command letter by letter goes further than the queue; a stop goes at once."""
    words = _text(data)
    _text_is_safe(words)
    executor = Nobody()
    queue = CommandQueue(executor, lambda *_: None, lambda: 0.0)
    pending = queue.take(words, "fuzz")
    waits, command = queue.next(0.0) is not None, read_command(words)
    assert (len(executor.stops) == 1) is (command is COMMANDS["stop"])
    assert (waits or bool(executor.orders)) is (command not in (None, COMMANDS["stop"]))
    assert pending.reply.done() is not (waits or bool(executor.orders))


def fuzz_mapper(data):
    """Only the words of a spelling, in English letters, are taken for anything but a halt."""
    text = _text(data)
    outcome = MAPPER(text)
    MAPPER.can_grow(text)
    assert tuple(outcome.wer) == SPOKEN.phrases
    if isinstance(outcome, Match) and outcome.command not in HALTS:
        threshold = SPOKEN.get(outcome.command).threshold
        assert outcome.wer[outcome.command] < threshold and not foreign(text)
    assert all(word.isalpha() for word in normalize(text))


def fuzz_callers(data):
    """Any names in any order: bounded memory, and a stop is always let in."""
    limiter = CallLimiter(CallersConfig(allowed=("/a*",), rate=1.0, burst=2), lambda: 0.0)
    for line in data.split(b"\n"):
        name = caller_name(_text(line))
        assert 0 < len(name) <= MAX_NAME and name.isprintable()
        assert limiter.admit(name, is_stop=True).refusal is None
        assert limiter.admit(name).refusal is None or limiter.admit(name).refusal
        assert limiter.counted <= MAX_CALLERS


def fuzz_sound(data):
    """A chunk of sound becomes frames on the grid, or is refused with a reason."""
    try:
        chunk = AudioChunk().deserialize(data)
    except DeserializationError:
        return
    if chunk.header.stamp.is_zero():
        return  # it gets the time of arrival, which only a node has
    troubles = []
    source = TopicSource(TopicConfig(name="audio_in", lost_after=1.0), troubles.append, print)
    source._enqueue(chunk)
    heard = source._next()
    assert (heard is None) is (troubles != [""])
    if heard is not None:
        frames = list(Framer().push(pcm(heard), heard.header.stamp.to_sec()))
        assert len(frames) == len(heard.samples) // FRAME


def _text(data):
    """Text from bytes, lone surrogates and all."""
    return data.decode("utf-8", "surrogateescape")


def _text_is_safe(words):
    command = read_command(words)
    refusal = unknown(words).words
    assert refusal.isprintable() and len(refusal) < 400
    if command is COMMANDS["stop"]:
        assert is_stop(words)
    elif command is not None:
        assert words.isascii() and len(words) <= MAX_LENGTH
        assert " ".join(words.split()).lower() == command.phrase


SILENT = Silent()
TARGETS = {name: globals()[f"fuzz_{name}"] for name in NAMES}
