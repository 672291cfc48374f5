# SPDX-License-Identifier: BSD-3-Clause
"""The line below the demonstration's timeline."""

from types import SimpleNamespace

from demo.live_line import live_line

ROBOT = SimpleNamespace(state="moving", phase="reach", progress=0.4, tension=0.5, rcm_error=2e-6)


def test_a_text_that_still_grows_is_shown_as_unsure():
    line = live_line(1.0, "active", ROBOT, "star")
    assert line.plain.endswith('RCM error   2.0 um | perhaps "star ..."')
    assert "dim" in str(line.spans[-1].style)


def test_nothing_is_shown_where_nobody_speaks():
    assert live_line(1.0, "active", None, "").plain.endswith("active | waiting for the controller")
