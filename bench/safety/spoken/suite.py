# SPDX-License-Identifier: BSD-3-Clause
"""From the end of a spoken "stop" to the robot at rest, in the running system.

Controller, simulated robot and voice node run as they are launched; sound reaches the voice node
on its topic, in pieces of 50 ms. A command by hand brings the robot into motion, and at a random
moment of it somebody says "stop": each synthetic voice that training never used, then people of
`dev`, where ../shared/speech is there. Counted from the end of the word's sound, which may come
after the decision, is the time until the controller has a stop, until its set-points rest, and
until the joints do. In the environment: TRIALS of each kind of voice (60).
"""

from __future__ import annotations

import math
import os
import tempfile
import time
from collections import Counter, deque
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import numpy as np
import rospy

from bench.common.part import HUMAN, SYNTHETIC
from bench.common.resumable import measured
from bench.safety.losses import judge
from bench.safety.losses.client import SpeechSource
from bench.safety.losses.parts import START_TIME, Parts
from bench.safety.losses.scene import FRESH, CommandLead, JointWatcher
from bench.safety.spoken import judge as spoken_judge
from bench.safety.spoken.judge import SoundPiece, SpokenStop
from bench.voice.material.held_out_voices import natives, spread
from bench.voice.material.synthesis import SpokenClip, spoken
from bench.voice.stop import people
from rst_control.msg import Event
from rst_control.ros.common.wall_clock import wall_offset
from support.figures import ROOT, Figure
from support.waiting import wait_until
from voice_assist.audio.sound_file import read_sound
from voice_assist.msg import AudioChunk
from voice_assist.types import Samples

FULL = 112  # of each kind of voice
TRIALS = int(os.environ.get("TRIALS", "60"))
SEED = 18
PHASES = {"tense": 2.5, "release": 1.0}  # [s] of a motion, at most, before somebody speaks
HEARD = 3.0  # [s] from the word's begin on in which a stop has to come
SETTLED = 0.8  # [s] of quiet after it, in which the robot comes to rest
LIMIT = 30.0  # [s] for a motion that nobody stopped
BEFORE = 0.2  # [s] of sound before it; a piece is stamped by its first sample
SENT = 200  # pieces of sound that are kept: ten seconds
ATTEMPTS = 8  # at a command that moves the robot


def measure() -> list[Figure]:
    """Say each "stop" once.

    Raises:
        RuntimeError: The system did not start, or could not be moved.
    """
    clips = _clips(np.random.default_rng(SEED))
    stops = []
    with _running() as trials:
        for number, (who, clip) in enumerate(clips, 1):
            stops.append(trials.say(who, clip))
            print(f"{number} of {len(clips)}: {stops[-1]}", flush=True)
    count = Counter(stop.who for stop in stops)
    return [measured(min(count.values()), "of each", FULL), *spoken_judge.figures(stops)]


def _clips(rng: np.random.Generator) -> list[tuple[str, SpokenClip]]:
    cast = natives().present
    synthetic = spoken(spread(("stop",), cast, math.ceil(TRIALS / len(cast)), SEED))
    humans = people()
    if not humans:
        print("no human speech in ../shared/speech: people left out")
    found = []
    for who, clips in ((SYNTHETIC, synthetic), (HUMAN, humans)):
        found += [(who, clips[i]) for i in rng.permutation(len(clips))[:TRIALS]]
    return found


class _Sounds(SpeechSource):
    """A room in which a recording may be played, and that knows when its sound was sent."""

    def __init__(self) -> None:
        super().__init__()
        self._sent: deque[SoundPiece] = deque(maxlen=SENT)
        self._hearing = rospy.Subscriber("audio_in", AudioChunk, self._keep)

    def play(self, sound: Samples) -> None:
        """From the next piece of sound on."""
        with self._lock:
            self._to_say = sound

    def since(self, moment: float) -> list[SoundPiece]:
        """What was sent from a moment [s] on."""
        return [piece for piece in list(self._sent) if piece.stamp >= moment]

    def _keep(self, chunk: AudioChunk) -> None:
        samples = np.array(chunk.samples, np.float32) / 32768.0
        self._sent.append(SoundPiece(chunk.header.stamp.to_sec() - wall_offset(), samples))


