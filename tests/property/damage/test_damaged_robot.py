# SPDX-License-Identifier: BSD-3-Clause
"""A URDF that is damaged: refused in words, or the model is the very same.

A digit that becomes another digit makes another robot. Only a person can distinguish it from the
right one. Such a model has to keep all bounds at least.
"""

import random
import re

import numpy as np
import pytest

from rst_control.config import URDF_FILE
from rst_control.errors import RobotModelError
from rst_control.kinematics.robot_model import load_robot, parse_robot

TEXT = URDF_FILE.read_text(encoding="utf-8")
WHOLE = parse_robot(TEXT)
DIGITS = re.compile(r"[\d.+\-e]+")


def parsed(text):
    """The model, or None where it is refused in words."""
    try:
        return parse_robot(text)
    except RobotModelError as error:
        assert "URDF" in str(error) or "joints up to" in str(error) or "no link" in str(error)
        return None


def counted(link):
    """What counts of a link: nobody asks for the name of a joint that does not move."""
    return {key: v for key, v in vars(link).items() if key != "joint" or link.type != "fixed"}


def is_same(model):
    if model.links.keys() != WHOLE.links.keys():
        return False
    same = all(counted(model.links[name]) == counted(link) for name, link in WHOLE.links.items())
    return same and np.array_equal(model.chain, WHOLE.chain)


def test_cut_off_anywhere_it_is_refused_or_the_same():
    refused = 0
    for cut in range(0, len(TEXT), 97):
        model = parsed(TEXT[:cut])
        refused += model is None
        assert model is None or is_same(model), cut
    assert refused > 100


def test_with_a_line_gone_or_doubled_it_is_refused_or_the_same():
    lines = TEXT.splitlines(keepends=True)
    refused = same = 0
    for index in range(len(lines)):
        gone, doubled = lines[:index] + lines[index + 1 :], lines[: index + 1] + lines[index:]
        for changed in (gone, doubled) if index % 3 == 0 else (gone,):
            model = parsed("".join(changed))
            refused += model is None
            same += model is not None
            assert model is None or is_same(model), index
    assert refused > 100 and same > 20  # shapes and colours are not in the model


def test_with_a_byte_changed_it_is_refused_the_same_or_differs_in_a_number_within_bounds():
    order, refused = random.Random(4), 0
    for _ in range(250):
        place = order.randrange(len(TEXT))
        letter = chr(order.randrange(32, 127))
        model = parsed(TEXT[:place] + letter + TEXT[place + 1 :])
        refused += model is None
        if model is None or is_same(model):
            continue
        assert DIGITS.fullmatch(letter) or DIGITS.fullmatch(TEXT[place]), (place, letter)
        for link in model.links.values():
            assert max(map(abs, link.xyz)) <= 2.0 and max(map(abs, link.rpy)) <= 6.2832
            assert link.type != "revolute" or -6.2832 <= link.lower < link.upper <= 6.2832
    assert refused > 20


def bomb():
    """Some lines that stand for ten to the ninth words."""
    lines = ['<!ENTITY a0 "lol">']
    lines += [f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 10)]
    return f'<?xml version="1.0"?><!DOCTYPE robot [{"".join(lines)}]><robot name="&a9;"/>'


def within(name, old, new):
    """The URDF with a text replaced inside of one joint or link."""
    start = re.search(rf'<(joint|link) name="{name}"', TEXT).start()
    at = TEXT.index(old, start, start + 500)
    return TEXT[:at] + new + TEXT[at + len(old) :]


