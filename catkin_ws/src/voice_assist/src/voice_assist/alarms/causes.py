# SPDX-License-Identifier: BSD-3-Clause
"""What each cause asks a person to do: one table for each way in which a cause shows itself.

The keys are the reason codes of the messages: of `rst_control/ReasonCode.msg`, of `Utterance.msg`,
and of the value `reason_code` in a status of `/diagnostics`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from voice_assist.alarms.types import Kind, Priority


@dataclass(frozen=True)
class Advice:
    """What to do about a cause, and how urgent it is."""

    next_step: str  # short, in the imperative
    kind: Kind = Kind.FAULT
    at_rest: Priority = Priority.MEDIUM  # of a fault at rest with nothing held
    loaded: Priority = Priority.HIGH  # of a fault while tissue is held or the robot moves


def _mild(next_step: str) -> Advice:
    """Of a fault that is no danger by itself."""
    return Advice(next_step, at_rest=Priority.LOW, loaded=Priority.MEDIUM)


def _refusals(steps: Mapping[str, str]) -> dict[str, Advice]:
    return {code: Advice(step, Kind.REFUSAL) for code, step in steps.items()}


UNKNOWN: Final = Advice('Look at the robot; say "hey robot" once it is safe.')
NO_REASON: Final = Advice("Read the reason, then say it again.", Kind.REFUSAL)

_CLEAR: Final = "Clear the fault at the robot, then say it again."
_ON: Final = 'then say "hey robot".'

LATCHES: Final = {  # by ControllerState.halt_reason_code: what braked and latched
    "stop_topic": Advice('Say "hey robot" when it is safe to go on.', Kind.STOP),
    "stop_command": Advice('Say "hey robot" when it is safe to go on.', Kind.STOP),
    "stop_cancel": Advice('Say "hey robot" when it is safe to go on.', Kind.STOP),
    "shutdown": Advice("Start the controller again before the next command.", Kind.STOP),
    "settings_changed": Advice(f"Put the setting back or launch anew, {_ON}"),
    "not_recorded": Advice(f"Start the recorder, {_ON}"),
    "not_connected": Advice(f"Check the robot's power, cable and driver, {_ON}"),
    "no_master": Advice(f"Start the ROS master again, {_ON}"),
    "node_lost": Advice(f"Start the node that is named again, {_ON}"),
    "joint_states_stale": Advice(f"Check the robot's driver and its network, {_ON}"),
    "setpoints_stopped": Advice(f"Check that the controller's machine keeps up, {_ON}"),
    "setpoint_refused": Advice(f"Check the joint that is named, {_ON}"),
    "sensor_fault": Advice(f"Check the sensor that is named, {_ON}"),
    "unknown_frame": Advice(f"Start what publishes the frame that is named, {_ON}"),
    "tracker_stale": Advice(f"Check the tracker and its view, {_ON}"),
    "tracker_jumped": Advice(f"Check the tracker's markers, {_ON}"),
    "tracker_too_far": Advice(f"Look at the trocar and its tracker, {_ON}"),
    "arm_fault": Advice(f"Look what the arm met; clear the fault, {_ON}"),
    "arm_in_use": Advice(f"Close the arm's web page, put joysticks away, {_ON}"),
    "arm_not_ready": Advice(f"Wait for the arm, or start its driver anew, {_ON}"),
    "arm_limits": Advice(f"Set the arm's soft limits as named, {_ON}"),
    "tension_sensor": Advice(f"Check the tension sensor, {_ON}"),
    "joint_messages": Advice(f"Check the robot's driver, {_ON}"),
    "robot_fault": Advice(f"Clear the fault at the robot, {_ON}"),
    "off_setpoint": Advice(f"Look what pushed or holds the arm and free it, {_ON}"),
    "off_trocar": Advice(f"Look at the trocar; set it anew if it moved, {_ON}"),
    "over_tension": Advice('Say "hey robot", then "release".'),
    "slipped": Advice('Look at the tissue; say "hey robot", then "tense".'),
    "dead_man": Advice(f"Press the dead-man, {_ON}", Kind.STOP),
    "voice_silent": Advice("Check microphone and clocks; give commands by hand meanwhile."),
    "overtime": Advice(f"Look what holds the robot up, {_ON}"),
    "loop_error": Advice("Free the tissue by hand; start the controller again."),
}

GIVE_UPS: Final = {  # by the code of an event at_rest: a motion that could not reach its end
    "no_response_to_pull": _mild('Look at tissue and jaws; say "release", then "tense".'),
    "closed_on_nothing": _mild('Bring tissue to the jaws; say "tense" again.'),
    "caught_tissue": _mild('Say "release", then give it once more.'),
    "tension_sensor": _mild('Say "pull more" to pull by distance, or "release".'),
}

REFUSALS: Final = _refusals(  # by the code of an event refused, trocar_refused or grasp_refused
    {
        "unknown_command": "Say one of the known commands.",
        "wrong_mode": 'Say "hey robot" first.',
        "halted": 'Say "hey robot" when it is safe to go on.',
        "busy": 'Wait until it rests, or say "stop".',
        "not_at_rest": "Wait until it rests, then say it again.",
        "by_hand_only": "Give this command by hand.",
        "may_not_command": "Let somebody who may give it.",
        "too_many_calls": "Wait a moment, then say it again.",
        "bad_amount": "Give numbers from 0 up.",
        "queue_full": "Wait for the answers, then repeat it.",
        "situation_changing": "Wait a moment, then say it again.",
        "check_failed": "Read the log; try another command.",
        "withdrawn": 'Say "hey robot" when you want to go on.',
        "not_recorded": "Start the recorder, then say it again.",
        "not_connected": "Check the robot's power, cable and driver.",
        "not_confirmed": "Look at the path that is shown, then confirm it.",
        "no_master": "Start the ROS master again.",
        "node_lost": "Start the node that is named.",
        "dead_man": "Press the dead-man, then say it again.",
        "voice_silent": "Check microphone and clocks; give commands by hand meanwhile.",
        "sensor_fault": "Check the sensor that is named.",
        "unknown_frame": "Give a frame that tf joins to base_link.",
        "tracker_stale": "Check the tracker and its view.",
        "tracker_jumped": "Check the tracker's markers.",
        "tracker_too_far": "Look at the trocar and its tracker.",
        "robot_fault": _CLEAR,
        "arm_fault": _CLEAR,
        "arm_in_use": "Close the arm's web page; put joysticks away.",
        "arm_not_ready": "Wait for the arm, or start its driver anew.",
        "arm_limits": "Set the arm's soft limits as named; restart.",
        "joint_states_stale": "Check the robot's driver and its network.",
        "already_grasped": 'Say "release" first.',
        "already_there": "Go on; nothing is left to do.",
        "nothing_grasped": 'Say "tense" first.',
        "not_inserted": 'Give "insert" by hand first.',
        "tension_limit": 'Pull no further; say "pull less" or "release".',
        "displacement_limit": 'Pull no further; "release" and regrasp.',
        "no_grasp": "Move the grasp point, or the tissue.",
        "collision": "Make room round the arm.",
        "near_singular": "Bring the arm into another pose first.",
        "workspace": "Choose a point nearer to the middle.",
        "tilt_limit": "Look another way.",
        "insertion_depth": 'Give "insert" by hand first.',
        "joint_limit": "Bring the arm into another pose first.",
        "rcm_tolerance": "Bring shaft and trocar together; set it anew.",
        "not_the_trocar": "Bring the shaft into the trocar, then set it.",
        "unreachable": "Choose a point that is easier to reach.",
        "setpoints_stopped": _CLEAR,
        "setpoint_refused": _CLEAR,
        "tension_sensor": _CLEAR,
        "joint_messages": _CLEAR,
        "no_answer": "Stop by hand; start the controller again.",
    }
)

UNHEARD: Final = _refusals(  # by Utterance.reason_code: the words of a command were not taken
    {
        "unsure": "Say it again, clearly.",
        "sounds_like_another": "Say it again, clearly.",
        "nearly_sure": 'Say "yes" if it is what you said.',
        "halt_unsure": 'Say "stop" again, or stop by hand.',
        "other_voice": "Let the enrolled person say it, or give it by hand.",
        "damaged_sound": "Check the microphone and its cable.",
        "tone": "Say it again, or give it by hand.",
        "robot_speaking": "Wait until it has spoken, then repeat.",
        "talk_gate": "Use the talk pedal, then say it again.",
        "same_breath": "Pause, then say the command alone.",
        "second_voice": "Say it again while nobody else talks.",
        "wrong_mode": 'Say "hey robot" first.',
        "other_mode": "Wait for the other mode, then say it again.",
    }
)

SILENT: Final = "silent"  # code of a part that has sent nothing for too long
PARTS: Final = {  # by a part and the code of its status; else by the code, or by the part, alone
    "voice: spotter_failed": Advice(
        "Speak clearly; start the voice node again at the next pause.",
        at_rest=Priority.LOW,
        loaded=Priority.LOW,
    ),
    "voice: spotter_slow": Advice(
        "Speak clearly; close other programs at the next pause.",
        at_rest=Priority.LOW,
        loaded=Priority.LOW,
    ),
    "voice: no_sound_yet": Advice("Stop by hand meanwhile; look at the microphone if it lasts."),
    "voice: recognition_slow": Advice("Stop by hand meanwhile; close other programs."),
    "voice: recognition_hangs": Advice("Stop by hand meanwhile; start the voice node again."),
    "voice: silent": Advice("Stop by hand meanwhile; start the voice node again."),
    "voice: microphone_muted": Advice("Stop by hand meanwhile; switch the microphone on."),
    "voice: microphone_overloaded": Advice("Stop by hand meanwhile; turn noise or gain down."),
    "voice: sound_torn": Advice("Stop by hand meanwhile; check the microphone's cable or network."),
    "voice: clocks_apart": Advice("Stop by hand meanwhile; set the clocks of both hosts."),
    "voice": Advice("Stop by hand meanwhile; check the microphone."),
    "controller: silent": Advice("Free the tissue by hand; start the controller again."),
    "pedal: silent": Advice("Stop by hand or voice meanwhile; start the pedal node again."),
    "pedal": _mild("Check the pedal and its cable; stop by hand or voice meanwhile."),
    "devices: silent": _mild("Start the devices node again."),
    "recording": _mild("Start the recorder before the next motion."),
    "stranger": _mild("End the program that is named; it is not believed."),
    "settings": _mild("Put the setting that is named back, or launch anew."),
    "control loop": _mild("Read the log; restart the controller at a pause."),
    "motion: no_master": Advice("Start the ROS master again."),
    "motion": Advice("Check the robot's power, cable and driver.", at_rest=Priority.LOW),
}


def part_advice(part: str, code: str) -> Advice:
    """What to do about a part that reports an error with a code, or has fallen silent."""
    return PARTS.get(f"{part}: {code}") or PARTS.get(code) or PARTS.get(part, UNKNOWN)
