# SPDX-License-Identifier: BSD-3-Clause
"""A controller that was started anew gets the next command once, over a connection of its own."""

import socket
import struct
import threading
from contextlib import suppress
from io import BytesIO
from queue import Queue

import pytest
import rospy
from rosgraph.network import read_ros_handshake_header, write_ros_handshake_header
from rospy.impl import tcpros_base

from rst_control.srv import Command, CommandRequest, CommandResponse
from support.waiting import PATIENCE
from voice_assist.ros.robot.command_client import CommandClient

SERVICE = {
    "callerid": "/controller",
    "type": Command._type,
    "md5sum": Command._md5sum,
    "request_type": CommandRequest._type,
    "response_type": CommandResponse._type,
}


class Controller:
    """Serves commands over persistent connections, as rospy does, without a master."""

    def __init__(self):
        self.taken, self._connections = [], []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.uri = f"rosrpc://127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    @property
    def connections(self):
        return len(self._connections)

    def end(self):
        """As where its process ends."""
        for one in (self._listener, *self._connections):
            with suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()

    def _accept(self):
        with suppress(OSError):  # it has ended
            while True:
                connection, _ = self._listener.accept()
                self._connections.append(connection)
                threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        with suppress(OSError, struct.error):  # it has ended
            read_ros_handshake_header(connection, BytesIO(), 4096)
            write_ros_handshake_header(connection, SERVICE)
            while True:
                size = struct.unpack("<I", connection.recv(4, socket.MSG_WAITALL))[0]
                request = CommandRequest().deserialize(connection.recv(size, socket.MSG_WAITALL))
                self.taken.append(request.command)
                answer = BytesIO()
                CommandResponse(accepted=True).serialize(answer)
                said = answer.getvalue()
                connection.sendall(struct.pack("<BI", 1, len(said)) + said)


@pytest.fixture
def services(monkeypatch):
    """Where the service is found, and what ends when it is over."""
    found = []
    # both ask the master
    monkeypatch.setattr(rospy.ServiceProxy, "_get_service_uri", lambda *_: found[-1].uri)
    monkeypatch.setattr(tcpros_base, "_is_use_tcp_keepalive", lambda: False)
    yield found
    for controller in found:
        controller.end()


@pytest.fixture
def ask(services, monkeypatch):
    """Answer to a command that must not be repeated."""
    is_over, answers = threading.Event(), Queue()
    monkeypatch.setattr(rospy, "is_shutdown", is_over.is_set)
    monkeypatch.setattr(CommandClient, "_check_controller", lambda _: None)
    client = CommandClient(PATIENCE, answers.put)

    def ask(command):
        client.call(command, may_repeat=False)
        return answers.get(timeout=PATIENCE).is_accepted

    yield ask
    is_over.set()
    for thread in threading.enumerate():
        if thread.name == "command client":  # before rospy is the true one again
            thread.join(10.0)


def test_the_first_command_after_a_restart_arrives_once(services, ask):
    services.append(before := Controller())
    assert ask("hey robot")
    before.end()
    services.append(after := Controller())
    assert ask("tense")
    assert (before.taken, after.taken) == (["hey robot"], ["tense"])


def test_a_connection_that_is_open_is_kept(services, ask):
    services.append(controller := Controller())
    assert ask("hey robot") and ask("tense")
    assert (controller.taken, controller.connections) == (["hey robot", "tense"], 1)


def test_a_command_to_a_controller_that_ended_is_answered_with_no(services, ask):
    services.append(controller := Controller())
    assert ask("hey robot")
    controller.end()
    assert not ask("tense")
    assert controller.taken == ["hey robot"]
