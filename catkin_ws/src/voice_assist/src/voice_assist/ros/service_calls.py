# SPDX-License-Identifier: BSD-3-Clause
"""Calls of services that are given up in time, and are not delivered later on."""

from __future__ import annotations

import socket
import struct
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from io import BytesIO
from queue import Empty, Queue
from typing import Any, TypeVar

import rospy

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


def timely(request: type[Any], send_by: float) -> type[Any]:
    """A class of requests that are refused after their deadline, however long connecting took.

    Args:
        request: Class of the service's requests.
        send_by: Deadline [s], steady clock.
    """

    def serialize(self: Any, buff: BytesIO) -> None:
        if time.monotonic() > send_by:
            raise rospy.ServiceException("too late to be sent")
        request.serialize(self, buff)

    return type(request.__name__, (request,), {"serialize": serialize})


def drop(proxy: rospy.ServiceProxy) -> None:
    """Close so that a request that the network still holds back is never delivered.

    Closed as usual, TCP would go on for minutes to deliver what it had been given.
    """
    transport = proxy.transport
    if transport is not None and transport.socket is not None:
        with suppress(OSError, AttributeError):  # it is closed by now
            transport.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _AT_ONCE)
    proxy.close()
