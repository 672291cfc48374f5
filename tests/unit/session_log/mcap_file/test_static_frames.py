# SPDX-License-Identifier: BSD-3-Clause
"""Static transforms of several nodes in the messages of one publisher."""

import pytest

from session_log.mcap_file.decoder import Decoder, MissingField, Undecodable
from session_log.mcap_file.static_frames import StaticFrames
from support.message_classes import class_of
from support.story import Story

TOPIC, KIND = "/tf_static", "tf2_msgs/TFMessage"


def said(*groups):
    """A message for each group of child frames with their heights [m]."""
    story = Story()
    for heights in groups:
        frames = []
        for child, z in heights.items():
            frame = class_of("geometry_msgs/TransformStamped")()
            frame.header.frame_id, frame.child_frame_id = "world", child
            frame.transform.translation.z, frame.transform.rotation.w = z, 1.0
            frames.append(frame)
        story.say(1.0, TOPIC, KIND, transforms=frames)
    return story.messages


def merged(messages):
    """Child frames with their heights [m] of each message as it is played."""
    frames, read = StaticFrames(), Decoder()
    played = [read.decode(m._replace(data=frames.merged(m))) for m in messages]
    return [{f.child_frame_id: f.transform.translation.z for f in p.transforms} for p in played]


def test_each_message_has_the_frames_of_all_before_it():
    assert merged(said({"trocar": 1.0}, {"camera": 2.0, "arm": 3.0})) == [
        {"trocar": 1.0},
        {"trocar": 1.0, "camera": 2.0, "arm": 3.0},
    ]


def test_the_last_transform_of_a_frame_holds():
    assert merged(said({"trocar": 1.0, "arm": 3.0}, {"trocar": 2.0}))[1] == {
        "trocar": 2.0,
        "arm": 3.0,
    }


def test_the_first_message_stays_as_it_is():
    (message,) = said({"trocar": 1.0, "arm": 3.0})
    assert StaticFrames().merged(message) == message.data


def test_what_holds_no_frames_is_named():
    story = Story()
    story.say(1.0, TOPIC, "std_msgs/String", data="x")
    with pytest.raises(MissingField):
        StaticFrames().merged(story.messages[0])
    (message,) = said({"trocar": 1.0})
    with pytest.raises(Undecodable):
        StaticFrames().merged(message._replace(data=b"x"))
