# SPDX-License-Identifier: BSD-3-Clause
"""How a launch file is called: unknown arguments and a missing address are refused by name."""

import os
import subprocess

import pytest

from tests.support.doc_lines import ROOT
from typed_config import ConfigError
from typed_config.launch_line import check_launch_line

LAUNCH = ROOT / "launch"
SYSTEM = LAUNCH / "system.launch"
HERE = {"ROS_IP": "127.0.0.1"}


def check(*words, file=SYSTEM, environment=HERE):
    check_launch_line(file, ["/usr/bin/python3", "/usr/bin/roslaunch", *words], environment)


@pytest.mark.parametrize("named", ["system.launch", str(SYSTEM)])
def test_a_misspelt_argument_is_refused_with_the_nearest(named):
    with pytest.raises(ConfigError, match=r"'profil'.*did you mean profile:="):
        check("voice_assist", named, "profil:=ada")


def test_an_argument_like_no_other_is_refused_with_all_of_them():
    with pytest.raises(ConfigError, match=r"'qqqq'.*gui.*controller_overrides"):
        check(str(SYSTEM), "qqqq:=1")


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("speak:=true", "alarms:=false"), "speak.*true.*only with alarms:=true"),
        (("display_port:=9999",), "display_port.*9999.*only with display:=true"),
        (("record:=false", "session:=today"), "session.*today.*only with record:=true"),
        (("wav:=/a.wav", "voice:=False"), "wav.*/a.wav.*only with voice:=true"),
        (("model_device:=cuda", "voice:=false"), "model_device.*cuda.*only with voice:=true"),
        (("candidates:=true", "voice:=false"), "candidates.*true.*only with voice:=true"),
    ],
)
def test_an_argument_of_a_part_that_is_not_started_is_refused(words, named):
    with pytest.raises(ConfigError, match=named):
        check("voice_assist", "system.launch", *words)


@pytest.mark.parametrize(
    "words",
    [
        (),
        ("profile:=ada", "config:=/a b/c"),
        ("__name:=x", "wav:=/tmp/profil:=.wav"),
        ("speak:=true",),
        ("speak:=false", "alarms:=false"),
        ("display_port:=9999", "display:=true"),
        ("session:=", "record:=false"),
        ("voice:=false",),
    ],
)
def test_arguments_of_ros_and_of_parts_that_are_started_pass(words):
    check("voice_assist", "system.launch", *words)


@pytest.mark.parametrize(
    ("name", "value"),
    [("gui", "true"), ("simulated_sensor", "robot/force"), ("simulation_overrides", "/a.yaml")],
)
def test_what_is_for_the_simulation_is_refused_on_the_real_arm(name, value):
    given = f"{name}:={value}"
    with pytest.raises(ConfigError, match=f"{name}.*{value}.*only with simulate:=true"):
        check("voice_assist", "kinova.launch", given, file=LAUNCH / "kinova.launch")
    check("voice_assist", "kinova.launch", given, "simulate:=true", file=LAUNCH / "kinova.launch")


def test_a_file_without_a_switch_for_the_simulation_takes_its_window():
    check("voice_assist", "system.launch", "gui:=true")


@pytest.mark.parametrize("caller", ["mine.launch", "voice.launch"])
def test_an_included_file_leaves_the_command_line_to_the_one_that_was_called(caller):
    check("mine", caller, "profil:=ada")


def test_a_file_of_the_same_name_elsewhere_is_another(tmp_path):
    other = tmp_path / "system.launch"
    other.write_text("<launch/>")
    check(str(other), "profil:=ada")


@pytest.mark.parametrize("environment", [{}, {"ROS_IP": ""}])
def test_without_an_address_nothing_is_launched(environment):
    with pytest.raises(ConfigError, match=r"ROS_IP is missing.*setup\.sh"):
        check("voice_assist", "system.launch", environment=environment)


def test_a_host_name_is_an_address_too():
    check("voice_assist", "system.launch", environment={"ROS_HOSTNAME": "robot"})


def test_every_launch_file_of_ours_asks_for_the_check_by_its_own_name():
    for file in LAUNCH.glob("*.launch"):
        assert f"--launch &quot;$(dirname)/{file.name}&quot;" in file.read_text("utf-8"), file.name


@pytest.mark.parametrize(("given", "shown"), [("", "127.0.0.1"), ("10.7.0.1", "10.7.0.1")])
def test_sourcing_the_workspace_sets_loopback_unless_an_address_is_given(given, shown):
    script = f'. {ROOT}/catkin_ws/devel/setup.sh; printf %s "$ROS_IP"'
    environment = {k: v for k, v in os.environ.items() if k not in ("ROS_IP", "ROS_HOSTNAME")}
    environment |= {"ROS_IP": given} if given else {}
    done = subprocess.run(
        ["sh", "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout == shown
