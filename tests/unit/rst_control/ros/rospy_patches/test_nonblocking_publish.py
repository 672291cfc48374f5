# SPDX-License-Identifier: BSD-3-Clause
"""Messages go out at once, in order; a subscriber that reads nothing holds nobody up."""

import socket
import threading

import pytest
import rospy.topics
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSPub
from std_msgs.msg import String

from rst_control.ros.rospy_patches.nonblocking_publish import NonblockingConnection
from support.waiting import PATIENCE, wait_until


class PipeTransport:
    """A connection as rospy keeps it, over a pair of sockets."""

    def __init__(self):
        self.socket, self.far = socket.socketpair()
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 8192)
        self.far.settimeout(PATIENCE)
        self.done, self.stat_bytes, self.stat_num_msg = False, 0, 0
        self.endpoint_id = "somebody"

    def set_cleanup_callback(self, callback):
        self.callback = callback

    def write_data(self, data):
        if self.done:
            raise ConnectionError("closed")
        self.socket.sendall(data)
        self.stat_bytes += len(data)
        self.stat_num_msg += 1
        return True

    def close(self):
        self.done = True
        self.callback(self)
        self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()


@pytest.fixture
def transport():
    transport = PipeTransport()
    yield transport
    if not transport.done:
        transport.close()
    transport.far.close()


def message(number, size):
    return number.to_bytes(4, "little") + bytes([number % 251]) * (size - 4)


def read(sock, count):
    got = b""
    while len(got) < count:
        piece = sock.recv(count - len(got))
        assert piece, "the connection ended"
        got += piece
    return got


def threads():
    return {t.name for t in threading.enumerate()}


def test_a_message_is_with_the_network_when_write_returns_and_no_thread_is_made(transport):
    connection = NonblockingConnection(transport, 5)
    for number in range(100):
        connection.write_data(message(number, 300))
        assert transport.far.recv(300, socket.MSG_DONTWAIT) == message(number, 300)
    assert "held_up" not in threads()
    assert (transport.stat_num_msg, transport.stat_bytes) == (100, 30_000)


def test_a_subscriber_that_does_not_read_holds_nobody_up_and_gets_whole_messages_later(transport):
    connection, size, count = NonblockingConnection(transport, 3), 5000, 60
    for number in range(count):
        connection.write_data(message(number, size))  # would block for ever in rospy's own way
    last = read(transport.far, size)
    seen = [int.from_bytes(last[:4], "little")]
    while seen[-1] != count - 1:
        got = read(transport.far, size)
        seen.append(int.from_bytes(got[:4], "little"))
        assert got == message(seen[-1], size)
    assert seen == sorted(set(seen))
    assert seen[0] == 0
    assert seen[-3:] == [count - 3, count - 2, count - 1]  # the newest are kept
    assert len(seen) < count


def test_after_a_jam_messages_go_out_at_once_again(transport):
    connection = NonblockingConnection(transport, 0)
    jam = [message(number, 5000) for number in range(40)]
    for data in jam:
        connection.write_data(data)
    assert read(transport.far, 40 * 5000) == b"".join(jam)  # none dropped: 0 is without limit
    wait_until(lambda: not connection._is_held_up, every=0.001)
    connection.write_data(b"again")
    assert transport.far.recv(5, socket.MSG_DONTWAIT) == b"again"


def test_a_subscriber_that_went_is_reported_to_the_publisher(transport):
    connection = NonblockingConnection(transport, 5)
    transport.far.close()
    with pytest.raises(BrokenPipeError):
        connection.write_data(b"hello")
    transport.close()
    with pytest.raises(ConnectionError, match="closed"):
        connection.write_data(b"hello")


def test_rospy_may_close_a_connection_while_a_message_fails_on_it(transport):
    """rospy's lock of the topic is held by who closes and wanted by whose message fails."""
    connection, is_closed = NonblockingConnection(transport, 5), []

    def fail(_):
        closing = threading.Thread(target=transport.callback, args=(transport,), daemon=True)
        closing.start()
        closing.join(PATIENCE)
        is_closed.append(not closing.is_alive())
        raise ConnectionError("closed")

    transport.write_data = fail
    transport.far.close()
    with pytest.raises(ConnectionError, match="closed"):
        connection.write_data(b"hello")
    assert is_closed == [True]


@pytest.fixture
def publisher():
    """A topic as rospy publishes it, with connections of ours."""
    topic = rospy.topics._PublisherImpl("/topic", String)
    topic.set_queue_size(5)
    yield topic
    topic.close()


def connect(publisher, number):
    ours, theirs = socket.socketpair()
    transport = TCPROSTransport(TCPROSPub("/topic", String), "/topic")
    transport.set_socket(ours, f"/subscriber_{number}")
    publisher.add_connection(transport)
    return transport, theirs


@pytest.mark.parametrize("is_removed_before", [False, True])
def test_a_subscriber_stays_whose_socket_has_the_number_of_one_that_went(
    publisher, monkeypatch, is_removed_before
):
    monkeypatch.setattr(rospy.topics, "QueuedConnection", NonblockingConnection)
    for _ in range(20):  # a thread beside may take the number before the new one does
        publisher.connections = []
        old, _ = connect(publisher, 1)
        (gone,) = publisher.connections
        old.socket.close()
        if is_removed_before:
            publisher.connections = []
        new, far = connect(publisher, 2)
        if new.fileno() == old.fileno():
            break
    assert new.fileno() == old.fileno()
    old.close()
    assert len(publisher.connections) == 1
    assert publisher.connections != [gone]
    publisher.publish(String("hello"))
    far.settimeout(PATIENCE)
    assert b"hello" in far.recv(100)


def test_a_jam_ends_with_the_connection(transport):
    connection = NonblockingConnection(transport, 1)
    for number in range(20):
        connection.write_data(message(number, 5000))
    thread = connection._thread
    transport.close()
    thread.join(PATIENCE)
    assert not thread.is_alive()


def test_the_rest_is_the_transports(transport):
    connection = NonblockingConnection(transport, 1)
    assert connection.endpoint_id == "somebody"
    with pytest.raises(AttributeError):
        _ = connection.no_such_thing
