# SPDX-License-Identifier: BSD-3-Clause
"""What a replay decides otherwise than the recording, and what it refuses to replay."""

import errno
import os

import pytest
import yaml

from session_log.cli import main
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.recover import recover
from session_log.replay import replay
from support.story import Story
from tests.unit.session_log.support.fake_pipeline import MADE, PLANS
from tests.unit.session_log.support.voice_recording import (
    BLOCK,
    FACTS,
    SAME,
    SETTINGS,
    block,
    hears,
    note,
    ordinary,
    play,
    say,
    say_sound,
    write,
)
from typed_config import load_yaml


@pytest.fixture
def refusal(config, capsys):
    """What is said where nothing can be replayed."""

    def run(path):
        with pytest.raises(SystemExit) as end:
            main(["replay", str(path), "--config", str(config)])
        shown = capsys.readouterr()
        assert (end.value.code, shown.out) == (2, "")
        return shown.err

    return run


def test_the_same_decisions_give_zero_and_one_line(tmp_path, replayed):
    PLANS.append(SAME)
    code, out, err, result = replayed(ordinary(tmp_path / "session.mcap"))
    assert (code, err) == (0, "")
    assert out.count("\n") == 1 and "2 utterances in 10.0 s of sound, 2 now: the same" in out
    assert result["sessions"][0]["is_same"] and result["sessions"][0]["differences"] == []
    (pipeline,) = MADE
    assert pipeline.heard == list(range(0, 160_000, BLOCK))
    assert pipeline.settings == SETTINGS and pipeline.modes == []


def test_a_difference_is_shown_with_number_time_and_both_sides(tmp_path, replayed):
    other = hears(6.0, transcript="dense", command="", reason="too far", confidence=0.3)
    PLANS.append({**SAME, block(6.2): [other]})
    code, out, _, result = replayed(ordinary(tmp_path / "session.mcap"))
    assert code == 1 and "1 differ" in out
    assert "#2 at 6.20 s: transcript, command, confidence" in out
    assert "recorded  'tense': tense, WER 0.00, confidence 0.900, in active mode" in out
    assert "now       'dense': no command (too far), WER 0.00, confidence 0.300" in out
    (found,) = result["sessions"][0]["differences"]
    assert (found["number"], found["time"]) == (2, pytest.approx(6.2, abs=1e-3))
    assert found["recorded"]["transcript"] == "tense" and found["now"]["reason"] == "too far"


def test_what_is_not_heard_now_or_only_now_is_shown(tmp_path, replayed):
    PLANS.append({block(3.2): [hears(3.0)], block(8.0): [hears(8.0, command="stop")]})
    code, out, _, _ = replayed(ordinary(tmp_path / "session.mcap"))
    assert code == 1 and "2 differ" in out
    assert "#2 at 6.20 s: missing" in out and "after #2 at 8.20 s: extra" in out
    assert out.count("nothing") == 2


def test_a_recording_without_sound_is_an_error(tmp_path, replayed):
    story = Story()
    say(story, 3.0)
    path = write(tmp_path / "session.mcap", story)
    code, _, err, result = replayed(path)
    assert code == 2 and "holds no sound on /voice_assist/audio" in err
    assert list(result["failed"]) == [str(path)]


def test_sound_without_a_field_is_named_where_there_is_none_to_hear(tmp_path, replayed):
    story = Story()
    story.say(0.0, "/voice_assist/audio", "std_msgs/String", data="x")
    _, _, err, _ = replayed(write(tmp_path / "session.mcap", story))
    words = "/voice_assist/audio: std_msgs/String was recorded without 'first_sample'"
    assert f"holds no sound on /voice_assist/audio; {words}\n" in err


def test_a_missing_recording_and_an_empty_folder_are_errors(tmp_path, refusal):
    (tmp_path / "empty").mkdir()
    assert "no such file" in refusal(tmp_path / "none.mcap")
    assert "without any recording" in refusal(tmp_path / "empty")


def test_a_folder_with_a_copy_alone_holds_no_recording(tmp_path, refusal):
    (tmp_path / "a.mcap").mkdir()  # the original's name, and no recording
    (tmp_path / "a_recovered.mcap").write_bytes(b"a copy")
    assert "without any recording" in refusal(tmp_path)


def test_sound_that_the_pipeline_cannot_take_is_an_error(tmp_path, replayed):
    story = Story()
    say_sound(story, 0.0, 0, rate=8_000)
    code, _, err, _ = replayed(write(tmp_path / "session.mcap", story))
    assert code == 2 and "rate 8000 Hz, allowed: 16000" in err


@pytest.mark.parametrize(
    ("pipeline", "words"),
    [
        ("no_such_package.here:make", "cannot be imported"),
        ("json:no_such_function", "has no function 'no_such_function'"),
        ("json", "is no module and function"),
    ],
)
def test_a_pipeline_that_is_not_there_is_a_clear_error(tmp_path, config, refusal, pipeline, words):
    config.write_text(yaml.safe_dump({**load_yaml(config), "pipeline": pipeline}))
    assert words in refusal(ordinary(tmp_path / "session.mcap"))


def test_the_former_key_of_the_pipeline_is_refused_with_its_present_name(tmp_path, config, refusal):
    settings = dict(load_yaml(config))
    config.write_text(yaml.safe_dump({**settings, "hearer": settings.pop("pipeline")}))
    assert "its name is now pipeline" in refusal(ordinary(tmp_path / "session.mcap"))


