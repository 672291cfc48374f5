# SPDX-License-Identifier: BSD-3-Clause
"""What the robot may do while nobody records it."""

from importlib import import_module
from pkgutil import extend_path
from types import SimpleNamespace

import pytest

import rst_control
from rst_control.admission.command_queue import CommandQueue
from rst_control.admission.recording_gate import (
    LASTING,
    RecordedOnly,
    RecordingNews,
    RecordingWatch,
)
from rst_control.commands.request import Plan
from rst_control.commands.spec import Load, Role
from rst_control.commands.table import COMMANDS
from rst_control.config import load_motion_config
from rst_control.config.recording import RecordingConfig
from rst_control.types import Reason, State
from tests.unit.rst_control.support.executor_rig import Rig

rst_control.__path__ = extend_path(rst_control.__path__, rst_control.__name__)  # with its messages
RecordingLink = import_module("rst_control.ros.controller.recording_link").RecordingLink

AGE = 2.0  # [s]


class Clock:
    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def watch_of(on_loss, clock):
    return RecordingWatch(RecordingConfig(on_loss=on_loss, heartbeat_age=AGE), clock)


@pytest.fixture
def clock():
    return Clock()


def test_a_recorder_that_is_lost_is_named_at_once_and_its_own_last_words_are_kept():
    watch = watch_of("stop", lambda: 10.0)
    watch.heard("/recorder", "")
    watch.lost("/recorder", "was stopped")
    assert watch.problem == "/recorder: recorder was stopped"
    watch.heard("/recorder", "the recorder was shut down")
    watch.lost("/recorder", "ended")
    assert watch.problem == "/recorder: the recorder was shut down"
    watch.heard("/recorder", "")
    assert watch.problem == ""


def test_every_motion_either_advances_or_eases():
    for command in COMMANDS.values():
        assert (command.load is not Load.NEITHER) is (command.role is Role.MOTION), command


@pytest.mark.parametrize("command", COMMANDS.values(), ids=tuple(COMMANDS))
def test_what_is_recorded_is_never_refused(command, clock):
    watch = watch_of("refuse", clock)
    watch.heard("/recorder", "")
    clock.now += AGE
    assert watch.problem == "" and watch.refusal(command) is None


@pytest.mark.parametrize("command", COMMANDS.values(), ids=tuple(COMMANDS))
@pytest.mark.parametrize("on_loss", ["refuse", "stop"])
def test_without_a_recorder_only_what_advances_is_refused(command, on_loss, clock):
    refusal = watch_of(on_loss, clock).refusal(command)
    if command.load is Load.LOADS:
        assert refusal.reason is Reason.NOT_RECORDED
        assert refusal.words.startswith("not recorded: no recorder was ever heard; start launch/")
        assert refusal.words.endswith('still allowed: "release", "pull less", "withdraw", "stop"')
    else:
        assert refusal is None


@pytest.mark.parametrize("command", COMMANDS.values(), ids=tuple(COMMANDS))
def test_where_it_is_ignored_nothing_is_refused_or_stopped(command, clock):
    watch = watch_of("ignore", clock)
    assert watch.problem and not watch.refusal(command)
    assert not watch.stop_cause(Plan(command, ""))


def test_a_silent_recorder_is_named_with_the_time_and_what_was_allowed(clock):
    watch = watch_of("refuse", clock)
    watch.heard("/recorder", "")
    clock.now += AGE + 0.1
    assert watch.problem == "/recorder: recorder silent for 2.1 s, allowed 2.0 s"
    watch.heard("/recorder", "")
    assert watch.problem == ""


def test_the_recorders_own_words_reach_the_refusal(clock):
    watch = watch_of("refuse", clock)
    watch.heard("/recorder", "cannot record to /s/x: No space left on device")
    assert (
        "/recorder: cannot record to /s/x: No space left" in watch.refusal(COMMANDS["tense"]).words
    )
    clock.now += 10.0
    assert "silent for 10.0 s" in watch.problem and "No space left" in watch.problem


def test_one_healthy_recorder_is_enough(clock):
    watch = watch_of("refuse", clock)
    watch.heard("/second", "")
    watch.heard("/recorder", "disk full")
    assert watch.problem == ""
    clock.now += AGE / 2
    watch.heard("/recorder", "disk full")
    clock.now += AGE / 2 + 0.1
    assert watch.problem == "/recorder: disk full"


@pytest.mark.parametrize("command", COMMANDS.values(), ids=tuple(COMMANDS))
@pytest.mark.parametrize("on_loss", ["ignore", "refuse", "stop"])
def test_only_the_setting_stop_brakes_and_only_what_advances(command, on_loss, clock):
    watch = watch_of(on_loss, clock)
    watch.heard("/recorder", "")
    assert watch.stop_cause(Plan(command, "")) is None
    clock.now += 60.0
    brakes = bool(watch.stop_cause(Plan(command, "")))
    assert brakes == (on_loss == "stop" and command.load is Load.LOADS)
    assert watch.stop_cause(None) is None


