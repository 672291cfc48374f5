# SPDX-License-Identifier: BSD-3-Clause
"""A process that publishes what others published before, as a bag does that is played.

Arguments: a pickled list of (topic, type, md5sum, name of the first publisher, bytes), and `claim`:
then each connection says that it is of the first publisher. It plays them again and again.
"""

import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import rospy
import rostopic
from rospy.impl.tcpros_pubsub import TCPROSPub

from session_log.ros.player_node import RawMessage
from support.message_classes import serialise
from support.waiting import PATIENCE

NAME = "/play_1700000000"
PAUSE = 0.005  # [s] between messages


class Copies:
    """Keeps all that is published on topics, to be played later.

    Args:
        topics: Their names.
    """

    def __init__(self, topics):
        self.messages = []
        kinds = {name: rostopic.get_topic_class(name)[0] for name in topics}
        self._links = [
            rospy.Subscriber(name, kind, self._keep, name) for name, kind in kinds.items() if kind
        ]

    def _keep(self, message, topic):
        first = message._connection_header["callerid"]
        self.messages.append((topic, message._type, message._md5sum, first, serialise(message)))

    def close(self):
        for link in self._links:
            link.unregister()


@contextmanager
def playing(messages, *, claim=False):
    """Play messages in a process of another name, for as long as the context lasts."""
    with tempfile.NamedTemporaryFile(suffix=".pickle") as file:
        file.write(pickle.dumps(messages))
        file.flush()
        words = [sys.executable, __file__, file.name, *(["claim"] if claim else [])]
        process = subprocess.Popen(words)
        try:
            yield process
        finally:
            process.terminate()
            process.wait(PATIENCE)


def main():
    """Play until the process is ended."""
    file, *options = sys.argv[1:]
    messages = pickle.loads(Path(file).read_bytes())
    first_publishers = {topic: first for topic, _, _, first, _ in messages}
    if "claim" in options:
        honest = TCPROSPub.get_header_fields

        def claiming(publisher):
            return {
                **honest(publisher),
                "callerid": first_publishers.get(publisher.resolved_name, NAME),
            }

        TCPROSPub.get_header_fields = claiming
    # rospy's own handler waits for the lock of a connection, which this thread may hold
    rospy.init_node(NAME[1:], disable_signals=True)
    is_over = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: is_over.set())
    topics = {}
    for topic, kind, md5sum, _, _ in messages:
        facts = {"_type": kind, "_md5sum": md5sum, "_full_text": "", "_has_header": False}
        if topic not in topics:
            message = type("Played", (RawMessage,), facts)
            topics[topic] = rospy.Publisher(topic, message, queue_size=100)
    while not is_over.is_set():
        for topic, _, _, _, data in messages:
            topics[topic].publish(topics[topic].data_class(data))
            time.sleep(PAUSE)
    rospy.signal_shutdown("ended")


if __name__ == "__main__":
    main()
