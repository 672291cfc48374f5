# SPDX-License-Identifier: BSD-3-Clause
"""Requests that come in through rospy: limits of sockets, of the command service and of goals."""

import logging
import socket
import struct
import threading
from collections import deque
from io import BytesIO
from types import SimpleNamespace

import genpy
import pytest
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus
from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_pubsub import TCPROSSub
from rospy.impl.tcpros_service import TCPService
from std_msgs.msg import Empty, String

from rst_control.admission.callers import CallLimiter
from rst_control.admission.command_queue import CommandQueue
from rst_control.config.callers import CallersConfig
from rst_control.execution.orders import Outcome
from rst_control.msg import AssistActionGoal, AssistGoal, AssistResult
from rst_control.ros.controller.services import action_server, command_service
from rst_control.ros.controller.services.action_server import GuardedServer
from rst_control.ros.controller.services.command_service import (
    CommandService,
    WordsCommand,
    WordsRequest,
)
from rst_control.ros.rospy_patches import message_limits
from rst_control.ros.rospy_patches.message_framing import LONGEST_MESSAGE
from rst_control.srv import SetTrocar
from rst_control.supervision.heartbeat import Heartbeat
from rst_control.types import Reason
from support.waiting import wait_until
from tests.support.null_executor import Nobody
from typed_config.node_names import UNNAMED

MEGA = 10_000_000


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Nobody sleeps, and nothing is logged."""
    monkeypatch.setattr(command_service.time, "sleep", lambda _: None)
    monkeypatch.setattr(action_server.time, "sleep", lambda _: None)
    logging.getLogger("rosout.rst_control.intake").setLevel(logging.CRITICAL)


def framed(raw):
    return struct.pack("<I", len(raw)) + raw


def words(text):
    raw = text.encode("utf-8", "surrogatepass")
    return framed(framed(raw))


class Wire:
    """A connection as rospy reads it: what was sent comes in pieces of a buffer's size."""

    def __init__(self, protocol, sent):
        self.protocol, self.buffer = protocol, BytesIO()
        self.near, self.far = socket.socketpair()
        self.near.settimeout(10.0)
        self._sender = threading.Thread(target=self._send, args=(sent,), daemon=True)
        self._sender.start()

    def _send(self, sent):
        self.far.sendall(sent)
        self.far.shutdown(socket.SHUT_WR)

    def next(self):
        """The next messages; none at the end."""
        messages = []
        while not messages:
            if self.buffer.tell() >= 4:
                message_limits._read_messages(self.protocol, self.buffer, messages, self.near)
            if not messages:
                piece = self.near.recv(65_536)
                if not piece:
                    break
                self.buffer.write(piece)
            assert self.buffer.getbuffer().nbytes < 4 * LONGEST_MESSAGE
        return messages

    def all(self):
        """What all messages say, up to the end."""
        said = []
        while messages := self.next():
            said += [message.data for message in messages]
        return said


def service():
    return TCPService("command", WordsCommand)


def topic(queue_size=None):
    return TCPROSSub("fault", String, queue_size=queue_size)


def test_requests_are_read_one_at_a_time_and_none_is_lost():
    wire = Wire(service(), b"".join(words(t) for t in ("tense", "stop", "")))
    assert [wire.next()[0].command for _ in range(3)] == ["tense", "stop", ""]
    assert wire.next() == []


def test_of_a_request_of_ten_megabytes_the_beginning_and_the_length_are_kept():
    wire = Wire(service(), words("x" * MEGA) + words("stop"))
    (long,) = wire.next()
    assert long.length == MEGA and len(long.command) == 400
    assert wire.next()[0].command == "stop"


CUT = struct.pack("<I", 99) + b"tense"  # what there is of it would be a command


@pytest.mark.parametrize("raw", [b"", b"\x01", CUT, framed(b"tense") + b"\x00", b"\xff" * 40])
def test_bytes_that_are_no_request_end_the_connection(raw):
    with pytest.raises(TransportTerminated, match="no rst_control/CommandRequest"):
        Wire(service(), framed(raw)).next()