def test_news_come_once_each_way(clock):
    watch = watch_of("refuse", clock)
    news = RecordingNews(watch, 15.0, clock)
    assert news.next() is None
    clock.now += 14.0
    assert news.next() is None
    watch.heard("/recorder", "")
    assert news.next() == (False, "recorded") and news.next() is None
    clock.now += 4.0
    assert news.next() is None  # it may be the end of the whole launch
    clock.now += LASTING
    is_loss, words = news.next()
    assert is_loss and "silent for 5.0 s" in words and "new motion is refused" in words
    clock.now += 5.0
    assert news.next() is None
    watch.heard("/recorder", "")
    assert news.next() == (False, "recorded again")


def test_a_recorder_that_never_comes_is_news_after_the_grace_or_at_once_where_ignored(clock):
    news = RecordingNews(watch_of("refuse", clock), 15.0, clock)
    assert news.next() is None
    clock.now += 15.1
    assert "no recorder was ever heard" in news.next()[1]
    ignored = RecordingNews(watch_of("ignore", clock), 15.0, clock)
    expected = "not recorded: no recorder was ever heard; ignored, as it was set"
    assert ignored.next() == (True, expected) and ignored.next() is None


class RecordedRig(Rig):
    """The executor with a recorder that the test lets fail."""

    def __init__(self, on_loss="refuse"):
        super().__init__()
        clock = lambda: self.now  # noqa: E731
        self.watch = watch_of(on_loss, clock)
        verify = RecordedOnly(self.context.verify, self.watch)
        self.queue = CommandQueue(self.executor, verify, clock)
        self.link = RecordingLink.__new__(RecordingLink)  # which needs no node to check
        self.link._watch, self.link._executor = self.watch, self.executor
        self.link._news = SimpleNamespace(next=lambda: None)
        self.problem = ""

    def record(self, problem):
        """Let the recorder work ("") or fail, beginning with a heartbeat at once."""
        self.problem = problem
        self.watch.heard("/recorder", problem)

    def tick(self):
        self.watch.heard("/recorder", self.problem)
        self.link.check(self.executor.snapshot)
        return super().tick()


def test_a_motion_under_way_is_finished_and_the_next_is_refused():
    rig = RecordedRig().awake()
    rig.say("tense")
    rig.run(0.5)
    rig.record("disk full")
    rig.until(lambda: rig.state is not State.MOVING)
    assert rig.state is State.ACTIVE
    assert rig.executor.events[-1].kind == "motion_finished"
    refusal = rig.refused("pull more")
    assert refusal.startswith("not recorded: /recorder: disk full; still allowed")
    assert rig.view.last_refusal.words == refusal
    rig.record("")
    rig.finish("pull more")


def test_tissue_that_is_held_can_be_eased_and_let_go_unrecorded():
    rig = RecordedRig().awake()
    rig.finish("tense")
    rig.record("disk full")
    tension = rig.view.tension
    pending = rig.say("pull less")
    rig.until(pending.ended.done)
    assert "not recorded: /recorder: disk full" in pending.reply.result(0).message
    assert rig.view.tension < tension - 0.1
    rig.finish("release")
    assert not rig.view.is_tissue_held
    assert "not recorded" in rig.refused("tense")


def test_stop_wakes_and_ends_unrecorded():
    rig = RecordedRig().awake()
    rig.record("disk full")
    rig.say("stop")
    assert rig.state is State.HALTED
    rig.say("hey robot")
    rig.say("terminate")
    assert rig.state is State.STANDBY


def test_a_nearer_reason_comes_first():
    rig = RecordedRig()
    rig.run(0.1)
    rig.record("disk full")
    assert "standby" in rig.refused("tense")


def test_with_the_setting_stop_a_pull_brakes_and_a_release_is_finished():
    rig = RecordedRig("stop").awake()
    rig.say("tense")
    rig.until(lambda: rig.view.tension > 0.2)
    rig.record("disk full")
    rig.until(lambda: rig.state is State.HALTED)
    assert rig.view.mode.reason == "not recorded: /recorder: disk full"
    assert rig.view.is_tissue_held, "a stop keeps the grip"
    rig.say("hey robot")
    rig.finish("release")
    assert rig.state is State.ACTIVE and not rig.view.is_tissue_held


def test_a_stop_by_a_person_keeps_its_reason_where_the_recording_is_lost_while_it_brakes():
    rig = RecordedRig("stop").awake()
    rig.say("tense")
    rig.until(lambda: rig.view.tension > 0.2)
    rig.say("stop")
    assert rig.state is State.STOPPING
    reason = rig.view.mode.reason
    rig.record("disk full")
    rig.until(lambda: rig.state is State.HALTED)
    assert rig.view.mode.reason == reason != ""
    assert all(event.reason is not Reason.NOT_RECORDED for event in rig.executor.events)


def test_where_it_is_ignored_the_robot_works_as_ever():
    rig = RecordedRig("ignore").awake()
    rig.record("disk full")
    pending = rig.say("tense")
    rig.until(pending.ended.done)
    assert pending.ended.result(0).kind == "succeeded"
    assert "not recorded" not in pending.reply.result(0).message


def test_the_shipped_setting_refuses():
    assert load_motion_config().controller.recording.on_loss == "refuse"