@pytest.mark.parametrize(
    ("out", "words"),
    [("file/out.json", "Not a directory"), ("session.mcap", "it is a recording")],
)
def test_a_place_for_the_differences_is_tried_before_a_word_is_heard(
    tmp_path, config, capsys, out, words
):
    path = ordinary(tmp_path / "session.mcap")
    before = path.read_bytes()
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(SystemExit) as end:
        main(["replay", str(path), "--config", str(config), "--json", str(tmp_path / out)])
    assert end.value.code == 2 and MADE == [] and path.read_bytes() == before
    assert capsys.readouterr().err == f"session_log: cannot write {tmp_path / out}: {words}\n"


def test_a_name_that_the_system_refuses_is_an_error_and_no_difference(refusal):
    assert "File name too long" in refusal("x" * 5000)


def test_a_session_that_the_disk_does_not_give_fails_beside_the_others(
    tmp_path, replayed, monkeypatch
):
    broken = ordinary(tmp_path / "many" / "a" / "session.mcap")
    ordinary(tmp_path / "many" / "b" / "session.mcap")
    read_voice = replay.read_voice

    def read(reader, config):
        if reader.path == broken:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return read_voice(reader, config)

    monkeypatch.setattr(replay, "read_voice", read)
    PLANS.append(SAME)
    code, _, err, result = replayed(tmp_path / "many")
    assert code == 2 and len(result["sessions"]) == 1
    assert list(result["failed"]) == [str(broken)]
    assert f"{broken}: cannot be heard again" in err and "Input/output error" in err


def test_a_recording_that_grows_by_a_run_while_it_is_read_is_an_error(
    tmp_path, replayed, monkeypatch
):
    story = Story()
    play(story, 0.0, 1.0)
    play(story, 0.0, 1.0, start=2.0)
    path = write(tmp_path / "session.mcap", story)
    read_voice = replay.read_voice

    def read_before(reader, config):
        voice = read_voice(reader, config)
        voice.runs.pop()
        return voice

    monkeypatch.setattr(replay, "read_voice", read_before)
    code, _, err, result = replayed(path)
    assert code == 2 and list(result["failed"]) == [str(path)]
    assert "cannot be heard again: it grew while it was read" in err


# --- models


def test_another_model_than_the_recorded_one_is_a_warning(tmp_path, replayed):
    PLANS.append(SAME)
    facts = {**FACTS, "model_sha256": "ef" * 32}
    code, _, err, _ = replayed(ordinary(tmp_path / "session.mcap", facts=facts))
    assert code == 0
    assert "warning: model 'embedded' is another than the recorded one: abab" in err


def test_a_model_that_was_asked_for_is_none(tmp_path, replayed):
    PLANS.append(SAME)
    path = ordinary(tmp_path / "session.mcap")
    code, out, err, _ = replayed(path, "--model", "base.en")
    assert (code, err) == (0, "") and "(model base.en)" in out


def test_a_recording_that_does_not_name_its_model_is_a_warning(tmp_path, replayed):
    PLANS.append(SAME)
    code, _, err, _ = replayed(ordinary(tmp_path / "session.mcap", facts={}))
    assert code == 0 and "which one it was is not recorded" in err


# --- runs of the node, and folders


def test_a_node_that_was_started_anew_is_heard_by_a_new_pipeline(tmp_path, replayed):
    story = Story()
    play(story, 0.0, 5.0)
    note(story, 4.0, "heard 60000")
    play(story, 0.0, 5.0, start=8.0)
    note(story, 12.0, "lost 512")
    say(story, 10.0)
    PLANS.extend([{}, {block(2.2): [hears(10.0)]}])
    code, out, _, _ = replayed(write(tmp_path / "session.mcap", story))
    assert code == 0, out
    first, second = MADE
    assert first.notes == ["heard 60000"] and second.notes == ["lost 512"]
    assert second.heard[0] == 0 and "lost:" not in out


@pytest.mark.parametrize(("plan", "status"), [(SAME, 0), ({}, 1)])
def test_a_recovered_copy_that_is_named_is_replayed(tmp_path, replayed, plan, status):
    original = ordinary(tmp_path / "session.mcap")
    copy = original.with_name("session_recovered.mcap")
    recover(SessionReader(original), copy)
    PLANS.append(plan)
    code, out, _, _ = replayed(copy)
    assert code == status and f"{copy}: 2 utterances in 10.0 s" in out and len(MADE) == 1


def test_a_folder_is_heard_session_by_session_with_a_total(tmp_path, replayed):
    for name in ("a", "b", "c"):
        ordinary(tmp_path / "many" / name / "session.mcap")
    (tmp_path / "many" / "a" / "session_recovered.mcap").write_bytes(b"a copy")
    PLANS.extend([SAME, {}, SAME])
    code, out, _, result = replayed(tmp_path / "many")
    assert code == 1 and len(result["sessions"]) == 3
    assert "total: 2 of 3 sessions the same, 2 differences in 6 utterances" in out


def test_a_session_that_fails_does_not_keep_the_others_from_being_heard(tmp_path, replayed):
    ordinary(tmp_path / "many" / "a" / "session.mcap")
    (tmp_path / "many" / "b.mcap").write_bytes(b"no recording")
    ordinary(tmp_path / "many" / "c" / "session.mcap")
    PLANS.extend([SAME, SAME])
    code, out, err, result = replayed(tmp_path / "many")
    assert code == 2 and len(result["sessions"]) == 2
    assert "is not an MCAP recording" in err and "1 sessions failed" in out
