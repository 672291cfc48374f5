# SPDX-License-Identifier: BSD-3-Clause
import csv
import json
import subprocess
import sys
import wave

import pytest

from session_log.cli import main
from session_log.export import sound_stream
from session_log.mcap_file.writer import SessionWriter
from session_log.recording.recorder import MANY_PUBLISHERS
from session_log.types import Message, MessageSource
from support.story import Story, recording_of
from tests.unit.session_log.support.foreign import write_foreign
from tests.unit.session_log.support.voice_recording import say_sound
from typed_config import package_version


def run(capsys, *words):
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    shown = capsys.readouterr()
    return end.value.code, shown.out, shown.err


def test_it_names_its_version(capsys):
    assert run(capsys, "--version")[:2] == (0, f"session_log {package_version('session_log')}\n")


def test_info_names_topics_rates_and_condition(story, capsys):
    code, out, _ = run(capsys, "info", story[0])
    assert code == 0 and "complete, checksum good" in out
    assert any(line.split()[:2] == ["/rst_control/state", "2350"] for line in out.splitlines())
    assert "seed: 7" in out


def test_info_is_also_for_machines(story, capsys):
    _, out, _ = run(capsys, "info", story[0], "--json")
    data = json.loads(out)
    assert data["topics"]["/rst_control/state"]["messages"] == 2350
    assert data["condition"]["is_closed"] is True


def test_info_names_a_clock_that_was_set_back_and_publishers_without_end(tmp_path, capsys):
    source = MessageSource("/t", "std_msgs/String", "992c", "string data", MANY_PUBLISHERS)
    now = 1_795_200_000 * 10**9
    times = enumerate((now, now - 60 * 10**9), 1)
    recording_of(tmp_path / "s.mcap", [Message(source, b"x", time, k) for k, time in times])
    _, out, _ = run(capsys, "info", tmp_path / "s.mcap")
    assert "the clock was set back by 60.0 s at 20" in out and "complete" not in out
    assert "/t: more than 64 nodes published it" in out


@pytest.mark.parametrize("dropped", [3, 0])
def test_what_never_reached_the_recorder_leaves_a_recording_complete_and_a_drop_does_not(
    tmp_path, capsys, dropped
):
    loss = f"{dropped} dropped, 1 missed"
    recording_of(tmp_path / "s.mcap", metadata={"losses": {"/t from /p": loss}})
    _, out, _ = run(capsys, "info", tmp_path / "s.mcap")
    assert f"/t from /p: {loss}" in out and ("complete" in out) is (dropped == 0)
    assert (f"lost on /t from /p: {loss}\n" in out) is (dropped > 0)


def test_info_of_a_cut_file_says_what_is_lost(story, tmp_path, capsys):
    (tmp_path / "s.mcap").write_bytes(story[0].read_bytes()[:100_000])
    code, out, _ = run(capsys, "info", tmp_path / "s.mcap")
    assert code == 0 and "not closed" in out and "cut off inside a record" in out