class _Trials:
    """A running system in which somebody says "stop".

    Args:
        room: Where it is said.
        watcher: Sees what moves.
        lead: Gives commands by hand.
    """

    def __init__(self, room: _Sounds, watcher: JointWatcher, lead: CommandLead) -> None:
        self._room, self._watcher, self._lead = room, watcher, lead
        self._rng = np.random.default_rng(SEED)
        self._stops: deque[float] = deque(maxlen=SENT)  # [s] when the controller had them
        self._events = rospy.Subscriber("rst_control/event", Event, self._on_event)

    def say(self, who: str, clip: SpokenClip) -> SpokenStop:
        """Bring the robot into motion and say one "stop".

        Raises:
            RuntimeError: No command moves the robot, or nothing stops it.
        """
        time.sleep(self._rng.uniform(0.0, self._into_motion()))
        begun = time.monotonic()
        sound = read_sound(ROOT / clip.path)
        self._room.play(sound)
        with suppress(RuntimeError):
            wait_until(lambda: bool(self._since(begun)), "a stop", HEARD)
        time.sleep(SETTLED)
        until = time.monotonic()
        joints, setpoints = self._watcher.joints(), self._watcher.setpoints()
        end = spoken_judge.end_of_word(self._room.since(begun - BEFORE), sound)
        came = self._since(begun)
        if not came:
            self._watcher.stop()
        wait_until(lambda: not self._watcher.is_("moving", "stopping"), "at rest", LIMIT)
        speed = judge.speed(joints, came[0]) if came else 0.0
        return SpokenStop(
            who=who,
            path=clip.path,
            received=came[0] - end if came else None,
            is_moving=speed > judge.MOVING,
            setpoints=judge.last_movement(setpoints, end, until),
            joints=judge.last_movement(joints, end, until),
        )

    def _into_motion(self) -> float:
        """How long at most it may move before somebody speaks [s]."""
        refused = ""
        for _ in range(ATTEMPTS):
            self._lead.wake()
            state = self._watcher.now()
            is_held = state is not None and state.tissue_held
            for words in ("release", "tense") if is_held else ("tense", "release"):
                reply = self._lead.say(words)
                if reply.accepted:
                    with suppress(RuntimeError):
                        wait_until(lambda: self._watcher.is_("moving"), words, 3.0)
                        return PHASES[words]
                refused = reply.message
        raise RuntimeError(f"nothing moves it: {refused}")

    def _since(self, moment: float) -> list[float]:
        return [stop for stop in list(self._stops) if stop >= moment]

    def _on_event(self, event: Event) -> None:
        if event.kind == "stop_received":
            self._stops.append(event.header.stamp.to_sec() - wall_offset())


@contextmanager
def _running() -> Iterator[_Trials]:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        parts = stack.enter_context(Parts(folder, folder / "parts.log"))
        rospy.init_node("spoken_stops", anonymous=True, disable_signals=True)
        watcher = JointWatcher()
        parts.launch("robot", "/robot", "robot.launch")
        parts.launch("controller", "/controller", "controller.launch", on_recording_loss="ignore")
        room = stack.enter_context(_Sounds())
        voice = {"source": "topic", "audio_node": "/spoken_stops_*"}
        parts.launch("voice", "/voice_assist", "voice.launch", **voice)

        def is_there() -> bool:
            beats = time.monotonic() - watcher.heartbeat_at < FRESH
            return watcher.hears_robot and watcher.now() is not None and watcher.can_stop and beats

        wait_until(is_there, "all parts speak", START_TIME)
        yield _Trials(room, watcher, CommandLead(watcher, np.random.default_rng(SEED)))
