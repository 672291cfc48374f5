# SPDX-License-Identifier: BSD-3-Clause
"""Recorded sound through the node's own pipeline again, in lock-step with the recorded stamps.

The recorder's package finds `replay_pipeline` by its name in a setting.
Neither package imports the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from typed_config import ConfigError, load_yaml, with_present_keys
from voice_assist.assembly import limit_torch, make_pipeline, make_recognizer, make_spotters
from voice_assist.audio.robot_speech import RobotSpeechChange
from voice_assist.audio.source import FRAME
from voice_assist.audio.talk_gate import TalkChange
from voice_assist.config import CONFIG_DIR, VoiceConfig, voice_config
from voice_assist.config.commands import ENGLISH
from voice_assist.config.profile import NOBODY
from voice_assist.config.voice import section_files
from voice_assist.errors import ModelError, VoiceError
from voice_assist.intent.dialogue import Answered
from voice_assist.pipeline.pipeline import Event, Pipeline
from voice_assist.profile.active import personalise
from voice_assist.replay.recorded_spotter import RecordedSpotter
from voice_assist.side_inputs import SideInput, SideInputKind, SideInputs, from_text
from voice_assist.types import RATE, Frame, Mode, UtteranceDecision, frozen_samples

if TYPE_CHECKING:
    from voice_assist.recognizer.recognizer import Recognizer
    from voice_assist.spotter.spotter import Spotting

_NEVER_ASKS = {
    "is_enabled": False,
    "min_confidence": 1.0,
    "min_verification": 1000.0,
    "max_distance": 0.0,
    "answer": "yes",
    "answer_within": 3.0,
}
_OTHER_PARAMETERS = frozenset(  # no sections
    ("launched", "believed", "opened_microphone", "precision", "has_talk_gate")
)
# Sections and settings that an older recording did not have, as the node behaved without them.
SWITCHED_OFF: dict[str, dict[str, Any]] = {
    "recognizer": {"motion_verification": -1000.0, "ask": _NEVER_ASKS, "precision": "float32"},
    "speaker": {"gate": "off"},
    "profile": {"name": "none"},
    "moving": {"is_enabled": False},
    "spotter": {"over_talk": False},
    "commands": {"amounts": False, "said_twice": False, "language": ENGLISH},
}
NOT_YET: dict[str, dict[str, Any]] = {  # in a section that was recorded
    "commands": {"slots": []},
    "moving": {"nearly_said": -1000.0},
}


class NotReplayable(VoiceError, ValueError):
    """Recorded sound, settings or side inputs that the pipeline cannot take."""


class RecordedSound(Protocol):
    """One recorded block of sound."""

    @property
    def samples(self) -> NDArray[np.int16]:
        """Mono. Shape (n,)."""

    @property
    def rate(self) -> int:
        """Of the samples [Hz]."""

    @property
    def first_sample(self) -> int:
        """Index of samples[0] since the stream began."""

    @property
    def stamp(self) -> float:
        """Clock time at which samples[0] was captured [s]."""


@dataclass(frozen=True)
class ReplayedDecision:
    """One decision, with the fields of the message voice_assist/Utterance but `reason_code`."""

    transcript: str
    wer: Mapping[str, float]
    command: str  # empty: none
    reason: str  # why none, in words
    nearest_command: str
    confidence: float  # [0, 1]
    mode: str
    decided_by: str
    is_partial: bool
    speech_start: float  # [s]
    speech_end: float  # [s]
    decision: float  # [s] end of the frame with which it was decided


class PipelineReplay:
    """The pipeline of one run of the node."""

    def __init__(
        self,
        config: VoiceConfig,
        recognizer: Recognizer,
        spotter: Spotting | None,
        past: SideInputs,
    ) -> None:
        """Start as the node does: in standby, with nothing heard.

        Args:
            config: Of all stages.
            recognizer: Makes text of sound.
            spotter: Hears "stop"; None: the recogniser is alone.
            past: Inputs of the live pipeline other than sound.
        """
        self.model, self.model_hash = recognizer.name, recognizer.model_hash
        self.spotter_hash = ""
        self.warnings: tuple[str, ...] = ()
        self._config, self._past = config, past
        self._now = 0.0  # [s] recorded time at which the newest frame was there
        self._spotter = RecordedSpotter(spotter, past) if spotter is not None else None
        self._pipeline = self._build(recognizer)

    def _build(self, recognizer: Recognizer) -> Pipeline:
        return make_pipeline(self._config, lambda: self._now, recognizer, self._spotter)

    def hear(self, sound: RecordedSound) -> list[ReplayedDecision]:
        """Take the next block of sound, as it was published; gives what was decided with it.

        Raises:
            NotReplayable: It is no frame of the pipeline.
        """
        frame = replace(_frame(sound), is_moving=self._past.is_moving(sound.first_sample))
        for given in self._past.take_reported(frame.first_sample):
            self._take(given)
        if self._spotter is not None:
            self._spotter.feed(frame)
        if self._past.get(SideInputKind.UNHEARD, frame.first_sample):
            return []
        self._now = frame.end
        if self._past.get(SideInputKind.BEHIND, frame.first_sample):
            self._now += 2.0 * self._config.recognizer.early.max_backlog + 1.0
        return _decisions(self._pipeline(frame), frame.end)

    def _take(self, given: SideInput) -> None:
        match given.kind:
            case SideInputKind.SPEAKING:
                self._pipeline.robot_spoke(RobotSpeechChange(given.is_speaking, given.time))
            case SideInputKind.TALK:
                self._pipeline.talk_changed(TalkChange(given.is_open, given.time))
            case SideInputKind.ROBOT_MODE:
                self._pipeline.follow(Mode(given.mode))
            case SideInputKind.ASKED:
                self._pipeline.question_shown(given.time)
            case SideInputKind.BY_HAND:
                self._pipeline.answer_by_hand(given.command, given.is_accepted)
            case _:
                self._pipeline.answer(Answered(given.command, given.is_accepted, given.message))

    def set_mode(self, mode: str, reason: str) -> None:
        """Put the dialogue into a recorded mode, where what led to it was not recorded.

        Raises:
            NotReplayable: There is no such mode.
        """
        try:
            self._pipeline.set_mode(Mode(mode), reason)
        except ValueError as error:
            raise NotReplayable(f"mode {mode!r}, allowed: standby, active") from error

    def heard_live(self, first_sample: int) -> bool:
        """Whether it is on record that the live pipeline decided on the frame of a sample."""
        return first_sample < self._past.heard_until

    def lost_live(self, first_sample: int) -> bool:
        """Whether the live pipeline, too, lacked the sound in front of a sample."""
        return self._past.get(SideInputKind.LOST, first_sample) is not None


def replay_pipeline(
    settings: Mapping[str, Any], notes: Sequence[str], model: str | None
) -> PipelineReplay:
    """A pipeline with recorded settings.

    Args:
        settings: The node's private parameters; empty: those of the package's files today.
        notes: Recorded side inputs of this run of the node, as text.
        model: Recogniser to use in place of the recorded one.

    Raises:
        NotReplayable: Settings, side inputs or models cannot be used.
    """
    try:
        config, warnings = restore_settings(settings, model)
        limit_torch(config)
        past = SideInputs(from_text(note) for note in notes)
        config, recognizer, missing = _with_profile(config, _recognizer(config))
        spotter, digest = None, ""
        if config.spotter.is_enabled:
            spotter, digest = make_spotters(config)
    except (VoiceError, ConfigError, ValueError) as error:
        raise NotReplayable(str(error)) from error
    replay = PipelineReplay(config, recognizer, spotter, past)
    replay.spotter_hash, replay.warnings = digest, (*warnings, *missing)
    return replay


def restore_settings(
    recorded: Mapping[str, Any], model: str | None
) -> tuple[VoiceConfig, tuple[str, ...]]:
    """Recorded settings in the form that the code has today, and what did not fit it.

    Raises:
        ConfigError: A recorded value is not allowed today.
        CommandsError: The recorded commands contradict each other.
    """
    commands = recorded.get("commands")
    language = commands.get("language", ENGLISH) if isinstance(commands, Mapping) else ENGLISH
    files = section_files(CONFIG_DIR, str(language))
    today = {name: dict(load_yaml(file)) for name, file in files.items()}
    warnings = [] if recorded else ["no settings were recorded; today's are used"]
    computed = recorded.get("precision")  # where the setting left it to the device
    recorded = {key: value for key, value in recorded.items() if key not in _OTHER_PARAMETERS}
    recorded = with_present_keys(VoiceConfig, recorded)
    for name, off in SWITCHED_OFF.items() if recorded else ():
        section = recorded.get(name)
        if isinstance(section, Mapping):
            known = {**NOT_YET.get(name, {}), **off, **section}
        else:
            known = {**today[name], **off}
        recorded = {**recorded, name: known}
    if isinstance(recognizer := recorded.get("recognizer"), Mapping):
        recorded = {**recorded, "recognizer": _asks_as_today(recognizer)}
    data = _merge(today, recorded, "", warnings) if recorded else today
    data["recognizer"]["device"] = today["recognizer"]["device"]
    if computed is not None:
        data["recognizer"]["precision"] = computed
    if model is not None:
        data["recognizer"]["model"] = model
    config, missing = _in_precision(voice_config(data))
    return config, (*warnings, *missing)


def _in_precision(config: VoiceConfig) -> tuple[VoiceConfig, tuple[str, ...]]:
    """With the recorded precision; where the processor lacks that, the best it has."""
    from voice_assist.recognizer.precision import AUTO, dtype_for

    settings = config.recognizer
    try:
        dtype_for(settings.device, settings.precision)
    except ModelError as error:
        here = replace(config, recognizer=replace(settings, precision=AUTO))
        return here, (f"confidences may differ a little: {error}",)
    return config, ()


def _asks_as_today(recognizer: Mapping[str, Any]) -> Mapping[str, Any]:
    """A recorded section whose questions went from `motion_verification` to `sure_verification`."""
    ask, least = recognizer.get("ask"), recognizer.get("motion_verification")
    if not isinstance(ask, Mapping) or "sure_verification" not in ask:
        return recognizer
    kept = {key: value for key, value in ask.items() if key != "sure_verification"}
    asked = {**kept, "min_verification": least, "max_distance": 0.0}
    sure = ask["sure_verification"]
    if not ask.get("is_enabled") or not all(isinstance(n, int | float) for n in (least, sure)):
        return {**recognizer, "ask": asked}
    return {**recognizer, "ask": asked, "motion_verification": max(least, sure)}


def _merge(
    today: Mapping[str, Any], recorded: Mapping[str, Any], path: str, warnings: list[str]
) -> dict[str, Any]:
    merged = {}
    for key, value in today.items():
        if key not in recorded:
            warnings.append(f"setting {path}{key} was not recorded; today's is {value!r}")
            merged[key] = value
        elif isinstance(value, dict) and isinstance(recorded[key], dict):
            merged[key] = _merge(value, recorded[key], f"{path}{key}.", warnings)
        else:
            merged[key] = recorded[key]
    for key in recorded:
        if key not in today:
            warnings.append(f"setting {path}{key} was recorded and exists no more")
    return merged


def _with_profile(
    config: VoiceConfig, base: Recognizer
) -> tuple[VoiceConfig, Recognizer, tuple[str, ...]]:
    """The recogniser with the recorded profile; where that is gone, the base and a warning."""
    try:
        return config, personalise(config, base), ()
    except (VoiceError, ConfigError) as error:
        nobody = replace(config.profile, name=NOBODY, sha256="")
        return replace(config, profile=nobody), base, (f"heard without a profile: {error}",)


def _recognizer(config: VoiceConfig) -> Recognizer:
    """That of the recorded language, without a profile."""
    if config.is_multilingual:
        return _of_another_language(config)
    settings = config.recognizer
    return _english(settings.model, settings.device, settings.precision)


@lru_cache(maxsize=2)
def _english(model: str, device: str, precision: str) -> Recognizer:
    """Load a model once for a folder of recordings."""
    from voice_assist.recognizer import load_recognizer

    return load_recognizer(model, device, precision)


_of_another_language = lru_cache(maxsize=1)(make_recognizer)


def _frame(sound: RecordedSound) -> Frame:
    if sound.rate != RATE or len(sound.samples) != FRAME:
        found = f"{len(sound.samples)} samples at {sound.rate} Hz"
        raise NotReplayable(f"a block of {found}, allowed: {FRAME} at {RATE} Hz")
    return Frame(frozen_samples(sound.samples), sound.first_sample, sound.stamp)


def _decisions(events: Iterable[Event], time: float) -> list[ReplayedDecision]:
    return [_heard(event, time) for event in events if isinstance(event, UtteranceDecision)]


def _heard(decision: UtteranceDecision, time: float) -> ReplayedDecision:
    rejection = decision.rejection
    return ReplayedDecision(
        transcript=decision.hypothesis.text,
        wer=dict(decision.outcome.wer),
        command=decision.command,
        reason="" if rejection is None else rejection.words,
        nearest_command=decision.nearest_command,
        confidence=decision.confidence,
        mode=decision.mode.value,
        decided_by=decision.decided_by,
        is_partial=decision.is_partial,
        speech_start=decision.speech_start,
        speech_end=decision.speech_end,
        decision=time,
    )
