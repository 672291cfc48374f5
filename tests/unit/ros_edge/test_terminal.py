# SPDX-License-Identifier: BSD-3-Clause
"""What a node logs is written beside it, and a terminal that is stopped keeps nobody waiting."""

import logging
import threading

import pytest
from rosgraph.roslogging import RosStreamHandler

from typed_config.ros import terminal
from typed_config.ros.terminal import KEPT, Beside, write_beside


class Terminal:
    """Takes words, unless it is stopped."""

    def __init__(self):
        self.goes_on, self.written = threading.Event(), []
        self.goes_on.set()

    def write(self, words):
        self.goes_on.wait()
        self.written.append(words)

    def flush(self):
        """Do nothing."""


@pytest.fixture
def screen():
    return Terminal()


@pytest.fixture
def log(screen, monkeypatch):
    """The logger of rospy's words, with its own handler for a terminal, and another."""
    logger = logging.getLogger("rosout")
    monkeypatch.setattr(logger, "handlers", [])
    monkeypatch.setattr(logger, "disabled", False)
    before = logger.level
    logger.setLevel(logging.INFO)  # which forgets what was logged before, and what was not
    logger.addHandler(RosStreamHandler(False, screen, screen))
    logger.addHandler(logging.NullHandler())
    write_beside()
    yield logger
    screen.goes_on.set()
    beside(logger).close()
    logger.setLevel(before)


def beside(log):
    return next(handler for handler in log.handlers if isinstance(handler, Beside))


def test_words_are_written_in_their_order_and_the_last_ones_before_the_end(log, screen):
    for number in range(20):
        log.warning("%s at %d", "stop", number)
    beside(log).close()
    assert [words.split(": ")[-1] for words in screen.written] == [
        f"stop at {number}\n" for number in range(20)
    ]


def test_only_what_writes_to_a_terminal_is_replaced(log):
    assert [type(handler) for handler in log.handlers] == [logging.NullHandler, Beside]


def test_a_terminal_that_is_stopped_keeps_nobody_waiting(log, screen, monkeypatch):
    monkeypatch.setattr(terminal, "WITHIN", 0.0)
    screen.goes_on.clear()
    for number in range(KEPT + 100):
        log.info("word %d", number)
    assert screen.written == []
    handler = beside(log)
    handler.flush()
    handler.close()
    screen.goes_on.set()
    handler._records.put(None)  # it had no place before
    handler._thread.join()
    kept = [int(words.rsplit(maxsplit=1)[-1]) for words in screen.written]
    assert kept == list(range(len(kept))) and len(kept) >= KEPT


def test_an_exception_is_written_with_its_trace(log, screen):
    try:
        raise ArithmeticError("not a number")
    except ArithmeticError:
        log.exception("a loop failed")
    beside(log).close()
    (words,) = screen.written
    assert "a loop failed" in words and "ArithmeticError: not a number" in words
