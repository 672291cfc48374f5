# SPDX-License-Identifier: BSD-3-Clause
"""The report as a reader gets it: sections, figures, nothing from outside the page."""

import base64
import io
import re
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser

import pytest
import soundfile
from PIL import Image

from session_log.mcap_file.reader import SessionReader
from session_log.report.notes import Note, add_note
from session_log.report.one_session import write_report
from session_log.report.tables.text_table import length
from support.story import Story, recording_of, write_session
from support.waiting import PATIENCE

FIGURES = {"timeline", "latency", "rcm_error", "tension", "scene", "joints", "loop_timing"}
FIGURES |= {"accuracy", "confusion"}
BROWSER = shutil.which("chromium-headless-shell")
SECTIONS = [
    "Timeline",
    "Commands",
    "What stopped the robot, and why",
    "What was refused, and why",
    "Recognition accuracy",
    "What was taken for what",
    "From the end of speech to motion",
    "RCM error",
    "Tissue tension",
    "The scene",
    "Joint ranges and margins",
    "Loop timing",
    "Health",
    "Recording",
    "Origin",
]


class Page(HTMLParser):
    """Text, headings and sources of a report's page."""

    def __init__(self, report):
        super().__init__()
        self.text = report.page.read_text(encoding="utf-8")
        self.headings, self.sources, self.rows, self._tag = [], [], [], ""
        self.feed(self.text)
        unseen = r"<style>.*?</style>|<script.*?</script>|<[^>]*>"
        self.words = re.sub(unseen, " ", self.text, flags=re.DOTALL)

    def handle_starttag(self, tag, attributes):
        self._tag = tag
        values = dict(attributes)
        self.sources += [values[k] for k in ("src", "srcset", "href") if k in values]
        if tag == "tr":
            self.rows.append([])

    def handle_data(self, data):
        if self._tag == "h2" and data.strip():
            self.headings.append(data)
        if self._tag == "span" and self.rows and data.strip():
            self.rows[-1].append(data)


