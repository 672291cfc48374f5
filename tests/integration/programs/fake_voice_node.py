# SPDX-License-Identifier: BSD-3-Clause
"""The voice node with a recogniser that hears tones; for test_voice_node.py."""

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, make_detector
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.ros import voice_node
from voice_assist.spotter.fusion import StopFusion

voice_node.limit_torch = lambda config: None  # which nothing here needs
voice_node.make_recognizer = lambda config: FakeRecognizer()
voice_node.make_pipeline = lambda config, clock, recognizer, spotting, observer: Pipeline(
    config, recognizer, make_detector(), clock, StopFusion(config.spotter, spotting), observer
)
voice_node.main()
