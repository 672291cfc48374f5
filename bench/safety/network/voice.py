# SPDX-License-Identifier: BSD-3-Clause
"""The voice node without recognition: publishers, caller and heartbeat, led by lines of JSON.

What is measured is the network between it and the controller, so no recogniser is needed, and none
takes the processor from the rest. All that it sends it sends by the voice node's own classes.

    ip netns exec HOST python -m bench.safety.network.voice SECONDS_BETWEEN_HEARTBEATS

A line is a command in words. It answers `["sent", words, time]` when it was said, and
`["answer", words, accepted, message, time]` when the controller answered, or did not in time; times
are time.monotonic() [s].
"""

from __future__ import annotations

import json
import sys
import threading
import time
from contextlib import suppress

import rospy

from voice_assist.config import load_voice_config
from voice_assist.intent.dialogue import Answered
from voice_assist.ros.publishers import Publishers
from voice_assist.ros.robot.command_client import CommandClient

_SAY = threading.Lock()


def main() -> None:
    """Say what the lines on standard input hold until they end."""
    rospy.init_node("voice_assist", argv=sys.argv[:1], disable_signals=True)
    interval = float(sys.argv[1])
    config = load_voice_config().commands
    publish = Publishers()
    caller = CommandClient(config.answer_within, _answered)
    repeatable = {command.command for command in config.commands if not command.is_motion}
    threading.Thread(target=_beat, args=(publish, interval), daemon=True).start()
    _say("ready", "", time.monotonic())
    for line in sys.stdin:
        words, now = line.strip(), time.monotonic()
        if words == "stop":
            publish.stop()
            caller.forget()
        caller.call(words, words in repeatable)
        _say("sent", words, now)


def _beat(publish: Publishers, interval: float) -> None:
    with suppress(rospy.ROSException):  # it is being shut down
        while not rospy.is_shutdown():
            time.sleep(interval)
            publish.heartbeat(rospy.get_time())


def _answered(answered: Answered) -> None:
    _say("answer", answered.command, answered.is_accepted, answered.message, time.monotonic())


def _say(*values: object) -> None:
    with _SAY:
        print(json.dumps(values), flush=True)


if __name__ == "__main__":
    main()
