# SPDX-License-Identifier: BSD-3-Clause
"""The alarm node: listens to controller, voice and diagnostics; shows, says and sounds alarms.

A process of its own, so that it outlives what it watches, and so that no sound device comes near
the threads that hear and move.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from queue import Empty, Queue

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Bool, String
from std_msgs.msg import Empty as EmptyMessage
from visualization_msgs.msg import Marker

from rst_control.msg import ControllerState, Event
from typed_config import load_config, load_file
from typed_config.ros.private_settings import private_settings
from typed_config.ros.starting import starting
from voice_assist.alarms.annunciator import Annunciator
from voice_assist.alarms.appearance import is_lit, line
from voice_assist.alarms.board import Board, Standing, wake_phrases
from voice_assist.alarms.player import Player
from voice_assist.alarms.sound_output import ProgramOutput
from voice_assist.alarms.types import IN_MOTION, PartHealth, Priority
from voice_assist.answers.sentences import asked
from voice_assist.answers.speech import SpokenAnswers
from voice_assist.config import CONFIG_DIR, CommandsConfig
from voice_assist.config.alarms import FILE, AlarmsConfig
from voice_assist.config.texts import texts_of
from voice_assist.config.voice import commands_file
from voice_assist.msg import Alarm as AlarmMessage
from voice_assist.msg import Utterance
from voice_assist.ros.alarms import messages
from voice_assist.ros.believed import Believed

PERIOD = 0.05  # [s] between two ticks of the board while nothing comes
_WAITING = 10_000  # messages, at least; a controller's state comes 50 times a second
_LOG = {
    Priority.HIGH: rospy.logerr,
    Priority.MEDIUM: rospy.logwarn,
    Priority.LOW: rospy.logwarn,
    Priority.INFORMATION: rospy.loginfo,
}

LOG_GAP = 1.0  # [s] within which one stop may come by topic, by service and from the spotter

Take = Callable[[Board, float], None]


class AlarmNode:
    """One thread takes in what came and shows what is new; callbacks of rospy only hand over."""

    def __init__(self, config: AlarmsConfig, commands: CommandsConfig) -> None:
        ask = partial(asked, commands=commands)
        self._config, self._board = config, Board(config.board, wake_phrases(commands), ask)
        self._output, self._texts = ProgramOutput(config.sound), texts_of(commands)
        self._answers = self._make_answers(commands) if config.speech.is_enabled else None
        length = (lambda _: 0.0) if self._answers is None else self._answers.duration
        self._annunciator = Annunciator(config.sound, length)
        self._player: Player | None = None
        self._inbox: Queue[Take] = Queue(_WAITING)
        self._shown: tuple[Standing, ...] | None = None  # as the board has them
        self._said: tuple[Standing, ...] = ()  # the same in the language of the commands
        self._logged: dict[str, tuple[str, int, float]] = {}  # words, times given, when [s]
        self._was_lit = True
        self._alarm = rospy.Publisher("voice_assist/alarm", AlarmMessage, queue_size=50, latch=True)
        self._marker = rospy.Publisher(
            "voice_assist/alarm_marker", Marker, queue_size=10, latch=True
        )
        self._heard = rospy.Publisher("voice_assist/heard_marker", Marker, queue_size=10)
        self._known = Believed()
        self._subscribers = [
            self._listen("controller", "rst_control/state", ControllerState, self._on_state),
            self._listen("controller", "rst_control/event", Event, self._on_event),
            self._listen("voice", "voice_assist/utterance", Utterance, self._on_utterance),
            self._listen("voice", "voice_assist/partial", String, self._on_partial),
            self._listen("system", "/diagnostics", DiagnosticArray, self._on_diagnostics),
            rospy.Subscriber("rst_control/stop", EmptyMessage, lambda _: self._hush()),
        ]

    def run(self) -> None:
        """Show and sound alarms until ROS shuts down."""
        with ExitStack() as stack:
            self._player = player = self._make_player(stack)
            thread = threading.Thread(target=self._guard, args=(player,), daemon=True)
            thread.start()
            rospy.spin()
            thread.join(1.0)

    def _make_player(self, stack: ExitStack) -> Player | None:
        if not self._config.sound.is_enabled:
            rospy.loginfo("alarms are seen, not heard: sound.is_enabled is false")
            return None
        output, quiet = stack.enter_context(self._output), self._config.speech.quiet_after_stop
        answers = None if self._answers is None else stack.enter_context(self._answers)
        player = Player(output, _say_sound, answers, quiet, _say_unspoken)
        return stack.enter_context(player)

    def _make_answers(self, commands: CommandsConfig) -> SpokenAnswers:
        speaking = rospy.Publisher("voice_assist/speaking", Bool, queue_size=10, tcp_nodelay=True)
        return SpokenAnswers(
            self._config.speech,
            commands,
            self._output.play_file,
            lambda is_speaking: speaking.publish(Bool(is_speaking)),
            _say_unspoken,
        )

    def _guard(self, player: Player | None) -> None:
        """Top of the thread: who shows alarms must not die unseen."""
        try:
            while not rospy.is_shutdown():
                self._step(player)
        except Exception as error:
            if rospy.core.is_shutdown_requested() and isinstance(error, rospy.ROSException):
                return  # the topics were closed meanwhile
            rospy.logfatal("alarms: %r", error, exc_info=True)
            rospy.signal_shutdown(f"alarms: {error!r}")

    def _step(self, player: Player | None) -> None:
        with suppress(Empty):
            self._inbox.get(timeout=PERIOD)(self._board, _now())
        now = _now()
        self._known.publish_status()
        self._board.tick(now)
        standing = self._board.standing
        if standing != self._shown:
            self._shown, self._said = standing, self._in_language(standing)
            self._alarm.publish(messages.alarm_message(self._said, now, _stamp()))
            self._log(self._said, now)
            self._show(now)
        elif standing and is_lit(standing[0].alarm.priority, now) is not self._was_lit:
            self._show(now)
        alarm = self._annunciator.next(self._said, now)
        if alarm is not None and player is not None:
            player.offer(alarm)

    def _in_language(self, standing: tuple[Standing, ...]) -> tuple[Standing, ...]:
        return tuple(replace(s, alarm=s.alarm.said_in(self._texts)) for s in standing)

    def _show(self, now: float) -> None:
        first = self._said[0].alarm if self._said else None
        self._was_lit = first is None or is_lit(first.priority, now)
        marker = messages.alarm_marker(first, self._was_lit, self._config.look, _stamp())
        self._marker.publish(marker)

    def _log(self, standing: tuple[Standing, ...], now: float) -> None:
        """Say an alarm in the log when it begins, gets worse or is given again later on."""
        logged = {}
        for entry in standing:
            words = line(entry.alarm)
            before = self._logged.get(entry.key, ("", 0, 0.0))
            is_again = entry.times != before[1] and now - before[2] >= LOG_GAP
            if words != before[0] or is_again:
                _LOG[entry.alarm.priority]("%s", words)
                before = words, entry.times, now
            logged[entry.key] = before
        self._logged = logged

    def _listen(
        self, by: str, topic: str, kind: type, callback: Callable[..., None]
    ) -> rospy.Subscriber:
        return self._known.hear(by, topic, kind, callback, tcp_nodelay=True)

    def _on_state(self, message: ControllerState) -> None:
        state = messages.robot_state(message)
        self._mute(state.state in IN_MOTION)
        self._inbox.put(lambda board, now: board.see_state(state, now))

    def _hush(self) -> None:
        """A stop was heard: nothing may be said over a second one."""
        if self._player is not None:
            self._player.hush()

    def _mute(self, is_moving: bool) -> None:
        """While the robot moves nothing is said, for a "stop" would be heard later."""
        if self._player is not None and not self._config.speech.in_motion:
            self._player.is_muted = is_moving

    def _on_event(self, message: Event) -> None:
        if message.kind == "stop_received":
            self._hush()
        elif message.kind == "motion_started":  # it comes with "accepted", before the first state
            self._mute(is_moving=True)
        event = messages.controller_event(message)
        self._inbox.put(lambda board, now: board.see_event(event, now))

    def _on_partial(self, message: String) -> None:
        self._show_heard(f'hears "{message.data.strip()}"', False)

    def _show_heard(self, words: str, is_taken: bool) -> None:
        shown_for = self._config.board.shown_for
        marker = messages.heard_marker(words, is_taken, self._config.look, shown_for, _stamp())
        self._heard.publish(marker)

    def _on_utterance(self, message: Utterance) -> None:
        self._show_heard(messages.heard_words(message), bool(message.command))
        heard = messages.utterance(message)
        self._inbox.put(lambda board, now: board.see_utterance(heard, now))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._on_health(messages.part_health(status))

    def _on_health(self, health: PartHealth) -> None:
        self._inbox.put(lambda board, now: board.see_health(health, now))


def main() -> None:
    """Run the alarm node."""
    with starting("alarms", __doc__):
        config = private_settings(AlarmsConfig, FILE)
        node = AlarmNode(config, _load_commands())
    node.run()


def _load_commands() -> CommandsConfig:
    """All that can be said, from the node's private parameters; without a launch, as shipped."""
    given = rospy.get_param("~commands", None)
    if given is None:
        return load_file(CommandsConfig, commands_file(CONFIG_DIR))
    return load_config(CommandsConfig, given, "commands.yaml")


def _say_sound(trouble: str) -> None:
    if trouble:
        rospy.logwarn("alarms are seen, not heard: %s", trouble)
    else:
        rospy.loginfo("alarms are heard again")


def _say_unspoken(words: str) -> None:
    """Tones may be heard all the same."""
    rospy.logwarn("%s", words)


def _now() -> float:
    """By a clock that nobody sets: alarms come, sound and go by it [s]."""
    return time.monotonic()


def _stamp() -> float:
    return float(rospy.get_time())
