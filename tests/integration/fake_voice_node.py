# SPDX-License-Identifier: BSD-3-Clause
"""The voice node with a recogniser that hears tones; for test_voice_node.py."""

from tests.unit.voice_assist.fake_speech import FakeRecognizer, make_detector
from voice_assist.pipeline import Pipeline
from voice_assist.ros import node
from voice_assist.spotter.second_way import SecondWay

node.make_recognizer = lambda config: FakeRecognizer()
node.make_pipeline = lambda config, clock, recognizer, spotting, witness: Pipeline(
    config, recognizer, make_detector(), clock, SecondWay(config.spotter, spotting), witness
)
node.main()
