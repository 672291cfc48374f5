# SPDX-License-Identifier: BSD-3-Clause
"""The service by which a person chooses another microphone."""

from __future__ import annotations

import threading
from functools import partial

import rospy

from voice_assist.audio.capture.microphone import Microphone
from voice_assist.audio.source import AudioSource
from voice_assist.ros.node_settings import OPENED
from voice_assist.srv import SetMicrophone, SetMicrophoneRequest, SetMicrophoneResponse

SERVICE = "voice_assist/set_microphone"


class MicrophoneService:
    """Serves as long as a microphone is listened to; of another source it does nothing."""

    def __init__(self, source: AudioSource) -> None:
        self._microphone = source if isinstance(source, Microphone) else None
        self._opened = ""
        if self._microphone is not None:
            rospy.Service(SERVICE, SetMicrophone, partial(_serve, self._microphone))

    def note_name(self) -> str:
        """Name of the open microphone, kept for a node that starts again; empty: no microphone."""
        if self._microphone is None or self._microphone.name == self._opened:
            return self._opened
        self._opened = self._microphone.name
        rospy.loginfo("the microphone is %r", self._opened)
        # In a thread: a master that hangs must not keep the node from hearing.
        keep = threading.Thread(target=rospy.set_param, args=(OPENED, self._opened), daemon=True)
        keep.start()
        return self._opened


def _serve(microphone: Microphone, request: SetMicrophoneRequest) -> SetMicrophoneResponse:
    problem = microphone.change(request.device)
    return SetMicrophoneResponse(not problem, problem)
