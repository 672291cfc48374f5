# SPDX-License-Identifier: BSD-3-Clause
"""The trocar from a recording: what is read, which poses count, what is printed."""

import csv
import json
import re

import numpy as np
import pytest
from mcap_ros1.writer import Writer
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.registration.calibrate_cli import main
from rst_control.registration.pose_file import ArmSample, PoseFileError, read_arm, rest_poses
from rst_control.types import JOINTS
from tests.support.other_tool import tool_beside

TOPIC = "/joint_states"
NO_VELOCITIES = "The file has no velocities"
SHIFTS = [(0.0, 0.0), (0.03, 0.0), (-0.03, 0.0), (0.0, 0.03), (0.0, -0.03), (0.02, 0.02)]


@pytest.fixture(scope="module")
def visit(planner, home):
    """Joint positions and velocities (10,) of a robot that goes from pose to pose and rests."""
    rows, q = [], home
    for x, y in SHIFTS:
        goal = Configuration(planner.model, q).T_base_tip
        goal[:3, 3] = planner.centre + np.array([x, y, 0.0])
        path = planner.leg(q, goal)
        for s in np.linspace(0.0, path.length, 20)[1:-1]:
            point = path.evaluate(s)
            beside = point.q + 0.002 * np.eye(9)[3]  # the trocar gives way while it moves
            rows.append((robot_joints(beside, 0.0), robot_joints(point.dq * 0.02, 0.0)))
        q = path.end
        rows += [(robot_joints(q, 0.0), np.zeros(10))] * 10
    return rows


def write_mcap(path, rows, names=JOINTS):
    with path.open("wb") as file, Writer(file) as writer:
        for n, (position, velocity) in enumerate(rows):
            message = JointState(name=names, position=position, velocity=velocity)
            message.header.stamp.secs, message.header.stamp.nsecs = 100 + n // 500, n % 500
            writer.write_message(TOPIC, message, log_time=n)
    return path


@pytest.fixture
def session(tmp_path, visit):
    write_mcap(tmp_path / "session.mcap", visit)
    return tmp_path


def printed(capsys, *words):
    main([str(word) for word in words])
    return capsys.readouterr().out


def refused(capsys, *words):
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    assert end.value.code == 1
    return capsys.readouterr().err


def test_the_trocar_of_a_session_is_printed_with_its_residual(capsys, session):
    out = printed(capsys, session)
    assert "trocar: [0.406000, -0.024000, 0.415000]" in out
    assert "from 6 shaft poses" in out and "residual 0.000 mm rms" in out
    assert "pose 6, 0.0 s: 0.000 mm" in out
    assert 'set_trocar "position: {x: 0.406000, y: -0.024000, z: 0.415000}"' in out
    assert printed(capsys, session / "session.mcap") == out


def test_the_shaft_is_that_of_the_tool_that_is_described(capfd, tmp_path, session):
    urdf = tmp_path / "beside.urdf"
    urdf.write_text(tool_beside(0.01))
    assert "mm from the common point, allowed 1.000 mm" in refused(capfd, session, "--urdf", urdf)
    none = tmp_path / "none.urdf"
    said = refused(capfd, session, "--urdf", none)
    assert said == f"calibrate_trocar: {none}: No such file or directory\n"


def test_a_second_visit_of_the_same_name_is_the_one_that_counts(capsys, caplog, session, visit):
    """The trocar of a robot turned by 0.1 rad about its base is turned as well."""
    turned = [(q + 0.1 * np.eye(10)[0], speed) for q, speed in visit]
    write_mcap(session / "session_2.mcap", turned)
    x, y, z = (
        float(v) for v in re.findall(r"trocar: \[(.*)\]", printed(capsys, session))[0].split(",")
    )
    assert abs(z - 0.415) < 1e-6 and abs(np.hypot(x, y) - np.hypot(0.406, -0.024)) < 1e-6
    assert abs(np.arctan2(y, x) - np.arctan2(-0.024, 0.406)) == pytest.approx(0.1, abs=1e-5)
    assert "session_2.mcap: the newest of 2 recordings" in caplog.text


def test_poses_in_motion_count_only_when_asked_for(capsys, session):
    out = printed(capsys, session, "--moving")
    assert "residual 0.000 mm" not in out and NO_VELOCITIES not in out
    assert NO_VELOCITIES not in printed(capsys, session)


def test_without_velocities_it_is_said_that_poses_in_motion_count(capsys, tmp_path, visit):
    path = write_mcap(tmp_path / "silent.mcap", [(position, []) for position, _ in visit])
    out = printed(capsys, path)
    assert out.startswith(f"{NO_VELOCITIES}, so poses in motion count, too.\n")
    assert "residual 0.000 mm" not in out
    assert NO_VELOCITIES not in printed(capsys, path, "--moving")


def test_a_trocar_that_moved_half_way_is_refused_and_the_poses_are_shown(capsys, tmp_path, visit):
    """The robot's base turned by 0.02 rad: 8 mm at the trocar."""
    half = len(visit) // 2
    slipped = [(q + 0.02 * np.eye(10)[0], speed) for q, speed in visit[half:]]
    path = write_mcap(tmp_path / "slipped.mcap", [*visit[:half], *slipped])
    with pytest.raises(SystemExit) as end:
        main([str(path)])
    shown = capsys.readouterr()
    assert end.value.code == 1
    assert "mm from the common point, allowed 1.000 mm" in shown.err
    assert "pose 6" in shown.out
    assert "# for scene.yaml" not in shown.out and "set_trocar" not in shown.out


