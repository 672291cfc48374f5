# SPDX-License-Identifier: BSD-3-Clause
"""The alarms in the documentation, on the screen and in the settings are those of the code."""

from itertools import pairwise
from pathlib import Path

import pytest
from rich.console import Console

from typed_config import load_file
from voice_assist.alarms.appearance import APPEARANCES, SYMBOLS, headline, is_lit, line
from voice_assist.alarms.catalogue import ENTRIES, markdown
from voice_assist.alarms.earcons import PATTERNS
from voice_assist.alarms.presenter import latch_alarm
from voice_assist.alarms.screen import AlarmScreen
from voice_assist.alarms.types import Earcon, Kind, Priority
from voice_assist.cli.main import main
from voice_assist.config.alarms import FILE, AlarmsConfig

ROOT = Path(__file__).resolve().parents[4]
STOP = latch_alarm("stopped by voice", "stop_topic", is_loaded=False)
FAULT = latch_alarm("tension 2.50 N, allowed 2.40 N", "over_tension", is_loaded=True)


def test_the_command_prints_these_tables(capsys):
    main(["alarms", "--markdown"])
    assert capsys.readouterr().out == markdown() + "\n"


def test_the_catalogue_shows_every_sound_once():
    assert [entry.earcon for entry in ENTRIES] == list(Earcon)
    assert all(e.example.priority is PATTERNS[e.earcon].priority for e in ENTRIES)


def test_the_documentation_claims_no_conformity():
    words = (ROOT / "docs" / "reference" / "alarms.md").read_text(encoding="utf-8")
    assert "no conformity with it is claimed" in words


def test_kinds_and_priorities_differ_without_colour():
    assert len({SYMBOLS[kind] for kind in Kind}) == len(Kind)
    lines = {headline(entry.example) for entry in ENTRIES}
    alarms = [e for e in ENTRIES if e.example.kind is not Kind.NOTICE]
    assert len(lines) >= len(alarms) + 1


def test_a_line_names_kind_priority_cause_and_next_step():
    assert line(FAULT) == (
        '▲ FAULT !!! HIGH: tension 2.50 N, allowed 2.40 N -> Say "hey robot", then "release".'
    )


@pytest.mark.parametrize("priority", Priority)
def test_flashing_is_as_fast_as_the_priority_asks(priority):
    times = [i / 100 for i in range(1000)]
    lit = [is_lit(priority, time) for time in times]
    begins = sum(1 for a, b in pairwise(lit) if b and not a)
    usual = {Priority.HIGH: (1.4, 2.8), Priority.MEDIUM: (0.4, 0.8)}  # [Hz] IEC 60601-1-8
    low, high = usual.get(priority, (0.0, 0.0))
    assert low * 10 - 1 <= begins <= high * 10
    assert APPEARANCES[priority].flashes == 0.0 or 0.4 < sum(lit) / len(lit) < 0.6


def shown(screen):
    console = Console(width=120, record=True, file=open("/dev/null", "w"))  # noqa: SIM115, PTH123
    console.print(screen)
    return console.export_text()


def test_the_screen_shows_what_stands_what_else_and_what_was():
    screen = AlarmScreen(lambda: 1_700_000_000.0)
    screen.show(STOP, False, ())
    screen.show(FAULT, True, (line(STOP),))
    words = shown(screen)
    assert "FAULT !!! HIGH (acknowledged)" in words and "next: Say" in words
    assert "also: ■ STOP" in words
    screen.show(None, False, ())
    words = shown(screen)
    assert "all is well" in words and "STOP !! MEDIUM" in words  # in the past


def test_the_screen_says_that_all_is_well_only_on_the_alarm_nodes_word():
    screen = AlarmScreen(lambda: 1_700_000_000.0)
    assert "no word from the alarm node" in shown(screen) and "well" not in shown(screen)
    screen.show(None, False, ())
    assert "all is well" in shown(screen) and "no word" not in shown(screen)
    screen.show(FAULT, False, (line(STOP),))
    screen.lose()
    words = shown(screen)
    assert "no word from the alarm node" in words
    assert "well" not in words and "next:" not in words and "also:" not in words
    screen.show(None, False, ())
    assert "all is well" in shown(screen)


def test_bursts_repeat_within_the_usual_pauses():
    sound = load_file(AlarmsConfig, FILE).sound
    assert 2.5 <= sound.repeat_high <= 15.0 and 2.5 <= sound.repeat_medium <= 30.0
    assert sound.repeat_high < sound.repeat_medium