@pytest.fixture(scope="module")
def report(story, report_config, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    result = write_report(SessionReader(story[0]), folder, report_config)
    return result, Page(result)


@pytest.fixture
def reported(tmp_path, report_config):
    """Writes the report of s.mcap, with some settings changed."""

    def write(**changes):
        config = replace(report_config, **changes)
        return write_report(SessionReader(tmp_path / "s.mcap"), tmp_path, config)

    return write


def test_every_section_is_there(report):
    assert report[1].headings == SECTIONS


def test_every_figure_is_a_png_of_a_papers_width(report):
    result, _ = report
    assert {path.stem for path in result.figures} == FIGURES
    for path in result.figures:
        with Image.open(path) as image:
            assert image.format == "PNG" and image.width == pytest.approx(7.16 * 60, abs=2)


def test_the_page_needs_nothing_outside_itself(report):
    _, page = report
    assert len(page.sources) == 2 * len(FIGURES)
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    assert "http" not in page.words


def test_latency_stands_beside_the_papers_table(report):
    rows = {row[0]: row for row in report[1].rows if len(row) == 7}
    paper = {"hey robot": 1.97, "tense": 1.14, "release": 1.42, "pull more": 2.39}
    paper |= {"pull less": 2.50, "stop": 1.29, "terminate": 1.52}
    for command, latency in paper.items():
        assert rows[command][-1] == f"{latency:.2f}"
    assert rows["all"][1] == "10"


def test_refusals_and_ignored_talk_are_reported_with_their_reason(report):
    rows = {row[1]: row for row in report[1].rows if len(row) == 8}
    assert rows["“could you pass me the clamp”"][-1].startswith("nothing close enough")
    assert any(
        row[4] == "refused" and row[-1] == "tissue is held already"
        for row in report[1].rows
        if len(row) == 8
    )


def test_what_was_refused_has_a_table_of_its_own(report):
    rows = [row for row in report[1].rows if len(row) == 4 and row[1] == "tense"]
    assert rows == [["28.8\u00a0s", "tense", "“tense”", "tissue is held already"]]


@pytest.mark.usefixtures("without_figures")
def test_the_page_counts_refused_hands_and_failed_devices_apart_from_the_voice(tmp_path, reported):
    story = Story(duration=3.0)
    story.event(1.0, "refused", "tense", "held")
    call = {"phrase": "light on", "target": "/light", "message": "away"}
    story.say(2.0, "/voice_assist/device", "voice_assist/DeviceCall", **call)
    recording_of(tmp_path / "s.mcap", story.messages)
    page = Page(reported())
    facts = re.findall(r'<b>(.*?)</b><span class="quiet">(.*?)</span>', page.text)
    assert facts[:3] == [
        ("0", "spoken commands"),
        ("0", "of them refused by the controller"),
        ("1", "device calls that failed"),
    ]
    assert "Device calls that failed, and why" in page.headings
    assert [row[1:] for row in page.rows if len(row) == 4] == [
        ["tense", "by\u00a0hand", "held"],
        ["light on", "by\u00a0devices", "/light, away"],
    ]


def test_accuracy_counts_what_was_meant_and_never_heard(report):
    rows = {row[0]: row[1:] for row in report[1].rows if len(row) == 5}
    assert rows["stop"] == ["2", "1", "50.0\u00a0%", "1.3 to 98.7\u00a0%"]
    assert rows["all commands"][:2] == ["12", "11"]
    assert rows["no command"][:2] == ["2", "2"]


def test_both_rcm_errors_and_the_trocars_change_are_reported(report):
    words = report[1].words
    assert "From the joint states, by the recorded robot model and trocar alone, while" in words
    assert "Trocar set at 20.0 s (by a service call)." in words


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (2.95e-8, "29.5 nm"),
        (50e-6, "50 µm"),
        (0.1e-6, "0.1 µm"),
        (0.0123, "12.3 mm"),
        (0.0, "0 µm"),
        (3e-17, "below 0.001 nm"),
        (float("nan"), "–"),
    ],
)
def test_lengths_keep_their_digits_in_a_fitting_unit(value, words):
    assert length(value).replace("\u00a0", " ") == words


def test_a_session_by_hand_has_commands_but_no_latency(tmp_path, reported):
    story = Story(duration=3.0)
    story.event(1.0, "accepted", "tense", "reaches")
    story.event(1.1, "motion_started", "tense", "")
    recording_of(tmp_path / "s.mcap", story.messages)
    page = Page(result := reported())
    assert any(row[1:3] == ["by\u00a0hand", "tense"] for row in page.rows if len(row) == 8)
    assert "No spoken command led to an action." in page.words
    assert {path.stem for path in result.figures} == {"timeline"}


def test_origin_and_limits_are_named(report):
    words = report[1].words
    assert "0123456789abcdef0123456789abcdef01234567" in words
    assert "model_sha256" in words and "limit of 50\u00a0µm" in words


@pytest.mark.usefixtures("with_timeline")
def test_what_was_recorded_is_text_never_markup(tmp_path, reported, monkeypatch):
    hostile = [(1.0, 0.5, "<script>alert(1)</script>", "", "<b>no</b>")]
    monkeypatch.setattr("support.story.SPEECH", hostile)
    write_session(tmp_path / "s.mcap", duration=3.0, rate=50)
    text = Page(reported()).text
    assert "<script>alert" not in text and "&lt;script&gt;alert(1)" in text and "<b>no" not in text
    assert text.count("<script") == text.count("</script") == 2, "that of the page and its values"


def test_a_session_without_anything_still_gives_a_page_that_says_so(tmp_path, reported):
    write_session(tmp_path / "s.mcap", duration=-1.0)
    page = Page(result := reported())
    assert result.figures == []
    assert page.headings == [s for s in SECTIONS if s != "What was taken for what"]
    assert "Nobody recorded what was meant to be said" in page.words
    assert "No spoken command led to an action." in page.words