def test_joints_may_come_in_any_order(capsys, tmp_path, visit):
    order = [7, 2, 9, 0, 1, 6, 5, 4, 3, 8]
    names = [JOINTS[n] for n in order]
    rows = [(position[order], velocity[order]) for position, velocity in visit]
    path = write_mcap(tmp_path / "other.mcap", rows, names)
    assert "trocar: [0.406000, -0.024000, 0.415000]" in printed(capsys, path)


def test_a_table_of_joints_will_do(capsys, tmp_path, visit):
    path = tmp_path / "poses.csv"
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, JOINTS)
        writer.writeheader()
        writer.writerows(
            dict(zip(JOINTS, position, strict=True)) for position, v in visit if not v.any()
        )
    assert "from 6 shaft poses" in printed(capsys, path)


def test_the_table_that_session_log_exports_will_do(capsys, tmp_path, visit):
    path = tmp_path / "joint_states.csv"
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["log_time", "header.stamp", "name", "position", "velocity"])
        for n, (position, velocity) in enumerate(visit):
            lists = [JOINTS, position.tolist(), velocity.tolist()]
            writer.writerow([n, f"{n}.0", *map(json.dumps, lists)])
    assert "from 6 shaft poses" in printed(capsys, path)


def test_a_part_of_the_recording_may_be_too_little(capsys, session):
    assert "shaft poses recorded, allowed 5 and more" in refused(capsys, session, "--since", "9")


@pytest.mark.parametrize(
    ("option", "value", "allowed"),
    [
        ("--apart", "nan", "allowed: 0 to 3.14159 rad"),
        ("--since", "-1", "allowed: 0 s or more"),
        ("--until", "soon", "allowed: 0 s or more"),
    ],
)
def test_an_option_that_is_no_such_number_is_refused(capsys, option, value, allowed):
    with pytest.raises(SystemExit) as end:
        main(["x.mcap", option, value])
    assert end.value.code == 2
    assert f"argument {option}: {value!r}, {allowed}" in capsys.readouterr().err


def flipped(content):
    """The file with one byte of its first chunk changed."""
    place = content.index(b"zstd") + 200
    return content[:place] + bytes([content[place] ^ 0xFF]) + content[place + 1 :]


def test_every_file_that_cannot_be_used_is_named_with_the_reason(capsys, tmp_path, session):
    whole = (session / "session.mcap").read_bytes()
    cases = {
        "missing.mcap": (None, "No such file"),
        "cut.mcap": (whole[: len(whole) // 2], "session_log recover"),
        "flipped.mcap": (flipped(whole), "session_log recover"),
        "empty.mcap": (b"", ": neither a .csv nor an MCAP file\n"),
        "other.mcap": (b"x" * 1000, ": neither a .csv nor an MCAP file\n"),
        "other.csv": (b"a,b\n1,2\n", "no joint states: 'joint_1' is missing"),
        "words.csv": (",".join(JOINTS).encode() + b"\n" + b"x," * 10, "no joint states"),
        "none.csv": (b"", "no joint states"),
    }
    for name, (content, reason) in cases.items():
        if content is not None:
            (tmp_path / name).write_bytes(content)
        error = refused(capsys, tmp_path / name)
        assert name in error and reason in error, (name, error)
    assert "no joint states on /arm" in refused(capsys, session, "--topic", "/arm")
    (tmp_path / "folder").mkdir()
    assert "folder: no recording in this folder\n" in refused(capsys, tmp_path / "folder")


def test_a_topic_of_another_type_is_refused_with_both_types(capsys, tmp_path):
    with (tmp_path / "tf.mcap").open("wb") as file, Writer(file) as writer:
        writer.write_message("/tf", TFMessage(), log_time=1)
    error = refused(capsys, tmp_path / "tf.mcap", "--topic", "/tf")
    assert "/tf is tf2_msgs/TFMessage, allowed: sensor_msgs/JointState\n" in error


def test_a_message_without_a_joint_of_the_arm_is_refused(tmp_path, visit):
    path = write_mcap(tmp_path / "tool.mcap", [(p[7:], v[7:]) for p, v in visit], JOINTS[7:])
    with pytest.raises(PoseFileError, match="joint_1"):
        list(read_arm(path, TOPIC))


def sample(time, joint, speed=0.0):
    return ArmSample(time, np.full(7, joint), speed)


def test_a_pose_counts_once_and_again_after_another():
    samples = [sample(0.0, 0.0), sample(1.0, 0.005), sample(2.0, 0.5), sample(3.0, 0.0)]
    poses = rest_poses(samples, apart=0.01, at_rest_speed=0.01)
    assert [(p.time, p.position[0]) for p in poses] == [(0.0, 0.0), (2.0, 0.5), (3.0, 0.0)]


def test_poses_in_motion_or_outside_the_span_do_not_count():
    samples = [sample(0.0, 0.0), sample(1.0, 0.5, speed=0.02), sample(2.0, 0.9), sample(3.0, 1.2)]
    assert len(rest_poses(samples, 0.01, 0.01)) == 3
    assert len(rest_poses(samples, 0.01, np.inf)) == 4
    assert [p.time for p in rest_poses(samples, 0.01, 0.01, (0.5, 2.5))] == [2.0]


def test_samples_without_speed_count_as_at_rest():
    assert len(rest_poses([sample(0.0, 0.0, speed=float("nan"))], 0.01, 0.01)) == 1
