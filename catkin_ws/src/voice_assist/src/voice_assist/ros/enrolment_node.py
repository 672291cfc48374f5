# SPDX-License-Identifier: BSD-3-Clause
"""Serves enrolment to a screen, from the sound that the voice node publishes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import rospy

from typed_config import ConfigError
from typed_config.ros.known_publishers import DIAGNOSTICS_PERIOD
from typed_config.ros.starting import starting
from voice_assist.assembly import limit_torch
from voice_assist.config import CONFIG_DIR, VoiceConfig, load_voice_config
from voice_assist.config.commands import ENGLISH
from voice_assist.config.enrolment import EnrolmentConfig, load_enrolment_config
from voice_assist.enrolment.remote_session import ActionResult, EnrolmentService
from voice_assist.enrolment.takes.script import require_letters
from voice_assist.errors import AudioError, VoiceError
from voice_assist.msg import AudioChunk, Mode
from voice_assist.profile.profile import profiles_folder
from voice_assist.recognizer import load_recognizer
from voice_assist.ros.believed import Believed
from voice_assist.ros.topic_source import TopicSource
from voice_assist.srv import Enroll, EnrollRequest, EnrollResponse
from voice_assist.types import Frame

_AUDIO, _MODE, _SERVICE = "voice_assist/audio", "voice_assist/mode", "voice_assist/enroll"


def main() -> None:
    """Run the enrolment node."""
    with starting("enrolment", __doc__, refusals=(ConfigError, VoiceError)):
        node = EnrolmentNode()
    while not rospy.is_shutdown():
        node.publish_status()
        rospy.rostime.wallsleep(DIAGNOSTICS_PERIOD)


class _Sound:
    """The voice node's sound: one subscription, whose chunks go to the take that goes on."""

    def __init__(self, believed: Believed) -> None:
        self._callback: Callable[[AudioChunk], None] | None = None
        believed.hear("voice", _AUDIO, AudioChunk, self._take)

    def subscribe(self, name: str, kind: type, callback: Callable[[AudioChunk], None]) -> _Sound:
        """Hand chunks on from now, until `unregister`."""
        self._callback = callback
        return self

    def unregister(self) -> None:
        """Hand none on."""
        self._callback = None

    def _take(self, chunk: AudioChunk) -> None:
        if (callback := self._callback) is not None:
            callback(chunk)


class EnrolmentNode:
    """Joins the enrolment service of the core, the sound and the ROS service."""

    def __init__(self) -> None:
        """Load the base recogniser and announce the service."""
        self._voice, config = _settings()
        limit_torch(self._voice)
        recognizer = self._voice.recognizer  # whose device may be another: learning needs none
        base = load_recognizer(recognizer.model, precision=recognizer.precision)
        root, self._mode = profiles_folder(self._voice.profile.folder), ""
        args = self._voice, config, base, root, self._listen, self._is_armed
        self._service = EnrolmentService(*args)
        self._believed = Believed()
        self._believed.hear("voice", _MODE, Mode, self._take_mode)
        self._sound = _Sound(self._believed)
        rospy.Service(_SERVICE, Enroll, self._serve)

    def publish_status(self) -> None:
        """Name who is not believed."""
        self._believed.publish_status()

    def _serve(self, request: EnrollRequest) -> EnrollResponse:
        limit_torch(self._voice)  # each call has a thread of its own
        return _response(self._service(request.name, request.action))

    def _take_mode(self, message: Mode) -> None:
        self._mode = message.mode

    def _is_armed(self) -> bool:
        return self._mode == "active"

    def _listen(self) -> Iterator[Frame]:
        topic = replace(self._voice.audio.topic, name=_AUDIO)
        with TopicSource(topic, _raise, self._sound.subscribe) as source:
            yield from source


def _settings() -> tuple[VoiceConfig, EnrolmentConfig]:
    """From the folder and in the language that the private parameters name; else as shipped.

    Raises:
        ConfigError: They are not as they must be.
        VoiceProfileError: A phrase has letters that no profile can learn.
    """
    folder = str(rospy.get_param("~config", CONFIG_DIR))
    voice = load_voice_config(folder, language=str(rospy.get_param("~language", ENGLISH)))
    require_letters(voice.commands.fixed_phrases)
    return voice, load_enrolment_config(folder)


def _raise(trouble: str) -> None:
    """Let a take fail without sound: its caller waits for it."""
    if trouble:
        raise AudioError(trouble)


def _response(result: ActionResult) -> EnrollResponse:
    response = EnrollResponse(success=result.success, message=result.message)
    if result.step is not None:
        response.kind, response.phrase = result.step.kind, result.step.phrase
        response.seconds, response.number = result.step.seconds, result.step.number
        response.total = result.step.total
    return response
