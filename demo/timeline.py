# SPDX-License-Identifier: BSD-3-Clause
"""Watches the running system's topics: prints them as a timeline and keeps them for the checks."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rich.console import Console
from rich.live import Live
from rich.text import Text
from std_msgs.msg import String

from demo.check import ControllerSample, Done, HeardUtterance, Observed
from demo.first_sound import FirstSound
from demo.live_line import live_line
from rst_control.msg import ControllerState, Event
from voice_assist.msg import AudioChunk, DeviceCall, Mode, Utterance

VOICE = "voice_assist: voice"  # the voice node's status of itself
MOTION = "rst_control: motion"  # the controller's status of the robot
COLOURS = {
    "accepted": "green",
    "refused": "yellow",
    "motion_started": "cyan",
    "motion_finished": "cyan",
    "stop_received": "red",
    "at_rest": "red",
    "halted": "red",
    "cleared": "green",
}


class Timeline:
    """Subscribes to the session and shows it; context manager."""

    def __init__(self, console: Console) -> None:
        self.observed = Observed()
        self.voice_ready = threading.Event()
        self.controller_ready = threading.Event()
        self.recorder_ready = threading.Event()
        self.listening = threading.Event()  # the voice node says that all is well with it
        self._console = console
        self._zero = rospy.Time.now().to_sec()
        self._partial, self._mode = "", "?"
        self._trouble = ""  # of the voice node, as it says
        self._state: ControllerState | None = None
        self._lock = threading.Lock()
        self._intended = rospy.Publisher("voice_assist/intended", String, queue_size=10)
        self._live = Live(
            console=console,
            refresh_per_second=8,
            get_renderable=self._footer,
            transient=not console.is_terminal,  # in a file it would only run into the next line
        )

    def start_clock(self, zero: float) -> None:
        """Call a moment [s] the zero of the script, and forget what was seen before."""
        with self._lock:
            self._zero = zero
            self.observed = Observed()

    @contextmanager
    def first_sound(self, within: float, is_file: bool) -> Iterator[Callable[[], float]]:
        """Hear what the voice node hears, from before anything is played.

        Args:
            within: Time [s] for the node to listen, and again for the first sound.
            is_file: The node reads a file, whose beginning its samples are counted from; else the
                first sound is the first that is no silence.

        Returns:
            A function that waits for the first sound, and gives when that was captured [s].

        Raises:
            RuntimeError: The voice node does not listen, or hears nothing.
        """
        sound = FirstSound(is_file)

        def listen(chunk: AudioChunk) -> None:
            sound.push(chunk.header.stamp.to_sec(), chunk.first_sample, chunk.rate, chunk.samples)

        subscriber = rospy.Subscriber("voice_assist/audio", AudioChunk, listen)
        try:
            sound.wait_until_it_listens(within)
            yield lambda: sound.wait(within)
        finally:
            subscriber.unregister()

    def now(self) -> float:
        """Time of the script [s]."""
        return float(rospy.Time.now().to_sec() - self._zero)

    def __enter__(self) -> Timeline:
        self._live.start()
        self._subscribers = [
            rospy.Subscriber("voice_assist/utterance", Utterance, self._on_utterance),
            rospy.Subscriber("voice_assist/partial", String, self._on_partial),
            rospy.Subscriber("voice_assist/mode", Mode, self._on_mode),
            rospy.Subscriber("rst_control/state", ControllerState, self._on_state),
            rospy.Subscriber("rst_control/event", Event, self._on_event),
            rospy.Subscriber("voice_assist/device", DeviceCall, self._on_device),
            rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics),
            rospy.Subscriber("session_log/file", String, self._on_file),
        ]
        return self

    def __exit__(self, *_: object) -> None:
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._live.stop()

    def say(self, words: str, style: str = "bold") -> None:
        """Print one line of the timeline."""
        self._console.print(Text(f"{self.now():7.2f} s  {words}", style=style))

    def intend(self, phrase: str) -> None:
        """Put on record what now begins to sound: the exact command, or empty for none."""
        self._intended.publish(String(phrase))

    def warn(self, words: str) -> None:
        """Print one line about something that went wrong beside the session."""
        self.say(words, "yellow")

    def _on_utterance(self, message: Utterance) -> None:
        start = message.speech_start.to_sec() - self._zero
        delay = (message.decision - message.speech_end).to_sec()
        with self._lock:
            self.observed.heard.append(HeardUtterance(start, message.transcript, message.command))
        wer = dict(zip(message.phrases, message.wer, strict=False))
        if message.command:
            outcome = (
                f"= {message.command}  (WER {wer.get(message.command, 0.0):.2f}, "
                f"confidence {message.confidence:.2f}, {delay * 1e3:.0f} ms after the last sound)"
            )
            self.say(f'heard   "{message.transcript}"  {outcome}', "bold magenta")
        elif message.transcript:
            self.say(f'heard   "{message.transcript}"  no command: {message.reason}', "dim magenta")

    def _on_event(self, message: Event) -> None:
        if message.kind == "accepted":
            with self._lock:
                self.observed.done.append(Done(self.now(), message.command, message.message))
        kind = message.kind.replace("_", " ")
        self.say(
            f"robot   {kind}: {message.command}. {message.message}",
            COLOURS.get(message.kind, "white"),
        )

    def _on_device(self, message: DeviceCall) -> None:
        if message.is_done:
            with self._lock:
                self.observed.done.append(Done(self.now(), message.phrase, ""))
        result = "done" if message.is_done else f"failed: {message.message}"
        self.say(f"device  {message.phrase}: {result}", "green" if message.is_done else "yellow")

    def _on_partial(self, message: String) -> None:
        self._partial = message.data

    def _on_file(self, message: String) -> None:
        if message.data:
            self.recorder_ready.set()

    def _on_mode(self, message: Mode) -> None:
        self._mode = message.mode
        self.voice_ready.set()

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        """The controller is ready once it sees a healthy robot; a first start takes a while."""
        for status in message.status:
            if status.name == VOICE and self.voice_ready.is_set():
                self._on_voice(status)
            if status.name == MOTION and status.level < DiagnosticStatus.ERROR:
                self.controller_ready.set()

    def _on_voice(self, status: DiagnosticStatus) -> None:
        """Say what is wrong with the voice node, such as a missing microphone, and when it ends."""
        trouble = status.message if status.level != DiagnosticStatus.OK else ""
        if trouble:
            self.listening.clear()
        else:
            self.listening.set()
        if trouble != self._trouble:
            self._trouble = trouble
            self.warn(f"voice   {status.message}")

    def _on_state(self, message: ControllerState) -> None:
        self._state = message
        state = ControllerSample(
            time=message.header.stamp.to_sec() - self._zero,
            state=message.state,
            active=message.assistance_enabled,
            halted=message.halted,
            tissue_held=message.tissue_held,
            tension=message.tension,
            path_speed=message.path_speed,
            rcm_error=message.rcm_error,
            insertion=message.insertion,
        )
        with self._lock:
            self.observed.states.append(state)

    def _footer(self) -> Text:
        return live_line(self.now(), self._mode, self._state, self._partial)
