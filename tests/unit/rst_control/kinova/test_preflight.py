# SPDX-License-Identifier: BSD-3-Clause
"""What launch/kinova.launch refuses to start without."""

import math

import pytest
import yaml

from rst_control.config import CONFIG_FOLDER
from rst_control.kinova.preflight import NotReady, check, main
from support.documents.release import version
from tests.support.other_tool import tool_beside
from typed_config import ConfigError, load_yaml

LIMITS, SCENE = CONFIG_FOLDER / "kinova_limits.yaml", CONFIG_FOLDER / "scene.yaml"
TROCAR = (0.406, -0.024, 0.415)
SWITCHES = ("--simulate", "false", "--in-air", "false", "--dry-run", "true")
ARGUMENTS = (
    *(*SWITCHES, "--trocar", "0.406 -0.024 0.415"),
    *("--limits", str(LIMITS), "--scene", str(SCENE), "--speed-scale", "0.1"),
)


@pytest.fixture
def refused(capsys):
    """Starts with options that must be refused; gives the words."""

    def start(*options):
        with pytest.raises(SystemExit) as ended:
            main(["--emergency-stop", "true", *ARGUMENTS, *options])
        assert ended.value.code == 2
        return capsys.readouterr().err

    return start


def test_what_is_complete_may_start():
    words = check(True, False, TROCAR, LIMITS, SCENE, 0.1)
    assert words == "the real robot, limits kinova, speeds times 0.1"


@pytest.mark.parametrize(
    ("trocar", "words"),
    [
        ("0.406 -2.4e-05 0.415", "past the trocar"),
        ("-2.4e-05 0.406 0.415", "past the trocar"),
        ("0.406 -0.024", "'0.406 -0.024', allowed: three numbers, x y z"),
        ("406 -24 415", "'406', allowed: -1.6 to 1.6 m"),
        ("0.406 zero 0.415", "'zero', allowed: -1.6 to 1.6 m"),
    ],
)
def test_a_trocar_is_three_numbers_as_a_program_prints_them(refused, trocar, words):
    assert words in refused(f"--trocar={trocar}")


def test_a_simulation_needs_no_emergency_stop():
    assert "simulated" in check(False, True, TROCAR, LIMITS, SCENE, 1.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"has_stop": False}, "i_have_an_emergency_stop:=true"),
        ({"trocar": (406.0, -24.0, 415.0)}, "from base_link, allowed up to 1.6 m"),
        ({"trocar": (float("nan"), 0.0, 0.4)}, "from base_link"),
        ({"trocar": (0.426, -0.024, 0.415)}, "leads the shaft 17.0 mm past the trocar"),
        ({"scale": 0.0}, "speed_scale is 0, allowed above 0"),
        ({"scale": 1.5}, "speed_scale is 1.5"),
        ({"scale": float("nan")}, "speed_scale is nan"),
    ],
)
def test_what_is_missing_is_named(changes, words):
    given = {
        "has_stop": True,
        "is_simulated": False,
        "trocar": TROCAR,
        "limits": LIMITS,
        "scene": SCENE,
        "scale": 0.1,
    }
    with pytest.raises(NotReady) as refused:
        check(**{**given, **changes})
    assert words in str(refused.value)


@pytest.mark.parametrize(
    ("joint", "words"),
    [
        (1, "joint_2 at 5.966 rad, allowed -2.240 to 2.240 rad"),
        (6, "joint_7 at 4.606 rad, allowed -3.142 to 3.142 rad"),
    ],
)
def test_a_home_in_the_angles_of_the_web_page_is_named(tmp_path, joint, words):
    data = load_yaml(SCENE)
    reported = data["home"][joint]
    data["home"][joint] = reported + 2 * math.pi
    scene = tmp_path / "scene.yaml"
    scene.write_text(yaml.safe_dump(data))
    with pytest.raises(NotReady) as refused:
        check(True, False, TROCAR, LIMITS, scene, 0.1)
    assert words in str(refused.value)
    assert f"the driver reports {reported:.3f} rad" in str(refused.value)


def test_a_limits_file_that_is_none_is_refused(tmp_path):
    with pytest.raises(ConfigError):
        check(True, False, TROCAR, tmp_path / "none.yaml", SCENE, 0.1)
    with pytest.raises(ConfigError):
        check(True, False, TROCAR, SCENE, SCENE, 0.1)


def test_limits_beyond_the_ranges_of_the_joints_are_named(tmp_path, refused):
    wide = tmp_path / "wide.yaml"
    settings = load_yaml(LIMITS)
    settings["arm_lower"][1] = -2.5
    wide.write_text(yaml.safe_dump(settings))
    words = refused("--limits", str(wide))
    assert "limits of joint_2 from -2.5 to" in words and "its range in the URDF" in words


def test_home_is_checked_with_the_tool_that_is_described(tmp_path, refused):
    urdf = tmp_path / "beside.urdf"
    urdf.write_text(tool_beside(0.01))
    with pytest.raises(NotReady, match=r"leads the shaft 10\.\d mm past the trocar"):
        check(True, False, TROCAR, LIMITS, SCENE, 0.1, urdf)
    (tmp_path / "text.urdf").write_text("no robot")
    for name, words in (("text.urdf", "URDF"), ("none.urdf", "No such file")):
        assert words in refused("--urdf", str(tmp_path / name))


def test_the_launch_hears_of_it_by_the_exit_status(refused, capsys):
    assert "does not start" in refused("--emergency-stop", "false")
    main(["--emergency-stop", "true", *ARGUMENTS])
    assert "the real robot" in capsys.readouterr().out


@pytest.mark.parametrize("value", ["no", "0", "1", "", "false ", "yes"])
@pytest.mark.parametrize(
    ("option", "name"),
    [
        ("--emergency-stop", "i_have_an_emergency_stop"),
        ("--simulate", "simulate"),
        ("--in-air", "in_air"),
        ("--dry-run", "dry_run"),
    ],
)
def test_a_switch_that_says_neither_true_nor_false_is_refused(refused, option, name, value):
    words = f"kinova.launch does not start: {name} is '{value}', allowed: true or false"
    assert refused(option, value).strip() == words


@pytest.mark.parametrize("value", ["True", "TRUE", "False", "FALSE"])
def test_switches_are_taken_in_letters_of_any_case(capsys, value):
    main(["--emergency-stop", "True", *ARGUMENTS, "--in-air", value, "--dry-run", value])
    assert "the real robot" in capsys.readouterr().out


def test_it_names_its_version(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"kinova_preflight {version()}\n"
