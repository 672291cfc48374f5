# SPDX-License-Identifier: BSD-3-Clause
r"""The robot's host: master, robot, controller, recorder, and the faults, one after the other.

    ip netns exec ROBOT python -m bench.safety.network.session \
        ROBOT VOICE RESULT TRIALS INTERVAL AGE

RESULT is the file into which the trials are pickled; INTERVAL [s] lies between two heartbeats of
the voice node; AGE is `watchdogs.voice_heartbeat_age`, or the word `two_hosts` for that of
launch/two_hosts.yaml.
"""

from __future__ import annotations

import os
import pickle
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import rospy

from bench.safety.network.faults import FAULTS, Fault
from bench.safety.network.hosts import ROBOT, VOICE, VOICE_MOVED, Child, Relay, on, readdress
from bench.safety.network.judge import ALLOWED, NetworkTrial, rest
from bench.safety.network.relay import RelayLink
from bench.safety.stops.judge import STILL, SetpointCourse
from bench.safety.stops.system import LIMIT, StopWatcher
from rst_control.types import JOINTS
from support.figures import ROOT
from support.launched_system import READY_TIME, System

SEED = 7
LASTS = 3.0  # [s] of a fault
AFTER = 1.0  # [s] of a good network before "hey robot"
AFTER_COMMAND = 4.0  # [s] the same where a command is on its way: TCP tries again after up to 3.2 s
PHASE = 0.6  # [s] of motion within which a fault begins, by chance
SAID = 0.8  # [s] after a fault within which "stop" is said, by chance
GIVEN_UP = 30.0  # [s] after which the robot is not waited for any more
ATTEMPTS = 5  # to set off
RETRY = 0.3  # [s] between two times "hey robot" is said


class VoiceHost:
    """The voice node on its host, started anew where it has to be.

    Args:
        namespace: Of its host.
        interval: Between two heartbeats [s].
    """

    def __init__(self, namespace: str, interval: float) -> None:
        self._namespace, self._interval = namespace, interval
        self.address = VOICE
        self._child = self._start()

    def say(self, words: str) -> float:
        """Say a command; returns when it was handed to the network [s], time.monotonic()."""
        self._child.send(words)
        while True:
            said = self._hear()
            if said[:2] == ["sent", words]:
                return float(str(said[2]))

    def ask(self, words: str) -> tuple[bool, str]:
        """Say a command and wait for its answer: whether it was accepted, and the words."""
        self.say(words)
        while True:
            said = self._hear()
            if said[:2] == ["answer", words]:
                return bool(said[2]), str(said[3])

    def move(self) -> float:
        """Take another address; returns when [s], time.monotonic()."""
        before, self.address = self.address, VOICE_MOVED if self.address == VOICE else VOICE
        begun = time.monotonic()
        readdress(self._namespace, before, self.address)
        return begun

    def restart(self) -> None:
        """Start the voice node anew, at the address that its host has."""
        self._child.kill()
        self._child = self._start()

    def end(self) -> None:
        """End it."""
        self._child.end()

    def _hear(self) -> list[object]:
        said = self._child.hear()
        return said if isinstance(said, list) else []

    def _start(self) -> Child:
        words = [sys.executable, "-m", "bench.safety.network.voice", str(self._interval)]
        child = Child(on(self._namespace, words), {"ROS_IP": self.address})
        child.hear()
        time.sleep(1.0)  # its topics find their subscribers
        return child


