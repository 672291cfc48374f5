# SPDX-License-Identifier: BSD-3-Clause
"""What the page of a session warns of."""

import re
from dataclasses import replace
from datetime import datetime
from html import unescape

import pytest

from session_log.report.one_session import write_report
from support.story import Story, recording_of

pytestmark = pytest.mark.usefixtures("without_figures")


@pytest.fixture
def warning_of(tmp_path, report_config):
    def write(messages):
        session = recording_of(tmp_path / "s.mcap", messages)
        text = write_report(session, tmp_path, report_config).page.read_text("utf-8")
        found = re.search(r'<p class="warn">(.*?)</p>', text)
        return unescape(found[1]) if found else ""

    return write


def stamped(behind):
    """Joint states that a clock stamped which is this much behind the recorder's [s]."""
    story = Story()
    story.say(100.0, "/joint_states", "sensor_msgs/JointState")
    (message,) = story.messages
    return [message._replace(log_time=message.log_time + int(behind * 1e9))]


@pytest.mark.parametrize(
    ("behind", "apart"), [(5.0, "5.0\u00a0s"), (-90.0, "90.0\u00a0s"), (9e7, "more than a day")]
)
def test_stamps_of_another_clock_are_a_warning_with_the_distance(warning_of, behind, apart):
    clock = f"The clock that stamped /joint_states is {apart} off the recorder's"
    assert clock in warning_of(stamped(behind))


def test_stamps_of_one_clock_are_no_warning(warning_of):
    assert warning_of(stamped(0.5)) == ""


def test_a_clock_that_is_a_little_off_is_a_warning(warning_of):
    (message,) = stamped(0.8)
    later = [message._replace(log_time=message.log_time + k) for k in range(30)]
    clock = "The clock that stamped /joint_states is 0.8\u00a0s off the recorder's"
    assert f"{clock}: their times, and latencies, are off by as much." in warning_of(later)


def test_a_clock_that_was_set_back_is_named_with_its_zone(warning_of):
    (message,) = stamped(0.0)
    words = warning_of([message, message._replace(log_time=message.log_time - 10**10)])
    zone = datetime.fromtimestamp(message.log_time * 1e-9).astimezone().strftime("%Z")
    assert words.startswith("The clock was set back") and f" {zone}: times after it" in words


def test_a_page_without_an_rcm_error_says_what_was_not_recorded(tmp_path, report_config):
    session = recording_of(tmp_path / "s.mcap", stamped(0.0))
    text = write_report(session, tmp_path, report_config).page.read_text("utf-8")
    assert "No state of the controller was recorded. Not computed from the joint states: " in text


def test_a_recording_from_outside_of_the_systems_names_their_namespaces(warning_of):
    story = Story()
    story.event(1.0, "accepted", "tense", "")
    (message,) = story.messages
    messages = [
        message._replace(source=replace(message.source, topic=f"/{side}/rst_control/event"))
        for side in ("left", "right")
    ]
    assert "Topics of the report lie in /left and /right" in warning_of(messages)


def test_joint_states_of_other_joints_are_counted(warning_of):
    story = Story()
    for k, names in enumerate((["a", "b"], ["c"], ["a", "b"])):
        fields = {"name": names, "position": [0.0] * len(names)}
        story.say(1.0 + k, "/joint_states", "sensor_msgs/JointState", **fields)
    assert "1 samples of /joint_states are left out" in warning_of(story.messages)