def test_info_of_a_recovered_copy_says_what_its_original_had_lost(story, tmp_path, capsys):
    content, again = story[0].read_bytes(), tmp_path / "again.mcap"
    (tmp_path / "s.mcap").write_bytes(content[: len(content) // 2])
    run(capsys, "recover", tmp_path / "s.mcap")
    run(capsys, "recover", tmp_path / "s_recovered.mcap", "--out", again)
    for copy in (tmp_path / "s_recovered.mcap", again):
        _, out, _ = run(capsys, "info", copy)
        assert "copied from s.mcap, which was not closed" in out and "complete" not in out


def test_a_copy_of_a_sound_recording_is_complete(story, tmp_path, capsys):
    run(capsys, "recover", story[0], "--out", tmp_path / "s.mcap")
    assert "complete, checksum good" in run(capsys, "info", tmp_path / "s.mcap")[1]


MISSING = """
import sys
from contextlib import suppress
from session_log.cli import main

for command in ("report", "replay"):
    with suppress(SystemExit):
        main([command, "/none.mcap"])
print({"matplotlib", "scipy", "shtab", "torch"} & set(sys.modules))
"""


def test_a_missing_file_is_named_before_anything_slow_is_loaded():
    """Plots and recognisers take seconds to load."""
    done = subprocess.run([sys.executable, "-c", MISSING], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "set()\n")
    assert done.stderr.count("session_log: /none.mcap: no such file or folder\n") == 2


@pytest.mark.parametrize("command", ["info", "report", "export", "recover"])
def test_a_missing_file_is_one_clear_line(tmp_path, capsys, command):
    code, _, err = run(capsys, command, tmp_path / "none.mcap")
    assert (code, err) == (1, f"session_log: {tmp_path / 'none.mcap'}: no such file or folder\n")


def test_another_kind_of_file_is_one_clear_line(tmp_path, capsys):
    (tmp_path / "x.bag").write_bytes(b"#ROSBAG V2.0")
    code, _, err = run(capsys, "info", tmp_path / "x.bag")
    assert code == 1 and "is not an MCAP recording" in err and err.count("\n") == 1


def test_recover_writes_beside_the_recording_and_never_over_anything(story, tmp_path, capsys):
    (tmp_path / "session.mcap").write_bytes(story[0].read_bytes()[:500_000])
    code, out, _ = run(capsys, "recover", tmp_path)
    assert code == 0 and (tmp_path / "session_recovered.mcap").exists() and "lost" in out
    code, _, err = run(capsys, "recover", tmp_path)
    assert code == 1 and "it exists already" in err


@pytest.mark.parametrize("content", [b"", b"x" * 5000])
def test_recover_of_what_is_no_recording_writes_nothing(tmp_path, capsys, content):
    path = tmp_path / "s.mcap"
    path.write_bytes(content)
    code, out, err = run(capsys, "recover", path)
    assert (code, out) == (1, "") and list(tmp_path.iterdir()) == [path]
    assert err == f"session_log: {path}: holds no readable message; nothing was written\n"


def test_recover_keeps_what_is_known_of_a_session_without_messages(tmp_path, capsys):
    recording_of(tmp_path / "s.mcap", metadata={"session": {"seed": "7"}})
    assert run(capsys, "recover", tmp_path / "s.mcap")[0] == 0
    assert "seed: 7" in run(capsys, "info", tmp_path / "s_recovered.mcap")[1]


def test_export_gives_tables_and_the_sound(story, tmp_path, capsys):
    code, out, _ = run(capsys, "export", story[0], "--out", tmp_path)
    assert code == 0 and "0 lost" in out and "closed" not in out
    assert "audio.wav: begins at 1795200000.000000000 s, the time of the tables\n" in out
    with (tmp_path / "voice_assist_utterance.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["command"] for row in rows[:2]] == ["hey robot", "tense"]
    assert json.loads(rows[0]["phrases"])[0] == "hey robot"
    with wave.open(str(tmp_path / "audio.wav")) as sound:
        form = (sound.getnchannels(), sound.getsampwidth(), sound.getframerate())
        assert form == (1, 2, 16000)
        assert sound.getnframes() == pytest.approx(47 * 16000, abs=512)


def test_export_says_how_much_of_the_lost_sound_has_no_silence(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sound_stream, "MOST_SILENCE", 9)
    story = Story()
    for first in (0, 10**9):
        say_sound(story, 1.0, first, count=1)
    recording_of(tmp_path / "s.mcap", story.messages)
    _, out, _ = run(capsys, "export", tmp_path / "s.mcap", "--out", tmp_path)
    assert "2 samples, 999999999 lost, 999999990 of them without silence in their place" in out


def test_export_of_a_topic_that_was_not_recorded_says_so(story, tmp_path, capsys):
    topics = ("--topic", "/none", "--topic", "/rst_control/event")
    code, out, _ = run(capsys, "export", story[0], "--out", tmp_path, *topics)
    assert code == 1 and "/none: nothing recorded" in out
    assert (tmp_path / "rst_control_event.csv").is_file()


def test_export_of_a_recording_that_was_not_closed_says_so_and_is_no_failure(tmp_path, capsys):
    writer = SessionWriter(tmp_path / "s.mcap")
    writer.abandon()
    code, out, _ = run(capsys, "export", tmp_path / "s.mcap", "--out", tmp_path)
    assert code == 0 and "not closed: the recorder was killed, or is still running\n" in out


def test_export_of_a_damaged_recording_says_so_and_fails(story, tmp_path, capsys):
    (tmp_path / "s.mcap").write_bytes(story[0].read_bytes()[:100_000])
    code, out, _ = run(capsys, "export", tmp_path / "s.mcap", "--out", tmp_path)
    assert code == 1 and "not closed" in out and "cut off inside a record" in out


@pytest.mark.parametrize(
    ("metadata", "status"),
    [
        ({"losses": {"/rst_control/event from /p": "3 dropped, 0 missed"}}, 1),
        ({"losses": {"/rst_control/event from /p": "0 dropped, 1 missed"}}, 0),
        ({"losses": {"/rst_control/event_2 from /p": "3 dropped, 0 missed"}}, 0),  # no table
        ({"recovered": {"was_closed": "False", "unreadable_bytes": "9"}}, 1),
        ({"recovered": {"was_closed": "True", "checksum": "wrong"}}, 1),
        ({"recovered": {"was_closed": "False", "unreadable_bytes": "0"}}, 0),
    ],
)
def test_export_fails_where_the_recording_itself_says_that_rows_are_lost(
    tmp_path, capsys, metadata, status
):
    recording_of(tmp_path / "s.mcap", metadata=metadata)
    assert run(capsys, "export", tmp_path / "s.mcap", "--out", tmp_path)[0] == status


@pytest.mark.parametrize(
    ("gap", "status"), [("/rst_control/event", 1), ("/voice_assist/audio", 1), ("/t", 0)]
)
def test_export_sees_what_a_recorder_dropped_that_was_killed(tmp_path, capsys, gap, status):
    story = Story()
    for k in range(3):
        story.event(60.0 * k, "accepted", "tense", "")
        say_sound(story, 60.0 * k, 960_000 * k)
        story.say(60.0 * k, "/t", "std_msgs/String", data="x")
    writer = SessionWriter(tmp_path / "s.mcap")
    for message in story.messages:
        if (message.source.topic, message.sequence) != (gap, 2):
            writer.add(message)
    writer.commit()
    writer.abandon()
    code, out, _ = run(capsys, "export", tmp_path / "s.mcap", "--out", tmp_path)
    assert code == status and "the clock was set" not in out
    assert ("1 messages were received but are not in the file\n" in out) is (status == 1)


def test_export_of_messages_that_do_not_fit_fails(tmp_path, capsys):
    path = write_foreign(tmp_path / "s.mcap", ["/rst_control/event"])
    code, out, _ = run(capsys, "export", path, "--out", tmp_path)
    assert code == 1 and "1 messages do not fit their definition" in out


def test_export_takes_a_topic_without_its_leading_slash(story, tmp_path, capsys):
    code, out, _ = run(
        capsys, "export", story[0], "--out", tmp_path, "--topic", "voice_assist/utterance"
    )
    assert code == 0 and "voice_assist_utterance.csv: 13 rows" in out
    assert "nothing recorded" not in out


def test_export_says_why_a_recorded_topic_has_no_table(tmp_path, capsys):
    path = write_foreign(tmp_path / "s.mcap")
    code, out, _ = run(capsys, "export", path, "--out", tmp_path, "--topic", "/t")
    assert code == 1 and "nothing recorded" not in out
    assert "1 messages do not fit their definition\n/t: not a std_msgs/String: recorded as" in out


def test_recover_of_another_encoding_is_one_clear_line(tmp_path, capsys):
    code, out, err = run(capsys, "recover", write_foreign(tmp_path / "s.mcap"))
    assert (code, out) == (1, "") and err.startswith("session_log: /t: recorded as 'cdr' with")
    assert err.count("\n") == 1 and not (tmp_path / "s_recovered.mcap").exists()


@pytest.mark.parametrize(
    "folders",
    [
        {"pivot": "export"},
        {
            "session": "export",
            "session_2": "session_2/export",
            "session_2_recovered": "session_2_recovered/export",
        },
    ],
)
def test_the_export_is_beside_its_recording_and_apart_from_that_of_another(
    tmp_path, capsys, folders
):
    story = Story()
    story.event(1.0, "accepted", "tense", "")
    for name in folders:
        recording_of(tmp_path / f"{name}.mcap", story.messages)
    for name, folder in folders.items():
        code, out, _ = run(capsys, "export", tmp_path / f"{name}.mcap")
        assert code == 0 and f"{tmp_path / folder / 'rst_control_event.csv'}: 1 rows" in out


@pytest.mark.usefixtures("with_timeline")
def test_report_is_written_beside_the_recording(story, tmp_path, capsys):
    (tmp_path / "session.mcap").write_bytes(story[0].read_bytes())
    code, out, _ = run(capsys, "report", tmp_path)
    assert code == 0 and str(tmp_path / "report.html") in out
    assert (tmp_path / "report.html").is_file() and (tmp_path / "timeline.png").is_file()


@pytest.mark.usefixtures("without_figures")
def test_report_over_a_folder_names_what_it_could_not_read(story, tmp_path, capsys):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "session.mcap").write_bytes(story[0].read_bytes())
    (tmp_path / "b.mcap").write_bytes(b"#ROSBAG V2.0")
    words = (tmp_path, "--no-pages", "--latex")
    code, out, err = run(capsys, "report", *words)
    assert code == 1 and "1 sessions read, 1 not readable" in out
    assert err.startswith(f"not read: {tmp_path / 'b.mcap'}: ") and err.count("\n") == 1
    assert str(tmp_path / "report.html") in out and str(tmp_path / "latency.tex") in out
    assert (tmp_path / "a" / "report_summary.json").is_file()


@pytest.mark.usefixtures("without_figures")
def test_report_over_a_folder_fails_where_a_page_cannot_be_written(story, tmp_path, capsys):
    (tmp_path / "a" / "report.html").mkdir(parents=True)
    (tmp_path / "a" / "session.mcap").write_bytes(story[0].read_bytes())
    code, out, _ = run(capsys, "report", tmp_path)
    assert code == 1 and "1 sessions read, 0 not readable, 1 without their page" in out


@pytest.mark.parametrize(
    ("words", "wrong"),
    [
        (["empty"], "empty: a folder without any recording (*.mcap) in or below it"),
        (["bag.mcap"], "bag.mcap is not an MCAP recording: it begins with b'#ROSBAG '"),
        (["bag.mcap", "empty"], "2 inputs and no place for the report over them: give --out DIR"),
        (["bag.mcap", "none", "--out", "o"], "none: no such file or folder"),
        (["bags"], "none of 1 recordings can be read: bags/bag.mcap is not an MCAP recording"),
    ],
)
def test_report_says_what_is_wrong_in_one_line(tmp_path, capsys, monkeypatch, words, wrong):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    (tmp_path / "bags").mkdir()
    for path in (tmp_path / "bag.mcap", tmp_path / "bags" / "bag.mcap"):
        path.write_bytes(b"#ROSBAG V2.0")
    code, _, err = run(capsys, "report", *words)
    assert code == 1 and err.startswith("session_log: " + wrong) and err.count("\n") == 1


def test_report_without_anything_named_shows_its_usage(capsys):
    code, _, err = run(capsys, "report")
    assert code == 2 and "SESSION|FOLDER" in err


def test_a_wrong_key_in_the_settings_is_named(story, tmp_path, capsys):
    (tmp_path / "report.yaml").write_text("rcm_limits: 3\n", encoding="utf-8")
    code, _, err = run(capsys, "report", story[0], "--config", tmp_path / "report.yaml")
    assert code == 1 and "did you mean rcm_limit?" in err


def test_a_report_by_no_process_names_what_is_allowed(capsys):
    code, _, error = run(capsys, "report", "session", "--jobs", "0")
    assert code == 2 and "'0', allowed: a whole number from 1" in error


def test_a_cluster_is_of_no_use_for_one_session(story, capsys):
    code, _, err = run(capsys, "report", story[0], "--cluster", "nohost")
    words = f"--cluster needs a folder of sessions, {story[0]} is one session"
    assert (code, err) == (1, f"session_log: {words}\n")


@pytest.mark.parametrize("time", ["-1", "soon", "nan", "inf"])
def test_a_note_at_no_time_names_what_is_allowed(capsys, time):
    code, _, error = run(capsys, "note", "session", "--at", time, "words")
    assert code == 2 and f"{time!r}, allowed: 0 s or more" in error
