#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A viewer of Foxglove's protocol reads topics live, and can do nothing else."""

import asyncio
import json
import re
import struct
import unittest
from importlib.util import find_spec
from pathlib import Path

import aiohttp
import roslib.message
import rospy
import rosservice
from std_msgs.msg import String

from rst_control.msg import Event
from support.waiting import PATIENCE, wait_until
from tests.support.robot_client import run_tests

PROTOCOL = "foxglove.sdk.v1"
MESSAGE = 1  # opcode of a message
LAYOUT = Path(__file__).resolve().parents[3] / "urdf" / "foxglove" / "session.json"


class Viewer:
    """One connection; gives what the server says of itself, of its channels, and messages."""

    def __init__(self, socket):
        self.socket, self.info, self.channels, self.said = socket, {}, {}, []

    async def until(self, condition):
        """Take in what comes until it holds; the bytes of a message where it asks for one."""
        async with asyncio.timeout(PATIENCE):
            while not (found := condition()):
                frame = await self.socket.receive()
                if frame.type is aiohttp.WSMsgType.BINARY and frame.data[0] == MESSAGE:
                    self.said.append((struct.unpack("<I", frame.data[1:5])[0], frame.data[13:]))
                elif frame.type is aiohttp.WSMsgType.TEXT:
                    self.take(json.loads(frame.data))
                elif frame.type is not aiohttp.WSMsgType.BINARY:
                    raise AssertionError(f"the connection ended: {frame}")
            return found

    def take(self, said):
        if said["op"] == "serverInfo":
            self.info = said
        elif said["op"] == "advertise":
            self.channels |= {c["topic"]: c for c in said["channels"]}

    async def message(self, topic):
        """The next message of a topic, decoded by the class that its schema names."""
        channel = await self.until(lambda: self.channels.get(topic))
        number = channel["id"]
        self.said.clear()
        subscription = {"id": number, "channelId": number}
        await self.socket.send_json({"op": "subscribe", "subscriptions": [subscription]})
        data = await self.until(lambda: next((d for n, d in self.said if n == number), None))
        kind = roslib.message.get_message_class(channel["schemaName"])
        assert channel["encoding"] == "ros1" and channel["schemaEncoding"] == "ros1msg"
        assert channel["schema"] == kind._full_text
        return kind().deserialize(data)


def viewed(steps):
    """Connect a viewer and take the steps."""

    async def run():
        async with aiohttp.ClientSession() as session:
            address = rospy.get_param("foxglove/address").replace("ws:", "http:")
            async with session.ws_connect(address, protocols=[PROTOCOL]) as socket:
                viewer = Viewer(socket)
                await viewer.until(lambda: viewer.info)
                return await steps(viewer)

    return asyncio.run(run())


class Foxglove(unittest.TestCase):
    """What it offers, what it shows, what it keeps out."""

    @classmethod
    def setUpClass(cls):
        if find_spec("foxglove") is None:
            raise unittest.SkipTest("foxglove-sdk is not installed")
        cls.latched = rospy.Publisher("from_the_test", String, queue_size=1, latch=True)
        cls.latched.publish("a word of before")
        wait_until(lambda: rospy.has_param("foxglove/address"))

    def test_1_it_is_on_loopback_and_offers_to_read_and_nothing_else(self):
        self.assertRegex(rospy.get_param("foxglove/address"), r"^ws://127\.0\.0\.1:\d+$")

        async def steps(viewer):
            return viewer.info

        info = viewed(steps)
        self.assertEqual((info["capabilities"], info.get("supportedEncodings") or []), ([], []))

    def test_2_every_viewer_gets_a_latched_message_decoded(self):
        async def steps(viewer):
            message = await viewer.message("/from_the_test")
            return message, await viewer.message("/robot_description")

        async def two(viewer):
            return (await viewer.message("/from_the_test")), await asyncio.to_thread(viewed, steps)

        first, (second, urdf) = viewed(two)
        self.assertEqual((first.data, second.data), ("a word of before", "a word of before"))
        self.assertEqual(urdf.data, rospy.get_param("robot_description", ""))

    def test_3_a_message_of_our_own_type_comes_as_it_was_sent(self):
        event = Event(kind="refused", command="tense", reason_code="busy")
        events = rospy.Publisher("rst_control/event", Event, queue_size=1, latch=True)
        events.publish(event)

        async def steps(viewer):
            return await viewer.message("/rst_control/event")

        found = viewed(steps)
        fields = found.kind, found.command, found.reason_code
        self.assertEqual(fields, ("refused", "tense", "busy"))
        events.unregister()

    def test_4_a_viewer_can_publish_nothing_and_call_nothing(self):
        heard = []
        rospy.Subscriber("rst_control/stop_of_a_viewer", String, heard.append)
        services = set(rosservice.get_service_list())

        async def steps(viewer):
            for said in (
                {
                    "op": "advertise",
                    "channels": [
                        {
                            "id": 7,
                            "topic": "/rst_control/stop_of_a_viewer",
                            "encoding": "ros1",
                            "schemaName": "std_msgs/String",
                        }
                    ],
                },
                {"op": "setParameters", "parameters": [{"name": "/from_a_viewer", "value": 1}]},
                {"op": "getParameters", "parameterNames": [], "id": "all"},
            ):
                await viewer.socket.send_json(said)
            await viewer.socket.send_bytes(b"\x01" + struct.pack("<I", 7) + b"\x01\x00\x00\x00x")
            await viewer.socket.send_bytes(b"\x02" + b"\x00" * 12)
            return await viewer.message("/from_the_test")  # it goes on

        self.assertEqual(viewed(steps).data, "a word of before")
        self.assertFalse(rospy.has_param("/from_a_viewer"))
        self.assertEqual((heard, set(rosservice.get_service_list())), ([], services))

    def test_5_what_is_excluded_is_not_offered(self):
        async def steps(viewer):
            await viewer.until(lambda: "/rosout" in viewer.channels)
            return set(viewer.channels)

        topics = viewed(steps)
        self.assertNotIn("/voice_assist/audio", topics)
        self.assertNotIn("/rosout_agg", topics)

    def test_6_the_layout_asks_for_topics_by_the_names_that_are_served(self):
        text = json.dumps(json.loads(LAYOUT.read_text(encoding="utf-8"))["configById"])
        asked = set(re.findall(r'"(/voice_assist/[a-z_/]+)', text))

        async def steps(viewer):
            served = {"/voice_assist/alarm", "/voice_assist/heard_marker"}
            await viewer.until(lambda: served <= set(viewer.channels))
            return served

        self.assertLessEqual(viewed(steps), asked)


if __name__ == "__main__":
    run_tests(Foxglove, "foxglove_test")
