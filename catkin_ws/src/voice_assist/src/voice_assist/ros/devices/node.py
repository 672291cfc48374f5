# SPDX-License-Identifier: BSD-3-Clause
"""The devices node: calls the theatre's devices as spoken commands ask, in a process of its own."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import Final

import rosgraph
import rospy
from std_msgs.msg import Empty as EmptyMessage
from std_msgs.msg import String

from rst_control.msg import Event
from typed_config import ConfigError, load_config
from typed_config.errors import Missing
from typed_config.ros.launch_settings import is_restart, launch_settings
from typed_config.ros.registration import stay_registered
from typed_config.ros.service_calls import never
from typed_config.ros.starting import starting
from typed_config.ros.xmlrpc import FAILURES, ask
from voice_assist.audio.capture.stamp_check import MAX_AHEAD
from voice_assist.config import CommandsConfig
from voice_assist.config.devices import (
    DeviceCallConfig,
    DevicesConfig,
    devices_config,
    require_harmless,
)
from voice_assist.devices.calls import CallResult, DeviceCalls, result_words
from voice_assist.errors import CommandsError
from voice_assist.msg import DeviceCall, Utterance
from voice_assist.ros.believed import Believed
from voice_assist.ros.devices.targets import Target, cancel_left, make_target
from voice_assist.text.spoken_reply import spoken_reply

VOICE = "voice_assist"  # node whose parameters hold the spoken commands
IDLE = 0.2  # [s] between checks whether ROS ends
SAY_AGAIN = 10.0  # [s] between warnings that nothing is kept
SAID_WITHIN: Final = 2.0  # [s] from decision to call; older words could come after a later stop
HEARD_AFTER = 1.0  # [s] since the start, until those who show and record results are connected
TO_UNDO: Final = "to_undo"  # private parameter: phrases of the calls that a stop has to undo
GOAL: Final = "goal"  # private parameter: phrase and goal's id of the action that a stop cancels


class DevicesNode:
    """Follows the voice node and stops; makes one call after the other, and undoes beside them.

    Args:
        config: The allow-list.
        commands: All that can be said.
        to_undo: Phrases of the calls that a stop had to undo where this node crashed. They are
            undone at once, as a stop may have come since.
        left: Phrase and goal's id of the action that was at work there. It is cancelled before.

    Raises:
        CommandsError: A type is not there, or arguments do not fit it.
        ConfigError: `~believed` is not as it must be.
    """

    def __init__(
        self,
        config: DevicesConfig,
        commands: CommandsConfig,
        to_undo: Collection[str] = (),
        left: Sequence[str] = (),
    ) -> None:
        self._config, self._phrases, self._left = config, commands.phrases, left
        self._heard_at = time.monotonic() + HEARD_AFTER
        self._targets: dict[str, Target] = {}
        for index, call in enumerate(config.calls):
            try:
                self._targets[call.phrase] = make_target(call, partial(self._keep_goal, call))
            except CommandsError as error:
                raise error.under(f"devices.calls[{index}]") from None
        self._calls = DeviceCalls(config)
        self._kept = list(to_undo)  # by the master
        self._result = rospy.Publisher("voice_assist/device", DeviceCall, queue_size=20)
        self._say = rospy.Publisher("voice_assist/say", String, queue_size=20)
        self._known = Believed()
        self._known.hear("voice", "voice_assist/utterance", Utterance, self._on_utterance)
        rospy.Subscriber("rst_control/stop", EmptyMessage, lambda _: self._on_stop())
        self._known.hear("controller", "rst_control/event", Event, self._on_event)
        if to_undo:
            rospy.logwarn("started again, a stop may have come: undoing %s", ", ".join(to_undo))
            self._calls.undo(to_undo)

    def run(self) -> None:
        """Make calls until ROS shuts down; this thread makes none, so that it is never silent."""
        threading.Thread(target=self._undo, name="undo", daemon=True).start()
        while not rospy.is_shutdown():
            self._known.publish_status()
            rospy.rostime.wallsleep(IDLE)

    def _make_calls(self) -> None:
        while not rospy.is_shutdown():
            call = self._calls.next(IDLE)
            self._keep()  # before the call, during which this process may end
            if call is not None:
                self._make(call, self._calls.stop_check(call))

    def _keep(self) -> None:
        """Let the master keep what a stop has to undo, for a start after a crash."""
        phrases = self._calls.to_undo()
        if phrases != self._kept and _set_parameter(TO_UNDO, phrases):
            self._kept = phrases

    def _keep_goal(self, call: DeviceCallConfig, goal_id: str) -> None:
        """Let the master keep the goal of an action; "": it has ended.

        No stop cancels what undoes calls.
        """
        if call.phrase not in {one.on_stop for one in self._config.calls}:
            _set_parameter(GOAL, [call.phrase, goal_id] if goal_id else [])

    def _cancel_left(self) -> None:
        """Cancel the action that was at work where this node crashed."""
        try:
            phrase, goal_id = self._left
            if (call := self._config.get(phrase)) is not None:
                self._report(cancel_left(call, goal_id))
        except Exception as error:  # calls are undone all the same
            rospy.logerr("the action at work is not cancelled: %r", error)
        _set_parameter(GOAL, [])

    def _undo(self) -> None:
        """Make what undoes calls at a stop; a thread of its own, as a call at work may hang."""
        if self._left:
            self._cancel_left()
        threading.Thread(target=self._make_calls, name="calls", daemon=True).start()
        while not rospy.is_shutdown():
            if (call := self._calls.next_undoing(IDLE)) is not None:
                self._make(call, never)

    def _make(self, call: DeviceCallConfig, is_stopped: Callable[[], bool]) -> None:
        try:
            result = self._targets[call.phrase].call(is_stopped)
        except Exception as error:  # top of a call: the person must hear of it
            result = CallResult(call, False, repr(error))
        self._calls.ended(result)
        self._report(result)

    def _on_utterance(self, message: Utterance) -> None:
        call = self._config.get(message.command)
        if call is not None and (why := _age_trouble(message)):
            self._report(CallResult(call, False, why, may_have_effect=False))
        elif (refused := self._calls.said(message.command)) is not None:
            self._report(refused)

    def _on_event(self, message: Event) -> None:
        if message.kind == "stop_received":
            self._on_stop()

    def _on_stop(self) -> None:
        for dropped in self._calls.stopped():
            self._report(dropped)

    def _report(self, result: CallResult) -> None:
        """Say, show and record what came of a call."""
        words = result_words(result.call.phrase, result.is_done, result.words)
        (rospy.loginfo if result.is_done else rospy.logwarn)("%s", words)
        message = DeviceCall(
            phrase=result.call.phrase,
            target=result.call.target,
            is_done=result.is_done,
            message=result.words,
        )
        message.header.stamp = rospy.Time.now()
        if (early := self._heard_at - time.monotonic()) > 0.0:
            timer = threading.Timer(early, self._publish, (message, words))
            timer.daemon = True
            timer.start()
        else:
            self._publish(message, words)

    def _publish(self, message: DeviceCall, words: str) -> None:
        self._result.publish(message)
        if spoken := spoken_reply(words, self._phrases):
            self._say.publish(String(spoken))


def _age_trouble(message: Utterance) -> str:
    """Why words are too old to call a device; empty: they are not, or have no age.

    Of a clock that is ahead the age is unknown, and a simulated one may be faster than a person.
    """
    stamp = message.decision.to_sec() or message.header.stamp.to_sec()
    if not stamp or not rospy.rostime.is_wallclock():
        return ""
    age = rospy.get_time() - stamp
    if -MAX_AHEAD <= age <= SAID_WITHIN:
        return ""
    if age > 0.0:
        return f"said {age:.1f} s ago, allowed {SAID_WITHIN:g} s"
    return f"said {-age:.1f} s ahead of this host's clock, allowed {MAX_AHEAD:g} s; run chrony"


def _set_parameter(key: str, value: list[str]) -> bool:
    """Let the master keep something for a start after a crash; gives whether it does."""
    name = rospy.resolve_name(f"~{key}")
    try:
        ask(rosgraph.get_master_uri(), "setParam", rospy.get_name(), name, value)
    except FAILURES as error:
        words = "not kept for a restart: what a stop undoes and cancels (%s)"
        rospy.logwarn_throttle(SAY_AGAIN, words, error)
        return False
    return True


def spoken_commands() -> CommandsConfig:
    """All that can be said to the voice node.

    Raises:
        ConfigError: None was launched, or its commands are not as they must be.
    """
    key = f"{VOICE}/commands"
    given = rospy.get_param(key, Missing())
    if isinstance(given, Missing):
        raise ConfigError(key, given, "the commands of a voice node that was launched before")
    return load_config(CommandsConfig, given, "commands.yaml")


def main() -> None:
    """Run the devices node."""
    with starting("devices", __doc__, needs_clock=False):
        settings = launch_settings(own=(TO_UNDO, GOAL))
        config = devices_config({"calls": settings.get("calls", [])})
        commands = spoken_commands()
        require_harmless(config, commands)
        left = settings if is_restart() else {}
        node = DevicesNode(config, commands, left.get(TO_UNDO, []), left.get(GOAL, []))
    stay_registered()
    node.run()
