# SPDX-License-Identifier: BSD-3-Clause
"""Every launch reads its settings files strictly before roslaunch takes what is left of them."""

import shlex
from pathlib import Path
from xml.etree import ElementTree

import pytest
from roslaunch import RLException
from roslaunch.config import load_config_default

from typed_config.check import main

LAUNCH = Path(__file__).resolve().parents[2] / "launch"
WITH_SETTINGS = sorted(
    file.name for file in LAUNCH.glob("*.launch") if 'rosparam command="load"' in file.read_text()
)
DOUBLED = "controller:\n  tension:\n    maximum: 2.0\n  tension:\n    noise: 0.01\n"
SAID = "overrides.yaml: controller.tension is 'given in line 2 and again in line 4"


@pytest.mark.parametrize("name", WITH_SETTINGS)
def test_every_file_that_is_loaded_was_checked(name):
    tree = ElementTree.parse(LAUNCH / name)
    loaded = {e.get("file") for e in tree.iter("rosparam") if e.get("command") == "load"}
    checks = [e.get("command") for e in tree.iter("param") if "check_settings" in str(e.attrib)]
    assert len(checks) == 1
    command, _, own, *files = shlex.split(checks[0].replace("$(find ", "$(find:"))
    assert command == "$(find:typed_config)/check_settings"
    assert own == f"$(dirname)/{name}"
    assert set(files) == {file.replace("$(find ", "$(find:") for file in loaded}


def test_a_key_given_twice_ends_the_launch_with_key_and_lines(tmp_path, capfd):
    overrides = tmp_path / "overrides.yaml"
    overrides.write_text(DOUBLED, encoding="utf-8")
    with pytest.raises(RLException, match="check_settings"):
        load_config_default(
            [(str(LAUNCH / "controller.launch"), [f"overrides:={overrides}"])], None, verbose=False
        )
    assert SAID in capfd.readouterr().err


def test_good_files_are_counted_and_a_bad_one_is_named(tmp_path, capsys):
    good, bad = tmp_path / "good.yaml", tmp_path / "bad.yaml"
    good.write_text("a: 1\n", encoding="utf-8")
    bad.write_text("a: 1\nb: 2", encoding="utf-8")
    main([str(good)])
    assert capsys.readouterr().out == "1 files\n"
    with pytest.raises(SystemExit, match="2"):
        main([str(good), str(bad)])
    assert "cut off behind 'b: 2'" in capsys.readouterr().err
