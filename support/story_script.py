# SPDX-License-Identifier: BSD-3-Clause
"""What happens in a made-up session, when, and what it is recorded with."""

from __future__ import annotations

import struct
import zlib
from bisect import bisect_left
from functools import cache

START = 1_795_200_000_000_000_000  # [ns]
JOINTS = [f"joint_{i}" for i in range(1, 8)] + [
    "joint_pitch",
    "joint_finger_left",
    "joint_finger_right",
]
COMMANDS = ["hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate"]
# spoken at [s], length [s], transcript, command or "", reason
SPEECH = [
    (2.0, 0.7, "hey robot", "hey robot", ""),
    (5.0, 0.5, "tense", "tense", ""),
    (12.0, 1.4, "could you pass me the clamp", "", "nothing close enough"),
    (15.0, 0.7, "pull more", "pull more", ""),
    (19.0, 0.8, "pull moor", "pull more", ""),
    (22.0, 0.4, "pull", "", "pull more and pull less fit equally"),
    (24.0, 0.7, "pull less", "pull less", ""),
    (28.0, 0.5, "tense", "tense", ""),
    (31.0, 0.7, "pull more", "pull more", ""),
    (32.2, 0.4, "stop", "stop", ""),
    (36.0, 0.7, "hey robot", "hey robot", ""),
    (39.0, 0.6, "release", "release", ""),
    (44.0, 0.8, "terminate", "terminate", ""),
]
# motion from, to [s]; phase; command
OUTSIDE_UNTIL = 1.0  # [s] the tool is not in the patient
MOTION = [
    (5.9, 9.0, "reach", "tense"),
    (9.0, 9.6, "close", "tense"),
    (9.6, 11.2, "pull", "tense"),
    (16.1, 17.0, "step", "pull more"),
    (20.2, 21.1, "step", "pull more"),
    (25.1, 26.0, "step", "pull less"),
    (32.05, 32.75, "step", "pull more"),
    (39.9, 40.4, "open", "release"),
    (40.4, 42.0, "ease", "release"),
]
REFUSED = {28.0: "tissue is held already"}
# began to sound at [s], command or "" for words that are none; one phrase is never heard
INTENDED = [(begin, command) for begin, _, _, command, _ in SPEECH] + [(46.0, "stop")]
TROCAR = (3e-6, 4e-6, 0.75)  # [m] 5 um beside the shaft, which stands still on the z axis
TROCAR_CHANGE = 20.0  # [s]
TROCAR_AFTER = (6e-6, 8e-6, 0.75)  # [m] 10 um beside it
END = 47.0


def urdf() -> str:
    """A robot all of whose joints turn about the z axis, so that its shaft never moves."""
    links = ["base_link", *(f"link_{i}" for i in range(1, 8))]
    joints = [
        joint_text(name, "revolute", parent, child)
        for name, parent, child in zip(JOINTS, links, links[1:], strict=False)
    ]
    joints.append(joint_text("joint_shaft", "fixed", "link_7", "interface_link", 0.0))
    joints += [joint_text(n, "revolute", "interface_link", f"{n}_link") for n in JOINTS[7:]]
    joints.append(joint_text("joint_tip", "fixed", "interface_link", "tool_tip", 0.3))
    return f"<robot name='test'>{''.join(joints)}</robot>"


def joint_text(name: str, kind: str, parent: str, child: str, z: float = 0.1) -> str:
    """One joint of a URDF."""
    return (
        f"<joint name='{name}' type='{kind}'><origin xyz='0 0 {z}' rpy='0 0 0'/>"
        f"<parent link='{parent}'/><child link='{child}'/><axis xyz='0 0 1'/>"
        "<limit lower='-2.2' upper='2.2'/></joint>"
    )


URDF = urdf()


def target(time: float) -> float:
    """Tension asked for at a time [s]; [N]."""
    steps = [(9.6, 1.0), (16.1, 1.5), (20.2, 2.0), (25.1, 1.5), (32.05, 1.8), (40.4, 0.0)]
    return next((t for since, t in reversed(steps) if time >= since), 0.0)


def tension(time: float) -> float:
    """Tension measured at a time [s] up to twice the story's, without noise; [N]."""
    times, values = _course()
    return values[bisect_left(times, time)]


@cache
def _course() -> tuple[list[float], list[float]]:
    """Times of steps [s], and the tension before each [N]."""
    times, values = [0.0], [0.0]
    while times[-1] < 2.0 * END:
        values.append(values[-1] + (target(times[-1]) - values[-1]) * 0.25)
        times.append(times[-1] + 0.1)
    return times, values


def png(width: int, height: int, k: int) -> bytes:
    """A small picture: a gradient whose colour differs from picture to picture."""
    row = bytes(c for x in range(width) for c in (x * 255 // width, 60 + 30 * k, 160))
    raw = b"".join(b"\0" + row for _ in range(height))

    def chunk(kind: bytes, data: bytes) -> bytes:
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    size = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", size)
        + chunk(b"IDAT", zlib.compress(raw))
        + chunk(b"IEND", b"")
    )


METADATA = {
    "session": {"started": "2026-11-20T10:00:00.000+00:00", "seed": "7"},
    "code": {"commit": "0123456789abcdef0123456789abcdef01234567", "changed_files": ""},
    "machine": {"host": "bench", "processor": "a processor", "cores": "2"},
    "session/voice_assist": {"model": "embedded", "model_sha256": "ab" * 32},
}
