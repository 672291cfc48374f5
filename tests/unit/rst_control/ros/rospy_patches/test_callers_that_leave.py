# SPDX-License-Identifier: BSD-3-Clause
"""A caller that leaves before its answer leaves no trace; another error of a service does."""

from types import SimpleNamespace

import pytest
from rospy.exceptions import TransportInitError, TransportTerminated
from rospy.impl.tcpros_service import ServiceImpl
from std_srvs.srv import Trigger, TriggerResponse

from rst_control.ros.rospy_patches import message_limits


@pytest.fixture
def service(monkeypatch):
    for name in ("error_handler", "_write_service_error"):
        monkeypatch.setattr(ServiceImpl, name, getattr(ServiceImpl, name))
    ServiceImpl.error_handler = message_limits._note_error
    ServiceImpl._write_service_error = message_limits._write_error
    made = object.__new__(ServiceImpl)
    made.resolved_name, made.response_class, made.seq = "/made", Trigger._response_class, 0
    return made


def left(*_):
    raise TransportTerminated("32 Broken pipe")


def gone(*_):
    raise TransportInitError("TCPROS transport was not successfully initialized")


def test_a_caller_that_left_is_passed_over(service, monkeypatch):
    logged = []
    monkeypatch.setattr(message_limits, "_error_handler", lambda *words: logged.append(words))
    service.handler = lambda request: TriggerResponse(True, "")
    buffer = SimpleNamespace(write=lambda data: None)
    transport = SimpleNamespace(write_buff=buffer, send_message=left, write_data=gone)
    service._handle_request(transport, None)
    assert logged == []


def test_an_error_of_the_service_itself_is_logged_and_answered(service, monkeypatch):
    logged, written = [], []
    monkeypatch.setattr(message_limits, "_error_handler", lambda *words: logged.append(words))

    def wrong(_):
        raise KeyError("its own fault")

    service.handler = wrong
    service._handle_request(SimpleNamespace(write_data=written.append), None)
    assert [str(words[1]) for words in logged] == ["'its own fault'"]
    assert b"its own fault" in written[0]
