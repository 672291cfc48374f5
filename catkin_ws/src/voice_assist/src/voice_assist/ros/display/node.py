# SPDX-License-Identifier: BSD-3-Clause
"""The node of the operator's page: follows the system, serves the page, at low priority."""

from __future__ import annotations

import asyncio
import json
import sys
import time
from collections.abc import Callable
from contextlib import AsyncExitStack, suppress

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from std_msgs.msg import Bool, String

from rst_control.msg import ControllerState
from typed_config import ConfigError, load_config
from typed_config.priority import set_priority
from typed_config.ros.launch_settings import KEPT
from typed_config.ros.private_settings import private_settings
from typed_config.ros.starting import starting
from typed_config.ros.xmlrpc import FAILURES, parameter
from voice_assist.config import CommandConfig, CommandsConfig
from voice_assist.config.believed import believed_config
from voice_assist.config.display import FILE, DisplayConfig
from voice_assist.display.access_token import AccessToken
from voice_assist.display.server import DisplayServer
from voice_assist.display.theatre import Limits, Theatre
from voice_assist.msg import Alarm, AudioChunk, DeviceCall, Mode, Utterance
from voice_assist.ros.alarms.alarm_watch import AlarmWatch
from voice_assist.ros.believed import Believed
from voice_assist.ros.connected import is_connected, publisher_of
from voice_assist.ros.display import messages
from voice_assist.ros.display.acts import RosActs
from voice_assist.ros.display.endoscope import Endoscope
from voice_assist.ros.display.pictures import Pictures
from voice_assist.ros.messages import is_bad

NICE = 10  # the page gives way to all that hears and moves
LOOK_AGAIN = 1.0  # [s] between looks at what no topic says: settings, and whether alarms are there
SETTINGS = "controller"  # node whose parameters hold the limits
VOICE = "voice_assist"  # node whose parameters hold the spoken commands


class NotServedError(Exception):
    """The page's address cannot be had."""


class DisplayNode:
    """Follows the topics.

    Args:
        theatre: Gets all that is shown.
    """

    def __init__(self, theatre: Theatre) -> None:
        self._theatre = theatre
        self._commands: object = None  # parameter that the spoken words were last read from
        self.known = Believed()
        follow = self.known.hear
        self._alarms = AlarmWatch(
            theatre.see_alarm, lambda: is_connected(self._alarm), time.monotonic
        )
        self._alarm = follow("system", "voice_assist/alarm", Alarm, self._on_alarm)
        self._subscribers = [
            follow(
                "controller", "rst_control/state", ControllerState, self._on_state, queue_size=1
            ),
            follow("system", "robot/tension_invalid_reason", String, self._on_invalid),
            follow("voice", "voice_assist/audio", AudioChunk, self._on_sound, queue_size=10),
            follow("voice", "voice_assist/partial", String, self._on_partial, queue_size=1),
            follow("voice", "voice_assist/utterance", Utterance, self._on_utterance, queue_size=10),
            follow("system", "voice_assist/device", DeviceCall, self._on_device, queue_size=10),
            follow("voice", "voice_assist/mode", Mode, self._on_mode, queue_size=1),
            follow("speaker", "voice_assist/speaking", Bool, self._on_speaking, queue_size=10),
            follow("system", "session_log/recording", String, self._on_recording, queue_size=1),
            follow("system", "session_log/file", String, self._on_file, queue_size=1),
            follow("system", "/diagnostics", DiagnosticArray, self._on_diagnostics, queue_size=20),
        ]

    def look_again(self) -> None:
        """Take in what no topic says, and name who is not believed."""
        self.known.publish_status()
        self._alarms.look_again()
        with suppress(*FAILURES):  # while the master is gone or hangs, the page goes on
            self._look_at_settings()

    def _look_at_settings(self) -> None:
        """Take in the parameters; raises FAILURES: what was read before stays."""
        motion, voice = _in_force(SETTINGS), _in_force(VOICE)
        self._theatre.limits = Limits(
            tension=_number(motion("controller/tension/limit")),
            rcm=_number(motion("rcm/measured_tolerance")),
        )
        self._theatre.answer_within = _number(voice("recognizer/ask/answer_within")) or 0.0
        given = voice("commands")
        if given != self._commands:  # another voice node was launched
            self._theatre.rules = messages.word_rules(_commands(given))
            self._commands = given

    def _on_state(self, message: ControllerState) -> None:
        stamp = message.header.stamp.to_sec()
        self._theatre.see_robot(*messages.robot_parts(message), stamp)

    def _on_invalid(self, message: String) -> None:
        self._theatre.see_tension_invalid(message.data)

    def _on_sound(self, message: AudioChunk) -> None:
        self._theatre.see_sound(messages.sound_level(message))

    def _on_partial(self, message: String) -> None:
        self._theatre.see_partial(message.data)

    def _on_utterance(self, message: Utterance) -> None:
        asked, is_rest = messages.asked_command(message), messages.is_rest(message)
        self._theatre.see_utterance(messages.utterance_part(message), asked, is_rest=is_rest)

    def _on_device(self, message: DeviceCall) -> None:
        self._theatre.see_device(messages.device_words(message))

    def _on_speaking(self, message: Bool) -> None:
        self._theatre.see_speaking(message.data)

    def _on_mode(self, message: Mode) -> None:
        self._theatre.see_mode(message.mode)

    def _on_alarm(self, message: Alarm) -> None:
        self._alarms.see_alarm(messages.alarm_part(message), publisher_of(message))

    def _on_recording(self, message: String) -> None:
        self._theatre.see_recording(message.data)

    def _on_file(self, message: String) -> None:
        self._theatre.see_file(message.data)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        self._alarms.see_status(publisher_of(message))
        for status in message.status:
            self._on_health(status)

    def _on_health(self, status: DiagnosticStatus) -> None:
        values = messages.values_of(status)
        if "microphone level [dB]" in values:
            source = values.get("source", "")
            microphone = values.get("microphone", "") if source == "microphone" else source
            trouble = status.message if is_bad(status) else ""
            self._theatre.see_voice_health(microphone, trouble)
        if "tension not trusted" in values:
            self._theatre.see_tension_distrust(values["tension not trusted"])
        if "free space [B]" in values:
            self._theatre.see_free_space(int(values["free space [B]"]) or None)
        if "recorded for [s]" in values:
            self._theatre.see_recorded_for(
                values.get("file", ""), float(values["recorded for [s]"])
            )