class NetworkSession:
    """Faults of the network between a voice and a robot in motion.

    Args:
        relay: The network.
        voice: Who commands.
        seed: Chooses moments.
    """

    def __init__(self, relay: Relay, voice: VoiceHost, seed: int) -> None:
        self.watcher, self._relay, self._voice = StopWatcher(), relay, voice
        self._rng = np.random.default_rng(seed)
        self._wall = time.time() - time.monotonic()
        self.void = 0

    def trial(self, fault: Fault) -> NetworkTrial:
        """Make the network bad while the robot moves, and good again."""
        while True:
            self._arm()
            moment = self._at_rest(fault) if fault.is_before else self._in_motion(fault)
            if moment is not None:
                time.sleep(LASTS)
            good = self._relay.set(RelayLink())
            if fault.moves_host and moment is not None:
                self._voice.restart()
            if moment is not None:
                time.sleep(AFTER_COMMAND if fault.since == "command said" else AFTER)
                seen = self._seen()
                if not self._was_over(fault, moment + self._wall, *seen[:3]):
                    break
            self.void += 1
        rearmed, moved = self._recover(fault, good)
        return NetworkTrial(
            fault.name, moment + self._wall, fault.since, *seen, rearmed=rearmed, moved=moved
        )

    @staticmethod
    def _was_over(
        fault: Fault, moment: float, setpoints: SetpointCourse, _: SetpointCourse, halted: bool
    ) -> bool:
        """Whether the motion ended by itself about when the fault began: that shows nothing."""
        ended = rest(setpoints.stamps, setpoints.speeds, moment, STILL)
        return fault.since == "fault" and not halted and (ended is None or ended < ALLOWED)

    def _in_motion(self, fault: Fault) -> float | None:
        """Time of a fault in mid-motion, or of a stop in it [s]; None: the robot stopped before."""
        self._set_off()
        time.sleep(float(self._rng.uniform(0.0, PHASE)))
        if not self._moves():
            return None
        moment = self._voice.move() if fault.moves_host else self._relay.set(fault.link)
        if fault.since == "stop said":
            time.sleep(float(self._rng.uniform(0.0, SAID)))
            moment = self._voice.say("stop")
        return moment

    def _at_rest(self, fault: Fault) -> float | None:
        """Time of a command or a stop that is said over a network that is bad already [s]."""
        self._relay.set(fault.link)
        time.sleep(LASTS / 2)
        said = self._voice.say(self._next())
        if fault.since == "command said":
            return said
        time.sleep(2 * fault.link.to_robot.delay + float(self._rng.uniform(0.1, PHASE)))
        return self._voice.say("stop")

    def _seen(self) -> tuple[SetpointCourse, SetpointCourse, bool, str]:
        """Set-points, joint states, whether it is halted, and why."""
        state, kept = self.watcher.state, list(self.watcher.joints)
        order = [kept[-1][1].name.index(name) for name in JOINTS] if kept else []
        measured = SetpointCourse(
            np.array([message.header.stamp.to_sec() for _, message in kept]),
            np.array([message.position for _, message in kept])[:, order],
            np.array([message.velocity for _, message in kept])[:, order],
        )
        halted = state is not None and state.halted
        return self.watcher.course()[0], measured, halted, state.halt_reason_code if state else ""

    def _recover(self, fault: Fault, good: float) -> tuple[float | None, float | None]:
        """Times from the good network to "hey robot" accepted and to the next motion [s]."""
        try:
            self._arm()
            rearmed = time.monotonic() - good
            self._set_off()
        except RuntimeError as error:
            print(f"{fault.name}: {error}", flush=True)
            return None, None
        moved = time.monotonic() - good
        self._voice.ask("stop")
        self.watcher.wait("halted", "faulted")
        return rearmed, moved

    def _arm(self) -> None:
        """Say "hey robot" until it is accepted.

        Raises:
            RuntimeError: It never was.
        """
        self._patiently("hey robot")
        self.watcher.wait("active", "moving")

    def _set_off(self) -> None:
        """Say a command that moves until the robot does; a heartbeat too late may stop it again.

        Raises:
            RuntimeError: It never moved.
        """
        for _ in range(ATTEMPTS):
            self._patiently(self._next())
            self.watcher.wait("moving", "halted", "faulted")
            if self._moves():
                return
            self.void += 1
            self._arm()
        raise RuntimeError(f"stopped {ATTEMPTS} times as it set off: {self.watcher.state}")

    def _next(self) -> str:
        state = self.watcher.state
        return "release" if state is not None and state.tissue_held else "tense"

    def _patiently(self, words: str) -> None:
        end, answer = time.monotonic() + GIVEN_UP, ""
        while time.monotonic() < end:
            accepted, answer = self._voice.ask(words)
            state = self.watcher.state
            is_awake = state is not None and state.state in ("active", "moving")
            if accepted or (words == "hey robot" and is_awake):
                return
            time.sleep(RETRY)
        raise RuntimeError(f'"{words}" is refused for {GIVEN_UP:.0f} s: {answer}')

    def _moves(self) -> bool:
        return self.watcher.state is not None and self.watcher.state.state == "moving"


def main() -> None:
    """Start both hosts' parts, and inflict all faults in turn."""
    robot, voice, result, trials, interval, age = sys.argv[1:7]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        system = System(folder / "launch.log", {})
        os.environ["ROS_IP"] = ROBOT
        os.environ["ROS_MASTER_URI"] = os.environ["ROS_MASTER_URI"].replace("127.0.0.1", ROBOT)
        try:
            with system:
                relay = Relay(robot, voice, SEED)
                _launch(system, folder, age)
                _run(relay, voice, Path(result), int(trials), float(interval))
        except RuntimeError:
            with suppress(OSError):
                print((folder / "launch.log").read_text(errors="replace")[-4000:], flush=True)
            raise


def _launch(system: System, folder: Path, age: str) -> None:
    overrides = ROOT / "launch" / "two_hosts.yaml"
    if age != "two_hosts":
        overrides = folder / "overrides.yaml"
        overrides.write_text(f"controller: {{watchdogs: {{voice_heartbeat_age: {float(age)}}}}}\n")
    rospy.init_node("bench", anonymous=True, disable_signals=True)
    system.launch(
        ROOT / "launch" / "system.launch",
        voice=False,
        alarms=False,
        sessions=folder,
        session="network",
        controller_overrides=overrides,
    )
    rospy.wait_for_service("rst_control/command", READY_TIME)
    time.sleep(LIMIT / 4)  # the recorder's first heartbeats, and the robot's first joint states


def _run(relay: Relay, namespace: str, result: Path, count: int, interval: float) -> None:
    voice = VoiceHost(namespace, interval)
    session = NetworkSession(relay, voice, SEED)
    trials: list[NetworkTrial] = []
    try:
        for number in range(count):
            for fault in FAULTS:
                trials.append(session.trial(fault))
                print(f"{number + 1} of {count}: {fault.name}", flush=True)
                result.write_bytes(pickle.dumps((trials, session.void)))
    finally:
        voice.end()
        relay.end()


if __name__ == "__main__":
    main()
