# SPDX-License-Identifier: BSD-3-Clause
"""The voice node: threads that listen, hear, spot "stop", call the controller, send heartbeats."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from queue import Empty, Full, Queue

import numpy as np
import rospy

from typed_config import ConfigError
from typed_config.ros.launch_settings import is_restart
from typed_config.ros.starting import starting
from voice_assist.assembly import (
    limit_torch,
    make_pipeline,
    make_recognizer,
    make_source,
    make_spotters,
    precision_of,
)
from voice_assist.audio.capture.input_check import SoundWatch, at_full_scale
from voice_assist.audio.source import AudioSource, level_db
from voice_assist.config import VoiceConfig
from voice_assist.errors import AudioError, VoiceError
from voice_assist.pipeline.hang_detection import HangWatch
from voice_assist.pipeline.pipeline import Event
from voice_assist.profile.profile import facts_of
from voice_assist.ros.believed import Believed
from voice_assist.ros.diagnostics import VoiceDiagnostics, VoiceHealth
from voice_assist.ros.microphone_service import MicrophoneService
from voice_assist.ros.node_settings import PRECISION, keep_profile, node_settings
from voice_assist.ros.other_messages.audio_data_source import AudioDataSource
from voice_assist.ros.priority import hear_first
from voice_assist.ros.publishers import Publishers
from voice_assist.ros.recognition_watch import RecognitionWatch
from voice_assist.ros.robot.robot_acts import RobotActs
from voice_assist.ros.robot.robot_commands import require_known
from voice_assist.ros.topic_source import TopicSource
from voice_assist.side_inputs import SideInput, SideInputKind
from voice_assist.spotter.spotter import Spotted, Spotting
from voice_assist.spotter.thread import SpotterThread
from voice_assist.types import (
    RATE,
    Ask,
    Frame,
    Lost,
    Match,
    Partial,
    Samples,
    UtteranceDecision,
    frozen_samples,
)

WATCH_PERIOD = 0.01  # [s] between checks of recognition; the delay in noticing a hang
HEARTBEAT = 0.05  # [s]
_HEARTBEAT_EVERY = round(HEARTBEAT / WATCH_PERIOD)  # checks
_DIAGNOSTICS_EVERY = 20  # heartbeats


def main() -> None:
    """Run the voice node."""
    priority = hear_first()
    with starting("voice_assist", __doc__, refusals=(ConfigError, VoiceError)):
        rospy.loginfo("priority: %s", priority)
        config = node_settings()
        require_known(config.commands)
        node = VoiceNode(config)
    node.run()


class VoiceNode:
    """Joins the source, the pipeline and what is done to the robot."""

    def __init__(self, config: VoiceConfig) -> None:
        """Load the model and announce the topics.

        Raises:
            VoiceError: The model cannot be used, or a recording has no pace.
        """
        if config.audio.source == "wav" and config.audio.wav.speed == 0.0:
            allowed = "allowed in the voice node: above 0, as the robot moves in real time"
            raise AudioError(f"audio.wav.speed is 0, {allowed}; `voice_assist listen` takes 0")
        self._config = config
        recognizer = make_recognizer(config)
        facts = {"model": recognizer.name, "model_sha256": recognizer.model_hash}
        if of_profile := facts_of(recognizer):  # pinned, so that a replay uses the same
            facts |= of_profile
            keep_profile(config.profile, of_profile["profile_sha256"])
            rospy.loginfo("profile %(profile)s %(profile_sha256).12s", of_profile)
        self._precision = precision_of(config)
        rospy.set_param(PRECISION, self._precision)
        self._frames: Queue[Frame | None] = Queue(config.audio.queue)
        self._over = threading.Event()
        self._busy_since: float | None = None  # [s] steady clock, at the frame under recognition
        self._publish = Publishers()
        self._health = VoiceHealth(
            f"{recognizer.name} {recognizer.model_hash[:12]}",
            config.audio.source,
            config.audio.queue,
        )
        spotting = self._load_spotter() if config.spotter.is_enabled else None
        self._spotter = None if spotting is None else self._in_thread(spotting)
        hang_watch = HangWatch(config.hung_after)
        self._watch = RecognitionWatch(hang_watch, spotting, config.spotter)
        facts["spotter_sha256"] = self._health.spotter
        rospy.set_param("session/voice_assist", facts)  # for the recording's metadata
        observer = self._publish.side_input
        self._pipeline = make_pipeline(config, _now, recognizer, self._spotter, observer)
        self._known = Believed()
        self._robot = RobotActs(config, self._pipeline, self._publish, self._known, _now)

    def run(self) -> None:
        """Hear until ROS shuts down, or the recording ends where the settings say so."""
        rospy.on_shutdown(self._over.set)
        self._robot.start()
        if self._spotter is not None:
            self._spotter.start()
        for target in (self._listen, self._hear, self._beat):
            threading.Thread(target=self._guard, args=(target,), daemon=True).start()
        heard_by = self._health.source, self._health.model, self._precision
        rospy.loginfo("listening to the %s, model %s in %s", *heard_by)
        rospy.loginfo("spotter model %s", self._health.spotter[:12])
        rospy.spin()
        self._over.set()
        if self._health.failure:
            sys.exit(1)  # as after a crash: `respawn` starts it again

    def _guard(self, target: Callable[[], None]) -> None:
        """Top of a thread: an error stops the robot and ends the heartbeat."""
        try:
            target()
        except Exception as error:
            name = target.__name__.strip("_")
            self._health.failure = f"{name}: {error}"
            if not rospy.is_shutdown():
                self._robot.hold()
            expected = isinstance(error, VoiceError)
            rospy.logfatal("%s", self._health.failure, exc_info=not expected)
            rospy.signal_shutdown(self._health.failure)

    def _listen(self) -> None:
        """Thread of the sound."""
        if is_restart() and self._config.audio.source == "wav":
            self._give_up_recording()
            return
        with self._source() as source:
            watch = SoundWatch(source, self._config.audio.deaf_after)
            service = MicrophoneService(source)
            for frame in source:
                if self._over.is_set():
                    return
                self._health.note_microphone(service.note_name())
                self._health.note_remark(source.remark)
                self._health.note_trouble(watch(frame), watch.fault)
                frame = self._robot.with_motion(frame)
                if self._spotter is not None:
                    self._spotter.feed(frame)
                    self._health.note_spotter(self._spotter.dropped, _now())
                self._publish.audio(frame)
                self._health.sounded(level_db(frame.samples), at_full_scale(frame.samples))
                try:
                    self._frames.put_nowait(frame)
                except Full:
                    self._health.dropped += 1  # the pipeline notices the gap
                    self._publish.side_input(SideInput(SideInputKind.UNHEARD, frame.first_sample))
        self._frames.put(None)

    def _give_up_recording(self) -> None:
        """A crash broke it off; what it has said must not be said again."""
        self._health.note_trouble("a crash broke the recording off; nothing of it is said again")
        if self._config.audio.wav.after_end == "exit":
            self._frames.put(None)

    def _source(self) -> AudioSource:
        config, report = self._config.audio, self._health.note_trouble
        hear = partial(self._known.hear, "audio")
        if config.source == "topic":
            return TopicSource(config.topic, report, hear, self._health.note_clocks)
        if config.source == "audio_data":
            return AudioDataSource(config.audio_data, report, hear)
        return make_source(config, _now, self._over.wait, report)

    def _hear(self) -> None:
        """Thread of recognition."""
        limit_torch(self._config)
        self._pipeline.warm_up(_noise())  # what is done only once must not look like a hang
        while not self._over.is_set():
            self._robot.take_reports()
            try:
                frame = self._frames.get(timeout=HEARTBEAT)
            except Empty:
                continue
            if frame is None:
                rospy.signal_shutdown("the recording is over")
                return
            self._busy_since = started = _steady()
            for event in self._pipeline(frame):
                self._take(event)
            self._busy_since, health = None, self._health
            health.worked(_steady() - started, frame.duration)
            health.queued, health.frame_done = self._frames.qsize(), _now()
            health.behind = health.frame_done - frame.stamp - frame.duration

    def _take(self, event: Event) -> None:
        if isinstance(event, UtteranceDecision):
            for action in event.actions:
                self._robot.do(action)
            self._publish.utterance(event, _now())
            if any(isinstance(action, Ask) for action in event.actions):
                self._pipeline.question_shown(_now())
            if isinstance(event.outcome, Match):
                self._health.commanded, self._health.last_command = _now(), event.outcome.command
        elif isinstance(event, Partial):
            self._publish.partial(event)
        elif isinstance(event, Lost):
            self._health.note_gap(event.samples, _now(), self._config.audio.deaf_after)
            rospy.logwarn("%d samples of sound were lost", event.samples)

    def _load_spotter(self) -> Spotting:
        spotter, self._health.spotter = make_spotters(self._config)
        return spotter

    def _in_thread(self, spotter: Spotting) -> SpotterThread:
        callbacks = self._spotted, self._spotter_failed
        patience = self._config.spotter.patience
        observer = self._publish.side_input
        return SpotterThread(spotter, self._config.spotter.queue, *callbacks, patience, observer)

    def _spotted(self, spotted: Spotted) -> None:
        """Thread of the spotter: stop at once, unless recognition just did.

        The pipeline takes the spotted word later.
        """
        since = abs(_now() - self._robot.stopped)  # also after the clock was set back
        if since >= self._config.spotter.rearm_after:
            self._robot.stop()
        rospy.loginfo("the spotter heard %r: %.1f nat", self._config.spotter.phrase, spotted.score)

    def _spotter_failed(self, error: Exception) -> None:
        self._health.spotter_failure = f"spotter: {error}; the recogniser alone hears a stop"
        rospy.logerr("%s", self._health.spotter_failure)

    def _beat(self) -> None:
        """Thread that watches over recognition, and sends heartbeat and diagnostics."""
        diagnostics = VoiceDiagnostics(self._health, _now, self._config.audio.deaf_after)
        checks = 0
        while not self._over.wait(WATCH_PERIOD):
            is_news = self._watch_recognition()
            would_hear = self._health.would_hear(_now(), self._config.audio.deaf_after)
            if checks % _HEARTBEAT_EVERY == 0 and would_hear:
                self._publish.heartbeat(_now())
            if is_news or checks % (_HEARTBEAT_EVERY * _DIAGNOSTICS_EVERY) == 0:
                self._health.controller = self._robot.trouble
                diagnostics.publish()
                self._known.publish_status()
            checks += 1

    def _watch_recognition(self) -> bool:
        """Stop the robot once recognition hangs; returns whether a hang has just begun or ended."""
        status = self._watch(self._busy_since, _steady(), _now())
        self._health.hang = status.hang
        if status.hang and status.is_news:
            self._robot.hold()
            rospy.logerr("%s; the robot is stopped", status.hang)
        if status.spotted is not None:
            self._spotted(Spotted(_now(), status.spotted))
        return status.is_news


def _now() -> float:
    return float(rospy.get_time())


def _steady() -> float:
    return time.monotonic()


def _noise() -> Samples:
    """Two seconds of it, full scale 1."""
    loud = 0.1 * np.random.default_rng(0).standard_normal(2 * RATE)
    return frozen_samples(loud.astype(np.float32))
