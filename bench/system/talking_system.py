# SPDX-License-Identifier: BSD-3-Clause
"""The whole simulated system on talk without end, and what it reports of itself."""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rospy
import soundfile
from diagnostic_msgs.msg import DiagnosticArray

from rst_control.msg import ControllerState
from rst_control.srv import Command
from support.figures import ROOT
from support.launched_system import READY_TIME, System
from support.theatre_sound import LEVEL, RATE, speak, theatre_noise
from support.waiting import wait_until
from voice_assist.msg import Mode, Utterance

PAUSE = 0.05  # [s] between two tries of the first command
SETTLE = 5.0  # [s] after the start that is not measured
LEAD = 40.0  # [s] more of sound than measured, for the nodes to start in
TALK = (
    "they will pull more people from the ward and release the beds before the morning",
    "I told him the lights were far too dim to see the stopper on the table",
    "the patient was tense all day and nobody could tell her what was wrong with the knee",
    "we should stop by the office later and ask for the results of the last three weeks",
)
COMMANDS = ("hey robot", "tense", "pull more", "pull less", "pull more", "pull less", "release")


@dataclass(frozen=True)
class Loop:
    """Totals of the control loop at one moment."""

    ticks: int
    late: float  # skipped ones included
    p99: float  # [us] of a tick
    lateness: float  # [us], p99

    def late_percent_since(self, first: Loop) -> float:
        """Late ticks since an earlier moment [%]."""
        return 100.0 * (self.late - first.late) / max(1, self.ticks - first.ticks)


class Observer:
    """Keeps what the running system says of itself."""

    def __init__(self) -> None:
        self.voice_ready = threading.Event()
        self.loop: Loop | None = None
        self.utterances = 0
        self.first_command = self.first_sound = 0.0  # [s] from roslaunch on, taken and heard
        self.state: ControllerState | None = None
        self._subscribers = [
            rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics),
            rospy.Subscriber("rst_control/state", ControllerState, self._on_state),
            rospy.Subscriber("voice_assist/mode", Mode, lambda _: self.voice_ready.set()),
            rospy.Subscriber("voice_assist/utterance", Utterance, self._on_utterance),
        ]

    def totals(self) -> Loop:
        """Totals of the loop as last published.

        Raises:
            RuntimeError: The controller publishes none.
        """
        wait_until(lambda: self.loop is not None, "diagnostics of the control loop", 5.0)
        assert self.loop is not None
        return self.loop

    def _on_diagnostics(self, array: DiagnosticArray) -> None:
        for status in array.status:
            if status.name == "rst_control: control loop":
                values = {entry.key: entry.value for entry in status.values}
                ticks = int(values["ticks"]) + int(values["skipped ticks"])
                late = float(values["late ticks [%]"]) / 100.0 * ticks
                p99, lateness = (float(values[k]) for k in ("tick p99 [us]", "lateness p99 [us]"))
                self.loop = Loop(ticks, late, p99, lateness)

    def _on_state(self, state: ControllerState) -> None:
        self.state = state

    def _on_utterance(self, _: Utterance) -> None:
        self.utterances += 1


@contextmanager
def own_master() -> Iterator[System]:
    """A ROS master of its own, with this process as a node."""
    with (
        tempfile.TemporaryDirectory() as name,
        System(Path(name) / "launch.log", {}) as system,
    ):
        rospy.init_node("bench", anonymous=True, disable_signals=True)
        yield system


@contextmanager
def talking(
    system: System, seconds: float, is_silent: bool = False, **arguments: str | bool | Path
) -> Iterator[Observer]:
    """The simulated system where people talk without a pause, armed and settled.

    Args:
        system: Its master.
        seconds: Of talk after it is ready [s].
        is_silent: Nobody talks; there is theatre noise alone.
        arguments: Further launch arguments.

    Raises:
        RuntimeError: It did not start.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        talk = _talk(folder / "talk.wav", seconds + LEAD, () if is_silent else TALK)
        recording: dict[str, str | bool | Path] = {}
        if arguments.get("record", True):  # without a recording the launch refuses them
            recording = {"sessions": folder, "session": "bench"}
        observer, began = Observer(), time.monotonic()
        system.launch(
            ROOT / "launch" / "system.launch",
            source="wav",
            wav=talk,
            **recording,
            **arguments,
        )
        _give_first_command(system)
        observer.first_command = time.monotonic() - began
        system.wait_for({"voice node": observer.voice_ready}, lambda _: None)
        observer.first_sound = time.monotonic() - began
        time.sleep(SETTLE)
        yield observer
        system.end_launch()


def _give_first_command(system: System) -> None:
    """Say "hey robot" by service until it is taken, as a person would who is in a hurry."""
    command, end = rospy.ServiceProxy("rst_control/command", Command), time.monotonic() + READY_TIME
    why = "nobody offers rst_control/command"
    while time.monotonic() < end and system.is_running():
        try:
            command.wait_for_service(0.5)
            answer = command(COMMANDS[0])
        except (rospy.ROSException, rospy.ServiceException) as error:
            why = str(error)
            continue
        if answer.accepted:
            return
        why = answer.message
        time.sleep(PAUSE)
    raise RuntimeError(f"no command was taken: {why}")


def work(system: System, observer: Observer, seconds: float, pause: float = 0.5) -> int:
    """Keep the robot at work by commands; returns how many were given.

    Args:
        system: That must keep running.
        observer: Of it.
        seconds: How long [s].
        pause: Between checks whether it rests [s].

    Raises:
        RuntimeError: A part of the system ended.
    """
    command, given = rospy.ServiceProxy("rst_control/command", Command), 0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if not system.is_running():
            raise RuntimeError("a part of the system ended")
        if observer.state is not None and observer.state.state not in ("moving", "stopping"):
            command(COMMANDS[given % len(COMMANDS)])
            given += 1
        time.sleep(pause)
    return given


def _talk(path: Path, seconds: float, texts: Sequence[str]) -> Path:
    """People who say texts without a pause over theatre noise; it alone where there are none."""
    sound = theatre_noise(seconds, 0.1 * LEVEL, seed=9)
    words = [speak(text, "en-gb+m3", 170) for text in texts]
    at, n = 0, 0
    while words and at < len(sound):
        piece = sound[at : at + len(words[n % len(words)])]
        piece += words[n % len(words)][: len(piece)]
        at, n = at + len(piece) + RATE // 2, n + 1
    soundfile.write(path, np.clip(sound, -1.0, 1.0), RATE, subtype="PCM_16")
    return path
