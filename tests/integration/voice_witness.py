# SPDX-License-Identifier: BSD-3-Clause
"""Serves the robot's commands and writes down all that the voice node does; for test_voice_node.py.

Arguments: seconds to watch, file to write, then per command what to do: refuse, hang or none.
"""

import json
import sys
import threading
import time
from pathlib import Path

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Log
from std_msgs.msg import Empty, String, Time

from rst_control.srv import Command, CommandResponse
from voice_assist.msg import AudioChunk, Mode, Utterance

SEEN: dict[str, list] = {}
HANG = 4.0  # [s]


def note(kind, *facts):
    SEEN.setdefault(kind, []).append([*facts, time.time()])


def serve(behaviour):
    def answer(request):
        note("call", request.command, request._connection_header["callerid"])
        if behaviour.get(request.command) == "hang":
            threading.Event().wait(HANG)
        if behaviour.get(request.command) == "refuse":
            return CommandResponse(False, "nothing is grasped")
        return CommandResponse(True, f"{request.command} it is")

    rospy.Service("rst_control/command", Command, answer)


def main():
    seconds, out, *pairs = sys.argv[1:]
    behaviour = dict(pair.split("=") for pair in pairs)
    rospy.init_node("witness")
    if behaviour.get("service") != "missing":
        serve(behaviour)
    topics = {
        "rst_control/stop": (Empty, lambda m: note("stop")),
        "rst_control/heartbeat": (Time, lambda m: note("heartbeat", m.data.to_sec())),
        "voice_assist/audio": (AudioChunk, lambda m: note("audio", m.first_sample, m.rate)),
        "voice_assist/partial": (String, lambda m: note("partial", m.data)),
        "voice_assist/mode": (Mode, lambda m: note("mode", m.mode, m.reason)),
        "voice_assist/utterance": (
            Utterance,
            lambda m: note(
                "utterance",
                m.transcript,
                m.command,
                m.reason,
                m.early,
                dict(zip(m.phrases, m.wer, strict=True)),
            ),
        ),
        "/diagnostics": (
            DiagnosticArray,
            lambda m: [
                note("diagnostics", s.level, s.message) for s in m.status if "voice" in s.name
            ],
        ),
        "/rosout": (Log, lambda m: note("log", m.name, m.level, m.msg)),
    }
    for topic, (kind, take) in topics.items():
        rospy.Subscriber(topic, kind, take)
    Path(out + ".ready").touch()
    end = time.time() + float(seconds)
    while time.time() < end and not rospy.is_shutdown():
        time.sleep(0.1)
    Path(out).write_text(json.dumps(SEEN))


main()
