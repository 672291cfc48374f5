# SPDX-License-Identifier: BSD-3-Clause
import json
import re

import pytest
import yaml
from mcap.reader import make_reader

from session_log.cli import main
from session_log.mcap_file.writer import SessionWriter
from session_log.replay.command import REPLAY_CONFIG
from support.story import START, Story, numbered
from tests.unit.session_log.support import fake_pipeline
from tests.unit.session_log.support.fake_pipeline import MADE, PLANS, utterance
from typed_config import load_yaml

BLOCK = 512
ZERO = START * 1e-9  # [s] of the clock
FACTS = {"model": "embedded", "model_sha256": "ab" * 32, "spotter_sha256": ""}
SETTINGS = {"recognizer": {"model": "embedded"}}
ACTIVE = {"mode": "active", "reason": "hey robot"}


@pytest.fixture(autouse=True)
def nothing_left():
    MADE.clear()
    PLANS.clear()


@pytest.fixture
def config(tmp_path):
    """The settings with a pipeline that does what the test says."""
    path = tmp_path / "replay.yaml"
    data = {**load_yaml(REPLAY_CONFIG), "pipeline": f"{fake_pipeline.__name__}:make"}
    path.write_text(yaml.safe_dump(data))
    return path


@pytest.fixture
def replayed(tmp_path, config, capsys):
    def run(*words):
        out = tmp_path / "result.json"
        given = ["replay", *map(str, words), "--config", str(config), "--json", str(out)]
        with pytest.raises(SystemExit) as end:
            main(given)
        shown = capsys.readouterr()
        return end.value.code, shown.out, shown.err, json.loads(out.read_text())

    return run


@pytest.fixture
def refusal(config, capsys):
    """What is said where nothing can be replayed."""

    def run(path):
        with pytest.raises(SystemExit) as end:
            main(["replay", str(path), "--config", str(config)])
        assert end.value.code == 2
        return capsys.readouterr().err

    return run


def say(story, end, **changes):
    """A recorded utterance that ended at a time of the session [s]."""
    u = utterance(end, **changes)
    fields = {
        name: getattr(u, name) for name in ("transcript", "command", "reason", "nearest_command")
    }
    fields |= {
        name: getattr(u, name) for name in ("confidence", "mode", "decided_by", "is_partial")
    }
    fields |= {n: float(getattr(u, n)) for n in ("speech_start", "speech_end", "decision")}
    wer = {"phrases": list(u.wer), "wer": list(u.wer.values())}
    topic = "/voice_assist/utterance"
    story.say(u.decision + 0.01, topic, "voice_assist/Utterance", **fields, **wer)


def hears(end, **changes):
    """What the pipeline decides now about speech that ended at a time of the session [s]."""
    return utterance(ZERO + end, **changes)


