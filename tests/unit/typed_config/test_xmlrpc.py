# SPDX-License-Identifier: BSD-3-Clause
"""Calls of an API whose process is killed while it answers fail as every caller expects."""

import gzip
import socket
import threading
import xmlrpc.client

import pytest
import rosmaster.util  # noqa: F401 replaces the reader of packed answers, as roslaunch does

from typed_config.ros.xmlrpc import FAILURES, ask, is_alive

ANSWER = xmlrpc.client.dumps(((1, "", "http://127.0.0.1:1/"),), methodresponse=True).encode()
PACKED = gzip.compress(ANSWER)


@pytest.fixture
def uri():
    """Makes an API whose every answer has a body of which only a part is sent."""
    listeners = []

    def uri(body, sent, *lines):
        header = "\r\n".join(["HTTP/1.1 200 OK", f"Content-Length: {len(body)}", *lines, "", ""])
        listener = socket.create_server(("127.0.0.1", 0))
        listeners.append(listener)
        answer = header.encode() + body[:sent]
        threading.Thread(target=answers, args=(listener, answer), daemon=True).start()
        return f"http://127.0.0.1:{listener.getsockname()[1]}/"

    yield uri
    for listener in listeners:
        listener.close()


def answers(listener, answer):
    try:
        while True:
            connection, _ = listener.accept()
            with connection:
                connection.recv(4096)
                connection.sendall(answer)
    except OSError:  # the test is over
        return


def test_a_whole_answer_is_read(uri):
    assert ask(uri(ANSWER, len(ANSWER)), "getPid", "/test") == "http://127.0.0.1:1/"


@pytest.mark.parametrize("missing", [2, 20, len(ANSWER) - 10, len(ANSWER)])
def test_an_answer_that_breaks_off_is_a_failure(uri, missing):
    with pytest.raises(FAILURES):
        ask(uri(ANSWER, len(ANSWER) - missing), "getPid", "/test")


@pytest.mark.parametrize("missing", [1, 20, len(PACKED)])
def test_so_is_one_that_was_packed(uri, missing):
    with pytest.raises(FAILURES):
        ask(uri(PACKED, len(PACKED) - missing, "Content-Encoding: gzip"), "getPid", "/test")


def test_a_node_is_not_known_to_be_there_by_half_an_answer(uri):
    assert not is_alive(uri(ANSWER, 20), "/node")
