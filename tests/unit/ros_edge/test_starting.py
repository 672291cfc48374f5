# SPDX-License-Identifier: BSD-3-Clause
"""Ctrl-C while a node starts ends it at once, and only then."""

import signal

import pytest
import rospy

from rst_control.ros.common.starting import ends_on_interrupt


def test_an_interrupt_while_a_node_starts_ends_it_and_leaves_the_master(monkeypatch):
    reasons = []
    monkeypatch.setattr(rospy, "signal_shutdown", reasons.append)
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(SystemExit) as ended, ends_on_interrupt():
        signal.raise_signal(signal.SIGINT)
    assert ended.value.code == 130
    assert reasons == ["interrupted while it starts"]
    assert signal.getsignal(signal.SIGINT) is before
