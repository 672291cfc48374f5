# SPDX-License-Identifier: BSD-3-Clause
"""Leads the robot into motion, by hand, by action or by voice, and watches all that moves."""

from __future__ import annotations

import time
from collections import deque
from contextlib import suppress

import numpy as np
import rosgraph
import rospy
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty, Float64, String, Time

from bench.safety.losses.client import ActionClient, SpeechSource
from bench.safety.losses.judge import JointTrace
from rst_control.msg import ControllerState, Event, ReasonCode
from rst_control.ros.common.wall_clock import wall_offset
from rst_control.srv import Command, CommandResponse
from rst_control.types import JOINTS
from support.waiting import wait_until

KEPT = 10_000  # messages of each stream: twenty seconds
LIMIT = 20.0  # [s] for anything to happen
REPEATS = 3  # times that somebody says a word that nobody obeys
LISTENS = 4.0  # [s] for a spoken word to be obeyed
BREATH = 0.6  # [s] of quiet between two commands, or the second one continues the first
# Voices and paces whose "stop!" the spotter alone takes: it was trained on people, and few do.
STOPS = (("en-029+m3", 140), ("en-gb-x-rp+m3", 140), ("en-gb+m1", 140))
HIGH = 1.0  # [N] above which the next pull is less
PULL = 0.6  # [N] of one pull by an action goal
FRESH = 0.3  # [s] that a state of the controller, or a heartbeat, is true for


class JointWatcher:
    """Keeps what the controller and the robot send, by their stamps: nobody here may be late."""

    def __init__(self) -> None:
        self._joints: deque[tuple[float, tuple[float, ...]]] = deque(maxlen=KEPT)
        self._setpoints: deque[tuple[float, tuple[float, ...]]] = deque(maxlen=KEPT)
        self.state: ControllerState | None = None
        self.state_at = self.heartbeat_at = float("-inf")  # [s] time.monotonic()
        self.recorded_at = float("-inf")  # [s] when the recorder last said that it records
        self.failed_at = float("-inf")  # [s] when the recogniser failed
        self.finished_at = float("-inf")  # [s] when a motion came to its own end
        self.stops = 0  # sent by topic, by anybody
        self._subscribers = [
            self._stream("joint_states", self._joints),
            self._stream("robot/servo_jp", self._setpoints),
            rospy.Subscriber("rst_control/state", ControllerState, self._on_state),
            rospy.Subscriber("rst_control/event", Event, self._on_event),
            rospy.Subscriber("rst_control/heartbeat", Time, self._on_heartbeat),
            rospy.Subscriber("rst_control/stop", Empty, self._on_stop),
            rospy.Subscriber("session_log/recording", String, self._on_recording),
            rospy.Subscriber("losses/failed", Float64, self._on_failed),
        ]
        self._stop = rospy.Publisher("rst_control/stop", Empty, queue_size=1, tcp_nodelay=True)

    def joints(self) -> JointTrace:
        """Of the joints, as the robot says."""
        return _trace(self._joints)

    def setpoints(self) -> JointTrace:
        """What the controller sent."""
        return _trace(self._setpoints)

    def stop(self) -> None:
        """Stop by topic, over the connection that there is."""
        self._stop.publish(Empty())

    @property
    def can_stop(self) -> bool:
        """The controller takes stops from here."""
        return bool(self._stop.get_num_connections())

    @property
    def hears_robot(self) -> bool:
        """Joint states have come within the last tenth of a second."""
        return bool(self._joints) and time.monotonic() - self._joints[-1][0] < 0.1

    def now(self) -> ControllerState | None:
        """The controller's state; None where it says nothing."""
        return self.state if time.monotonic() - self.state_at < FRESH else None

    def is_(self, *states: str) -> bool:
        """Whether the controller says that it is in one of these states."""
        state = self.now()
        return state is not None and state.state in states

    def _on_state(self, state: ControllerState) -> None:
        self.state, self.state_at = state, time.monotonic()

    def _on_event(self, event: Event) -> None:
        if event.kind == "motion_finished":
            self.finished_at = event.header.stamp.to_sec() - wall_offset()

    def _on_heartbeat(self, _: Time) -> None:
        self.heartbeat_at = time.monotonic()

    def _on_recording(self, trouble: String) -> None:
        if not trouble.data:
            self.recorded_at = time.monotonic()

    def _on_stop(self, _: Empty) -> None:
        self.stops += 1

    def _on_failed(self, moment: Float64) -> None:
        self.failed_at = float(moment.data)

    @staticmethod
    def _stream(name: str, kept: deque[tuple[float, tuple[float, ...]]]) -> rospy.Subscriber:
        def keep(message: JointState) -> None:
            by_name = dict(zip(message.name, message.position, strict=True))
            moment = message.header.stamp.to_sec() - wall_offset()
            kept.append((moment, tuple(by_name[joint] for joint in JOINTS)))

        return rospy.Subscriber(name, JointState, keep, tcp_nodelay=True)


