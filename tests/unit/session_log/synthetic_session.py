# SPDX-License-Identifier: BSD-3-Clause
"""Writes a session as the whole system would record it, without the system.

The story: activation, a tense, talk that does nothing, pulls, a refused command, a stop in
mid-motion, activation again, release, terminate.
"""

from __future__ import annotations

import math
import struct
import zlib
from dataclasses import replace

import numpy as np

from session_log.types import Message
from session_log.writer import SessionWriter
from tests.unit.session_log.message_classes import class_of, serialise, source_of

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
END = 47.0


class Story:
    """Produces the messages in order of time."""

    def __init__(self, duration=END, rate=500, seed=1):
        self.rng = np.random.default_rng(seed)
        self.duration, self.rate = duration, rate
        self.sources, self.counts = {}, {}
        self.messages = []

    def say(self, time, topic, datatype, **fields):
        if topic not in self.sources:
            self.sources[topic] = source_of(topic, datatype)
        message = class_of(datatype)()
        if hasattr(message, "header"):
            message.header.seq = self.counts.get(topic, 0) + 1
            set_time(message.header.stamp, time)
        for name, value in fields.items():
            if isinstance(value, float) and hasattr(getattr(message, name), "secs"):
                set_time(getattr(message, name), value)
            else:
                setattr(message, name, value)
        self.put(time, topic, serialise(message))

    def put(self, time, topic, data):
        self.counts[topic] = self.counts.get(topic, 0) + 1
        stamp = START + int(time * 1e9)
        self.messages.append(Message(self.sources[topic], data, stamp, self.counts[topic]))

    def build(self):
        self.speech()
        self.motions()
        self.fast()
        self.states()
        self.others()
        cut = START + int(self.duration * 1e9)
        kept = [m for m in self.messages if m.log_time <= cut]
        return numbered(sorted(kept, key=lambda m: m.log_time))

    def speech(self):
        mode = "standby"
        self.mode(0.1, "standby", "started")
        for begin, length, transcript, command, reason in SPEECH:
            end = begin + length
            decided = end + 0.25 + self.rng.uniform(0, 0.1)
            wer = [0.0 if c == command and c == transcript else 0.5 for c in COMMANDS]
            self.say(
                decided + 0.002,
                "/voice_assist/utterance",
                "voice_assist/Utterance",
                transcript=transcript,
                phrases=COMMANDS,
                wer=wer,
                command=command,
                reason=reason,
                nearest=command or "pull more",
                confidence=0.93,
                mode=mode,
                origin="recognizer",
                early=command == "stop",
                speech_start=float(begin),
                speech_end=float(end),
                decision=float(decided),
            )
            if command:
                self.answer(decided + 0.004, begin, command)
            if command in ("hey robot", "terminate"):
                mode = "active" if command == "hey robot" else "standby"
                self.mode(decided + 0.01, mode, command)

    def mode(self, time, mode, reason):
        self.say(time, "/voice_assist/mode", "voice_assist/Mode", mode=mode, reason=reason)

    def answer(self, time, begin, command):
        if begin in REFUSED:
            self.event(time, "refused", command, REFUSED[begin])
        elif command == "stop":
            self.event(time, "stop_received", command, "braking along the path")
            self.event(time + 0.25, "at_rest", command, "")
            self.event(time + 0.25, "halted", command, "stop was said")
        else:
            self.event(time, "accepted", command, f"{command}: will do")

    def event(self, time, kind, command, message):
        self.say(
            time,
            "/rst_control/event",
            "rst_control/Event",
            kind=kind,
            command=command,
            message=message,
        )

    def motions(self):
        started = set()
        for begin, end, _, command in MOTION:
            if not any(abs(begin - b) < 4 and c == command for b, c in started):
                self.event(begin, "motion_started", command, "")
            started.add((begin, command))
            self.event(end, "motion_finished", command, "")

    def fast(self):
        js, wrench = class_of("sensor_msgs/JointState")(), class_of("geometry_msgs/WrenchStamped")()
        js.name = JOINTS
        js.velocity = js.effort = [0.0] * len(JOINTS)
        for topic, kind in (
            ("/joint_states", "sensor_msgs/JointState"),
            ("/robot/servo_jp", "sensor_msgs/JointState"),
            ("/robot/tension", "geometry_msgs/WrenchStamped"),
        ):
            self.sources[topic] = source_of(topic, kind)
        for k in range(int(self.duration * self.rate)):
            time = k / self.rate + abs(self.rng.normal(0, 5e-5))
            js.position = [0.4 * i * 0.2 + 0.1 * math.sin(0.2 * time + i) for i in range(10)]
            wrench.wrench.force.z = tension(time) + self.rng.normal(0, 0.01)
            for message in (js, wrench):
                message.header.seq = k + 1
                set_time(message.header.stamp, time)
            data = serialise(js)
            self.put(time, "/joint_states", data)
            self.put(time + 0.0003, "/robot/servo_jp", data)
            self.put(time + 0.0005, "/robot/tension", serialise(wrench))

    def states(self):
        for k in range(int(self.duration * 50)):
            time = k / 50
            motion = next((m for m in MOTION if m[0] <= time < m[1]), None)
            is_halted = 32.8 < time < 36.9
            state = "moving" if motion else "halted" if is_halted else "active"
            state = "stopping" if 32.7 < time < 32.95 else state
            state = "standby" if time < 2.9 or time > 45.0 else state
            error = abs(self.rng.normal(0, 6e-6)) + (1.2e-5 if motion else 0.0)
            is_outside = time < OUTSIDE_UNTIL
            self.say(
                time,
                "/rst_control/state",
                "rst_control/ControllerState",
                state=state,
                phase=motion[2] if motion else "hold",
                command=motion[3] if motion else "",
                halted=is_halted,
                rcm_error=0.2 if is_outside else error,
                insertion=-0.05 if is_outside else 0.12,
                path_speed=0.02 if motion else 0.0,
                tension=tension(time),
                tension_target=target(time),
                tissue_held=9.6 < time < 40.4,
            )

    def others(self):
        for k in range(int(self.duration)):
            array = class_of("diagnostic_msgs/DiagnosticArray")()
            status = class_of("diagnostic_msgs/DiagnosticStatus")()
            status.name, status.message = "controller: loop", "late" if k == 20 else "running"
            status.level = 1 if k == 20 else 0
            value = class_of("diagnostic_msgs/KeyValue")()
            value.key, value.value = "late ticks", str(3 if k >= 20 else 0)
            status.values = [value]
            array.status = [status]
            self.say(
                k + 0.5,
                "/diagnostics",
                "diagnostic_msgs/DiagnosticArray",
                status=array.status,
            )
        for k, time in enumerate((4.0, 11.5, 18.0, 34.0, 43.0)):
            self.say(
                time,
                "/robot/scene/compressed",
                "sensor_msgs/CompressedImage",
                format="png",
                data=png(320, 240, k),
            )
        self.audio()
        self.say(0.0, "/robot_description", "std_msgs/String", data=URDF)

    def audio(self):
        for k in range(int(self.duration * 16000 / 512)):
            time = k * 512 / 16000
            is_speech = any(b <= time < b + n for b, n, *_ in SPEECH)
            level = 6000 if is_speech else 80
            samples = self.rng.normal(0, level, 512).clip(-32767, 32767).astype(np.int16)
            self.say(
                time,
                "/voice_assist/audio",
                "voice_assist/AudioChunk",
                rate=16000,
                first_sample=k * 512,
                samples=samples.tolist(),
            )