def play(story, begin, end, start=0.0, skip=()):
    """Sound of a run of the node that began at `start`; blocks of the session's time [s]."""
    for first in range(round(begin * 16_000) // BLOCK * BLOCK, round(end * 16_000), BLOCK):
        if first not in skip:
            fields = {"rate": 16_000, "first_sample": first, "samples": [1] * BLOCK}
            time = start + first / 16_000
            story.say(time, "/voice_assist/audio", "voice_assist/AudioChunk", **fields)


def note(story, time, text):
    story.say(time, "/voice_assist/circumstances", "std_msgs/String", data=text)


def write(path, story, facts=FACTS, settings=SETTINGS, drop=()):
    """Write a session; messages with the given numbers in order of time are lost from the file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with SessionWriter(path) as writer:
        writer.add_metadata("session/voice_assist", facts)
        writer.add_metadata("parameters", {"voice_assist": yaml.safe_dump(settings)})
        ordered = numbered(sorted(story.messages, key=lambda m: m.log_time))
        for number, message in enumerate(ordered):
            if number not in drop:
                writer.add(message)
                writer.commit()
    return path


def block(time):
    """First sample of the block at a time [s]."""
    return round(time * 16_000) // BLOCK * BLOCK


def ordinary(path, **options):
    """Ten seconds, in which "tense" was said twice."""
    story = Story()
    play(story, 0.0, 10.0)
    say(story, 3.0)
    say(story, 6.0)
    return write(path, story, **options)


SAME = {block(3.2): [hears(3.0)], block(6.2): [hears(6.0)]}


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


def test_a_missing_recording_and_an_empty_folder_are_errors(tmp_path, refusal):
    (tmp_path / "empty").mkdir()
    assert "no such file" in refusal(tmp_path / "none.mcap")
    assert "without any recording" in refusal(tmp_path / "empty")


def test_sound_that_the_pipeline_cannot_take_is_an_error(tmp_path, replayed):
    story = Story()
    fields = {"rate": 8_000, "first_sample": 0, "samples": [0] * BLOCK}
    story.say(0.0, "/voice_assist/audio", "voice_assist/AudioChunk", **fields)
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


# --- what is lost


def test_sound_lost_from_the_file_is_said_and_what_follows_it_is_not_counted(tmp_path, replayed):
    story = Story()
    story.say(2.0, "/voice_assist/mode", "voice_assist/Mode", **ACTIVE)
    play(story, 0.0, 20.0)
    say(story, 5.0)
    say(story, 18.0)
    ordered = sorted(story.messages, key=lambda m: m.log_time)
    gone = [k for k, m in enumerate(ordered) if 4.0 <= (m.log_time - START) * 1e-9 < 6.0]
    PLANS.append({block(7.0): [hears(7.0)], block(18.2): [hears(18.0)]})
    path = write(tmp_path / "session.mcap", story, drop=gone)
    code, out, _, result = replayed(path)
    assert code == 0
    assert "lost: 1 utterances that were recorded" in out
    assert "lost: 2.02 s of sound in front of sample 96256" in out
    (found,) = result["sessions"][0]["differences"]
    assert found["excuse"].endswith("is lost") and found["kinds"] == ["extra"]
    (mode,) = MADE[0].modes
    assert mode[1:] == ("active", "hey robot")


def test_a_difference_long_after_lost_sound_counts(tmp_path, replayed):
    story = Story()
    play(story, 0.0, 20.0)
    say(story, 18.0)
    ordered = sorted(story.messages, key=lambda m: m.log_time)
    gone = [k for k, m in enumerate(ordered) if 4.0 <= (m.log_time - START) * 1e-9 < 6.0]
    code, out, _, _ = replayed(write(tmp_path / "session.mcap", story, drop=gone))
    assert code == 1 and "#1 at 18.20 s: missing\n" in out


def test_a_gap_that_the_node_had_too_is_no_loss(tmp_path, replayed):
    story = Story()
    skip = range(block(4.0), block(5.0), BLOCK)
    play(story, 0.0, 10.0, skip=skip)
    note(story, 5.1, f"lost {block(5.0)}")
    note(story, 9.9, "heard 159000")
    PLANS.append({block(6.0): [hears(6.0)]})
    code, out, _, _ = replayed(write(tmp_path / "session.mcap", story))
    assert code == 1 and "lost:" not in out and "after #0 at 6.20 s: extra\n" in out
    assert MADE[0].modes == []


def test_a_recording_that_begins_late_says_so_and_takes_the_mode(tmp_path, replayed):
    story = Story()
    story.say(0.5, "/voice_assist/mode", "voice_assist/Mode", **ACTIVE)
    play(story, 4.0, 10.0)
    code, out, _, _ = replayed(write(tmp_path / "session.mcap", story))
    assert code == 0 and "lost: 4.00 s of sound before the first" in out
    assert MADE[0].modes == [(None, "active", "hey robot")]


def middle(path):
    """Place inside the middle chunk of a recording [B]."""
    with path.open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    return chunks[len(chunks) // 2].chunk_start_offset + 40


def test_a_truncated_file_is_heard_as_far_as_it_goes(tmp_path, replayed):
    PLANS.append(SAME)
    whole = ordinary(tmp_path / "whole.mcap")
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole.read_bytes()[: middle(whole)])
    code, out, _, result = replayed(path)
    assert code == 0 and "cut off inside a record" in out
    assert 4.0 < result["sessions"][0]["sound"] < 6.0
    assert result["sessions"][0]["recorded"] == 1


def test_a_damaged_stretch_is_said_and_the_rest_is_heard(tmp_path, replayed):
    PLANS.append(SAME)
    place = middle(ordinary(tmp_path / "session.mcap"))
    content = bytearray((tmp_path / "session.mcap").read_bytes())
    content[place : place + 2_000] = bytes(2_000)
    (tmp_path / "session.mcap").write_bytes(content)
    code, out, _, result = replayed(tmp_path / "session.mcap")
    assert re.search(r"lost: \d+ bytes at \d+", out) and "s of sound in front of sample" in out
    assert code == 0 and result["sessions"][0]["sound"] > 9.0


def test_what_the_node_may_have_ended_before_is_not_counted(tmp_path, replayed):
    story = Story()
    play(story, 0.0, 10.0)
    note(story, 5.0, "heard 80000")
    PLANS.append({block(4.0): [hears(3.9)], block(8.0): [hears(7.9)]})
    code, _, _, result = replayed(write(tmp_path / "session.mcap", story))
    assert code == 1
    early, late = result["sessions"][0]["differences"]
    assert early["excuse"] == "" and "may have ended" in late["excuse"]


def test_without_notes_only_the_very_end_is_not_counted(tmp_path, replayed):
    story = Story()
    play(story, 0.0, 10.0)
    PLANS.append({block(8.0): [hears(7.9)], block(9.9): [hears(9.7)]})
    code, _, _, result = replayed(write(tmp_path / "session.mcap", story))
    excuses = [d["excuse"] for d in result["sessions"][0]["differences"]]
    assert code == 1 and excuses == ["", "the recording ends there"]


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
