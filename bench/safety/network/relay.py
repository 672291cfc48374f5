# SPDX-License-Identifier: BSD-3-Clause
"""The bad network: a process that carries the packets between two hosts, late, lossy or not at all.

netem would do the same where the kernel has it; many have not (virtual machines, containers). This
relay needs nothing but TUN devices: it reads each IP packet that one host sends and writes it to
the other one's device. What TCP does about a lost packet is thus done by the real TCP of both.

    python -m bench.safety.network.relay NAMESPACE_A NAMESPACE_B DEVICE SEED

Each line on its standard input is a JSON object with the conditions of both directions; it answers
with the time at which they came into force [s], time.monotonic().
"""

from __future__ import annotations

import ctypes
import fcntl
import heapq
import json
import os
import random
import select
import struct
import sys
import time
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

NAMESPACES = Path("/var/run/netns")  # where iproute2 keeps those that have a name
TUN = Path("/dev/net/tun")
LARGEST = 65536  # [bytes] of an IP packet
QUEUE = 10_000  # packets that may be on their way; what comes then is lost, as in any router
_TUNSETIFF, _IFF_TUN, _IFF_NO_PI = 0x400454CA, 0x0001, 0x1000  # linux/if_tun.h
_CLONE_NEWNET = 0x40000000  # linux/sched.h


@dataclass(frozen=True)
class LinkConditions:
    """What happens to packets of one direction."""

    loss: float = 0.0  # [0, 1] chance of each to be lost; 1: the way is cut
    delay: float = 0.0  # [s] of each


@dataclass(frozen=True)
class RelayLink:
    """Both directions."""

    to_robot: LinkConditions = LinkConditions()
    to_voice: LinkConditions = LinkConditions()


class RelayDirection:
    """One direction: takes packets, and gives them back when they are due, or never.

    Args:
        seed: Chooses the packets that are lost.
    """

    def __init__(self, seed: int) -> None:
        self.conditions = LinkConditions()
        self._random = random.Random(seed)
        self._waiting: list[tuple[float, int, bytes]] = []  # a heap, by the time due
        self._count = 0

    def take(self, packet: bytes, now: float) -> None:
        """A packet was sent at a time [s]."""
        if self._random.random() < self.conditions.loss or len(self._waiting) >= QUEUE:
            return
        self._count += 1  # keeps the order of packets that are due at the same time
        heapq.heappush(self._waiting, (now + self.conditions.delay, self._count, packet))

    def due(self, now: float) -> list[bytes]:
        """Packets that arrive by a time [s]; those on their way when it was cut are lost."""
        found = []
        while self._waiting and self._waiting[0][0] <= now:
            packet = heapq.heappop(self._waiting)[2]
            if self.conditions.loss < 1.0:
                found.append(packet)
        return found

    @property
    def next_due(self) -> float:
        """When the next packet is due [s]; infinity: none waits."""
        return self._waiting[0][0] if self._waiting else float("inf")


def to_line(link: RelayLink) -> str:
    """Conditions as one line for the relay."""
    return json.dumps(asdict(link))


def from_line(line: str) -> RelayLink:
    """Conditions as the relay reads them."""
    given = json.loads(line)
    return RelayLink(*(LinkConditions(**given[name]) for name in ("to_robot", "to_voice")))


def main() -> None:
    """Carry packets until standard input ends."""
    robot_side, voice_side, device, seed = sys.argv[1:5]
    with suppress(OSError):  # waiting for a processor would be a delay that nobody asked for
        os.setpriority(os.PRIO_PROCESS, 0, -15)
    ends = [_attach(name, device) for name in (robot_side, voice_side)]
    # A packet read from one end is due at the other: index 0 is what the robot's host sent.
    ways = [RelayDirection(int(seed)), RelayDirection(int(seed) + 1)]
    print(json.dumps(time.monotonic()), flush=True)
    commands, rest = sys.stdin.fileno(), b""
    while True:
        wait = max(0.0, min(min(way.next_due for way in ways) - time.monotonic(), 1.0))
        ready = select.select([*ends, commands], [], [], wait)[0]
        for number in (0, 1):
            if ends[number] in ready:
                ways[number].take(os.read(ends[number], LARGEST), time.monotonic())
            for packet in ways[number].due(time.monotonic()):
                with suppress(OSError):  # the other device is down: lost
                    os.write(ends[1 - number], packet)
        if commands in ready:
            read = os.read(commands, LARGEST)
            if not read:
                return
            *lines, rest = (rest + read).split(b"\n")
            for line in lines:
                link = from_line(line.decode())
                ways[0].conditions, ways[1].conditions = link.to_voice, link.to_robot
                print(json.dumps(time.monotonic()), flush=True)


def _attach(namespace: str, device: str) -> int:
    """A descriptor of the TUN device of a namespace; the process itself ends up in there."""
    libc = ctypes.CDLL(None, use_errno=True)
    entrance = os.open(NAMESPACES / namespace, os.O_RDONLY)
    try:
        if libc.setns(entrance, _CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), f"namespace {namespace} cannot be entered")
    finally:
        os.close(entrance)
    descriptor = os.open(TUN, os.O_RDWR)
    request = struct.pack("16sH22x", device.encode(), _IFF_TUN | _IFF_NO_PI)
    fcntl.ioctl(descriptor, _TUNSETIFF, request)
    return descriptor


if __name__ == "__main__":
    main()
