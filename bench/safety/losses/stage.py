# SPDX-License-Identifier: BSD-3-Clause
"""One loss after the other of one part: into motion, lost, watched, given back, into motion."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from pathlib import Path

import numpy as np
import rospy

from bench.safety.losses import judge
from bench.safety.losses.client import ActionClient, SpeechSource
from bench.safety.losses.judge import JointTrace, LossRule, PartLoss
from bench.safety.losses.parts import START_TIME, Part, Parts
from bench.safety.losses.scene import FRESH, CommandLead, JointWatcher
from rst_control.config import load_motion_config
from rst_control.msg import ReasonCode
from rst_control.types import JOINTS
from support.waiting import wait_until
from voice_assist.config.believed import believed_config

WATCHED = 0.8  # [s] after a loss, and after a stop
FOUND = 10.0  # [s] for new clients to find the controller
RETURNED = 0.5  # [s] after its return that is watched before "hey robot"
FROZEN = 1.0  # [s] at most that a part stays stopped beyond that
UNTIL_STOP = (0.15, 0.3)  # [s] from a loss that stops nothing to a stop
PHASES = {"tense": 2.0, "release": 0.6, "pull": 0.15}  # [s] of a motion, at most, before its loss
GRASPING = 0.4  # share of the losses with free jaws before which tissue is taken
ATTEMPTS = 8  # at a motion that lasts until its loss
ROOM = "/losses*"  # node that publishes the sound
SPOKEN = ("voice", "recogniser")  # their loss concerns motion that was spoken
TALK = "they will release the beds before the morning"  # that the recogniser decodes, and fails

EASING = ("release", "pull less")
_CONFIG = load_motion_config().controller
_UNRECORDED = _CONFIG.recording.heartbeat_age
RULES = {
    "controller": LossRule("held by the robot side", 0.1),
    "robot": LossRule("joint states stale: brakes", 0.1, finishes=0.1, may_end=True),
    "voice": LossRule("a spoken motion brakes", 0.1),
    "recogniser": LossRule("the voice node stops the robot", 0.5, demanded=0.5),
    "recorder": LossRule("with on_loss: stop, what advances brakes", 0.1, spares=EASING),
    "roscore": LossRule("all motion brakes", 0.1),
    "client": LossRule("its goal brakes", 0.1),
}


@contextmanager
def stage_for(victim: str, seed: int, log: Path) -> Iterator[LossStage]:
    """The parts that the loss of one of them needs, and somebody who gives commands.

    Args:
        victim: One of RULES.
        seed: Chooses moments and motions.
        log: File that takes what the parts say.
    """
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        parts = stack.enter_context(Parts(folder, log))
        rospy.init_node("losses", anonymous=True, disable_signals=True)
        watcher, rng = JointWatcher(), np.random.default_rng((6, seed))
        lead = CommandLead(watcher, rng)
        on_loss = "stop" if victim == "recorder" else "ignore"
        parts.launch("robot", "/robot", "robot.launch")
        parts.launch("controller", "/controller", "controller.launch", on_recording_loss=on_loss)
        if victim == "recorder":
            parts.launch("recorder", "/recorder", "record.launch", sessions=folder)
        if victim in SPOKEN:
            lead.room = stack.enter_context(SpeechSource())
        if victim == "voice":
            voice = {"source": "topic", "audio_node": ROOM}
            parts.launch("voice", "/voice_assist", "voice.launch", **voice)
        if victim == "recogniser":
            believed = asdict(believed_config(None)) | {"audio": [ROOM]}
            rospy.set_param("/voice_assist/believed", believed)
            words = (sys.executable, "-m", "bench.safety.losses.voice", "__name:=voice_assist")
            parts.run("recogniser", "/voice_assist", words)
        if victim == "client":
            lead.client = ActionClient()
            stack.callback(lead.client.end)
            lead.client.start()
        part = lead.client or parts[victim]
        stage = LossStage(victim, part, watcher, lead, rng)
        wait_until(stage.is_back, "all parts speak", START_TIME)
        yield stage


class LossStage:
    """A running system of which one part is lost.

    Args:
        victim: One of RULES.
        part: That it is.
        watcher: Sees what moves.
        lead: Gives commands.
        rng: Chooses moments.
    """

    def __init__(
        self,
        victim: str,
        part: Part | ActionClient,
        watcher: JointWatcher,
        lead: CommandLead,
        rng: np.random.Generator,
    ) -> None:
        self._victim, self._part, self._rule = victim, part, RULES[victim]
        self._watcher, self._lead, self._rng = watcher, lead, rng

    def is_back(self) -> bool:
        """Whether all parts speak."""
        watcher = self._watcher
        now = time.monotonic()
        beats = self._victim not in SPOKEN or now - watcher.heartbeat_at < FRESH
        beats &= self._victim != "recorder" or now - watcher.recorded_at < FRESH
        return watcher.hears_robot and watcher.now() is not None and watcher.can_stop and beats

    def lose(self, way: str) -> PartLoss:
        """Lose the part in a motion, and see the system come back.

        Raises:
            RuntimeError: The robot could not be moved in the first place.
        """
        motion = self._into_motion()
        lost = self._failed(self._part.lose(way))
        limit = self._rule.limit_of(motion)
        goes_on = limit is None
        ended, stopped, by = self._watch(lost, goes_on)
        rest = time.monotonic()
        finished = limit is not None and 0.0 <= self._watcher.finished_at - lost <= limit
        trace, seen = self._trace(), lost + WATCHED  # now, for streams are not kept for ever
        arm = judge.last_movement(JointTrace(trace.times, trace.positions[:, :-2]), lost, seen)
        if goes_on:
            seen = lost + UNTIL_STOP[0] + WATCHED
        words = [self._unrecorded(lost)] if self._victim == "recorder" else []
        if way == "hang" and not self._lead.is_spotted():
            words.append('while the recogniser hung, no spoken "stop" was spotted')
        time.sleep(self._rng.uniform(0.0, FROZEN))
        moved, back, returning = self._return(way, rest)
        blind = "" if self._rule.may_end else judge.blindness(trace, lost, seen)
        last = judge.last_joint(trace, lost, rest)
        return PartLoss(
            victim=self._victim,
            way=way,
            motion=motion,
            speed=judge.speed(trace, lost),
            joint="" if last is None else JOINTS[last],
            alone=ended,
            arm=arm,
            stopped=stopped,
            by=by,
            drift=moved,
            back=back,
            found=self._lead.is_found(),
            objections=tuple(word for word in (*words, blind, *returning) if word),
            load=os.getloadavg()[0],
            finished=finished,
        )

    def _return(self, way: str, rest: float) -> tuple[float, float | None, list[str]]:
        """Give the part back and move again.

        Args:
            way: By which it was lost.
            rest: When the robot rested [s].

        Returns:
            Largest way of a joint before "hey robot" [rad], time from the return to the next motion
            [s] (None: there was none), and what was not as it must be.
        """
        returned, words = time.monotonic(), list[str]()
        try:
            returned = self._part.give_back(way)
            wait_until(self.is_back, "all parts speak again", START_TIME)
            wait_until(self._lead.is_found, "new clients find the controller", FOUND)
            time.sleep(RETURNED)
            until = time.monotonic()
            if self._victim != "recorder":  # it was awake again while the recorder was lost
                words.append(self._lead.refuses())
            moved = self._drift(way, rest, returned, until)
            self._lead.wake()
            self._lead.set_off()
        except RuntimeError as error:
            return self._drift(way, rest, returned, time.monotonic()), None, [*words, str(error)]
        return moved, time.monotonic() - returned, words

    def _into_motion(self) -> str:
        """Bring the robot into a motion, and to a random moment of it; gives which motion."""
        ended: list[str] = []
        for _ in range(ATTEMPTS):
            self._rest()
            self._lead.wake()
            state = self._watcher.now()
            is_free = state is not None and not state.tissue_held
            if is_free and self._lead.room is None and self._rng.random() < GRASPING:
                self._lead.grasp()
            if self._watcher.is_("moving", "stopping"):
                continue  # it takes longer than anybody waits
            motion = self._lead.set_off()
            longest = next(PHASES[word] for word in PHASES if motion.startswith(word))
            time.sleep(self._rng.uniform(0.0, longest))
            trace = self._trace()  # what is on its way here is missing, so judged by its end
            is_going = len(trace.times) > 0 and judge.speed(trace, float(trace.times[-1])) > 0.0
            if self._watcher.is_("moving") and is_going:
                return motion
            state = self._watcher.state
            ended.append(f"{motion}: {state.state} {state.halt_reason}" if state else motion)
        raise RuntimeError(f"no motion lasted until its loss: {'; '.join(ended)}")

    def _failed(self, lost: float) -> float:
        """When the part was truly lost [s]: a recogniser fails at its next decoder pass."""
        if self._victim == "recogniser" and self._lead.room is not None:
            self._lead.room.say(TALK)
            wait_until(lambda: self._watcher.failed_at > lost, "the recogniser fails", 3.0)
            return self._watcher.failed_at
        return lost

    def _rest(self) -> None:
        """Stop what moves."""
        if self._watcher.is_("moving", "stopping"):
            self._watcher.stop()
            wait_until(lambda: not self._watcher.is_("moving", "stopping"), "at rest", 5.0)

    def _watch(self, lost: float, goes_on: bool) -> tuple[float, float | None, str]:
        """Time to rest by itself; where that is not meant to be: by a stop, and which [s]."""
        if not goes_on:
            time.sleep(WATCHED)
            return judge.last_movement(self._trace(), lost, lost + WATCHED), None, ""
        time.sleep(self._rng.uniform(*UNTIL_STOP))
        by = "topic" if self._rng.random() < 0.5 else "service"
        given = time.monotonic()
        if by == "topic":
            self._watcher.stop()
        else:
            self._lead.say("stop")
        time.sleep(WATCHED)
        trace = self._trace()
        alone = judge.last_movement(trace, lost, given)
        return alone, judge.last_movement(trace, given, given + WATCHED), by

    def _unrecorded(self, lost: float) -> str:
        """Why new motion without a recorder is not refused as documented; empty: it is."""
        time.sleep(max(0.0, lost + _UNRECORDED + 0.3 - time.monotonic()))
        self._lead.say("hey robot")
        replies = {words: self._lead.say(words) for words in ("tense", "pull more")}
        accepted = [words for words, reply in replies.items() if reply.accepted]
        if accepted:
            return f'"{accepted[0]}" was accepted without a recorder'
        if any(reply.reason_code == ReasonCode.NOT_RECORDED for reply in replies.values()):
            return ""
        words = "; ".join(reply.message for reply in replies.values())
        return f"no refusal names the recorder: {words}"

    def _drift(self, way: str, rest: float, returned: float, until: float) -> float:
        """Largest way from rest to now [rad]; a robot that was started anew begins anew."""
        trace = self._watcher.joints()
        if self._victim == "robot":
            if way == "SIGKILL":
                trace = _after(trace, returned)
                rest = float(trace.times[0]) if len(trace.times) else until
            else:
                rest = returned + self._rule.finishes
        return judge.drift(trace, rest, until)

    def _trace(self) -> JointTrace:
        """What is judged."""
        return self._watcher.setpoints() if self._victim == "robot" else self._watcher.joints()


def _after(trace: JointTrace, moment: float) -> JointTrace:
    first = int(np.searchsorted(trace.times, moment, side="right"))
    return JointTrace(trace.times[first:], trace.positions[first:])
