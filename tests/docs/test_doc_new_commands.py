# SPDX-License-Identifier: BSD-3-Clause
"""docs/how-to/add-a-command.md and other-words.md: what they type, and what is printed."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest

from rst_control.commands.camera_step import STEPS
from typed_config import load_config, load_yaml
from voice_assist.cli.main import main
from voice_assist.config import CONFIG_DIR, CommandsConfig
from voice_assist.intent.mapper import Mapper
from voice_assist.text.phonetic_distance import can_pronounce
from voice_assist.types import Match, NoMatch

ROOT = Path(__file__).resolve().parents[2]
NEW, MORE = (
    (ROOT / "docs" / "how-to" / f"{n}.md").read_text("utf-8")
    for n in ("add-a-command", "other-words")
)
PAGE = NEW + MORE
STEP = re.compile(
    r"<!-- (?P<verb>run|append|replace)(?:: (?P<what>[^>]*?))? -->"
    r"(?:\n```\w+\n(?P<text>.*?)```)?",
    re.DOTALL,
)


def steps():
    return [(m["verb"], m["what"] or "", m["text"] or "") for m in STEP.finditer(PAGE)]


def run(line, capsys):
    """Carry out a line of the page; gives how it ended and what it printed."""
    program, *arguments = shlex.split(line.replace("$(rospack find voice_assist)/config", "CONFIG"))
    if program == "cp":
        source, target = arguments[-2:]
        if source == "CONFIG":
            shutil.copytree(CONFIG_DIR, target)
        else:
            shutil.copy(source, target)
        return 0, ""
    assert program == "voice_assist", line
    code = 0
    try:
        main(arguments)
    except SystemExit as ended:
        code = int(ended.code or 0)
    return code, capsys.readouterr().out


@pytest.mark.skipif(not can_pronounce(), reason="the page's numbers are those of espeak-ng")
def test_every_line_of_the_page_does_what_the_page_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    ran = 0
    for verb, what, text in steps():
        if verb == "append":
            with Path(what).open("a") as file:
                file.write("\n" + text)
        elif verb == "replace":
            file, old, new = what.split(": ")
            Path(file).write_text(Path(file).read_text().replace(old, new))
        else:
            printed: list[str] = []
            for line in text.splitlines():
                if line.startswith("$ "):
                    code, out = run(line[2:], capsys)
                    assert code == int(what or 0), (line, out)
                    printed, ran = [p.rstrip() for p in out.splitlines()], ran + 1
                else:
                    assert line.rstrip() in printed, (line, printed)
    assert ran > 7


def test_the_table_of_the_endoscope_is_that_of_its_commands():
    commands = load_config(CommandsConfig, load_yaml(CONFIG_DIR / "endoscope_commands.yaml"))
    rows = re.findall(r"^\| ((?:go|upper|zoom).*?) \| (look .*?) \|", PAGE, re.MULTILINE)
    documented = {
        phrase: call
        for phrases, calls in rows
        for phrase, call in zip(phrases.split(", "), calls.split(", "), strict=True)
    }
    assert documented == {c.phrase: c.command for c in commands.commands if c.is_motion}
    assert set(documented.values()) == set(STEPS)


def test_what_is_no_direction_of_the_endoscope_is_no_command():
    commands = load_config(CommandsConfig, load_yaml(CONFIG_DIR / "endoscope_commands.yaml"))
    hear = Mapper(commands)
    for text in ("go", "left", "do not go left", "we go left at the corner", "zoom", "upper"):
        assert isinstance(hear(text), NoMatch), text
    assert isinstance(hear("Go left."), Match)


@pytest.mark.parametrize(
    ("mark", "file"),
    [
        ("nudge", "tests/unit/rst_control/support/nudge.py"),
        ("row", "tests/unit/rst_control/commands/test_new_command.py"),
    ],
)
def test_the_new_motion_of_the_page_is_the_one_that_a_test_carries_out(mark, file):
    shown = re.search(rf"<!-- {mark} -->\n```python\n(.*?)```", NEW, re.DOTALL)[1]
    assert shown.strip() in (ROOT / file).read_text("utf-8")


def test_the_how_to_is_short():
    assert len(NEW.split()) <= 600