def _parameter(name: str) -> object:
    """One of ours, None if it is not set; raises FAILURES soon where a master hangs."""
    return parameter(rospy.resolve_name(name))


def _in_force(node: str) -> Callable[[str], object]:
    """The settings of a node by their keys, None: not set. Both raise FAILURES.

    A node that runs has those of its launch, which it keeps, whatever the server holds since. The
    server's count where nothing is kept: the node has not started yet.
    """
    try:
        kept = json.loads(str(_parameter(f"{node}/{KEPT}")))
    except json.JSONDecodeError:
        kept = None
    if not isinstance(kept, dict):
        return lambda key: _parameter(f"{node}/{key}")
    return lambda key: _within(kept, key)


def _within(settings: object, key: str) -> object:
    """The value of a key such as tension/limit in nested settings; None: there is none."""
    for part in key.split("/"):
        settings = settings.get(part) if isinstance(settings, dict) else None
    return settings


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) else None


def _commands(given: object) -> tuple[CommandConfig, ...]:
    """What can be said; nothing while no voice node was launched."""
    if given is None:
        return ()
    try:
        return load_config(CommandsConfig, given, "commands.yaml").commands
    except ConfigError:  # the voice node refuses it, and says why
        return ()


async def serve(config: DisplayConfig) -> None:
    """Serve the page until ROS shuts down.

    Raises:
        NotServedError: The address cannot be had.
    """
    theatre = Theatre(config.old_after, time.monotonic, time.time)
    token = AccessToken(time.monotonic)
    node = DisplayNode(theatre)
    acts = RosActs(theatre, Endoscope(config.picture, node.known))
    server = DisplayServer(config, theatre, acts, token, rospy.logerr)
    async with AsyncExitStack() as stack:
        try:
            await stack.enter_async_context(server)
        except OSError as error:
            raise NotServedError(f"the page cannot be served: {error}") from error
        pictures = Pictures(config.picture, theatre, lambda: len(server.viewers) > 0, node.known)
        # printed, not logged: what is logged is recorded
        print(f"operator's page: {server.address}   token: {token.text}", flush=True)
        rospy.loginfo("operator's page: %s", server.address)
        rospy.set_param("~page", server.address)
        loop = asyncio.get_running_loop()
        while not rospy.is_shutdown():
            await loop.run_in_executor(None, node.look_again)
            await asyncio.sleep(LOOK_AGAIN)
        del pictures


def main() -> None:
    """Run the display node."""
    set_priority(NICE)
    with starting("display", __doc__, needs_clock=False):
        config = private_settings(DisplayConfig, FILE)
        believed_config(rospy.get_param("~believed", None))
    try:
        asyncio.run(serve(config))
    except NotServedError as error:
        rospy.logfatal("%s", error)
        sys.exit(2)
