# SPDX-License-Identifier: BSD-3-Clause
"""Publishing without waiting: the publishing thread sends itself while the network takes it."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from socket import MSG_DONTWAIT, socket
from typing import Any, Protocol

import rospy.topics


def publish_without_waiting() -> None:
    """Publish without a thread per subscriber; call it before the first publisher is made."""
    rospy.topics.QueuedConnection = NonblockingConnection


class Transport(Protocol):
    """What rospy keeps for a connection to a subscriber."""

    socket: socket | None
    done: bool
    stat_bytes: int
    stat_num_msg: int

    def write_data(self, data: bytes) -> bool:
        """Send all bytes, however long it takes."""
        ...

    def fileno(self) -> int | None:
        """Give the number of the socket, also after it was closed."""
        ...

    def set_cleanup_callback(self, callback: Callable[[Transport], None]) -> None:
        """Have a function called when the connection closes."""
        ...


class NonblockingConnection:
    """Stands where rospy puts its queue: same order, same length, no thread while all goes well.

    rospy hands every message for every subscriber to a thread of that subscriber. At 500 Hz these
    threads cost a control loop more than its mathematics, for each asks for the interpreter several
    times per message. Here a message goes out at once, without waiting; only from where the network
    takes no more, a thread sends what is left, and up to `queue_size` messages wait behind it, of
    which the oldest are dropped.

    rospy closes connections under its lock of the topic, and `_on_closed` then takes ours. So
    nothing that may take rospy's lock is called under ours.

    Args:
        transport: The connection.
        queue_size: Messages that may wait; 0: any number.
    """

    def __init__(self, transport: Transport, queue_size: int) -> None:
        self._transport, self._limit = transport, queue_size
        self._changed = threading.Condition()
        self._rest = b""  # of a message that went out in part; never dropped
        self._waiting: deque[bytes] = deque()
        self._is_held_up = False  # a thread is sending
        self._thread: threading.Thread | None = None
        self._error: Exception | None = None
        transport.set_cleanup_callback(self._on_closed)

    def __getattr__(self, name: str) -> Any:
        """All else is the connection's."""
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._transport, name)

    def set_cleanup_callback(self, callback: Callable[[NonblockingConnection], None]) -> None:
        """As the transport has it, but this connection is what closed: rospy's list holds it."""
        self._transport.set_cleanup_callback(lambda _: callback(self))

    def fileno(self) -> int | None:
        """The socket's number; None once it is closed, for another connection may bear it by then.

        rospy goes by it where it removes connections.
        """
        return None if self._transport.done else self._transport.fileno()

    def write_data(self, data: bytes) -> bool:
        """Send a message, or let it wait; never blocks.

        Raises:
            Exception: What the connection raised when it sent the last ones.
        """
        with self._changed:
            if self._error is not None:
                error, self._error = self._error, None
                raise error
            if self._is_held_up:
                if 0 < self._limit <= len(self._waiting):
                    self._waiting.popleft()
                self._waiting.append(data)
                return True
            sent = self._send_now(data)
            if sent is not None and sent < len(data):
                self._is_held_up, self._rest = True, data[sent:]
                self._wake_thread()
        if sent is None:  # without our lock: a transport that fails closes and takes rospy's
            self._transport.write_data(data)
        return True

    def _send_now(self, data: bytes) -> int | None:
        """Bytes that went out; None: something is wrong, and the transport has to report it."""
        transport = self._transport
        if transport.socket is None or transport.done:
            return None
        try:
            sent = transport.socket.send(data, MSG_DONTWAIT)
        except BlockingIOError:
            return 0
        except OSError:
            return None
        transport.stat_bytes += sent
        transport.stat_num_msg += sent == len(data)
        return sent

    def _wake_thread(self) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="held_up", daemon=True)
            self._thread.start()
        self._changed.notify()

    def _run(self) -> None:
        while data := self._next():
            try:
                self._transport.write_data(data)
            except Exception as error:  # raised at the next message
                with self._changed:
                    self._error = error

    def _next(self) -> bytes:
        """What is to be sent now; empty: the connection is closed."""
        with self._changed:
            while not self._transport.done:
                if self._rest:
                    data, self._rest = self._rest, b""
                    return data
                if self._waiting:
                    return self._waiting.popleft()
                self._is_held_up = False
                self._changed.wait()
        return b""

    def _on_closed(self, _: Transport) -> None:
        with self._changed:
            self._changed.notify()