URDF = (
    "<robot name='test'>"
    + "".join(
        f"<joint name='{n}' type='revolute'><limit lower='-2.2' upper='2.2'/></joint>"
        for n in JOINTS
    )
    + "</robot>"
)


def numbered(messages):
    counts = {}
    for message in messages:
        topic = message.source.topic
        counts[topic] = counts.get(topic, 0) + 1
        yield replace(message, sequence=counts[topic])


def target(time):
    steps = [(9.6, 1.0), (16.1, 1.5), (20.2, 2.0), (25.1, 1.5), (32.05, 1.8), (40.4, 0.0)]
    return next((t for since, t in reversed(steps) if time >= since), 0.0)


def tension(time):
    value, now = 0.0, 0.0
    while now < time:
        value += (target(now) - value) * min(0.1 / 0.4, 1.0)
        now += 0.1
    return value


def set_time(stamp, seconds):
    stamp.secs, stamp.nsecs = divmod(START + int(seconds * 1e9), 1_000_000_000)


def png(width, height, k):
    """A small picture: a gradient whose colour tells pictures apart."""
    row = bytes(c for x in range(width) for c in (x * 255 // width, 60 + 30 * k, 160))
    raw = b"".join(b"\0" + row for _ in range(height))

    def chunk(kind, data):
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


def write_session(path, **options):
    """Write the story to a new file; returns its messages."""
    messages = list(Story(**options).build())
    path.parent.mkdir(parents=True, exist_ok=True)
    with SessionWriter(path) as writer:
        for name, values in METADATA.items():
            writer.add_metadata(name, values)
        for message in messages:
            writer.add(message)
            writer.commit()
    return messages