def test_a_stop_that_was_damaged_is_read_even_so():
    (damaged,) = Wire(service(), framed(struct.pack("<I", 99) + b"stop")).next()
    assert damaged.command == "stop"


def test_a_service_that_can_make_nothing_of_a_long_request_hangs_up():
    protocol = TCPService("set_trocar", SetTrocar)
    with pytest.raises(TransportTerminated, match="allowed: 65536"):
        Wire(protocol, framed(bytes(LONGEST_MESSAGE + 1))).next()


def test_a_topic_passes_over_what_is_too_long_or_no_message():
    sent = framed(bytes(MEGA)) + framed(b"\x07") + words("good") + framed(b"\xff") + words("too")
    assert Wire(topic(), sent).all() == ["good", "too"]


def test_of_what_piles_up_on_a_topic_the_newest_counts():
    heard = Wire(topic(queue_size=1), b"".join(words(str(n)) for n in range(1000))).all()
    assert heard[-1] == "999" and len(heard) < 1000


def test_a_sender_who_hangs_up_in_the_middle_is_noticed():
    with pytest.raises(TransportTerminated, match="hung up"):
        Wire(service(), struct.pack("<I", MEGA) + bytes(70_000)).next()


@pytest.mark.parametrize(
    ("sent", "is_heard"),
    [(framed(framed(b"callerid=/a")), True), (b"GET / HTTP/1.1\r\n\r\n", False), (b"", False)],
)
def test_a_stranger_is_let_in_by_a_whole_header_alone(sent, is_heard):
    near, far = socket.socketpair()
    far.sendall(sent)
    far.shutdown(socket.SHUT_WR)
    assert message_limits._says_in_time(near) is is_heard
    assert near.recv(100, socket.MSG_PEEK) == sent


def test_a_silent_stranger_is_left_after_a_time(monkeypatch):
    monkeypatch.setattr(message_limits, "HANDSHAKE_TIME", 0.05)
    near, _far = socket.socketpair()
    with pytest.raises(TimeoutError):
        message_limits._says_in_time(near)


def request(text, caller="/panel", length=0):
    message = WordsRequest(text)
    message.length = length
    message._connection_header = {"callerid": caller}
    return message


@pytest.fixture
def served():
    """The command service in front of a queue behind which nothing is carried out."""
    nobody = Nobody()
    service = CommandService.__new__(CommandService)
    service._commands = CommandQueue(nobody, lambda *_: None, lambda: 0.0)
    service._limiter = CallLimiter(
        CallersConfig(allowed=("/panel", "/long"), rate=1.0, burst=5), lambda: 0.0
    )
    service._spoken_by, service._heartbeat = "/voice_assist", Heartbeat(0.5)
    service._executor = nobody
    nobody.call, nobody.hear_stop = service._on_command, service._on_stop
    return nobody


def test_a_flood_is_refused_with_the_limits_and_its_stop_is_not(served):
    answers = [served.call(request("dance")) for _ in range(8)]
    assert not any(answer.accepted for answer in answers)
    assert "unknown command" in answers[4].message
    assert all("1 per second after 5 at once" in answer.message for answer in answers[5:])
    assert sum("too many calls" in words for _, words in served.refusals) == 1
    assert served.call(request("STOP")).accepted
    assert served.stops == ['"stop" from /panel']


def test_a_caller_that_is_not_on_the_list_is_refused_and_may_stop(served):
    for words in ("terminate", "tense", "hey robot", "dance"):
        assert "may not give commands" in served.call(request(words, "/stray")).message
    assert served.orders == []
    assert served.call(request("stop", "/stray")).accepted
    assert served.stops == ['"stop" from /stray']


def test_a_stop_by_topic_says_who_sent_it_and_that_of_the_voice_node_is_by_voice(served):
    for sender in ("/voice_assist", "/panel"):
        message = Empty()
        message._connection_header = {"callerid": sender}
        served.hear_stop(message)
    assert served.stops == ["stopped by voice", "stopped by /panel"]


