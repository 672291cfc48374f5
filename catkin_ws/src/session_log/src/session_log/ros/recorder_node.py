# SPDX-License-Identifier: BSD-3-Clause
"""The recorder node: every topic of the session into one MCAP file."""

from __future__ import annotations

import hashlib
import sys
import threading
import time
from collections.abc import Mapping
from functools import partial
from typing import Any, cast

import rospy
from std_msgs.msg import String, Time

from session_log.config import RecorderConfig
from session_log.mcap_file.session_folder import open_session, sessions_folder
from session_log.recording import metadata
from session_log.recording.namespace import Namespace
from session_log.recording.recorder import Recorder
from session_log.ros.diagnostics import RecorderDiagnostics
from session_log.ros.discovery import Discovery, TopicSubscriber
from session_log.types import URDF_TOPIC, MessageSource
from typed_config import load_config, package_folder, package_version, repository
from typed_config.ros.starting import starting
from typed_config.ros.xmlrpc import FAILURES, ask_master

FACTS = "session"  # any node may put facts about itself under /session/<name>
REPORT_PERIOD = 1.0  # [s] between two statuses in /diagnostics
TURN_LIMIT = 1.0  # [s] for a turn to end; the master may hang


class Announcer:
    """Publishes whether the system is recorded, to which file, and up to when that is complete."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._heartbeat = rospy.Publisher("session_log/recording", String, queue_size=10)
        self._file = rospy.Publisher("session_log/file", String, latch=True, queue_size=1)
        self._written = rospy.Publisher("session_log/written", Time, queue_size=10)
        self._said: tuple[str, str] | None = None

    def announce(self, is_ready: bool, problem: str) -> bool:
        """Publish heartbeat, file (empty while nothing is recorded) and acknowledged time.

        Args:
            is_ready: Every topic that was waited for is being recorded.
            problem: Why the recording is not what was asked for; empty: it is.

        Returns:
            Whether recording began or ended since the last time.
        """
        status = self._recorder.status()
        self._heartbeat.publish(status.error or problem or ("" if status.path else "starting"))
        path = status.path if status.is_recording and is_ready else ""
        is_news = (path, status.error) != self._said
        if is_news:
            self._said = (path, status.error)
            self._file.publish(path)
            if status.error:
                rospy.logerr("NOT RECORDING: %s", status.error)
            elif path:
                rospy.loginfo("recording to %s", path)
        if status.is_recording:
            self._written.publish(rospy.Time(*divmod(status.written_until, 1_000_000_000)))
        return is_news

    def retire(self) -> None:
        """Say that nothing is recorded from now on."""
        self._heartbeat.publish("the recorder was shut down")


class ParameterWatcher:
    """Writes the parameter server into the recording, again whenever it changes."""

    def __init__(self, recorder: Recorder, namespace: Namespace) -> None:
        self._recorder, self._namespace = recorder, namespace
        self._hashes: dict[str, str] = {}
        source = MessageSource(
            URDF_TOPIC, String._type, String._md5sum, String._full_text, "", True
        )
        self._urdf = recorder.register(source)

    def check(self) -> None:
        """Compare with the last check and record what changed.

        Only what changed is written out and hashed: the heartbeat waits meanwhile.
        """
        try:
            every = cast(dict[str, Any], ask_master("getParam", "/"))
        except FAILURES as error:
            rospy.logwarn_throttle(10.0, "cannot read the parameters: %s", error)
            return
        parameters = self._namespace.parameters(every)
        facts = parameters.pop(FACTS, {})
        if self._is_new(metadata.PARAMETERS, metadata.content(parameters)):
            texts = metadata.parameter_facts(parameters)
            self._recorder.add_metadata(metadata.PARAMETERS, texts)
            _warn_of_lost(texts)
        for name, values in facts.items() if isinstance(facts, dict) else ():
            record = f"session/{name}"
            if isinstance(values, dict) and self._is_new(record, metadata.content(values)):
                self._recorder.add_metadata(record, metadata.named_facts(values))
        if isinstance(parameters.get("robot_description"), str):
            self._record_urdf(parameters["robot_description"])

    def _record_urdf(self, urdf: str) -> None:
        """Keep the URDF as a latched message, so that viewers show the robot."""
        if self._is_new(URDF_TOPIC, urdf):
            data = urdf.encode()
            self._recorder.offer(self._urdf, len(data).to_bytes(4, "little") + data)

    def _is_new(self, name: str, content: str) -> bool:
        digest = hashlib.sha256(content.encode()).hexdigest()
        is_new = self._hashes.get(name) != digest
        self._hashes[name] = digest
        return is_new


def _warn_of_lost(texts: Mapping[str, str]) -> None:
    """Name the parameters that could not be recorded."""
    lost = metadata.NOT_RECORDED
    found = [f"/{key}: {text[len(lost) :]}" for key, text in texts.items() if text.startswith(lost)]
    if found:
        rospy.logwarn_throttle(60.0, f"parameters that are not recorded: {'; '.join(found)}")


def add_facts(
    recorder: Recorder, config: RecorderConfig, started: int, namespace: Namespace
) -> None:
    """Record what is known from the start."""
    facts = metadata.session_facts(started, config.seed)
    recorder.add_metadata("session", {**facts, "namespace": namespace.name})
    package = "session_log"
    sources = package_folder(package) if repository(package) else None
    code = metadata.code_facts(sources)
    code["version"] = package_version(package)
    recorder.add_metadata("code", code)
    recorder.add_metadata("machine", metadata.machine_facts())
    recorder.add_metadata("versions", metadata.version_facts())


class RecorderNode:
    """Joins recorder, discovery, parameters and diagnostics."""

    def __init__(self, config: RecorderConfig) -> None:
        started = time.time_ns()
        self._config = config
        folder = sessions_folder(config.folder)
        namespace = Namespace(rospy.get_namespace())
        opener = partial(open_session, folder, config.name, started, namespace.suffix)
        self._recorder = Recorder(opener, config, time.time_ns)
        self._topics = TopicSubscriber(self._recorder, namespace, config.exclude)
        self._discovery = Discovery(self._topics, config.discovery_period)
        self._early = [namespace.resolved(topic) for topic in config.subscribe_early]
        self._wanted = [namespace.resolved(topic) for topic in config.wait_for]
        self._deadline = time.monotonic() + config.wait_timeout
        self._next_check = 0.0
        self._is_ready = not config.wait_for
        self._diagnostics = RecorderDiagnostics(self._recorder, config)
        self._announcer = Announcer(self._recorder)
        self._parameters = ParameterWatcher(self._recorder, namespace)
        self._next_report = 0.0
        self._ended = threading.Event()
        self._error = ""  # why the recording is not complete; known at the end
        self._turns = threading.Thread(target=self._run_turns, name="turns", daemon=True)
        add_facts(self._recorder, config, started, namespace)

    def run(self) -> int:
        """Record until the node is shut down; gives 0, or 1 if the recording is not complete."""
        for topic in self._early:
            self._topics.subscribe(topic)
        self._recorder.start()
        self._discovery.start()
        rospy.on_shutdown(self.close)
        self._turns.start()
        rospy.spin()  # signals come to this thread: it must hold no lock that closing needs
        return 1 if self._error else 0

    def _run_turns(self) -> None:
        while not self._ended.is_set():
            try:
                self._turn()
            except Exception as error:  # top of the node: the recording must go on
                if not rospy.is_shutdown():
                    rospy.logerr_throttle(5.0, f"recorder: {type(error).__name__}: {error}")
            self._ended.wait(1.0 / self._config.acknowledge_rate)  # whatever a simulated clock does

    def close(self) -> None:
        """Stop receiving, write the ending, say how it went."""
        self._ended.set()
        self._turns.join(TURN_LIMIT)  # so that its heartbeat does not follow the last word
        try:
            self._announcer.retire()
            self._discovery.stop()
            self._topics.close()
        finally:  # whatever ROS says, the file is closed
            self._error = self._recorder.close()
        status = self._recorder.status()
        if self._error:
            rospy.logerr("the recording is not complete: %s", self._error)
        print(f"session_log: {status.written} messages in {status.path or 'no file'}", flush=True)

    def _turn(self) -> None:
        if time.monotonic() >= self._next_check:
            self._next_check = time.monotonic() + self._config.parameters_period
            self._parameters.check()
        self._check_ready()
        is_news = self._announcer.announce(self._is_ready, self._diagnostics.problem)
        if is_news or time.monotonic() >= self._next_report:
            self._next_report = time.monotonic() + REPORT_PERIOD
            self._diagnostics.publish()

    def _check_ready(self) -> None:
        problem = self._discovery.error
        if not self._is_ready:
            missing = self._topics.unpublished(self._wanted)
            self._is_ready = not missing
            if missing and time.monotonic() > self._deadline:
                problem = "nobody publishes " + ", ".join(missing)
        if problem and problem != self._diagnostics.problem:
            rospy.logerr("%s", problem)
        self._diagnostics.problem = problem


def main() -> None:
    """Run the recorder node."""
    with starting("recorder", __doc__, needs_clock=False):
        settings: Any = rospy.get_param("~", {})
        config = load_config(RecorderConfig, settings, "recorder.yaml")
        node = RecorderNode(config)
    sys.exit(node.run())