class CommandLead:
    """Gives commands: by hand, as an action, or spoken.

    Args:
        watcher: Sees what comes of them.
        rng: Chooses.
    """

    def __init__(self, watcher: JointWatcher, rng: np.random.Generator) -> None:
        self._watcher, self._rng = watcher, rng
        self._command: rospy.ServiceProxy | None = None
        self.room: SpeechSource | None = None  # where commands are spoken
        self.client: ActionClient | None = None  # that sends goals

    def say(self, words: str) -> CommandResponse:
        """Give a command by service, over the connection that there is, or a new one."""
        for _ in range(2):
            proxy = self._command or rospy.ServiceProxy(
                "rst_control/command", Command, persistent=True
            )
            try:
                self._command, reply = proxy, proxy(words)
            except (rospy.ServiceException, rospy.ROSException, OSError) as error:
                self._command, reply = (
                    None,
                    CommandResponse(False, f"no answer: {error}", ReasonCode.NO_ANSWER),
                )
                with suppress(rospy.ROSException, OSError):  # the connection is gone
                    proxy.close()
                continue
            break
        return reply

    def wake(self) -> None:
        """Say "hey robot" until it is obeyed.

        Raises:
            RuntimeError: It never was.
        """
        if self.room is not None:
            self._speak("hey robot", "active", "moving")
            return
        end = time.monotonic() + LIMIT
        while not (reply := self.say("hey robot")).accepted:
            if time.monotonic() > end:
                raise RuntimeError(f'"hey robot" is refused: {reply.message}')
            time.sleep(0.1)
        wait_until(lambda: self._watcher.is_("active", "moving"), "active", LIMIT)

    def set_off(self) -> str:
        """Bring the robot into motion; gives how.

        Raises:
            RuntimeError: No command moves it.
        """
        refused = ""
        for words in self.choices():
            if self.room is not None:
                self._speak(words, "moving")
                return f"{words}, spoken"
            if self.client is not None:
                self.client.send(words, PULL if words.startswith("pull") else 0.0)
            else:
                reply = self.say(words)
                for _ in range(2 if words.startswith("pull") else 0):
                    self.say(words)  # a longer way
                if not reply.accepted:
                    refused += f'; "{words}": {reply.message}'
                    continue
            with suppress(RuntimeError):
                wait_until(lambda: self._watcher.is_("moving"), f'"{words}" moves it', 3.0)
                return words
        raise RuntimeError(f"nothing moves it{refused}")

    def choices(self) -> list[str]:
        """Commands that may be possible now, in an order by chance."""
        state = self._watcher.now()
        if state is None or not state.tissue_held:
            return ["tense", "release"]
        pull = "pull less" if state.tension > HIGH else "pull more"
        if self.room is not None:  # one spoken step of a pull is over before a loss is noticed
            return ["release", "tense"]
        return [pull, "release"] if self._rng.random() < 0.7 else ["release", pull]

    def grasp(self) -> None:
        """Take tissue, to its end; a refusal shows in what comes next."""
        if self.say("tense").accepted:
            with suppress(RuntimeError):
                wait_until(lambda: self._watcher.is_("moving"), "tensing", 3.0)
                wait_until(lambda: self._watcher.is_("active"), "tensed", LIMIT)

    def is_spotted(self) -> bool:
        """Say "stop", some times if need be; gives whether somebody stops by topic."""
        before = self._watcher.stops
        for voice, pace in STOPS:
            if self.room is not None:
                self.room.say("stop!", voice, pace)
            with suppress(RuntimeError):
                wait_until(lambda: self._watcher.stops > before, "a stop", 2.0)
                return True
        return False

    def refuses(self) -> str:
        """Ask for motion; gives why that was wrong, or nothing where it was refused."""
        for words in ("tense", "pull less", "release"):
            reply = self.say(words)
            if reply.accepted:
                return f'"{words}" was accepted: {reply.message}'
        return ""

    @staticmethod
    def is_found() -> bool:
        """Whether a new client would find the controller."""
        try:
            _, _, services = rosgraph.Master("/losses").getSystemState()
        except (OSError, rosgraph.MasterException):
            return False
        return "/rst_control/command" in [name for name, _ in services]

    def _speak(self, words: str, *states: str) -> None:
        for _ in range(REPEATS):
            time.sleep(BREATH)
            if self.room is not None:
                self.room.say(words)
            with suppress(RuntimeError):
                wait_until(lambda: self._watcher.is_(*states), words, LISTENS)
                return
        raise RuntimeError(f'"{words}", spoken {REPEATS} times, was not obeyed')


def _trace(kept: deque[tuple[float, tuple[float, ...]]]) -> JointTrace:
    some = list(kept)
    times = np.array([moment for moment, _ in some])
    positions = np.array([joints for _, joints in some]).reshape(len(some), len(JOINTS))
    return JointTrace(times, positions)
