# SPDX-License-Identifier: BSD-3-Clause
"""Processes under traffic, started by the other parts: `sessions_traffic.py record|talk`."""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

RATE = 500  # [Hz] of each of the three fast topics
SIZE = 320  # [B] of a JointState with ten joints
SOUND_RATE = 31  # [Hz] of chunks
SOUND_SIZE = 1100  # [B] of a chunk
TOPICS = ("/joint_states", "/servo", "/tension")
BURSTS = (3000, 6000, 12_000, 24_000)  # [messages/s] over all topics, one after the other
BURST_TIME = 2.5  # [s] of each


def record(path: Path) -> None:
    """Record three topics of 500 Hz and sound from threads, as rospy would deliver them.

    Each line that is printed is the number of messages that the recorder says are written.
    """
    from session_log.config import RecorderConfig
    from session_log.mcap_file.writer import SessionWriter
    from session_log.recording.recorder import Recorder
    from session_log.types import MessageSource
    from typed_config import load_config, load_yaml

    package = Path(__file__).resolve().parents[2] / "catkin_ws" / "src" / "session_log"
    config = load_config(RecorderConfig, load_yaml(package / "config" / "recorder.yaml"))
    recorder = Recorder(lambda: SessionWriter(path), config, time.time_ns)
    sources = [
        MessageSource(f"/t{i}", "std_msgs/String", "992c", "string data", "/p") for i in range(4)
    ]
    sizes, rates = (SIZE, SIZE, 80, SOUND_SIZE), (RATE, RATE, RATE, SOUND_RATE)
    recorder.start()
    for source, size, rate in zip(sources, sizes, rates, strict=True):
        tally, data = recorder.register(source), bytes(size)

        def offer(tally=tally, data=data) -> None:  # noqa: ANN001 - bound to this topic
            recorder.offer(tally, data)

        threading.Thread(target=_repeat, args=(offer, 1.0 / rate), daemon=True).start()
    while True:
        time.sleep(0.01)
        sys.stdout.write(f"{recorder.status().written}\n")
        sys.stdout.flush()


def _repeat(act: Callable[[], None], period: float) -> None:
    due = time.monotonic()
    while True:
        act()
        due += period
        time.sleep(max(due - time.monotonic(), 0.0))


def talk(seconds: float) -> None:
    """Publish 500 Hz on three topics and sound for so long, then in bursts; tell how much."""
    import rospy

    rospy.init_node("talker")
    out = _publishers(rospy)
    while not all(p.get_num_connections() for p, _ in out.values()):
        rospy.sleep(0.05)
    rospy.sleep(0.5)
    sound = _sound(rospy)
    due, end, count = time.monotonic(), time.monotonic() + seconds, 0
    while time.monotonic() < end:
        for topic in TOPICS:
            publisher, message = out[topic]
            publisher.publish(message)
        if count % (RATE // SOUND_RATE) == 0:
            sound()
        count += 1
        due += 1.0 / RATE
        time.sleep(max(due - time.monotonic(), 0.0))
    time.sleep(1.0)
    print(json.dumps({"published": count}), flush=True)
    print(json.dumps({"bursts": [_burst(out, rate) for rate in BURSTS]}), flush=True)
    time.sleep(3.0)


def _publishers(rospy):  # noqa: ANN001, ANN202 - ROS has no types
    from geometry_msgs.msg import WrenchStamped
    from sensor_msgs.msg import JointState

    joints = JointState(name=[f"joint_{i}" for i in range(10)], position=[0.0] * 10)
    joints.velocity = joints.effort = [0.0] * 10
    messages = {"/joint_states": joints, "/servo": joints, "/tension": WrenchStamped()}
    buffer = BytesIO()
    joints.serialize(buffer)

    class Ready(JointState):
        """Joint states serialised once, so that the talker is no slower than the recorder."""

        _has_header = False

        def serialize(self, buff: BytesIO) -> None:
            """Write the bytes."""
            buff.write(buffer.getvalue())

    messages |= {f"/burst_{rate}": Ready() for rate in BURSTS}
    return {
        topic: (rospy.Publisher(topic, type(message), queue_size=100_000), message)
        for topic, message in messages.items()
    }


def _sound(rospy):  # noqa: ANN001, ANN202 - ROS has no types
    from voice_assist.msg import AudioChunk

    publisher = rospy.Publisher("/voice_assist/audio", AudioChunk, queue_size=100)
    chunk = AudioChunk(rate=16_000, samples=[0] * 512)
    return lambda: publisher.publish(chunk)


def _burst(out, rate: int) -> dict[str, float]:  # noqa: ANN001 - ROS has no types
    """Publish at a rate [messages/s]; returns what was asked for, published and how fast."""
    publisher, message = out[f"/burst_{rate}"]
    began = due = time.monotonic()
    count = 0
    while time.monotonic() < began + BURST_TIME:
        for _ in range(10):
            publisher.publish(message)
        count += 10
        due += 10.0 / rate
        time.sleep(max(due - time.monotonic(), 0.0))
    return {"asked": rate, "count": count, "rate": count / (time.monotonic() - began)}


if __name__ == "__main__":
    if sys.argv[1] == "record":
        record(Path(sys.argv[2]))
    else:
        talk(float(sys.argv[2]))
