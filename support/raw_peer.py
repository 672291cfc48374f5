# SPDX-License-Identifier: BSD-3-Clause
"""A peer that speaks TCPROS by itself, and says whatever it likes."""

from __future__ import annotations

import os
import socket
import struct
import threading
import time
from contextlib import suppress
from pathlib import Path

import rosgraph
import rosgraph.network
import rospy

from rst_control.srv import Command
from typed_config.ros.xmlrpc import ask

SERVICE = "/rst_control/command"
PATIENCE = 10.0  # [s] for an answer
BATCH = 50  # calls that a flood sends at a time, without waiting for their answers


def service_address() -> tuple[str, int]:
    """Where the controller takes connections."""
    uri = rosgraph.Master(rospy.get_name()).lookupService(SERVICE)
    return rospy.core.parse_rosrpc_uri(uri)


def process_of(node: str) -> int:
    """Number of a node's process."""
    api = rosgraph.Master(rospy.get_name()).lookupNode(node)
    return int(str(ask(api, "getPid", rospy.get_name())))


def resident_memory(process: int) -> float:
    """Memory that a process holds [MB]."""
    statm = Path(f"/proc/{process}/statm").read_text(encoding="ascii")
    return int(statm.split()[1]) * os.sysconf("SC_PAGESIZE") / 1e6


def words(text: str | bytes) -> bytes:
    """A request of the command service, led by its length."""
    raw = text.encode() if isinstance(text, str) else text
    return struct.pack("<II", len(raw) + 4, len(raw)) + raw


class Peer:
    """One connection to the controller's TCPROS port; a context manager.

    Args:
        caller: Name that it claims; None: it sends no header at all.
        header: Fields to send instead of, or beside, the right ones.
    """

    def __init__(self, caller: str | None, **header: str) -> None:
        self.socket = socket.create_connection(service_address(), PATIENCE)
        if caller is not None:
            fields = {
                "service": SERVICE,
                "md5sum": Command._md5sum,
                "callerid": caller,
                "persistent": "1",
                **header,
            }
            rosgraph.network.write_ros_handshake_header(self.socket, fields)

    def __enter__(self) -> Peer:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def greet(self) -> dict[str, str]:
        """Read the controller's own header."""
        head = self.take(4)
        (size,) = struct.unpack("<I", head)
        return rosgraph.network.decode_ros_handshake_header(head + self.take(size))

    def call(self, text: str | bytes) -> tuple[bool, str]:
        """Give a command, and wait for the answer: accepted or not, and the message."""
        self.socket.sendall(words(text))
        return self.answer()

    def answer(self) -> tuple[bool, str]:
        """Read one answer."""
        assert self.take(1) == b"\x01"
        (size,) = struct.unpack("<I", self.take(4))
        raw = self.take(size)
        (length,) = struct.unpack_from("<I", raw, 1)
        return bool(raw[0]), raw[5 : 5 + length].decode()

    def take(self, count: int) -> bytes:
        """Read so many bytes; fails where the controller hangs up before."""
        raw = b""
        while len(raw) < count:
            piece = self.socket.recv(count - len(raw))
            assert piece, f"the controller hung up after {len(raw)} of {count} bytes"
            raw += piece
        return raw


class Flood:
    """Callers that send as fast as they are let, each over a connection of its own, until closed.

    Args:
        texts: What they call, in turn.
        callers: How many.
        rate: Calls per second, of all together [1/s].
    """

    def __init__(self, texts: tuple[str, ...], callers: int = 50, rate: float = 10_000.0) -> None:
        self.offered = 0  # calls that the connections took
        self._texts, self._period = texts, callers * BATCH / rate
        self._over = threading.Event()
        self._lock = threading.Lock()
        self._threads = [
            threading.Thread(target=self._run, args=(f"/flood_{number}",), daemon=True)
            for number in range(callers)
        ]

    def __enter__(self) -> Flood:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        for thread in self._threads:
            thread.join(PATIENCE)

    def _run(self, caller: str) -> None:
        calls = b"".join(words(self._texts[n % len(self._texts)]) for n in range(BATCH))
        with suppress(OSError), Peer(caller) as peer:
            peer.greet()
            peer.socket.setblocking(False)
            due, left = time.monotonic(), b""
            while not self._over.is_set():
                with suppress(BlockingIOError):
                    peer.socket.recv(1 << 16)
                left = left or calls
                with suppress(BlockingIOError):
                    left = left[peer.socket.send(left) :]
                    if not left:
                        self._count()
                due += self._period
                self._over.wait(max(0.0, due - time.monotonic()))

    def _count(self) -> None:
        with self._lock:
            self.offered += BATCH
