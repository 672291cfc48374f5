# SPDX-License-Identifier: BSD-3-Clause
import math
from dataclasses import replace

import numpy as np
import pytest
import yaml

from session_log.mcap_file.reader import SessionReader
from session_log.report.session.analysis import loop_timing
from session_log.report.session.extract import extract
from session_log.report.session.session_data import SampledTable
from session_log.report.session.tension import tension_with_target
from support.message_classes import class_of
from support.story import MOTION, OUTSIDE_UNTIL, SPEECH, Story, recording_of
from tests.unit.session_log.support.foreign import write_foreign
from tests.unit.session_log.support.voice_recording import say_sound


@pytest.fixture
def extracted(tmp_path, report_config):
    """What a report takes from a recording of these messages."""

    def of(messages, **metadata):
        return extract(recording_of(tmp_path / "s.mcap", messages, metadata), report_config)

    return of


def test_every_utterance_is_there_with_its_times(data):
    assert [h.transcript for h in data.heard] == [words for _, _, words, _, _ in SPEECH]
    first = data.heard[0]
    assert (first.speech_start, first.speech_end) == pytest.approx((2.0, 2.7), abs=1e-6)
    assert 0.2 < first.decision - first.speech_end < 0.4


def test_states_become_spans_without_holes(data):
    assert data.states[0].word == "standby" and data.states[-1].word == "standby"
    for one, next_one in zip(data.states, data.states[1:], strict=False):
        assert one.end == next_one.start and one.word != next_one.word
    assert {s.word for s in data.states} == {"standby", "active", "moving", "stopping", "halted"}
    assert [s.word for s in data.phases if s.word][: len(MOTION[:3])] == ["reach", "close", "pull"]


def test_the_rcm_error_is_unknown_while_the_tool_is_outside(data):
    is_outside = data.controller["time"] < OUTSIDE_UNTIL
    assert is_outside.any()
    assert (np.isnan(data.controller["rcm_error"]) == is_outside).all()


def test_fast_topics_are_sampled_and_every_interval_is_kept(data):
    duration = data.recording.duration
    assert len(data.tension) == pytest.approx(duration * 50, rel=0.02)
    assert len(data.joints) == pytest.approx(duration * 50, rel=0.02)
    (joints, _) = data.loops
    assert len(joints.length) == data.recording.topics["/joint_states"].messages - 1


def test_a_lost_message_makes_no_late_cycle(extracted):
    story = Story()
    for sequence in (1, 2, 3, 40, 41):
        story.say(0.002 * sequence, "/joint_states", "sensor_msgs/JointState")
        data = story.messages[-1].data
        numbered = sequence.to_bytes(4, "little") + data[4:]
        story.messages[-1] = story.messages[-1]._replace(data=numbered)
    (loop,) = extracted(story.messages).loops
    assert list(loop.length) == pytest.approx([0.002] * 3, abs=1e-6)


def two_publishers():
    """Joint states of an arm, 500 Hz, and of a gripper, 50 Hz, both even."""
    messages = []
    for publisher, step, phase in (("/arm", 0.002, 0.0), ("/gripper", 0.02, 0.001)):
        story = Story()
        for k in range(int(1.0 / step)):
            story.say(phase + k * step, "/joint_states", "sensor_msgs/JointState")
        messages += [
            m._replace(source=replace(m.source, publisher=publisher)) for m in story.messages
        ]
    return sorted(messages, key=lambda message: message.log_time)


def test_each_publisher_of_a_fast_topic_has_its_own_cycles(extracted):
    loops = extracted(two_publishers()).loops
    assert [loop.topic for loop in loops] == ["/joint_states (/arm)", "/joint_states (/gripper)"]
    assert [loop_timing(loop, 1.5).late for loop in loops] == [0, 0]


def test_a_stamp_that_was_not_set_is_replaced_by_the_time_of_arrival(extracted):
    story = Story(duration=1.0)
    story.event(0.5, "accepted", "tense", "")
    (message,) = story.messages
    unset = message._replace(data=message.data[:4] + bytes(8) + message.data[12:])
    story.messages = [unset]
    (event,) = extracted(story.messages).events
    assert event.time == 0.0


