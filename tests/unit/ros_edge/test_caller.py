# SPDX-License-Identifier: BSD-3-Clause
"""A command that could not be delivered in time is never delivered."""

import io
import socket
import time
from types import SimpleNamespace

import pytest
import rospy

from voice_assist.ros.robot.command_client import _drop, _TimelyRequest


def test_a_request_is_written_until_its_time_is_over_and_not_after_it():
    request, written = _TimelyRequest("tense"), io.BytesIO()
    request.send_by = time.monotonic() + 60.0
    request.serialize(written)
    assert written.getvalue() == b"\x05\x00\x00\x00tense"
    request.send_by = time.monotonic() - 1e-6
    with pytest.raises(rospy.ServiceException, match="too late"):
        request.serialize(written)
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
            _drop(proxy(ours))
            received = 0
            with pytest.raises(ConnectionResetError):
                while read := theirs.recv(1 << 20):
                    received += len(read)
            assert received < sent


def test_a_proxy_that_never_connected_is_closed_all_the_same():
    closed = []
    _drop(SimpleNamespace(transport=None, close=lambda: closed.append(True)))
    assert closed == [True]
