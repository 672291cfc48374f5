# SPDX-License-Identifier: BSD-3-Clause
"""Who may confirm a first motion, how long an error is shown, and how often guards look."""

from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from rst_control.execution.orders import Reply
from rst_control.ros.controller import diagnostics, liveness_watch
from rst_control.ros.controller.services.first_motion import ConfirmedFirst
from rst_control.types import Reason

ON_TIME = SimpleNamespace(
    late_percent=0.0, ticks=1, skipped=0, duration_p50=0.0, duration_p99=0.0, lateness_p99=0.0
)


@pytest.mark.parametrize("is_homing", [True, False])
@pytest.mark.parametrize(
    ("refusal", "is_confirmed"),
    [(None, True), (Reply(False, "/other may not", Reason.MAY_NOT_COMMAND), False)],
)
def test_only_those_who_may_command_confirm_a_motion_or_the_homing(
    refusal, is_confirmed, is_homing
):
    confirmed = []
    service = object.__new__(ConfirmedFirst)
    service._admit = SimpleNamespace(refusal=lambda _: refusal)
    service._homing = SimpleNamespace(confirm=lambda: is_homing and not confirmed.append("homing"))
    motion = Reply(True, "confirmed")
    service.verify = SimpleNamespace(confirm=lambda: confirmed.append("motion") or motion)
    answer = service._on_confirm(object())
    assert answer.success is is_confirmed
    assert confirmed == ([] if not is_confirmed else ["homing" if is_homing else "motion"])
    assert is_confirmed or answer.message == "/other may not"


def test_an_error_in_a_thread_is_shown_for_a_while(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(diagnostics.rospy, "Publisher", lambda *_, **__: None)
    monkeypatch.setattr(diagnostics.time, "monotonic", lambda: now[0])
    shown = diagnostics.Diagnostics()
    shown.error("a worker failed")
    assert shown._loop(ON_TIME).message == "a worker failed"
    now[0] += diagnostics.SHOWN_FOR + 1.0
    later = shown._loop(ON_TIME)
    assert (later.level, later.message) == (DiagnosticStatus.OK, "on time")


def test_recording_and_dead_man_are_looked_at_as_often_as_the_master(monkeypatch):
    slept, looks = [], []
    monkeypatch.setattr(liveness_watch.time, "sleep", slept.append)
    peers = SimpleNamespace(want=lambda _: None, state=lambda _: "")
    monkeypatch.setattr(liveness_watch, "Peers", lambda: peers)
    executor = SimpleNamespace(owner="", snapshot="now")
    recording = SimpleNamespace(recorders=frozenset(), check=lambda view: looks.append(view))
    dead_man = SimpleNamespace(check=lambda view: looks.append(view))
    liveness = SimpleNamespace(report=lambda _: None)
    watch = liveness_watch.LivenessWatch(liveness, executor, "/voice", (), recording, dead_man)
    watch.step()
    assert (slept, looks) == ([liveness_watch.PERIOD], ["now", "now"])