def test_a_text_that_was_cut_is_refused_by_its_length_unless_it_begins_as_a_stop(served):
    answer = served.call(request("tense" + " " * 395, "/long", MEGA))
    assert not answer.accepted and f"{MEGA} bytes, allowed: 200" in answer.message
    assert served.call(request("stop " * 80, "/long", MEGA)).accepted


def test_a_caller_without_a_name_is_an_unnamed_node(served):
    message = WordsRequest("dance")
    message._connection_header = None
    assert UNNAMED in served.call(message).message


class Actions(GuardedServer):
    """An action server without topics."""

    def __init__(self, allowed=("/panel",)):
        config = CallersConfig(allowed=allowed, rate=1.0, burst=3)
        self._limiter = CallLimiter(config, lambda: 0.0)
        self.lock, self.started = threading.RLock(), True
        self.status_list, self.last_cancel = [], genpy.Time()
        self.taken, self.refused, self.stopped = [], [], []
        self._on_stop = lambda goal: self.stopped.append(goal.goal_id.id)
        self.ActionResultType = AssistResult
        self.goal_callback = lambda handle: self.taken.append(handle.get_goal().command)
        self.cancel_callback = lambda handle: None
        self.all_cancelled = []
        self._on_cancel_all = self.all_cancelled.append
        self.late_cancelled, self.replaced = [], deque()
        self._on_late_cancel = lambda goal_id: self.late_cancelled.append(goal_id.id)
        self._goals = SimpleNamespace(has_true_name=lambda goal: goal.goal_id.id != "false")
        listeners = [SimpleNamespace(endpoint_id="/panel"), SimpleNamespace(endpoint_id="/stray")]
        self.result_pub = SimpleNamespace(impl=SimpleNamespace(connections=listeners))

    def publish_result(self, status, result):
        self.refused.append((status.goal_id.id, status.status, result.outcome))

    def publish_status(self):
        pass


def goal(command, name, caller="/panel"):
    message = AssistActionGoal(goal=AssistGoal(command=command))
    message.goal_id.id = name
    message._connection_header = {"callerid": caller}
    return message


def test_goals_of_a_flood_are_rejected_and_a_stop_among_them_is_not():
    server = Actions()
    for number in range(10):
        server.internal_goal_callback(goal("tense", f"g{number}"))
    server.internal_goal_callback(goal("stop", "last"))
    assert server.taken == ["tense"] * 3 + ["stop"]
    assert server.refused == [(f"g{n}", GoalStatus.REJECTED, "refused") for n in range(3, 10)]


@pytest.mark.parametrize(("name", "caller"), [("g", "/stray"), ("false", "/panel")])
def test_a_goal_of_who_is_not_on_the_list_or_under_the_name_of_another_is_rejected(name, caller):
    server = Actions()
    server.internal_goal_callback(goal("tense", name, caller))
    assert server.taken == [] and len(server.refused) == 1


def test_goals_of_who_does_not_hear_of_their_end_are_rejected_as_those_of_a_bag_are():
    server = Actions(allowed=())
    server.internal_goal_callback(goal("tense", "g", "/play_1700000000"))
    server.internal_goal_callback(goal("hey robot", "h", "/play_1700000000"))
    assert server.taken == [] and len(server.refused) == 2
    server.internal_goal_callback(goal("stop", "s", "/play_1700000000"))
    assert server.taken == ["stop"]


def test_a_stop_counts_though_its_id_or_its_time_was_cancelled():
    server, now = Actions(allowed=()), rospy.Time.now()
    server.internal_cancel_callback(GoalID(stamp=now))
    server.internal_cancel_callback(GoalID(id="used"))
    late = goal("stop", "late")
    late.goal_id.stamp = now - rospy.Duration(1.0)
    for stop in (late, goal("stop", "used"), goal("stop", "used"), goal("tense", "no stop")):
        server.internal_goal_callback(stop)
    assert server.stopped == ["late", "used", "used"]