@pytest.mark.parametrize(
    ("session", "callers"),
    [
        ({"namespace": "/left/"}, ["/voice_assist", "/right/voice_assist", ""]),
        ({"namespace": "/"}, ["/left/voice_assist", "/right/voice_assist", ""]),
        ({}, ["/left/voice_assist", "/right/voice_assist", ""]),
    ],
)
def test_callers_have_the_names_that_publishers_have_in_the_recording(extracted, session, callers):
    story = Story()
    for caller in ("/left/voice_assist", "/right/voice_assist", ""):
        fields = {"kind": "accepted", "command": "tense", "caller": caller}
        story.say(1.0, "/rst_control/event", "rst_control/Event", **fields)
    found = extracted(story.messages, session=session)
    assert [event.caller for event in found.events] == callers


def test_what_the_controller_calls_a_phrase_is_known_by_the_node_that_heard_it(extracted):
    commands = [{"phrase": "halt", "command": "stop", "is_halt": True}]
    others = [{"phrase": "halt", "command": "terminate", "is_halt": False}]
    texts = {
        name: yaml.safe_dump({"commands": {"commands": listed}})
        for name, listed in (("test", commands), ("other", others))
    }
    story = Story()
    story.say(1.0, "/voice_assist/utterance", "voice_assist/Utterance", command="halt")
    assert extracted(story.messages, parameters=texts).called == {"halt": "stop"}


def test_every_command_that_was_ever_compared_is_known(extracted):
    story = Story()
    for time, phrases in ((1.0, ["stop", "tense"]), (2.0, ["stop", "light on"]), (3.0, [])):
        fields = {"phrases": phrases, "wer": [0.5] * len(phrases)}
        story.say(time, "/voice_assist/utterance", "voice_assist/Utterance", **fields)
    assert extracted(story.messages).phrases == ("stop", "tense", "light on")


def test_messages_that_do_not_fit_are_counted_not_fatal(extracted):
    story = Story(duration=1.0)
    story.event(0.5, "accepted", "tense", "")
    story.put(0.6, "/rst_control/event", b"\1\2")
    found = extracted(story.messages)
    assert found.undecodable == {"/rst_control/event": 1} and len(found.events) == 1


def test_many_pictures_are_thinned_over_the_whole_session(extracted):
    story = Story(duration=1.0)
    for k in range(200):
        topic, picture = "/robot/scene/compressed", {"format": "png", "data": b"x"}
        story.say(k * 1.0, topic, "sensor_msgs/CompressedImage", **picture)
    times = [p.time for p in extracted(story.messages).pictures]
    assert 8 <= len(times) <= 16 and times[0] == 0.0 and times[-1] > 160.0


def test_the_worst_of_diagnostics_is_kept_with_its_time(data):
    (health,) = data.health
    assert (health.worst, health.worst_message, health.last_message) == (1, "late", "running")
    assert health.worst_time == pytest.approx(20.5, abs=0.01)


@pytest.mark.parametrize("levels", [(0, 2, 3, 0), (0, 3, 2, 0)])
def test_no_state_of_a_part_hides_its_error(extracted, levels):
    story = Story()
    status = class_of("diagnostic_msgs/DiagnosticStatus")
    for k, level in enumerate(levels):
        said = [status(name="arm", level=level, message=f"level {level}")]
        story.say(1.0 + k, "/diagnostics", "diagnostic_msgs/DiagnosticArray", status=said)
    (health,) = extracted(story.messages).health
    assert (health.worst, health.worst_message) == (2, "level 2")
    assert health.worst_time == pytest.approx(float(levels.index(2)))


def test_the_state_of_another_systems_part_of_the_same_name_stands_by_itself(extracted):
    story = Story()
    status = class_of("diagnostic_msgs/DiagnosticStatus")
    for time, level, publisher in ((1.0, 0, "/arm"), (2.0, 2, "/arm of no namespace")):
        said = [status(name="arm", level=level, message=f"level {level}")]
        story.say(time, "/diagnostics", "diagnostic_msgs/DiagnosticArray", status=said)
        last = story.messages[-1]
        story.messages[-1] = last._replace(source=replace(last.source, publisher=publisher))
    found = {h.name: h.worst for h in extracted(story.messages).health}
    assert found == {"arm": 0, "arm of no namespace": 2}


