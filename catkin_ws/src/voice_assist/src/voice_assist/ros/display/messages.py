# SPDX-License-Identifier: BSD-3-Clause
"""Messages of the running system to what the page shows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus

from rst_control.commands.parser import read_command
from rst_control.commands.spec import TissueNeeded
from rst_control.msg import ControllerState
from rst_control.types import State
from voice_assist.audio.source import level_db
from voice_assist.config import CommandConfig
from voice_assist.config.commands import AmountCommand
from voice_assist.devices.calls import result_words
from voice_assist.display.snapshot import AlarmPart, RobotPart, TissuePart, UtterancePart
from voice_assist.display.words import WordRule
from voice_assist.msg import Alarm, AudioChunk, DeviceCall, Utterance
from voice_assist.ros.messages import pcm
from voice_assist.types import FULL_SCALE, RejectionReason

ANY_STATE = frozenset(state.value for state in State)
_HELD = {TissueNeeded.HELD: True, TissueNeeded.NONE: False, TissueNeeded.ANY: None}
_BEGINNINGS = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8\xff": "image/jpeg"}


def robot_parts(message: ControllerState) -> tuple[RobotPart, TissuePart]:
    """What the controller does, and what it measures."""
    robot = RobotPart(
        state=message.state,
        phase=message.phase,
        command=message.command,
        progress=message.progress if math.isfinite(message.progress) else 0.0,
        is_tissue_held=message.tissue_held,
        halt_reason=message.halt_reason,
    )
    tissue = TissuePart(
        tension=_number(message.tension),
        tension_target=_number(message.tension_target) or None,
        rcm_error=_number(message.rcm_error),
        insertion=_number(message.insertion),
    )
    return robot, tissue


def utterance_part(message: Utterance) -> UtterancePart:
    """A decision of the recogniser."""
    return UtterancePart(message.transcript, message.command, message.reason, message.decided_by)


def is_rest(message: Utterance) -> bool:
    """Whether it was said in one breath with what was decided before, and is no command."""
    is_same_breath = message.reason_code == RejectionReason.SAME_BREATH.value
    return is_same_breath and 0.0 not in message.wer


def asked_command(message: Utterance) -> str:
    """The command that a decision asks for; empty: none."""
    is_question = message.reason_code == RejectionReason.NEARLY_SURE.value
    return str(message.nearest_command) if is_question else ""


def device_words(message: DeviceCall) -> str:
    """What came of a call to a device, such as "light on: done"."""
    return result_words(message.phrase, message.is_done, message.message)


def alarm_part(message: Alarm) -> AlarmPart:
    """What stands first."""
    return AlarmPart(
        kind=message.kind,
        priority=message.priority,
        cause=message.cause,
        next_step=message.next_step,
        is_acknowledged=message.acknowledged,
        others=tuple(message.others),
    )


def sound_level(message: AudioChunk) -> float:
    """Level of a block of sound [dB of full scale]."""
    return level_db(pcm(message).astype(np.float32) / np.float32(FULL_SCALE))


def picture_kind(data: bytes) -> str:
    """image/png or image/jpeg, by its first bytes; empty: it is neither."""
    return next((kind for start, kind in _BEGINNINGS.items() if data.startswith(start)), "")


def values_of(status: DiagnosticStatus) -> Mapping[str, str]:
    """What a part reports, by name."""
    return {pair.key: pair.value for pair in status.values}


def word_rules(commands: Iterable[CommandConfig]) -> tuple[WordRule, ...]:
    """When each spoken word counts, by voice and controller; one for all amounts of a command."""
    rules = (_rule(command) for command in commands)
    return tuple({rule.phrase: rule for rule in rules}.values())


def _rule(command: CommandConfig) -> WordRule:
    spec = read_command(command.command)
    states: Iterable[Any] = spec.counts_in if spec else ()
    return WordRule(
        phrase=command.template if isinstance(command, AmountCommand) else command.phrase,
        modes=frozenset(command.modes),
        states=frozenset(state.value for state in states) if spec else ANY_STATE,
        is_tissue_held=_HELD[spec.tissue] if spec else None,
    )


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
