# SPDX-License-Identifier: BSD-3-Clause
"""Commands that were taken, for nodes that hear speech_recognition_msgs.

What was refused is not passed on, nor what others than the voice node say: who acts on these
texts would act on it.
"""

from __future__ import annotations

import time

import rospy
from speech_recognition_msgs.msg import SpeechRecognitionCandidates

from typed_config.ros.starting import starting
from voice_assist.msg import Utterance
from voice_assist.ros.believed import Believed

TOPIC = "speech_to_text"  # where the nodes of jsk_3rdparty listen
IDLE = 0.2  # [s] between looks whether ROS ends


def candidates(message: Utterance) -> SpeechRecognitionCandidates | None:
    """The command, then what was written of it where that differs; None: no command was taken."""
    if not message.command:
        return None
    written = message.transcript.strip()
    texts = list(dict.fromkeys(text for text in (message.command, written) if text))
    return SpeechRecognitionCandidates(
        transcript=texts, confidence=[message.confidence] * len(texts)
    )


def main() -> None:
    """Run the node."""
    with starting("candidates", __doc__, needs_clock=False):
        results = rospy.Publisher(TOPIC, SpeechRecognitionCandidates, queue_size=20)

        def pass_on(message: Utterance) -> None:
            if (found := candidates(message)) is not None:
                results.publish(found)

        known = Believed()
        known.hear("voice", "voice_assist/utterance", Utterance, pass_on)
    while not rospy.is_shutdown():
        known.publish_status()
        time.sleep(IDLE)
