# SPDX-License-Identifier: BSD-3-Clause
import math
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

from rst_control.config import URDF_FILE
from rst_control.description import urdf_writer
from rst_control.description.facts import FACTS_FILE, BodyFact, load_facts
from rst_control.description.urdf_writer import cylinder_pose, main, urdf_text
from rst_control.kinematics.robot_model import rotation


@pytest.fixture(scope="module")
def robot_xml():
    return Xml.fromstring(urdf_text(load_facts()))


def test_the_committed_urdf_is_what_the_numbers_give():
    assert URDF_FILE.read_text(encoding="utf-8") == urdf_text(load_facts())


def test_the_command_writes_the_file_and_then_finds_it_up_to_date(tmp_path, capsys):
    file = tmp_path / "robot.urdf"
    assert main([str(file)]) == 0
    assert main([str(file), "--check"]) == 0
    file.write_text("<robot/>")
    assert main([str(file), "--check"]) == 1
    assert "out of date" in capsys.readouterr().out
    file.write_bytes(b"\xff\x00")
    assert main([str(file), "--check"]) == 1
    assert capsys.readouterr().out == "robot.urdf is out of date\n"


def test_what_is_no_urdf_is_not_overwritten(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(urdf_writer, "URDF_FILE", tmp_path / "shipped.urdf")
    facts, same = tmp_path / "long_shaft.yaml", tmp_path / "facts.urdf"
    for file in (facts, same):
        file.write_bytes(FACTS_FILE.read_bytes())
    monkeypatch.chdir(tmp_path)
    for words in (["long_shaft.yaml"], ["facts.urdf", "--facts", str(same)]):
        assert main(words) == 2
        assert capsys.readouterr().err == (
            f"urdf_writer: FILE is '{words[0]}', allowed: a file .urdf other than that of --facts\n"
        )
    with pytest.raises(SystemExit, match="2"):
        main([])
    assert "FILE is missing" in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == [same, facts]
    assert same.read_bytes() == facts.read_bytes() == FACTS_FILE.read_bytes()


def test_it_says_its_version(capsys):
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    assert capsys.readouterr().out.startswith("urdf_writer ")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("mass: 1.697", "mass: heavy", "links[0].mass is 'heavy', allowed: a number"),
        ("name: gen3_openrst", "nam: gen3_openrst", "nam is 'gen3_openrst', allowed: no such key"),
        ("shape: cylinder", "shape: cone", "shape is 'cone', allowed: one of cylinder"),
        ("joints:", "joints: [", "allowed: valid YAML"),
        ("child: half_arm_1_link", "child: shoulder_link", "child shoulder_link is given twice"),
        ("parent: shoulder_link", "parent: tool_tip", "no circle"),
        ("inertia: [0.000", "inertia: [-0.1", "principal moments of inertia is"),
    ],
)
def test_a_wrong_number_is_named_in_one_line_and_nothing_is_written(
    tmp_path, capsys, old, new, words
):
    facts, file = tmp_path / "facts.yaml", tmp_path / "robot.urdf"
    facts.write_text(FACTS_FILE.read_text(encoding="utf-8").replace(old, new, 1), encoding="utf-8")
    assert main([str(file), "--facts", str(facts)]) == 2
    said = capsys.readouterr().err
    assert words in said and said.count("\n") == 1
    assert not file.exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere/x.urdf"], "urdf_writer: nowhere/x.urdf: No such file or directory"),
        (["x.urdf", "--facts", "nowhere.yaml"], "urdf_writer: nowhere.yaml is 'No such file"),
    ],
)
def test_a_file_that_is_not_there_is_named_in_one_line(capfd, arguments, words):
    assert main(arguments) == 2
    said = capfd.readouterr().err
    assert said.startswith(words) and said.count("\n") == 1


def test_all_turns_between_frames_are_exact_quarters(robot_xml):
    for origin in robot_xml.findall("joint/origin"):
        for word in origin.attrib["rpy"].split():
            assert float(word) in {k * math.pi / 2 for k in range(-2, 3)}


def test_the_root_is_the_world_at_the_base_without_inertia_which_kdl_asks_for(robot_xml):
    children = {joint.find("child").attrib["link"] for joint in robot_xml.findall("joint")}
    (root,) = (x for x in robot_xml.findall("link") if x.attrib["name"] not in children)
    assert root.attrib["name"] == "world"  # PyBullet takes a root of this name without a warning
    assert not list(root)
    base = robot_xml.find("joint[@name='joint_base']")
    assert base.find("child").attrib["link"] == "base_link"
    assert base.find("origin").attrib == {"xyz": "0 0 0", "rpy": "0 0 0"}


def test_every_moving_link_can_be_seen_and_nothing_needs_a_mesh(robot_xml):
    for link in robot_xml.findall("link"):
        if link.attrib["name"] not in ("world", "tool_tip"):
            assert link.findall("visual/geometry"), link.attrib
    assert not list(robot_xml.iter("mesh"))


def test_joints_carry_the_limits_of_the_data_sheets(robot_xml):
    limits = {j.attrib["name"]: j.find("limit") for j in robot_xml.findall("joint")}
    assert limits["joint_4"].attrib["upper"] == "2.57"
    assert limits["joint_7"].attrib["velocity"] == "1.2218"
    assert limits["joint_1"].attrib["effort"] == "39"
    assert "upper" not in limits["joint_1"].attrib


@pytest.mark.parametrize(
    ("start", "end"),
    [
        ((0, 0, 0), (0, 0, 2)),
        ((0, 0, 0), (0, -1, 0)),
        ((1, 2, 3), (-1, 2.5, 3)),
        ((0, 0, 1), (0, 0, 0)),
    ],
)
def test_a_cylinder_reaches_from_its_start_to_its_end(start, end):
    centre, rpy, length = cylinder_pose(start, end)
    half = 0.5 * length * rotation(rpy)[:, 2]
    np.testing.assert_allclose(centre - half, start, atol=1e-8)
    np.testing.assert_allclose(centre + half, end, atol=1e-8)


def test_inertia_of_a_cube_and_of_a_thin_rod():
    cube, rod = BodyFact(box=(1.0, 1.0, 1.0)), BodyFact(cylinder=(1e-9, 1.0))
    assert cube.inertia(6.0) == (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
    across, *_, along = rod.inertia(12.0)
    assert across == pytest.approx(1.0)
    assert along == pytest.approx(0.0)
