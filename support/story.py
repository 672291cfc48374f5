# SPDX-License-Identifier: BSD-3-Clause
"""Writes a session as the whole system would record it, without the system.

The story: activation, a tense, talk that does nothing, pulls, a refused command, a stop in
mid-motion, activation again, release, terminate. Tests use it, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.writer import SessionWriter
from session_log.types import Message, MessageSource
from support.message_classes import class_of, serialise, source_of
from support.story_script import (
    COMMANDS,
    END,
    INTENDED,
    JOINTS,
    METADATA,
    MOTION,
    OUTSIDE_UNTIL,
    REFUSED,
    SPEECH,
    START,
    TROCAR,
    TROCAR_AFTER,
    TROCAR_CHANGE,
    URDF,
    png,
    target,
    tension,
)

COMMIT = 80  # messages in one, as the recorder's of 50 ms


class Story:
    """Produces the messages in order of time; `begins` [s] shifts all of it, stamps included."""

    def __init__(
        self, duration: float = END, rate: int = 500, seed: int = 1, begins: float = 0.0
    ) -> None:
        self.start = START + int(begins * 1e9)  # [ns]
        self.rng = np.random.default_rng(seed)
        self.duration, self.rate = duration, rate
        self.sources: dict[str, MessageSource] = {}
        self.counts: dict[str, int] = {}
        self.messages: list[Message] = []

    def say(self, time: float, topic: str, datatype: str, **fields: Any) -> None:
        """Add a message of these fields, said at a time [s]."""
        if topic not in self.sources:
            self.sources[topic] = source_of(topic, datatype)
        message = class_of(datatype)()
        if hasattr(message, "header"):
            message.header.seq = self.counts.get(topic, 0) + 1
            self.set_time(message.header.stamp, time)
        for name, value in fields.items():
            if isinstance(value, float) and hasattr(getattr(message, name), "secs"):
                self.set_time(getattr(message, name), value)
            else:
                setattr(message, name, value)
        self.put(time, topic, serialise(message))

    def put(self, time: float, topic: str, data: bytes) -> None:
        """Add a message as bytes."""
        self.counts[topic] = self.counts.get(topic, 0) + 1
        stamp = self.start + int(time * 1e9)
        self.messages.append(Message(self.sources[topic], data, stamp, self.counts[topic]))

    def set_time(self, stamp: Any, seconds: float) -> None:
        """Set a time field [s since the beginning]."""
        stamp.secs, stamp.nsecs = divmod(self.start + int(seconds * 1e9), 1_000_000_000)

    def build(self) -> Iterator[Message]:
        """Make all messages, in the order of time."""
        self.speech()
        self.motions()
        self.fast()
        self.states()
        self.others()
        cut = self.start + int(self.duration * 1e9)
        kept = [m for m in self.messages if m.log_time <= cut]
        return numbered(sorted(kept, key=lambda m: m.log_time))

    def speech(self) -> None:
        """What was said, and how it was answered."""
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
                nearest_command=command or "pull more",
                confidence=0.93,
                mode=mode,
                decided_by="recognizer",
                is_partial=command == "stop",
                speech_start=float(begin),
                speech_end=float(end),
                decision=float(decided),
            )
            if command:
                self.answer(decided + 0.004, begin, command)
            if command in ("hey robot", "terminate"):
                mode = "active" if command == "hey robot" else "standby"
                self.mode(decided + 0.01, mode, command)

    def mode(self, time: float, mode: str, reason: str) -> None:
        """A change of the voice mode."""
        self.say(time, "/voice_assist/mode", "voice_assist/Mode", mode=mode, reason=reason)

    def answer(self, time: float, begin: float, command: str) -> None:
        """What the controller makes of a command."""
        if begin in REFUSED:
            self.event(time, "refused", command, REFUSED[begin])
        elif command == "stop":
            self.event(time, "stop_received", command, "braking along the path")
            self.event(time + 0.25, "at_rest", command, "")
            self.event(time + 0.25, "halted", command, "stop was said")
        else:
            self.event(time, "accepted", command, f"{command}: will do")

    def event(self, time: float, kind: str, command: str, message: str) -> None:
        """An event."""
        fields = {"kind": kind, "command": command, "message": message}
        self.say(time, "/rst_control/event", "rst_control/Event", **fields)

    def motions(self) -> None:
        """Beginning and end of every phase, in the event log."""
        started: set[tuple[float, str]] = set()
        for begin, end, _, command in MOTION:
            if not any(abs(begin - b) < 4 and c == command for b, c in started):
                self.event(begin, "motion_started", command, "")
            started.add((begin, command))
            self.event(end, "motion_finished", command, "")

    def fast(self) -> None:
        """Joint states, set-points and tension."""
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
                self.set_time(message.header.stamp, time)
            data = serialise(js)
            self.put(time, "/joint_states", data)
            self.put(time + 0.0003, "/robot/servo_jp", data)
            self.put(time + 0.0005, "/robot/tension", serialise(wrench))

    def states(self) -> None:
        """The controller's state, 50 Hz."""
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

    def others(self) -> None:
        """Diagnostics, pictures, trocar, sound, URDF."""
        for k in range(int(self.duration)):
            status = class_of("diagnostic_msgs/DiagnosticStatus")()
            status.name, status.message = "controller: loop", "late" if k == 20 else "running"
            status.level = 1 if k == 20 else 0
            value = class_of("diagnostic_msgs/KeyValue")()
            value.key, value.value = "late ticks", str(3 if k >= 20 else 0)
            status.values = [value]
            kind = "diagnostic_msgs/DiagnosticArray"
            self.say(k + 0.5, "/diagnostics", kind, status=[status])
        topic, kind = "/robot/scene/compressed", "sensor_msgs/CompressedImage"
        for k, time in enumerate((4.0, 11.5, 18.0, 34.0, 43.0)):
            self.say(time, topic, kind, format="png", data=png(320, 240, k))
        for time, command in INTENDED:
            self.say(time, "/voice_assist/intended", "std_msgs/String", data=command)
        self.trocar(0.05, TROCAR)
        self.trocar(TROCAR_CHANGE, TROCAR_AFTER)
        self.event(TROCAR_CHANGE, "trocar_set", "", "by a service call")
        self.audio()
        self.say(0.0, "/robot_description", "std_msgs/String", data=URDF)

    def trocar(self, time: float, position: tuple[float, float, float]) -> None:
        """The remote centre from a time on."""
        topic, kind = "/rst_control/trocar", "geometry_msgs/PointStamped"
        message = class_of(kind)()
        message.header.frame_id = "base_link"
        message.point.x, message.point.y, message.point.z = position
        self.sources[topic] = source_of(topic, kind)
        self.set_time(message.header.stamp, time)
        self.put(time, topic, serialise(message))

    def audio(self) -> None:
        """Noise, louder where there is speech."""
        for k in range(int(self.duration * 16000 / 512)):
            time = k * 512 / 16000
            is_speech = any(b <= time < b + n for b, n, *_ in SPEECH)
            level = 6000 if is_speech else 80
            samples = self.rng.normal(0, level, 512).clip(-32767, 32767).astype(np.int16)
            fields = {"rate": 16000, "first_sample": k * 512, "samples": samples.tolist()}
            self.say(time, "/voice_assist/audio", "voice_assist/AudioChunk", **fields)


def numbered(messages: Iterable[Message]) -> Iterator[Message]:
    """Count the messages of each topic, as the recorder does."""
    counts: dict[str, int] = {}
    for message in messages:
        topic = message.source.topic
        counts[topic] = counts.get(topic, 0) + 1
        yield message._replace(sequence=counts[topic])


def write_session(path: Path, **options: Any) -> list[Message]:
    """Write the story to a new file; returns its messages."""
    messages = list(Story(**options).build())
    path.parent.mkdir(parents=True, exist_ok=True)
    recording_of(path, messages, METADATA)
    return messages


def recording_of(
    path: Path, messages: Iterable[Message] = (), metadata: Mapping[str, Any] = MappingProxyType({})
) -> SessionReader:
    """Write messages, and metadata by name, to a new file; returns its reader."""
    with SessionWriter(path) as writer:
        for name, values in metadata.items():
            writer.add_metadata(name, values)
        for index, message in enumerate(messages):
            writer.add(message)
            if index % COMMIT == 0:
                writer.commit()
    return SessionReader(path)
