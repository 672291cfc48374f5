# SPDX-License-Identifier: BSD-3-Clause
"""Calls of services that are given up in time, and are not delivered later on."""

from __future__ import annotations

import socket
import struct
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from queue import Empty, Queue
from typing import Any, TypeVar

import rospy

from typed_config.ros.connections import is_closed

_ANSWERED = "responded with an error"  # in rospy's words for an error that the service sent
_AT_ONCE = struct.pack("ii", 1, 0)  # SO_LINGER: what is not delivered yet is thrown away
T = TypeVar("T")


def in_time(work: Callable[[], T], within: float) -> T | None:
    """What a thread of its own finds, which the end of the process does not wait for.

    Args:
        work: What it does.
        within: Longest wait for it [s].

    Returns:
        What it gives; None: an error of the network, or not in time.
    """
    box: Queue[T | None] = Queue(1)

    def run() -> None:
        try:
            box.put(work())
        except (rospy.ServiceException, rospy.ROSException, OSError):
            box.put(None)

    threading.Thread(target=run, name="call", daemon=True).start()
    try:
        return box.get(timeout=within)
    except Empty:
        return None


def timely(
    request: type[Any], send_by: float, on_send: Callable[[], None] = lambda: None
) -> type[Any]:
    """A class of requests that are refused after their deadline, however long connecting took.

    Args:
        request: Class of the service's requests.
        send_by: Deadline [s], steady clock.
        on_send: Called just before a request goes out; it may refuse by a `ServiceException`.
    """

    def serialize(self: Any, buff: BytesIO) -> None:
        if time.monotonic() > send_by:
            raise rospy.ServiceException("too late to be sent")
        on_send()
        request.serialize(self, buff)

    return type(request.__name__, (request,), {"serialize": serialize})


def has_ended(proxy: rospy.ServiceProxy) -> bool:
    """Whether the service closed the connection that a proxy keeps open, as where its node ended.

    A request over it would fail, and nobody could say whether it was carried out.
    """
    connection = getattr(proxy.transport, "socket", None)
    return connection is not None and is_closed(connection)


def drop(proxy: rospy.ServiceProxy) -> None:
    """Close so that a request that the network still holds back is never delivered.

    Closed as usual, TCP would go on for minutes to deliver what it had been given.
    """
    transport = proxy.transport
    if transport is not None and transport.socket is not None:
        with suppress(OSError, AttributeError):  # it is closed by now
            transport.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _AT_ONCE)
    proxy.close()


@dataclass(frozen=True)
class Reply:
    """What came of a call."""

    response: Any  # of the service; None: there is none
    trouble: str = ""  # why there is none
    may_take_effect: bool = False  # the request went out, and nothing says what became of it


def never() -> bool:
    """Nothing is given up."""
    return False


def call_service(
    name: str,
    kind: Any,
    *words: Any,
    within: float,
    appears: float = 0.0,
    is_void: Callable[[], bool] = never,
) -> Reply:
    """Ask a service once; what is not sent in time is never sent.

    Args:
        name: Of the service.
        kind: Its class.
        words: Of the request.
        within: Longest wait for the answer [s].
        appears: Longest wait for the service to be there [s]; 0: it has to be there already.
        is_void: Whether the request is not to be sent any more.
    """
    sending = _Sending(is_void)
    request = timely(kind._request_class, time.monotonic() + within, sending.begin)(*words)
    proxy = rospy.ServiceProxy(name, kind, persistent=True)  # which `drop` can close

    def ask() -> Reply:
        try:
            if appears > 0.0:
                rospy.wait_for_service(name, appears)
            return Reply(proxy(request))
        except (rospy.ServiceException, rospy.ROSException, OSError) as error:
            is_open = sending.has_begun and _ANSWERED not in str(error)
            return Reply(None, str(error), is_open)

    reply = in_time(ask, within)
    if reply is None:
        reply = Reply(None, f"no answer within {within:g} s", sending.give_up())
    if reply.response is None:
        drop(proxy)
    else:
        proxy.close()
    return reply


class _Sending:
    """Whether a request went out; once it is given up it no longer does."""

    def __init__(self, is_void: Callable[[], bool]) -> None:
        self._lock, self._is_given_up, self._is_void = threading.Lock(), False, is_void
        self.has_begun = False

    def begin(self) -> None:
        """Note that it goes out.

        Raises:
            rospy.ServiceException: It was given up before.
        """
        with self._lock:
            if self._is_given_up or self._is_void():
                raise rospy.ServiceException("given up before it was sent")
            self.has_begun = True

    def give_up(self) -> bool:
        """Keep it from going out; gives whether it had gone out before."""
        with self._lock:
            self._is_given_up = True
            return self.has_begun
