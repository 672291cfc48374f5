# SPDX-License-Identifier: BSD-3-Clause
"""The whole system at work: does the 500 Hz loop keep its times while the recogniser is busy?

Sixty seconds by default; `BENCH_SECONDS=600 make bench ONLY=system` for the ten minutes of the
target.
"""

from __future__ import annotations

import os
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rospy
import soundfile
from diagnostic_msgs.msg import DiagnosticArray

from bench.common.resumable import measured
from rst_control.msg import ControllerState
from rst_control.srv import Command
from support.figures import ROOT, Figure
from support.launched_system import System
from support.theatre_sound import LEVEL, RATE, speak, theatre_noise
from support.waiting import wait_until
from voice_assist.msg import Mode, Utterance

FULL = 600.0  # [s]
SECONDS = float(os.environ.get("BENCH_SECONDS", "60"))
READY_TIME = 90.0  # [s] allowed for the nodes to start
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
        self.controller_ready, self.voice_ready = threading.Event(), threading.Event()
        self.loop: Loop | None = None
        self.utterances = 0
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
        self.controller_ready.set()

    def _on_utterance(self, _: Utterance) -> None:
        self.utterances += 1


def measure(seconds: float = SECONDS) -> list[Figure]:
    """Run the system on continuous talk while the robot works on commands by service.

    Args:
        seconds: How long to measure [s].

    Raises:
        RuntimeError: The system did not start, or a part of it ended.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with System(folder / "launch.log", {}) as system:
            rospy.init_node("bench", anonymous=True, disable_signals=True)
            observer = Observer()
            start_talking_system(system, observer, folder, seconds + LEAD)
            time.sleep(SETTLE)
            return _observe(system, observer, seconds)


def start_talking_system(
    system: System, observer: Observer, folder: Path, seconds: float, **arguments: str | bool
) -> None:
    """Launch the simulated system where people talk without a pause; returns when it is ready.

    Args:
        system: Its master.
        observer: Of what it says.
        folder: For the sound and the session.
        seconds: Of talk [s].
        arguments: Further launch arguments.

    Raises:
        RuntimeError: It did not start.
    """
    system.launch(
        ROOT / "launch" / "system.launch",
        sessions=folder,
        session="bench",
        source="wav",
        wav=_talk(folder / "talk.wav", seconds),
        **arguments,
    )
    _wait_until_ready(system, observer)


def _observe(system: System, observer: Observer, seconds: float) -> list[Figure]:
    command = rospy.ServiceProxy("rst_control/command", Command)
    first, heard, busy = observer.totals(), observer.utterances, _processor_time()
    begin, said = time.monotonic(), 0
    while time.monotonic() < begin + seconds:
        if not system.is_running():
            raise RuntimeError("a part of the system ended")
        if observer.state is not None and observer.state.state not in ("moving", "stopping"):
            command(COMMANDS[said % len(COMMANDS)])
            said += 1
        time.sleep(1.0)
    last, heard = observer.totals(), observer.utterances - heard
    busy = np.array(_processor_time()) - busy
    late = last.late_percent_since(first)
    load = 100.0 * busy[0] / busy.sum()
    note = f"({last.ticks - first.ticks} ticks in {seconds:.0f} s, {heard} utterances heard)"
    return [
        measured(seconds, "s", FULL),
        Figure("500 Hz loop: late ticks", late, "%", 0.1, note=note),
        Figure("500 Hz loop: lateness p99", last.lateness, "us", note="(last 10 s)"),
        Figure("500 Hz loop: time of a tick p99", last.p99, "us", note="(last 10 s)"),
        Figure("all cores busy", load, "%", note=f"({said} commands by service meanwhile)"),
    ]


def _talk(path: Path, seconds: float) -> Path:
    """People who talk without a pause over theatre noise."""
    sound = theatre_noise(seconds, 0.1 * LEVEL, seed=9)
    words = [speak(text, "en-gb+m3", 170) for text in TALK]
    at, n = 0, 0
    while at < len(sound):
        piece = sound[at : at + len(words[n % len(words)])]
        piece += words[n % len(words)][: len(piece)]
        at, n = at + len(piece) + RATE // 2, n + 1
    soundfile.write(path, np.clip(sound, -1.0, 1.0), RATE, subtype="PCM_16")
    return path


def _wait_until_ready(system: System, observer: Observer) -> None:
    deadline = time.monotonic() + READY_TIME
    for ready in (observer.controller_ready, observer.voice_ready):
        while not ready.wait(0.2):
            if not system.is_running() or time.monotonic() > deadline:
                raise RuntimeError("the system did not start")


def _processor_time() -> tuple[float, float]:
    """Busy and idle time of all cores since the machine started, in ticks of the kernel."""
    numbers = [float(word) for word in Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]
    idle = numbers[3] + numbers[4]
    return sum(numbers) - idle, idle
