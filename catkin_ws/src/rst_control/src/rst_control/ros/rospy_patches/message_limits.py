# SPDX-License-Identifier: BSD-3-Clause
"""What rospy lets in from the network, bounded: rospy itself reads whatever a peer announces.

Left alone, a peer that connects and says nothing keeps everybody else from connecting, a message
of 10 MB holds the interpreter, and with it the control loop, for milliseconds while it is copied,
and bytes that are no message end the thread that reads them with a trace. `limit_messages` replaces
the places in rospy that take up connections and read from them. A caller that leaves before its
answer ends the thread of its call with a trace as well: that is an ordinary thing, and is passed
over.
"""

from __future__ import annotations

import contextlib
import logging
import socket
import threading
import time
from io import BytesIO
from types import TracebackType

import genpy
from rospy.exceptions import TransportException, TransportTerminated
from rospy.impl.tcpros_base import TCPROSServer, TCPROSTransportProtocol, TCPServer
from rospy.impl.tcpros_pubsub import TCPROSSub
from rospy.impl.tcpros_service import ServiceImpl, TCPService
from rospy.impl.transport import Transport

from rst_control.ros.rospy_patches.message_framing import (
    LONGEST_HEADER,
    LONGEST_MESSAGE,
    Refusals,
    announced,
    has_whole_header,
    split_messages,
)

log = logging.getLogger("rosout.rst_control.message_limits")

HANDSHAKE_TIME = 2.0  # [s] for a peer to say what it wants
PEEK_PERIOD = 0.005  # [s] between checks whether the rest of it has come
MAX_STRANGERS = 64  # peers at once that have not said yet what they want
WAITING = 128  # connections that may wait to be taken up; rospy's 5 make the sixth caller wait 1 s
CHUNK = 65_536  # bytes of an oversized message that are read and forgotten at a time

_strangers = threading.BoundedSemaphore(MAX_STRANGERS)
_refusals = Refusals(time.monotonic)
_welcome = TCPROSServer._tcp_server_callback
_open = TCPServer._create_server_sock
_error_handler, _write_service_error = ServiceImpl.error_handler, ServiceImpl._write_service_error


def limit_messages() -> None:
    """Bound what this process takes in; call it before rospy.init_node."""
    TCPServer._create_server_sock = _listen
    TCPROSServer._tcp_server_callback = _admit
    TCPROSSub.read_messages = _read_messages
    TCPService.read_messages = _read_messages
    ServiceImpl.error_handler = _note_error
    ServiceImpl._write_service_error = _write_error


def _note_error(
    service: ServiceImpl,
    error: Exception,
    kind: type[BaseException],
    value: BaseException,
    trace: TracebackType,
) -> None:
    if isinstance(error, TransportTerminated):
        log.info("a caller of %s left before its answer", service.resolved_name)
    else:
        _error_handler(service, error, kind, value, trace)


def _write_error(service: ServiceImpl, transport: Transport, words: str) -> None:
    with contextlib.suppress(TransportException):  # the caller has left
        _write_service_error(service, transport, words)


def _listen(server: TCPServer) -> socket.socket:
    sock = _open(server)
    sock.listen(WAITING)
    return sock


def _admit(server: TCPROSServer, sock: socket.socket, peer: tuple[str, int]) -> None:
    """Take up a connection in a thread of its own, so that it delays no other."""
    if not _strangers.acquire(blocking=False):
        _refuse("connections", f"{MAX_STRANGERS} peers are connecting already")
        sock.close()
        return
    threading.Thread(target=_meet, args=(server, sock, peer), name="meet", daemon=True).start()


def _meet(server: TCPROSServer, sock: socket.socket, peer: tuple[str, int]) -> None:
    try:
        if _says_in_time(sock):
            _welcome(server, sock, peer)
        else:
            _refuse("connections", f"{peer} sent no ROS header within {HANDSHAKE_TIME:g} s")
            sock.close()
    except OSError as error:  # it hung up; nobody is left to be answered
        _refuse("connections", f"{peer}: {error}")
        sock.close()
    finally:
        _strangers.release()


def _says_in_time(sock: socket.socket) -> bool:
    """Whether a peer's header comes whole, and in time; nothing of it is consumed."""
    end = time.monotonic() + HANDSHAKE_TIME
    sock.settimeout(HANDSHAKE_TIME)
    while time.monotonic() < end:
        seen = sock.recv(LONGEST_HEADER + 4, socket.MSG_PEEK)
        whole = has_whole_header(seen)
        if whole is not None:
            sock.settimeout(None)
            return whole
        time.sleep(PEEK_PERIOD)
    return False


def _read_messages(
    protocol: TCPROSTransportProtocol,
    b: BytesIO,
    messages: list[genpy.Message],
    sock: socket.socket,
) -> None:
    """Take the messages out of a connection's buffer, as rospy would, within bounds.

    A message that is too long is read and forgotten. Where its class has a method `cut`, that makes
    something of its beginning; else a subscriber passes over it, and a service hangs up.
    """
    data = b.getvalue()[: b.tell()]
    b.seek(0)
    b.truncate()
    one_by_one = 1 if isinstance(protocol, TCPService) else None  # answer before reading on
    while True:
        whole, data = split_messages(data, one_by_one)
        for raw in whole if protocol.queue_size is None else whole[-protocol.queue_size :]:
            _decode(protocol, raw, messages)
        size = announced(data)
        if messages or size <= LONGEST_MESSAGE:
            b.write(data)
            return
        held, data = data[4 : 4 + size], data[4 + size :]
        _forget(sock, size - len(held))
        _take_cut(protocol, held, size, messages)


def _decode(protocol: TCPROSTransportProtocol, raw: bytes, messages: list[genpy.Message]) -> None:
    try:
        messages.append(protocol.recv_data_class().deserialize(raw))
    except Exception as error:  # the boundary: any bytes may come, and any must be borne
        _turn_down(
            protocol, f"{len(raw)} bytes that are no {protocol.recv_data_class._type}: {error}"
        )


def _take_cut(
    protocol: TCPROSTransportProtocol, held: bytes, size: int, messages: list[genpy.Message]
) -> None:
    cut = getattr(protocol.recv_data_class, "cut", None)
    if cut is not None:
        messages.append(cut(held, size))
    else:
        _turn_down(protocol, f"a message of {size} bytes, allowed: {LONGEST_MESSAGE}")


def _turn_down(protocol: TCPROSTransportProtocol, words: str) -> None:
    _refuse(protocol.resolved_name, words)
    if isinstance(protocol, TCPService):
        raise TransportTerminated(words)  # a caller waits for an answer: let it hear of the end


def _forget(sock: socket.socket, size: int) -> None:
    scratch = bytearray(CHUNK)
    while size > 0:
        count = sock.recv_into(scratch, min(size, CHUNK))
        if not count:
            raise TransportTerminated("the sender hung up in the middle of a message")
        size -= count


def _refuse(where: str, words: str) -> None:
    if reported := _refusals.count(where, words):
        log.warning("refused on %s: %s", where, reported)
