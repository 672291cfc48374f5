# SPDX-License-Identifier: BSD-3-Clause
"""Serves the robot's commands and writes down all that the voice node does; for test_voice_node.py.

Arguments: file to write, again and again until Ctrl-C, then pairs: command=refuse, command=hang,
service=missing, robot=speaking, which is reported from the beginning on, play=FILE, which is
published on the topic audio_in, or play_data=FILE, as other packages do on audio/audio.
"""

import json
import sys
import threading
import time
from pathlib import Path

import rospy
import soundfile
from audio_common_msgs.msg import AudioData
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Log
from std_msgs.msg import Bool, Empty, String, Time

from rst_control.srv import Command, CommandResponse
from voice_assist.msg import AudioChunk, Mode, Utterance

SEEN: dict[str, list] = {}
HANG = 30.0  # [s]
EVERY = 0.2  # [s] that the file is written


def note(kind, *facts, at=None):
    """Keep facts, and when they came, or when they were sent."""
    SEEN.setdefault(kind, []).append([*facts, time.time() if at is None else at.to_sec()])


def serve(behaviour):
    def answer(request):
        note("call", request.command, request._connection_header["callerid"])
        if behaviour.get(request.command) == "hang":
            threading.Event().wait(HANG)
        if behaviour.get(request.command) == "refuse":
            return CommandResponse(False, "nothing is grasped", "nothing_grasped")
        return CommandResponse(True, f"{request.command} it is", "")

    rospy.Service("rst_control/command", Command, answer)


def play(path, topic="audio_in", kind=AudioChunk):
    """Publish a sound file chunk by chunk in real time, as soon as somebody listens."""
    sound, rate = soundfile.read(path, dtype="int16")
    publisher = rospy.Publisher(topic, kind, queue_size=100)
    while publisher.get_num_connections() == 0 and not rospy.is_shutdown():
        time.sleep(0.05)
    start, size = time.time(), rate // 20
    for first in range(0, len(sound), size):
        chunk = AudioChunk(
            rate=rate, first_sample=first, samples=sound[first : first + size].tolist()
        )
        due = start + (first + size) / rate
        chunk.header.stamp = rospy.Time.from_sec(due - size / rate)
        time.sleep(max(due - time.time(), 0.0))
        is_ours = kind is AudioChunk
        publisher.publish(chunk if is_ours else AudioData(sound[first : first + size].tobytes()))
    note("played")


def write(out):
    """What was seen so far, as a whole file at each moment."""
    seen = {kind: list(notes) for kind, notes in list(SEEN.items())}
    part = out.with_suffix(".part")
    part.write_text(json.dumps(seen), encoding="utf-8")
    part.replace(out)


def main():
    out, *pairs = sys.argv[1:]
    behaviour = dict(pair.split("=") for pair in pairs)
    rospy.init_node("witness")
    if behaviour.get("service") != "missing":
        serve(behaviour)
    topics = {
        "rst_control/stop": (Empty, lambda m: note("stop")),
        "rst_control/heartbeat": (Time, lambda m: note("heartbeat", at=m.data)),
        "voice_assist/audio": (AudioChunk, lambda m: note("audio", m.first_sample, m.rate)),
        "voice_assist/say": (String, lambda m: note("say", m.data)),
        "voice_assist/partial": (String, lambda m: note("partial", m.data)),
        "voice_assist/mode": (Mode, lambda m: note("mode", m.mode, m.reason)),
        "voice_assist/utterance": (
            Utterance,
            lambda m: note(
                "utterance",
                m.transcript,
                m.command,
                m.reason,
                m.is_partial,
                dict(zip(m.phrases, m.wer, strict=True)),
            ),
        ),
        "/diagnostics": (
            DiagnosticArray,
            lambda m: [
                note("diagnostics", s.level, s.message) for s in m.status if "voice" in s.name
            ],
        ),
        "/rosout": (Log, lambda m: note("log", m.name, m.level, m.msg, at=m.header.stamp)),
    }
    for topic, (kind, take) in topics.items():
        rospy.Subscriber(topic, kind, take)
    if behaviour.get("robot") == "speaking":
        rospy.Publisher("voice_assist/speaking", Bool, queue_size=1, latch=True).publish(True)
    if "play" in behaviour:
        threading.Thread(target=play, args=(behaviour["play"],), daemon=True).start()
    if "play_data" in behaviour:
        args = behaviour["play_data"], "audio/audio", AudioData
        threading.Thread(target=play, args=args, daemon=True).start()
    while not rospy.is_shutdown():
        write(Path(out))
        time.sleep(EVERY)
    write(Path(out))


main()
