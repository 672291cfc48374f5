# SPDX-License-Identifier: BSD-3-Clause
"""A signal while a node starts ends it at once, and only then."""

import signal
from contextlib import suppress

import pytest

from typed_config import ends_on_signal

NUMBERS = (signal.SIGINT, signal.SIGTERM)


@pytest.fixture
def of_the_node():
    """Sets the handlers as they were before: here they stand for those of a node."""
    before = {number: signal.getsignal(number) for number in NUMBERS}

    def afterwards():
        for number, handler in before.items():
            signal.signal(number, handler)

    yield afterwards
    assert {number: signal.getsignal(number) for number in NUMBERS} == before


@pytest.mark.parametrize("number", NUMBERS)
def test_a_signal_while_a_node_starts_ends_it_and_its_own_handlers_come_afterwards(
    of_the_node, number
):
    with pytest.raises(SystemExit) as ended, ends_on_signal(of_the_node):
        signal.raise_signal(number)
    assert ended.value.code == 128 + number


@pytest.mark.parametrize("number", NUMBERS)
def test_code_that_swallows_the_exit_does_not_start_the_node(of_the_node, number):
    with pytest.raises(SystemExit) as ended, ends_on_signal(of_the_node), suppress(SystemExit):
        signal.raise_signal(number)
    assert ended.value.code == 128 + number


def test_a_start_without_a_signal_goes_on_and_leaves_no_handler_that_exits(of_the_node):
    found = []

    def afterwards():
        found.extend(map(signal.getsignal, NUMBERS))
        of_the_node()

    with ends_on_signal(afterwards):
        pass
    assert found == [signal.default_int_handler, signal.SIG_DFL]
