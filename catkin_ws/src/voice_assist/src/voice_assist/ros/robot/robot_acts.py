# SPDX-License-Identifier: BSD-3-Clause
"""What decisions do to the robot, and what it and people report back to the dialogue."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from queue import Queue

import rospy

from voice_assist.config import VoiceConfig
from voice_assist.intent.dialogue import Answered
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.ros.believed import Believed
from voice_assist.ros.publishers import Publishers
from voice_assist.ros.question_service import HandAnswer, QuestionService
from voice_assist.ros.robot.command_client import CommandClient
from voice_assist.ros.robot.controller_state import ControllerFollower
from voice_assist.ros.robot.robot_speech import RobotSpeechTopic
from voice_assist.ros.talk_topic import TalkTopic
from voice_assist.text.spoken_reply import spoken_reply
from voice_assist.types import Action, Ask, Call, Frame, Halt, Mode, SetMode


class RobotActs:
    """Carries out actions and takes reports, in recognition's thread.

    `stop` and `hold` are called in any thread. `start` is in the main one, `with_motion` in that of
    the sound, `trouble` in that of the heartbeat.

    Args:
        config: All settings of the voice.
        pipeline: Gets the reports.
        publish: The node's topics.
        known: Makes the subscribers, each to those that are believed.
        clock: The one that stamps the frames [s].
    """

    def __init__(
        self,
        config: VoiceConfig,
        pipeline: Pipeline,
        publish: Publishers,
        known: Believed,
        clock: Callable[[], float],
    ) -> None:
        self._pipeline, self._publish, self._clock = pipeline, publish, clock
        self._commands = config.commands
        self._answers: Queue[Answered] = Queue()
        self._client = CommandClient(config.commands.answer_within, self._answers.put)
        self._questions = QuestionService()
        longest = config.audio.robot_speech.max_duration
        self._robot_speech = RobotSpeechTopic(clock, known, longest)
        self._talk = TalkTopic(clock, known)
        self._robot = ControllerFollower(config.moving, time.monotonic, publish.side_input, known)
        self._repeatable = {c.command for c in config.commands.commands if not c.is_motion}
        self.stopped = float("-inf")  # [s] when the newest stop was sent

    def start(self) -> None:
        """Show the mode, and serve answers that are given by hand."""
        state = self._pipeline.state
        self._publish.mode(state.mode, state.reason, self._clock())
        self._questions.start()

    @property
    def trouble(self) -> str:
        """Why the controller takes no commands; empty when it does."""
        return self._client.trouble

    def with_motion(self, frame: Frame) -> Frame:
        """The frame with whether the robot moves now, or may."""
        return self._robot.with_motion(frame)

    def stop(self) -> None:
        """Stop; what is spotted soon after is the same stop."""
        self.stopped = self._clock()
        self.hold()

    def hold(self) -> None:
        """Stop; where hearing failed, a stop that is spotted later is sent, too."""
        self._publish.stop()
        self._client.forget()
        self._robot.drop()

    def do(self, action: Action) -> None:
        """Carry one action out."""
        if isinstance(action, Halt):
            self.stop()
        elif isinstance(action, Call):
            is_repeatable = action.command in self._repeatable
            self._robot.send(is_motion=not is_repeatable)
            self._client.call(action.command, is_repeatable)
        elif isinstance(action, Ask):
            if not self._commands.said_twice:  # to say it aloud would be to say it again
                self._publish.reply(spoken_reply(f"{action.command}?", self._commands.phrases))
        elif isinstance(action, SetMode):
            self._robot.arm(action.mode is Mode.ACTIVE)
            self._publish.mode(action.mode, action.reason, self._clock())

    def take_reports(self) -> None:
        """Give the dialogue all that came since the last call, and do what comes of it."""
        for spoke in self._robot_speech.take():
            self._pipeline.robot_spoke(spoke)
        for change in self._talk.take():
            self._pipeline.talk_changed(change)
        while not self._answers.empty():
            self._take_answer(self._answers.get())
        for given in self._questions.take():
            self._take_answer_by_hand(given)
        if (mode := self._robot.mode()) is not None:
            self._do_all(self._pipeline.follow(mode))

    def _take_answer(self, answered: Answered) -> None:
        self._robot.answer(is_motion=answered.command not in self._repeatable)
        if reply := spoken_reply(answered.message, self._commands.phrases):
            self._publish.reply(reply)
        if answered.is_accepted:
            rospy.loginfo("%s: %s", answered.command, answered.message)
        else:
            rospy.logwarn("%s refused: %s", answered.command, answered.message)
        self._do_all(self._pipeline.answer(answered))

    def _take_answer_by_hand(self, given: HandAnswer) -> None:
        actions = self._pipeline.answer_by_hand(given.command, given.is_yes)
        if actions is not None:
            rospy.loginfo("%s? %s, by hand", given.command, "yes" if given.is_yes else "no")
        self._do_all(actions or ())
        given.stood.set_result(actions is not None)

    def _do_all(self, actions: Iterable[Action]) -> None:
        for action in actions:
            self.do(action)