MIMIC = '<mimic joint="joint_finger_left" multiplier="-1" />'
CASES = [
    ("not text", None, "text of at most"),
    ("empty", "", "no XML"),
    ("words", "no robot", "no XML"),
    ("another root", "<sdf/>", "its root is sdf, allowed: robot"),
    ("no joint", '<robot name="x"/>', "links that are no joint's child"),
    ("entities", bomb(), "<!DOCTYPE"),
    ("a file", '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///dev/null">]><robot/>', "<!DOCTYPE"),
    ("too large", "<robot>" + " " * 5_000_001 + "</robot>", "at most 5000000 characters"),
    ("missing joint", TEXT.replace("joint_finger_right", "finger"), "without joint_finger_right"),
    ("joint twice", TEXT.replace('"joint_7"', '"joint_6"'), "joint joint_6 is given twice"),
    ("type", within("joint_2", '"revolute"', '"prismatic"'), "joint joint_2: type is prismatic"),
    ("no type", within("joint_2", 'type="revolute"', ""), "joint joint_2: type is None"),
    ("no limit", within("joint_2", "<limit", "<limits"), "joint joint_2: limit is given 0 times"),
    ("no lower", within("joint_2", 'lower="', 'low="'), "joint joint_2: limit lower is missing"),
    ("swapped", within("joint_2", 'lower="-2.24"', 'lower="2.25"'), "a rising pair within 6.28"),
    ("degrees", within("joint_2", 'upper="2.24"', 'upper="128.3"'), "a rising pair within 6.28"),
    ("NaN limit", within("joint_2", 'lower="-2.24"', 'lower="nan"'), "nan, allowed: a finite"),
    ("no speed", within("joint_2", 'velocity="1.3963"', 'velocity="0"'), "velocity is 0.0, allow"),
    ("deg/s", within("joint_2", 'velocity="1.3963"', 'velocity="80"'), "above 0, up to 20 rad/s"),
    ("no axis", within("joint_2", "<axis", "<axes"), "joint joint_2: axis is given 0 times"),
    ("axis", within("joint_2", 'xyz="0 0 1"', 'xyz="0 1 0"'), "axis is 0 1 0, allowed: 0 0 1"),
    ("mm", within("joint_2", 'xyz="0 0.005375 -0.12838"', 'xyz="0 5.4 -128"'), "-2 to 2 m"),
    ("two numbers", within("joint_2", 'xyz="0 0.005375', 'xyz="'), "three numbers from -2"),
    ("text", within("joint_2", 'xyz="0 0.005375', 'xyz="a 0.005375'), "is a, allowed: a finite"),
    ("turn", within("joint_2", 'rpy="1.5707963267948966', 'rpy="90'), "rad"),
    ("comma", within("joint_2", 'xyz="0 0.005375', 'xyz="0,0 0.005375'), "0,0"),
    ("shape", TEXT.replace("<visual>", '<visual><origin xyz="nan 0 0" rpy="0 0 0"/>', 1), "nan"),
    ("xacro", TEXT.replace("</robot>", '<xacro:a xmlns:xacro="x"/></robot>'), "run xacro first"),
    ("no child", within("joint_2", "<child", "<kid"), "joint joint_2: child is given 0 times"),
    ("circle", within("joint_1", 'link="base_link"', 'link="tool_tip"'), "no circle"),
    ("itself", within("joint_2", 'link="shoulder_link"', 'link="half_arm_1_link"'), "no circle"),
    ("stranger", within("joint_2", 'link="shoulder_link"', 'link="elbow"'), "parent is elbow"),
    ("mass", within("forearm_link", 'value="0.9302"', 'value="-0.9302"'), "mass is -0.9302"),
    ("NaN mass", within("forearm_link", 'value="0.9302"', 'value="nan"'), "mass is nan, allowed"),
    ("grams", within("forearm_link", 'value="0.9302"', 'value="930.2"'), "up to 100 kg"),
    ("no mass", within("forearm_link", "<mass", "<weight"), "mass is given 0 times"),
    ("inertia", within("forearm_link", 'ixx="0.008147"', 'ixx="-0.008147"'), "each above 0"),
    ("bent zero", within("joint_pitch", 'rpy="-1.5707963267948966', 'rpy="-1.2'), "tool_tip at "),
    ("tip aside", within("joint_tool_tip", 'xyz="0 ', 'xyz="0.01 '), "mm beside its z axis"),
    ("tip behind", within("joint_tool_tip", "-0.015", "0.015"), "and above 280.000 mm along it"),
    ("z forward", within("joint_tool_tip", 'rpy="0', 'rpy="1.570796'), "-y of tool_tip in"),
    ("opens aside", within("joint_tool_tip", 'rpy="0 0', 'rpy="0 1.5'), "z of tool_tip in"),
    ("one axis", within("joint_finger_right", 'rpy="0 1', 'rpy="0 -1'), "allowed: (0, 0, -1)"),
    ("one jaw", within("joint_finger_right", "revolute", "fixed"), "allowed: revolute"),
    ("jaw aside", within("joint_finger_right", 'xyz="0', 'xyz="0.001'), "[0.001, -0.0115"),
    ("jaw off", within("joint_finger_right", "pitch_link", "tool0"), "] m of tool0"),
    ("mimic", within("joint_finger_right", "<axis", f"{MIMIC}<axis"), "mimic is joint_finger_left"),
    ("product", within("forearm_link", 'ixy="', 'ixy="0.1" x="'), "principal moments of inertia"),
]


@pytest.mark.parametrize(("text", "words"), [case[1:] for case in CASES], ids=[c[0] for c in CASES])
def test_each_damage_is_refused_with_the_place_the_value_and_what_is_allowed(text, words):
    with pytest.raises(RobotModelError, match=re.escape(words)):
        parse_robot(text)


def test_joints_of_other_parts_of_the_file_are_no_joints_of_the_robot():
    """A description of a real robot names its joints again among its transmissions."""
    extra = '<transmission name="t"><joint name="joint_1"><effort/></joint></transmission>'
    assert is_same(parse_robot(TEXT.replace("</robot>", f"{extra}</robot>")))


def test_a_file_that_is_no_text_is_refused_by_its_name(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_bytes(TEXT.encode()[:500] + b"\xff" + TEXT.encode()[500:])
    with pytest.raises(RobotModelError, match=r"arm\.urdf is not UTF-8"):
        load_robot(file)
