# SPDX-License-Identifier: BSD-3-Clause
"""A command that could not be delivered in time is never delivered."""

import io
import socket
import threading
import time
from queue import Queue
from types import SimpleNamespace

import pytest
import rospy

from rst_control.srv import Command, CommandRequest, CommandResponse
from support.waiting import PATIENCE, wait_until
from typed_config.ros import service_calls
from typed_config.ros.service_calls import call_service, drop, in_time, timely


def test_a_request_is_written_until_its_time_is_over_and_not_after_it():
    written = io.BytesIO()
    timely(CommandRequest, time.monotonic() + 60.0)("tense").serialize(written)
    assert written.getvalue() == b"\x05\x00\x00\x00tense"
    late = timely(CommandRequest, time.monotonic() - 1e-6)("tense")
    with pytest.raises(rospy.ServiceException, match="too late"):
        late.serialize(written)
    assert written.getvalue() == b"\x05\x00\x00\x00tense"


def proxy(connection):
    """A proxy with a connection, which it closes as rospy does."""

    def close():
        connection.shutdown(socket.SHUT_RDWR)
        connection.close()

    return SimpleNamespace(transport=SimpleNamespace(socket=connection), close=close)


def test_what_the_network_holds_back_is_thrown_away():
    with socket.create_server(("127.0.0.1", 0)) as server:
        ours = socket.create_connection(server.getsockname())
        theirs, _ = server.accept()
        with theirs:
            ours.setblocking(False)
            sent = 0
            with pytest.raises(BlockingIOError):  # until the buffers of both sides are full
                while True:
                    sent += ours.send(bytes(65536))
            drop(proxy(ours))
            received = 0
            with pytest.raises(ConnectionResetError):
                while read := theirs.recv(1 << 20):
                    received += len(read)
            assert received < sent


def test_a_proxy_that_never_connected_is_closed_all_the_same():
    closed = []
    drop(SimpleNamespace(transport=None, close=lambda: closed.append(True)))
    assert closed == [True]


def raising(error):
    def work():
        raise error

    return work


@pytest.mark.parametrize(
    "work",
    [
        raising(rospy.ServiceException()),
        raising(rospy.ROSException()),
        raising(ConnectionRefusedError()),
    ],
)
def test_an_error_of_the_network_is_no_answer(work):
    assert in_time(work, 60.0) is None


def test_an_answer_is_waited_for_and_given_up_in_time_by_a_thread_that_ends_with_the_process():
    assert in_time(lambda: "answer", 60.0) == "answer"
    go_on, seen = threading.Event(), []

    def hang():
        seen.append(threading.current_thread().daemon)
        return go_on.wait(60.0)

    began = time.monotonic()
    assert in_time(hang, 0.05) is None
    assert time.monotonic() - began < 10.0
    go_on.set()
    wait_until(lambda: seen == [True], "its thread")


class Service:
    """In place of a service: it answers, fails, or hangs before or after the request."""

    def __init__(self, monkeypatch, hangs="", error=None):
        self.hangs, self.error, self.thaws = hangs, error, threading.Event()
        self.received, self.outcomes, self.transport, self.closed = [], Queue(), None, 0
        monkeypatch.setattr(rospy, "ServiceProxy", lambda *_, **__: self)

    def __call__(self, request):
        try:
            if self.hangs == "before":
                self.thaws.wait(60.0)
            request.serialize(SimpleNamespace(write=self.received.append))
            if self.hangs == "after":
                self.thaws.wait(60.0)
            if self.error is not None:
                raise self.error
        except Exception as error:
            self.outcomes.put(error)
            raise
        return CommandResponse(True, "", "")

    def close(self):
        self.closed += 1


def test_a_service_that_answers_is_asked_once(monkeypatch):
    service = Service(monkeypatch)
    reply = call_service("name", Command, "tense", within=60.0)
    assert (reply.response.accepted, reply.trouble, reply.may_take_effect) == (True, "", False)
    assert service.received and service.closed == 1


def test_what_a_service_that_hangs_was_not_sent_it_is_never_sent(monkeypatch):
    service = Service(monkeypatch, hangs="before")
    reply = call_service("name", Command, "tense", within=0.05)
    assert (reply.response, reply.trouble) == (None, "no answer within 0.05 s")
    assert not reply.may_take_effect
    service.thaws.set()
    assert isinstance(service.outcomes.get(timeout=10.0), rospy.ServiceException)
    assert not service.received and service.closed == 1


def test_what_is_given_up_while_it_is_just_being_sent_is_not_sent(monkeypatch):
    """The thread may be late between its look at the deadline and what follows."""
    service = Service(monkeypatch, hangs="before")
    clock = SimpleNamespace(monotonic=lambda: 0.0)  # so that no deadline is ever over
    monkeypatch.setattr(service_calls, "time", clock)
    assert not call_service("name", Command, "tense", within=0.05).may_take_effect
    service.thaws.set()
    assert "given up" in str(service.outcomes.get(timeout=10.0))
    assert not service.received


SAYS_NO = rospy.ServiceException("service [/name] responded with an error: b'no'")


@pytest.mark.parametrize(
    ("fault", "may_take_effect"),
    [
        ({"hangs": "after"}, True),
        ({"error": rospy.ServiceException("transport error completing service call")}, True),
        ({"error": BrokenPipeError("broken")}, True),
        ({"error": SAYS_NO}, False),
    ],
)
def test_what_was_sent_and_not_answered_may_still_take_effect(monkeypatch, fault, may_take_effect):
    service = Service(monkeypatch, **fault)
    within = 2.0 if "hangs" in fault else PATIENCE
    reply = call_service("name", Command, "tense", within=within)
    assert reply.response is None and reply.trouble and service.closed == 1
    assert reply.may_take_effect is may_take_effect
    service.thaws.set()


def test_a_service_that_does_not_appear_is_not_asked(monkeypatch):
    def fail(name, within):
        raise rospy.ROSException(f"{name}: not within {within:g}")

    service = Service(monkeypatch)
    monkeypatch.setattr(rospy, "wait_for_service", fail)
    reply = call_service("name", Command, "tense", within=60.0, appears=2.0)
    assert (reply.trouble, reply.may_take_effect) == ("name: not within 2", False)
    assert not service.received
