# SPDX-License-Identifier: BSD-3-Clause
"""The catalogue of spoken answers: one short sentence for each reason code and each command.

No sentence may hold the words of a command, or sound like one: `word_check` looks at each when the
node starts. The keys are the codes of `rst_control/ReasonCode.msg` and of `Utterance.msg`.
"""

from __future__ import annotations

from typing import Final

from voice_assist.config.commands import ENGLISH, CommandsConfig

TAKEN: Final = {  # by the command that the controller accepted
    "hey robot": "ready",
    "tense": "taking hold",
    "release": "opening wide",
    "pull more": "drawing further",
    "pull less": "easing",
    "terminate": "asleep",
    "insert": "going in",
    "withdraw": "coming out",
    "grasp here": "remembered",
}
TAKEN_OTHERWISE: Final = "accepted"  # of any other command

WHY: Final = {  # by reason code
    # a command is refused
    "unknown_command": "unknown words",
    "wrong_mode": "wake me first",
    "halted": "still halted",
    "busy": "still busy",
    "not_at_rest": "wait for the end",
    "by_hand_only": "by hand only",
    "may_not_command": "that caller may not",
    "too_many_calls": "too many calls",
    "bad_amount": "wrong amount",
    "queue_full": "too many waiting",
    "situation_changing": "wait a moment",
    "check_failed": "check failed",
    "withdrawn": "called off",
    "nothing_grasped": "jaws are empty",
    "already_grasped": "it holds tissue",
    "already_there": "that is done",
    "not_inserted": "tool is outside",
    "unreachable": "out of reach",
    "no_grasp": "unable to grip",
    "joint_limit": "joint limit",
    "rcm_tolerance": "shaft left the trocar",
    "workspace": "outside the workspace",
    "insertion_depth": "wrong depth",
    "collision": "something in the way",
    "near_singular": "bad arm position",
    "tension_limit": "too much force",
    "displacement_limit": "drawn too far",
    "tilt_limit": "tilted too far",
    "not_confirmed": "path unconfirmed",
    "not_the_trocar": "that is a wrong trocar",
    "no_answer": "controller is mute",
    # refused, or braked and latched
    "not_connected": "arm is disconnected",
    "robot_fault": "arm has a fault",
    "joint_states_stale": "arm is behind",
    "not_recorded": "recorder is off",
    "no_master": "network is gone",
    "node_lost": "a part is gone",
    "voice_silent": "hearing is gone",
    "dead_man": "dead man is up",
    "sensor_fault": "bad gauge",
    "unknown_frame": "unknown frame",
    "tracker_stale": "tracking is lost",
    "tracker_jumped": "tracker jumped",
    "tracker_too_far": "trocar is too far off",
    "arm_fault": "arm has a fault",
    "arm_in_use": "arm is in other hands",
    "arm_not_ready": "arm is not ready",
    "arm_limits": "arm limits are too low",
    # braked and latched
    "settings_changed": "settings were changed",
    "setpoints_stopped": "set points are late",
    "setpoint_refused": "bad set point",
    "tension_sensor": "bad force gauge",
    "joint_messages": "bad arm data",
    "off_setpoint": "arm is held up",
    "off_trocar": "shaft left the trocar",
    "over_tension": "too much force",
    "slipped": "tissue slipped",
    "overtime": "took too long",
    "loop_error": "controller failed",
    # given up
    "no_response_to_pull": "tissue gave way",
    "closed_on_nothing": "jaws are empty",
    "caught_tissue": "tissue is caught",
    # the voice did not take the words of a command
    "unsure": "unsure, say again",
    "sounds_like_another": "unclear, say again",
    "other_voice": "another voice",
    "damaged_sound": "sound is damaged",
    "tone": "that was a tone",
    "talk_gate": "foot pedal first",
    "same_breath": "pause before it",
    "second_voice": "others were talking",
    "other_mode": "wrong mode",
}


def taken(command: str) -> str:
    """What is said of a command that was accepted, whatever its amount."""
    return _named(command) or TAKEN_OTHERWISE


def asked(phrase: str, commands: CommandsConfig) -> str:
    """What is said of a command that is asked for: what it does, or to say it again.

    Only where a motion is said twice does saying it again answer the question. Elsewhere nothing is
    said of a command without a sentence of its own.

    Args:
        phrase: Of the command.
        commands: All that can be said.
    """
    if commands.language != ENGLISH:
        return WHY["unsure"]
    called = {command.phrase: command.command for command in commands.commands}
    return _named(called.get(phrase, "")) or (WHY["unsure"] if commands.said_twice else "")


def _named(command: str) -> str:
    named = (said for one, said in TAKEN.items() if f"{command} ".startswith(f"{one} "))
    return next(named, "")


def why(code: str) -> str:
    """What is said of a reason code; empty: nothing."""
    return WHY.get(code, "")


def catalogue() -> tuple[str, ...]:
    """All sentences, each once."""
    return tuple(dict.fromkeys((*TAKEN.values(), TAKEN_OTHERWISE, *WHY.values())))
