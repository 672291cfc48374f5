# SPDX-License-Identifier: BSD-3-Clause
"""How the recorder node ends."""

from unittest.mock import MagicMock

import pytest

from session_log.ros import recorder_node


@pytest.mark.parametrize(("error", "status"), [("", 0), ("the disk is full", 1)])
def test_a_recording_that_is_not_complete_is_no_success(
    monkeypatch, recorder_config, error, status
):
    at_end = []
    rospy = MagicMock(on_shutdown=at_end.append, spin=lambda: at_end[0]())
    rospy.get_namespace.return_value = "/"
    monkeypatch.setattr(recorder_node, "rospy", rospy)
    recorder = MagicMock()
    recorder.close.return_value = error
    monkeypatch.setattr(recorder_node, "Recorder", lambda *_: recorder)
    parts = ("TopicSubscriber", "Discovery", "RecorderDiagnostics", "Announcer")
    for name in (*parts, "ParameterWatcher", "add_facts", "starting"):
        monkeypatch.setattr(recorder_node, name, MagicMock())
    monkeypatch.setattr(recorder_node, "load_config", lambda *_: recorder_config)
    monkeypatch.setattr(recorder_node.RecorderNode, "_run_turns", lambda node: None)
    with pytest.raises(SystemExit) as end:
        recorder_node.main()
    assert end.value.code == status