def test_a_stop_does_not_wait_for_who_sends_it_to_be_known():
    server, looked_up = Actions(), threading.Event()
    server._goals = SimpleNamespace(has_true_name=lambda _: looked_up.wait())
    to_run, given = server.internal_goal_callback, (goal("stop", "g"),)
    thread = threading.Thread(target=to_run, args=given, daemon=True)
    thread.start()
    wait_until(lambda: server.stopped == ["g"])
    assert server.taken == []
    looked_up.set()
    thread.join(10.0)
    assert server.taken == ["stop"]


def test_cancels_of_what_never_was_are_not_remembered_without_end():
    server = Actions()
    for number in range(1000):
        server.internal_cancel_callback(GoalID(id=f"none{number}"))
    assert len(server.status_list) <= action_server.MAX_GOALS
    server.internal_goal_callback(goal("stop", "g"))
    assert server.taken == ["stop"]


def test_an_endless_goal_id_is_refused_and_not_repeated():
    server = Actions()
    server.internal_goal_callback(goal("tense", "x" * 60_000))
    ((name, status, _),) = server.refused
    assert len(name) == action_server.LONGEST_ID and status == GoalStatus.REJECTED


@pytest.mark.parametrize("stamp", [genpy.Time(0xFFFFFFFF), genpy.Time(0xFFFFFFFF, 0xFFFFFFFF)])
def test_a_cancel_from_the_future_does_not_cancel_all_goals_to_come(stamp):
    server = Actions()
    server.internal_cancel_callback(GoalID(stamp=stamp))
    assert server.last_cancel <= rospy.Time.now()
    later = goal("tense", "g")
    later.goal_id.stamp = stamp
    server.internal_goal_callback(later)
    assert server.taken == ["tense"]
    for status in server.status_list:
        status.status.serialize(BytesIO())


def test_a_cancel_that_names_no_goal_stops_whatever_is_under_way():
    server = Actions(allowed=())
    for _ in range(3):
        server.internal_cancel_callback(GoalID())
    assert len(server.all_cancelled) == 3
    server.internal_cancel_callback(GoalID(id="one that ended long ago"))
    assert len(server.all_cancelled) == 3


@pytest.mark.parametrize(
    ("kind", "reason", "is_late"),
    [
        ("stopped", Reason.REPLACED, True),
        ("stopped", Reason.STOP_COMMAND, False),  # what moves now took the place of another
        ("succeeded", None, False),
        ("failed", Reason.WITHDRAWN, False),
    ],
)
def test_a_cancel_of_a_goal_that_was_replaced_is_handed_on(kind, reason, is_late):
    server, handles = Actions(), []
    server.goal_callback = handles.append
    server.internal_goal_callback(goal("tense", "g"))
    handles[0].set_accepted()
    bare = bare_server()[0]
    bare._server, bare._running = server, {}
    bare._end(handles[0], Outcome(kind, "", reason))
    for name in ("g", "another"):
        server.internal_cancel_callback(GoalID(id=name))
    assert server.late_cancelled == (["g"] if is_late else [])


def bare_server(is_moving=True):
    """The server of the action without topics, and the stops that it has asked for."""
    stops, bare = [], object.__new__(action_server.AssistServer)
    bare._executor = SimpleNamespace(
        snapshot=SimpleNamespace(is_moving=is_moving),
        stop=lambda cause, received, caller: stops.append((cause.reason, caller)),
    )
    return bare, stops


@pytest.mark.parametrize("is_moving", [True, False])
def test_a_cancel_of_a_goal_that_was_replaced_stops_what_moves(is_moving):
    bare, stops = bare_server(is_moving)
    bare._on_late_cancel(GoalID(id="g"))
    assert stops == ([(Reason.STOP_CANCEL, UNNAMED)] if is_moving else [])


@pytest.mark.parametrize("is_moving", [True, False])
def test_a_cancel_that_names_no_goal_and_a_goal_that_is_a_stop_reach_the_controller(is_moving):
    bare, stops = bare_server(is_moving)
    cancel = GoalID()
    cancel._connection_header = {"callerid": "/pedal"}
    bare._on_cancel_all(cancel)
    assert stops == [(Reason.STOP_CANCEL, "/pedal")]
    bare._on_stop(goal("stop", "s"))
    assert stops[1:] == [(Reason.STOP_COMMAND, "/panel")]
