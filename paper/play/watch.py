# SPDX-License-Identifier: BSD-3-Clause
"""Follows the running system, so that nothing waits longer than it must."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import rospy
from std_msgs.msg import String

from paper.play.plan import STOP, RobotDialogue
from rst_control.msg import ControllerState, Event
from voice_assist.msg import AudioChunk, Mode, Utterance

UNDER_WAY = ("moving", "stopping")
ANSWERS = ("accepted", "refused", "stop_received")
SILENT = 3  # of 32767
SECOND_THOUGHT = 0.4  # [s] in which a command may follow words of the same phrase that were none
STATE_LAG = 0.1  # [s] by which the state may follow the event
STATE_WITHIN = 0.5  # [s] in which the state follows the event of a motion
RECORDER_WITHIN = 5.0  # [s] for the recorder to find the topic of what is meant


@dataclass(frozen=True)
class Happened:
    """One decision of the recogniser or one entry of the controller's events."""

    time: float  # [s] since 1970, its own stamp
    kind: str  # heard, or that of the event
    command: str
    words: str  # transcript or message


class SessionWatch:
    """Subscribes to the session; context manager. All times are wall clock [s]."""

    def __init__(self) -> None:
        self.ready = {part: threading.Event() for part in ("recorder", "robot", "voice")}
        self.hears_sound = threading.Event()
        self._happened: list[Happened] = []
        self._state: ControllerState | None = None
        self._mode = ""
        self._changed = threading.Condition()
        self._intended = rospy.Publisher("voice_assist/intended", String, queue_size=10)

    def __enter__(self) -> SessionWatch:
        self._subscribers = [
            rospy.Subscriber("voice_assist/utterance", Utterance, self._on_utterance),
            rospy.Subscriber("voice_assist/mode", Mode, self._on_mode),
            rospy.Subscriber("rst_control/state", ControllerState, self._on_state),
            rospy.Subscriber("rst_control/event", Event, self._on_event),
            rospy.Subscriber("session_log/file", String, self._on_file),
            rospy.Subscriber("voice_assist/audio", AudioChunk, self._on_audio),
        ]
        return self

    def __exit__(self, *_: object) -> None:
        for subscriber in self._subscribers:
            subscriber.unregister()

    def wait_for_recorder(self) -> None:
        """Wait until the recorder listens to what is meant.

        Raises:
            RuntimeError: It does not in time.
        """
        deadline = time.monotonic() + RECORDER_WITHIN
        while self._intended.get_num_connections() == 0:
            if time.monotonic() > deadline:
                raise RuntimeError("the recorder does not record voice_assist/intended")
            time.sleep(0.05)

    def intend(self, phrase: str) -> None:
        """Put on record what begins to sound; empty: no command."""
        self._intended.publish(String(phrase))

    def situation(self) -> RobotDialogue:
        """State of dialogue and robot."""
        with self._changed:
            state = self._state
            if state is None:
                return RobotDialogue(self._mode == "active", False, False, False)
            return RobotDialogue(
                is_listening=self._mode == "active",
                is_active=state.assistance_enabled,
                is_halted=state.halted,
                is_held=state.tissue_held,
                tension=round(state.tension, 1) if state.tissue_held else 0.0,
            )

    def since(self, moment: float, *kinds: str) -> list[Happened]:
        """All of some kinds that happened at or after a moment."""
        with self._changed:
            return [h for h in self._happened if h.time >= moment and h.kind in kinds]

    def heard(self, began: float, ended: float, within: float) -> Happened | None:
        """Wait for what is decided of a phrase: a command, or else the last that is none.

        Args:
            began: When the phrase began.
            ended: When it had ended; what is refused before may have been its first half.
            within: Longest wait.
        """
        self._wait(
            lambda: bool(self._commands(began) or self.since(ended, "heard")),
            within,
        )
        self._wait(lambda: bool(self._commands(began)), SECOND_THOUGHT)
        decisions = self._commands(began) or self.since(began, "heard")
        return decisions[-1] if decisions else None

    def answer(self, command: str, moment: float, within: float) -> Happened | None:
        """Wait for the controller's answer to a command that was decided after a moment."""

        def find() -> Happened | None:
            answers = self.since(moment, *ANSWERS)
            return next(
                (
                    a
                    for a in answers
                    if a.command == command or (command == STOP and a.kind == "stop_received")
                ),
                None,
            )

        self._wait(lambda: find() is not None, within)
        return find()

    def started(self, command: str, moment: float, within: float) -> bool:
        """Wait for the motion of a command."""

        def is_there() -> bool:
            return any(h.command == command for h in self.since(moment, "motion_started"))

        return self._wait(is_there, within)

    def phase(self, phase: str, within: float) -> bool:
        """Wait until a motion that has begun is in a phase; false when it ended before."""

        def now() -> str:
            state = self._state
            return state.phase if state is not None and state.state == "moving" else ""

        self._wait(lambda: bool(now()), STATE_WITHIN)
        self._wait(lambda: now() in ("", phase), within)
        return now() == phase

    def rest(self, within: float) -> bool:
        """Wait until the robot rests, after the last motion that has begun."""

        def is_there() -> bool:
            state = self._state
            if state is None or state.state in UNDER_WAY:
                return False
            starts = [h.time for h in self._happened if h.kind == "motion_started"]
            return state.header.stamp.to_sec() > max(starts, default=0.0) + STATE_LAG

        return self._wait(is_there, within)

    @property
    def is_moving(self) -> bool:
        """Whether a motion is under way."""
        with self._changed:
            return self._state is not None and self._state.state in UNDER_WAY

    def _commands(self, moment: float) -> list[Happened]:
        return [h for h in self.since(moment, "heard") if h.command]

    def _wait(self, is_there: Callable[[], bool], within: float) -> bool:
        with self._changed:
            return self._changed.wait_for(is_there, within)

    def _add(self, happened: Happened) -> None:
        with self._changed:
            self._happened.append(happened)
            self._changed.notify_all()

    def _on_utterance(self, m: Utterance) -> None:
        words = m.transcript if m.command else f"{m.transcript} ({m.reason})"
        self._add(Happened(m.decision.to_sec(), "heard", m.command, words))

    def _on_event(self, m: Event) -> None:
        self._add(Happened(m.header.stamp.to_sec(), m.kind, m.command, m.message))

    def _on_mode(self, m: Mode) -> None:
        with self._changed:
            self._mode = m.mode
            self._changed.notify_all()
        self.ready["voice"].set()

    def _on_state(self, m: ControllerState) -> None:
        with self._changed:
            self._state = m
            self._changed.notify_all()
        if m.state != "faulted":
            self.ready["robot"].set()

    def _on_file(self, m: String) -> None:
        if m.data:
            self.ready["recorder"].set()

    def _on_audio(self, m: AudioChunk) -> None:
        if not self.hears_sound.is_set() and max(map(abs, m.samples), default=0) > SILENT:
            self.hears_sound.set()