def test_an_empty_recording_has_nothing(extracted):
    data = extracted(())
    assert data.heard == [] and data.joints is None and data.recording.messages == 0


def test_what_came_of_a_call_to_a_device_is_kept(extracted):
    story = Story()
    call = {"phrase": "light on", "target": "/theatre/light"}
    for time, is_done, message in ((1.0, True, ""), (2.0, False, "no answer in 1 s")):
        fields = {**call, "is_done": is_done, "message": message}
        story.say(time, "/voice_assist/device", "voice_assist/DeviceCall", **fields)
    calls = extracted(story.messages).device_calls
    assert [(c.kind, c.command, c.message) for c in calls] == [
        ("accepted", "light on", "/theatre/light"),
        ("refused", "light on", "/theatre/light, no answer in 1 s"),
    ]
    assert calls[1].time - calls[0].time == pytest.approx(1.0)


def pull(story, time, force):
    """What the sensor of the tension says [N]."""
    wrench = class_of("geometry_msgs/WrenchStamped")().wrench
    wrench.force.z = force
    story.say(time, "/robot/tension", "geometry_msgs/WrenchStamped", wrench=wrench)


@pytest.mark.parametrize("odd", [math.nan, math.inf, -math.inf])
def test_a_force_that_is_no_number_is_left_out_and_the_others_kept(extracted, odd):
    story = Story()
    for k, force in enumerate((1.0, odd, 2.0)):
        pull(story, 1.0 + k, force)
    tension = extracted(story.messages).tension
    assert list(tension["time"]) == pytest.approx([0.0, 2.0])
    assert list(tension["tension"]) == [1.0, 2.0]


def test_a_pull_between_two_samples_is_the_largest_tension(extracted):
    story = Story()
    for k in range(1000):  # at 1 kHz
        pull(story, k / 1000, 12.0 if 503 <= k < 515 else 1.0)
    for k in range(50):
        fields = {"state": "active", "tension": 1.0, "tension_target": 1.0}
        story.say(k / 50, "/rst_control/state", "rst_control/ControllerState", **fields)
    data = extracted(sorted(story.messages, key=lambda message: message.log_time))
    assert data.tension["tension"].max() == 12.0 == tension_with_target(data).max()
    assert len(data.tension) == pytest.approx(50, abs=2)


ARM, BOTH = ["a", "b"], ["a", "b", "finger"]


@pytest.mark.parametrize(
    "others",
    [
        [(BOTH, [1.0, 1.0, 1.0])],
        [(ARM, [1.0, 1.0, 1.0]), (ARM, [])],
        [([], []), ([], [1.0, 1.0])],
        [(["b", "a"], [1.0, 1.0])],
    ],
)
def test_of_joint_states_of_several_lengths_those_of_most_messages_are_kept_and_others_counted(
    extracted, others
):
    story = Story()
    rows = [(ARM, [0.1, 0.2]), *others, (ARM, [0.3, 0.4])]
    for k, (names, position) in enumerate(rows):
        fields = {"name": names, "position": position}
        story.say(1.0 + k, "/joint_states", "sensor_msgs/JointState", **fields)
    found = extracted(story.messages)
    assert found.joints.columns == ("time", "a", "b")
    assert list(found.joints["time"]) == pytest.approx([0.0, len(rows) - 1.0])
    assert list(found.joints["a"]) == [0.1, 0.3] and list(found.joints["b"]) == [0.2, 0.4]
    assert found.other_joints == len(others)
    assert not found.undecodable and not found.missing_fields


def test_joint_states_without_positions_give_no_joints(extracted):
    story = Story()
    story.say(1.0, "/joint_states", "sensor_msgs/JointState", name=ARM)
    found = extracted(story.messages)
    assert found.joints is None and not found.missing_fields