@pytest.mark.usefixtures("without_figures")
def test_a_killed_recording_is_reported_with_a_warning(story, tmp_path, reported):
    content = story[0].read_bytes()
    (tmp_path / "s.mcap").write_bytes(content[: len(content) * 2 // 3])
    assert "The recorder did not close this file" in Page(reported()).text


@pytest.mark.usefixtures("with_timeline")
def test_figures_are_also_written_for_a_paper_when_asked(tmp_path, reported):
    story = Story()
    story.event(1.0, "accepted", "tense", "reaches")
    story.event(1.1, "motion_started", "tense", "")
    recording_of(tmp_path / "s.mcap", story.messages)
    assert (tmp_path / "timeline.pdf") in reported(vector=True).figures
    assert (tmp_path / "timeline.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.usefixtures("without_figures")
@pytest.mark.parametrize(("missed", "is_warned"), [(1, False), (500, True)])
def test_one_lost_message_of_thousands_is_a_note_and_many_are_a_warning(
    story, tmp_path, reported, missed, is_warned
):
    losses = {"/joint_states from /robot": f"0 dropped, {missed} missed"}
    messages = [m for m in story[1] if m.source.topic == "/joint_states"]
    recording_of(tmp_path / "s.mcap", messages, {"losses": losses})
    text = Page(reported()).text
    words = f"Lost on /joint_states from /robot: 0 dropped, {missed} missed of"
    assert words in text
    warning = re.search(r'<p class="warn">(.*?)</p>', text)
    assert (warning is not None and words in warning[1]) == is_warned


@pytest.mark.usefixtures("without_figures")
def test_an_utterance_can_be_heard_and_that_can_be_switched_off(report, tmp_path, reported):
    _, page = report
    sounds = re.findall(r'class="hear".*?data-sound="data:audio/mpeg;base64,([^"]*)"', page.text)
    spoken = [row for row in page.rows if len(row) == 8 and row[1] != "by\u00a0hand"]
    assert len(sounds) == len(spoken)
    samples, rate = soundfile.read(io.BytesIO(base64.b64decode(sounds[0])))
    assert rate == 16000 and 0.5 < len(samples) / rate < 3.0 and samples.std() > 0.05
    write_session(tmp_path / "s.mcap", duration=6.0, rate=50)
    assert "data:audio" not in Page(reported(utterance_sound=False)).text


@pytest.mark.usefixtures("with_timeline")
def test_notes_stand_in_the_report_and_those_of_a_moment_on_its_time_axis(tmp_path, reported):
    path = tmp_path / "s.mcap"
    write_session(path, duration=6.0, rate=50)
    add_note(path, Note("the light was\n<b>off</b>"))
    add_note(path, Note("a cough", 2.5))
    page = Page(reported())
    assert ["–", "the light was <b>off</b>"] in page.rows
    assert ["2.5\u00a0s", "a cough"] in page.rows
    assert '[2.5,"a cough","#1f2933"]' in page.text and "<b>off" not in page.text


@pytest.mark.skipif(not BROWSER, reason="no Chromium: docker/apt-packages-dev.txt")
@pytest.mark.parametrize(("width", "are_open"), [(1400, True), (390, False)])
def test_a_browser_draws_the_time_axis_and_folds_the_page_on_a_phone(report, width, are_open):
    command = [BROWSER, "--no-sandbox", f"--window-size={width},900", "--dump-dom"]
    dom = subprocess.run(
        [*command, report[0].page.as_uri()],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=True,
    ).stdout
    assert re.search(r'<div class="zoom">.*?<canvas [^>]*height: \d+px', dom, re.DOTALL)
    parts = re.findall(r'<details class="part"( open="")?>', dom)
    assert len(parts) == len(SECTIONS) and parts[0] and bool(parts[1]) == are_open
