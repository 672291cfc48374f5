# SPDX-License-Identifier: BSD-3-Clause
"""Which sockets of this host wait for peers, and which of them can be reached from other hosts.

Read from /proc/net, which says what is, and not what some variable was meant to bring about.
"""

from __future__ import annotations

import ipaddress
import re
import socket
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

PROC: Final = Path("/proc")
TABLES: Final = ("tcp", "tcp6", "udp", "udp6")
REMEDY: Final = "set ROS_IP=127.0.0.1 before roscore and roslaunch, or see docs/how-to/two-hosts.md"

_LISTENS = {"tcp": "0A", "tcp6": "0A", "udp": "07", "udp6": "07"}  # udp: bound, without a peer
_SOCKET = re.compile(r"socket:\[(\d+)\]")


@dataclass(frozen=True)
class Listener:
    """A socket that waits for peers."""

    protocol: str  # one of TABLES
    address: str
    port: int
    inode: int

    @property
    def is_loopback(self) -> bool:
        """Only this host can reach it."""
        return is_loopback(self.address)

    def __str__(self) -> str:
        return f"{self.protocol} {self.address}:{self.port}"


def listeners(tables: Path = PROC / "net") -> tuple[Listener, ...]:
    """All of this host, as far as this process sees its network; empty where there is no /proc."""
    found: list[Listener] = []
    for protocol in TABLES:
        try:
            lines = (tables / protocol).read_text(encoding="ascii").splitlines()
        except OSError:
            continue
        found += parse_table(protocol, lines)
    return tuple(found)


def parse_table(protocol: str, lines: Sequence[str]) -> list[Listener]:
    """Listeners among the lines of a table of /proc/net, the first of which is its head."""
    rows = (line.split() for line in lines[1:])
    return [
        Listener(protocol, *_endpoint(row[1]), int(row[9]))
        for row in rows
        if len(row) > 9 and row[3] == _LISTENS[protocol] and row[2].strip("0") == ":"
    ]


def inodes_of(process: int | str = "self", proc: Path = PROC) -> set[int]:
    """Inodes of the sockets that a process has open; empty where it is gone or not ours."""
    inodes = set()
    try:
        for entry in (proc / str(process) / "fd").iterdir():
            match = _SOCKET.fullmatch(_target(entry))
            if match:
                inodes.add(int(match[1]))
    except OSError:
        pass
    return inodes


def is_loopback(address: str) -> bool:
    """Whether an IP address leads nowhere but to the host itself."""
    ip = ipaddress.ip_address(address)
    mapped = ip.ipv4_mapped if isinstance(ip, ipaddress.IPv6Address) else None
    return (mapped or ip).is_loopback


def warnings(master: str, found: Iterable[Listener], own: set[int]) -> list[str]:
    """What makes a system reachable from other hosts, and what to do about it; empty: nothing.

    Args:
        master: URI of the ROS master.
        found: What listens on this host.
        own: Inodes of the sockets of the process that asks.
    """
    host, port = _host_and_port(master)
    words = []
    if not _is_loopback_host(host):
        words.append(f"the ROS master is {master}, which is not on loopback: {REMEDY}")
    for listener in found:
        if listener.is_loopback or not listener.protocol.startswith("tcp"):
            continue
        if listener.port == port:
            words.append(
                f"the ROS master listens on {listener}: all who reach this host can command the "
                f"robot, for ROS 1 asks nobody who he is; {REMEDY}"
            )
        elif listener.inode in own:
            words.append(f"this node listens on {listener}, not on loopback alone: {REMEDY}")
    return words


def _endpoint(words: str) -> tuple[str, int]:
    address, port = words.split(":")
    packed = bytes.fromhex(address)  # 32-bit words in the byte order of this host
    count = len(packed) // 4
    octets = struct.pack(f"={count}I", *struct.unpack(f">{count}I", packed))
    return str(ipaddress.ip_address(octets)), int(port, 16)


def _target(entry: Path) -> str:
    try:
        return str(entry.readlink())
    except OSError:  # closed in the meantime
        return ""


def _host_and_port(uri: str) -> tuple[str, int]:
    try:
        parts = urlsplit(uri)
        return parts.hostname or "", parts.port or 0
    except ValueError:
        return "", 0


def _is_loopback_host(host: str) -> bool:
    try:
        found = socket.getaddrinfo(host, None) if host else []
    except OSError:
        return False
    return bool(found) and all(is_loopback(str(entry[4][0]).split("%")[0]) for entry in found)