def test_after_the_clock_was_set_back_fast_topics_are_taken_again(extracted):
    story = Story()
    for begin in (0.0, -60.0):  # [s]
        for k in range(10):
            time = begin + 0.1 * k
            pull(story, time, 1.0)
            joints = {"name": ARM, "position": [0.1, 0.2]}
            story.say(time, "/joint_states", "sensor_msgs/JointState", **joints)
            story.say(time, "/rst_control/state", "rst_control/ControllerState", state="active")
            say_sound(story, time, 0)
    data = extracted(story.messages)
    tables = (data.tension, data.joints, data.controller, data.sound)
    assert [len(table) for table in tables] == [20] * 4
    assert len(data.recording.clock_steps) == 1


def test_messages_that_are_none_of_ros_1_are_counted_as_unfit(tmp_path, report_config):
    topics = ["/rst_control/event", "/rst_control/state", "/joint_states", "/odd"]
    reader = SessionReader(write_foreign(tmp_path / "s.mcap", topics))
    found = extract(reader, report_config)
    assert found.undecodable == dict.fromkeys(topics[:3], 1)
    assert found.recording.messages == 4


def silent_controller(stretches, end):
    """Messages of a controller that says only in these stretches that it moves, and of others."""
    story = Story()
    for begin, stop in stretches:
        for time in np.arange(begin, stop, 0.02):
            fields = {"state": "moving", "phase": "pull"}
            story.say(time, "/rst_control/state", "rst_control/ControllerState", **fields)
    story.say(0.0, "/voice_assist/mode", "voice_assist/Mode", mode="active")
    story.say(end, "/voice_assist/device", "voice_assist/DeviceCall", phrase="light on")
    return sorted(story.messages, key=lambda message: message.log_time)


@pytest.mark.parametrize("length", [1.0, 30.0])  # in one batch, and in several
def test_a_silent_controller_is_in_no_state(extracted, length):
    stretches = [(0.0, length), (length + 5.0, 2.0 * length + 5.0)]
    messages = silent_controller(stretches, 100.0)
    data = extracted(messages)
    for spans in (data.states, data.phases):
        found = [time for span in spans for time in (span.start, span.end)]
        assert found == pytest.approx([time for ends in stretches for time in ends], abs=0.03)
    assert data.modes[-1].end == pytest.approx(100.0)  # is sent on change only


@pytest.mark.parametrize(("said", "end"), [(1.0, 5.0), (7.0, 20.0)])
def test_the_voice_mode_ends_with_the_sound_unless_it_was_said_later(extracted, said, end):
    story = Story()
    for time in np.arange(0.0, 5.0, 0.1):
        say_sound(story, time, 0)
    story.say(said, "/voice_assist/mode", "voice_assist/Mode", mode="active")
    story.say(20.0, "/voice_assist/device", "voice_assist/DeviceCall", phrase="light on")
    (span,) = extracted(sorted(story.messages, key=lambda message: message.log_time)).modes
    assert (span.start, span.end) == pytest.approx((said, end), abs=0.11)


def test_a_table_is_put_in_order_of_time_and_rows_of_one_time_keep_theirs():
    table = SampledTable(("time", "value"))
    table.sort()
    assert not len(table)
    table.extend(np.array([1.0, 4.0, 5.0]), np.array([0.0, 1.0, 2.0]))
    table.extend(np.array([2.0, 4.0, 4.0]), np.array([3.0, 4.0, 5.0]))
    for _ in range(2):  # nothing changes where it is in order
        table.sort()
        assert table["time"].tolist() == [1.0, 2.0, 4.0, 4.0, 4.0, 5.0]
        assert table["value"].tolist() == [0.0, 3.0, 1.0, 4.0, 5.0, 2.0]
    table.extend(np.array([6.0]), np.array([6.0]))
    assert len(table) == 7


def test_samples_of_two_publishers_of_a_topic_are_in_order_of_time(extracted):
    messages = []
    for publisher, times in (("/sensor_1", range(1500)), ("/sensor_2", range(2000, 5000))):
        story = Story()
        for k in times:
            pull(story, k / 100, 1.0)
        messages += [
            m._replace(source=replace(m.source, publisher=publisher)) for m in story.messages
        ]
    time = extracted(messages).tension["time"]
    assert (np.diff(time) >= 0.0).all()
    assert (time[0], time[-1]) == pytest.approx((0.0, 49.99), abs=0.02)
