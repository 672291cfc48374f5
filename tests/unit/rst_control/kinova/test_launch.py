# SPDX-License-Identifier: BSD-3-Clause
"""launch/kinova.launch: nothing starts where something is missing; what is given takes effect."""

from contextlib import nullcontext
from pathlib import Path

import pytest
from roslaunch import RLException
from roslaunch.config import load_config_default

from rst_control.config import CONFIG_FOLDER
from tests.support.launch_reading import commands_here, read

FILE = Path(__file__).resolve().parents[4] / "launch" / "kinova.launch"
TROCAR = ["trocar_x:=0.406", "trocar_y:=-0.024", "trocar_z:=0.415"]
LIMITS = [f"limits:={CONFIG_FOLDER / 'kinova_limits.yaml'}"]
STOP = ["i_have_an_emergency_stop:=true"]
QUIET = ["voice:=false", "alarms:=false", "record:=false"]


def given_by(*arguments):
    """What would be set and started; the checks of that are not run."""
    return read([str(FILE), *arguments, *QUIET])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (LIMITS + STOP, "trocar_x"),
        (TROCAR[1:] + LIMITS + STOP, "trocar_x"),
        (TROCAR[:2] + LIMITS + STOP, "trocar_z"),
        (TROCAR + STOP, "limits"),
        (TROCAR + LIMITS, "kinova_preflight"),
        ([*TROCAR, *LIMITS, "i_have_an_emergency_stop:=false"], "kinova_preflight"),
        (TROCAR + LIMITS + STOP + ["speed_scale:=3"], "kinova_preflight"),
        (TROCAR + LIMITS + STOP + ["in_air:=no"], "kinova_preflight"),
        (TROCAR + LIMITS + STOP + ["dry_run:=0"], "kinova_preflight"),
    ],
)
def test_it_does_not_start_without(arguments, words):
    with commands_here(), pytest.raises(RLException, match=words):
        load_config_default([(str(FILE), [*arguments, *QUIET])], None, verbose=False)


def test_the_program_itself_ends_the_launch():
    with pytest.raises(RLException, match="kinova_preflight"):
        load_config_default([(str(FILE), [*TROCAR, *LIMITS, *QUIET])], None, verbose=False)


@pytest.mark.parametrize("y", ["-2.4e-05", "8e-05", "-0.00002"])
def test_a_trocar_of_hundredths_of_a_millimetre_is_taken_as_a_program_prints_it(y):
    given = TROCAR[0], f"trocar_y:={y}", TROCAR[2], *LIMITS, *STOP, "simulate:=true"
    value = given_by(*given).parameters
    assert value["/controller/scene/trocar"] == [0.406, float(y), 0.415]
    assert value["/robot/scene/trocar"] == [0.406, float(y), 0.415]


def test_a_first_start_is_slow_and_asks():
    found = given_by(*TROCAR, *LIMITS, *STOP)
    value = found.parameters
    assert value["/controller/controller/speed/scale"] == 0.1
    assert value["/controller/controller/first_motion"] == "confirmed"
    assert value["/controller/scene/trocar"] == [0.406, -0.024, 0.415]
    assert value["/controller/limits/layer"] == "kinova"
    assert value["/kinova_bridge/limits/layer"] == "kinova"
    assert {"/controller", "/kinova_bridge", "/kinova_guard"} <= set(found.nodes)
    assert "/robot" not in found.nodes  # that is hardware


def test_what_is_given_counts():
    found = given_by(
        *TROCAR, *LIMITS, "simulate:=true", "speed_scale:=0.5", "dry_run:=false", "arm:=a"
    )
    value = found.parameters
    assert value["/controller/controller/speed/scale"] == 0.5
    assert value["/controller/controller/first_motion"] == "free"
    assert value["/kinova_bridge/bridge/arm/namespace"] == "a"
    assert value["/kinova_guard/bridge/arm/namespace"] == "a"
    assert "/robot" in found.nodes


@pytest.mark.parametrize(
    ("given", "arm", "tool"),
    [
        (["simulate:=true"], ["/robot"], ["/robot"]),
        (STOP, ["/a/*"], ["/t/*"]),
        ([*STOP, "simulate:=false"], ["/a/*"], ["/t/*"]),
    ],
)
def test_either_the_simulated_robot_is_believed_or_the_drivers(given, arm, tool):
    value = given_by(*TROCAR, *LIMITS, *given, "arm:=a", "tool:=t").parameters
    for node in ("kinova_bridge", "kinova_guard"):
        assert value[f"/{node}/bridge/believed/arm"] == arm
    assert value["/kinova_bridge/bridge/believed/tool"] == tool


def test_a_guard_on_another_host_hears_the_drivers_alone():
    value = read([str(FILE.with_name("kinova_guard.launch")), "arm:=a"]).parameters
    assert value["/kinova_guard/bridge/believed/arm"] == ["/a/*"]


@pytest.mark.parametrize(
    ("true", "false", "checks"),
    [("True", "FALSE", nullcontext), ("TRUE", "False", commands_here)],
)
def test_true_and_false_are_taken_in_letters_of_any_case(true, false, checks):
    given = [*TROCAR, *LIMITS, *QUIET, f"simulate:={true}", f"in_air:={false}", f"dry_run:={true}"]
    with checks():
        value = read([str(FILE), *given], runs_commands=True).parameters
    assert value["/controller/controller/homing"] == "outside"
    assert value["/controller/controller/first_motion"] == "confirmed"


@pytest.mark.parametrize("name", ["in_air", "dry_run", "simulate", "i_have_an_emergency_stop"])
@pytest.mark.parametrize("value", ["", "false "])
def test_a_file_that_includes_it_cannot_leave_a_switch_open(tmp_path, capfd, name, value):
    """On a command line, roslaunch itself strips values, and passes over empty ones."""
    given = dict(word.split(":=") for word in (*TROCAR, *LIMITS, *STOP, *QUIET, f"{name}:={value}"))
    arguments = "".join(f'<arg name="{key}" value="{given[key]}"/>' for key in given)
    own = tmp_path / "own.launch"
    own.write_text(f'<launch><include file="{FILE}">{arguments}</include></launch>')
    with commands_here(), pytest.raises(RLException, match="kinova_preflight"):
        load_config_default([(str(own), [])], None, verbose=False)
    assert f"start: {name} is '{value}', allowed: true or false" in capfd.readouterr().err


def test_other_settings_of_the_bridge_count_for_its_guard_too():
    overrides = Path(__file__).parents[3] / "rostest" / "kinova" / "kinova_bridge.yaml"
    value = given_by(*TROCAR, *LIMITS, *STOP, f"bridge_overrides:={overrides}").parameters
    assert value["/kinova_bridge/bridge/guard/silence"] == 0.8
    assert value["/kinova_guard/bridge/guard/silence"] == 0.8
