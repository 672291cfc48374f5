# SPDX-License-Identifier: BSD-3-Clause
"""Two hosts on one machine: network namespaces with a TUN device each, by iproute2."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from bench.safety.network.relay import NAMESPACES, TUN, RelayLink, to_line

ROBOT, VOICE, VOICE_MOVED = "10.77.0.1", "10.77.0.2", "10.77.0.3"
DEVICE = "rst0"
_NETWORK = 24  # bits of the network's part of an address
_CAP_SYS_ADMIN = 21  # linux/capability.h
STEP_TIME = 10.0  # [s] for one step of iproute2, or for a child to end


def missing() -> str:
    """What this machine lacks for two hosts, in plain words; empty: nothing."""
    if shutil.which("ip") is None:
        return "iproute2 is not installed: there is no program `ip`"
    if os.geteuid() != 0 or not _may_administer():
        return "network namespaces need root with CAP_SYS_ADMIN"
    if not TUN.exists():
        return f"there is no {TUN}: the kernel has no TUN, or the container keeps it"
    name = f"rst-probe-{os.getpid()}"
    tried = subprocess.run(["ip", "netns", "add", name], capture_output=True, text=True)
    if tried.returncode:
        return f"no network namespace can be made: {tried.stderr.strip()}"
    subprocess.run(["ip", "netns", "del", name], check=False)
    return ""


def _may_administer() -> bool:
    status = Path("/proc/self/status").read_text(encoding="ascii")
    effective = next(line for line in status.splitlines() if line.startswith("CapEff:")).split()[1]
    return bool(int(effective, 16) >> _CAP_SYS_ADMIN & 1)


class Hosts:
    """The robot's host and the voice's, not yet joined by anything; a context manager."""

    def __init__(self) -> None:
        self.robot, self.voice = (f"rst{os.getpid()}{side}" for side in ("robot", "voice"))

    def __enter__(self) -> Hosts:
        try:
            for name, address in ((self.robot, ROBOT), (self.voice, VOICE)):
                _ip("netns", "add", name)
                _ip("-n", name, "link", "set", "lo", "up")
                _ip("-n", name, "tuntap", "add", "dev", DEVICE, "mode", "tun")
                _ip("-n", name, "addr", "add", f"{address}/{_NETWORK}", "dev", DEVICE)
                _ip("-n", name, "link", "set", DEVICE, "up")
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(self, *_: object) -> None:
        for name in (self.robot, self.voice):
            if (NAMESPACES / name).exists():
                _ip("netns", "del", name)


def on(namespace: str, command: Sequence[str]) -> list[str]:
    """A command, to be run on the host of a namespace."""
    return ["ip", "netns", "exec", namespace, *command]


def readdress(namespace: str, before: str, after: str) -> None:
    """Give a host another address, as a new lease of DHCP does."""
    _ip("-n", namespace, "addr", "del", f"{before}/{_NETWORK}", "dev", DEVICE)
    _ip("-n", namespace, "addr", "add", f"{after}/{_NETWORK}", "dev", DEVICE)


def _ip(*words: str) -> None:
    done = subprocess.run(["ip", *words], capture_output=True, text=True, timeout=STEP_TIME)
    if done.returncode:
        raise RuntimeError(f"`ip {' '.join(words)}`: {done.stderr.strip()}")


class Child:
    """A module of this package as a process that takes lines of JSON and answers in such.

    Args:
        command: That starts it.
        environment: Added to that of this process.
    """

    def __init__(self, command: Sequence[str], environment: Mapping[str, str]) -> None:
        self.process = subprocess.Popen(
            command,
            env={**os.environ, **environment},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )

    def send(self, line: str) -> None:
        """Send a line.

        Raises:
            RuntimeError: The process ended.
        """
        if self.process.stdin is None or self.process.poll() is not None:
            raise RuntimeError(f"{self.process.args!r} ended with {self.process.returncode}")
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def hear(self) -> object:
        """The next line, read as JSON; waits for it.

        Raises:
            RuntimeError: The process ended.
        """
        line = self.process.stdout.readline() if self.process.stdout is not None else ""
        if not line:
            raise RuntimeError(f"{self.process.args!r} says nothing any more")
        return json.loads(line)

    def end(self) -> None:
        """Close its standard input, which ends it; kill it where it does not."""
        if self.process.stdin is not None and self.process.poll() is None:
            self.process.stdin.close()
        try:
            self.process.wait(STEP_TIME)
        except subprocess.TimeoutExpired:
            self.kill()

    def kill(self) -> None:
        """End it at once: it gets no time to say good-bye."""
        self.process.kill()
        self.process.wait()


class Relay:
    """The link between both hosts.

    Args:
        robot: Namespace of the robot's host.
        voice: Namespace of the voice's.
        seed: Chooses the packets that are lost.
    """

    def __init__(self, robot: str, voice: str, seed: int) -> None:
        words = [sys.executable, "-m", "bench.safety.network.relay", robot, voice, DEVICE]
        self._child = Child([*words, str(seed)], {})
        self._child.hear()

    def set(self, link: RelayLink) -> float:
        """Bring conditions into force; returns when they are [s], time.monotonic()."""
        self._child.send(to_line(link))
        return float(str(self._child.hear()))

    def end(self) -> None:
        """Take the link away."""
        self._child.end()
