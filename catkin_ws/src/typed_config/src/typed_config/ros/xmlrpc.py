# SPDX-License-Identifier: BSD-3-Clause
"""Calls of the ROS master's and of nodes' XML-RPC API that give up in time."""

from __future__ import annotations

import http.client
import xmlrpc.client
from typing import Final, cast
from xml.parsers.expat import ExpatError

import rosgraph

ANSWER_TIME: Final = 2.0  # [s] for an answer, which a busy host may delay
SUCCESS: Final = 1
CALLER: Final = "/typed_config"  # of questions that concern no node of ours

# What goes wrong where nobody is there, or somebody else is, or who answers is killed meanwhile.
FAILURES: Final = (
    *(OSError, http.client.HTTPException, xmlrpc.client.Error, ValueError),
    *(EOFError, ExpatError),  # of answers that break off, packed and plain
)


class _Transport(xmlrpc.client.Transport):
    def make_connection(self, host: tuple[str, dict[str, str]] | str) -> http.client.HTTPConnection:
        """A connection that gives up in time."""
        connection = super().make_connection(host)
        connection.timeout = ANSWER_TIME
        return connection


def server(uri: str) -> xmlrpc.client.ServerProxy:
    """The API at a URI; to be closed, as a context is."""
    return xmlrpc.client.ServerProxy(uri, transport=_Transport())


def master() -> xmlrpc.client.ServerProxy:
    """The API of the ROS master."""
    return server(rosgraph.get_master_uri())


def ask(uri: str, method: str, *arguments: object) -> object:
    """Call one method.

    Raises:
        TimeoutError: Nobody answers.
        OSError: Nobody is there.
        EOFError, ExpatError: The answer breaks off.
        ValueError: The answer says that it failed, or makes no sense.
    """
    with server(uri) as api:
        return value_of(getattr(api, method)(*arguments))


def ask_master(method: str, *arguments: object) -> object:
    """Call one method of the ROS master; raises what `ask` does."""
    return ask(rosgraph.get_master_uri(), method, CALLER, *arguments)


def parameter(name: str) -> object | None:
    """A parameter of the master by its full name, None: it is not set; raises what `ask` does."""
    try:
        return ask_master("getParam", name)
    except ValueError:
        return None


def published_topics() -> list[tuple[str, str]]:
    """Name and type of each topic that has a publisher; raises what `ask` does."""
    return cast(list[tuple[str, str]], ask_master("getPublishedTopics", ""))


def value_of(answer: object) -> object:
    """What an answer of three parts brings.

    Raises:
        ValueError: It says that the call failed, or has other parts.
    """
    if not isinstance(answer, list | tuple) or len(answer) != 3:
        raise ValueError(f"an answer that is none of ROS: {str(answer)[:80]}")
    code, words, value = answer
    if code != SUCCESS:
        raise ValueError(str(words))
    return value


def is_alive(master: str, node: str) -> bool:
    """Whether a registered node is there; one that hangs is, one that was killed is not."""
    try:
        ask(str(ask(master, "lookupNode", CALLER, node)), "getPid", CALLER)
    except TimeoutError:
        return True
    except FAILURES:
        return False
    return True


def master_problem() -> str:
    """Why no node can start: rospy would wait for the master without a word; empty: one can."""
    uri = rosgraph.get_master_uri()
    try:
        is_there = rosgraph.is_master_online()
    except ValueError:  # of an address that is none
        return f"no ROS master at {uri!r}: ROS_MASTER_URI has the form http://HOST:PORT"
    return "" if is_there else f"no ROS master at {uri}: start `roscore` first"
