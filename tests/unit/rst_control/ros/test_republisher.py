# SPDX-License-Identifier: BSD-3-Clause
"""What is published, and when it is published again."""

from __future__ import annotations

from rst_control.ros.common.republisher import Repeated


def test_a_change_is_published_at_once_and_the_same_again_after_a_while() -> None:
    grip: Repeated[bool] = Repeated(0.5)
    published = [now for now in (0.0, 0.1, 0.49, 0.51, 0.6) if grip.is_due(False, now)]
    assert published == [0.0, 0.51]
    assert grip.is_due(True, 0.61) and grip.last is True
    assert not grip.is_due(True, 1.1) and grip.is_due(True, 1.12)


def test_other_words_for_the_same_are_no_news_but_are_published_in_their_turn() -> None:
    fault: Repeated[str] = Repeated(0.5, lambda a, b: bool(a) is bool(b))
    assert fault.is_due("", 0.0) and fault.is_due("no tool for 0.1 s", 0.1)
    assert not fault.is_due("no tool for 0.2 s", 0.2) and fault.last == "no tool for 0.1 s"
    assert fault.is_due("no tool for 0.6 s", 0.6) and fault.is_due("", 0.61)
