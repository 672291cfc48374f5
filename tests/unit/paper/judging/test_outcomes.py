# SPDX-License-Identifier: BSD-3-Clause
import math
from dataclasses import replace

import numpy as np
import pytest
import soundfile

from paper.judging import truth
from paper.judging.outcomes import judge, kept, outcome
from paper.judging.trials import FILE, SpokenTrial, append, read
from session_log.cli import CONFIG
from session_log.config import ReportConfig
from session_log.report.session.analysis import CommandRow
from session_log.report.session.session_data import RecordedUtterance
from support.story import write_session
from support.story_script import SPEECH, START
from typed_config import load_file

REPORT = load_file(ReportConfig, CONFIG)
TRIAL = SpokenTrial(1, "pull more", "pull more", "1.wav", 0.0, 1.0, 1.0, 0.5, True, "")
END = 0.8  # [s] of the sound


def row(decided, command="pull more", result="accepted", message="", action=None):
    heard = RecordedUtterance(0.1, 0.9, decided, command, command, "", command, 0.0, False)
    return CommandRow(command, heard, decided + 0.01, result, message, action)


def test_times_count_from_the_end_of_the_sound_not_from_the_detector():
    result = outcome(TRIAL, END, [row(1.2, action=1.5)])
    assert result.is_correct and result.taken == ("pull more",)
    assert result.decided == pytest.approx(0.4)
    assert result.acted == pytest.approx(0.7)


def test_a_decision_before_the_end_of_the_sound_has_a_negative_time():
    assert outcome(TRIAL, END, [row(0.7)]).decided == pytest.approx(-0.1)


def test_a_refused_command_is_heard_but_not_acted_on():
    result = outcome(TRIAL, END, [row(1.2, result="refused", message="tension limit")])
    assert result.is_correct and result.refusal == "tension limit"
    assert math.isnan(result.acted)


def test_a_command_taken_for_another_is_wrong_and_has_no_times():
    result = outcome(TRIAL, END, [row(1.2, "pull less", action=1.3)])
    assert not result.is_correct and result.taken == ("pull less",)
    assert math.isnan(result.decided) and math.isnan(result.acted)


def test_a_second_command_from_one_phrase_is_wrong():
    assert not outcome(TRIAL, END, [row(1.2), row(1.6, "stop")]).is_correct


def test_talk_is_right_when_nothing_is_taken():
    talk = replace(TRIAL, command="", words="rowboat")
    assert outcome(talk, END, []).is_correct
    assert not outcome(talk, END, [row(1.2, "hey robot")]).is_correct


def test_sound_that_was_torn_apart_is_marked():
    result = outcome(TRIAL, math.nan, [row(1.2)])
    assert not result.is_whole and math.isnan(result.decided)


def test_the_phrases_of_a_recording_get_the_commands_of_their_own_time(tmp_path, monkeypatch):
    write_session(tmp_path / "session.mcap", rate=1)
    zero = START * 1e-9
    for index, (begin, length, words, command, _) in enumerate(SPEECH):
        name = f"{index}.wav"
        soundfile.write(tmp_path / name, np.zeros(160), 16_000)
        began, ended = zero + begin - 0.1, zero + begin + length
        append(tmp_path, SpokenTrial(index, command, words, name, began, ended, 1, 0.5, True, ""))
    ends = iter([t.ended for t in read(tmp_path)])
    monkeypatch.setattr(
        truth, "find", lambda *_: truth.Sounded(begin=0.0, end=next(ends), likeness=1.0)
    )
    found = judge(tmp_path, REPORT)
    assert all(o.is_correct for o in found)
    assert all(0.2 < o.decided < 0.4 for o in found if o.command)
    assert [o.refusal for o in found if o.refusal] == ["tissue is held already"]
    assert kept(tmp_path)[0] == found[0]


def test_trials_come_back_as_they_were_kept(tmp_path):
    assert read(tmp_path) == []
    append(tmp_path, TRIAL)
    append(tmp_path, replace(TRIAL, index=2, interrupts="tense"))
    assert read(tmp_path) == [TRIAL, replace(TRIAL, index=2, interrupts="tense")]


def test_half_a_last_line_of_a_killed_session_is_left_out(tmp_path):
    append(tmp_path, TRIAL)
    append(tmp_path, replace(TRIAL, index=2))
    path = tmp_path / FILE
    path.write_bytes(path.read_bytes()[:-20])
    assert read(tmp_path) == [TRIAL]
