# SPDX-License-Identifier: BSD-3-Clause
"""A command that could not be delivered in time is never delivered."""

import io
import socket
import threading
import time
from types import SimpleNamespace

import pytest
import rospy

from rst_control.srv import CommandRequest
from voice_assist.ros.service_calls import drop, in_time, timely


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
    assert seen == [True]
