# SPDX-License-Identifier: BSD-3-Clause
import csv
import json
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import soundfile

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, make_detector, say
from voice_assist.config import load_voice_config
from voice_assist.errors import ManifestError, VoiceError
from voice_assist.evaluation import command as evaluate_module
from voice_assist.evaluation.command import Job, evaluate
from voice_assist.evaluation.evaluator import (
    ClipOutcome,
    Evaluator,
    LabelledClip,
    StreamClock,
    Taken,
    read_manifest,
)
from voice_assist.evaluation.metrics import summarize, verdict
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.types import RATE

CONFIG = load_voice_config()


def write(path, text, rate=RATE):
    soundfile.write(path, say(text, before=0.1, after=0.1), RATE)
    return path.name


@pytest.fixture
def manifest(tmp_path):
    rows = [
        "id,path,transcript,speaker",
        f"1,{write(tmp_path / 'a.wav', 'hey robot')},Hey robot!,x",
        f"2,{write(tmp_path / 'b.flac', 'pull less')},pull less,x",
        f"3,{write(tmp_path / 'c.wav', 'pull less')},pull more,x",
        f"4,{write(tmp_path / 'd.wav', 'mumble')},tense,x",
        f"5,{write(tmp_path / 'e.ogg', 'he said release')},he said release,x",
        f"6,{write(tmp_path / 'f.wav', 'release')},what he said,x",
        f"7,{write(tmp_path / 'g.wav', 'stop')},stop,x",
    ]
    path = tmp_path / "clips.csv"
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.fixture
def fakes(monkeypatch):
    monkeypatch.setattr(evaluate_module, "make_recognizer", lambda config: FakeRecognizer())
    monkeypatch.setattr(
        evaluate_module,
        "make_pipeline",
        lambda config, clock, recognizer: Pipeline(config, recognizer, make_detector(), clock),
    )


def job(manifest, **changes):
    given = {
        "manifest": manifest,
        "out": manifest.parent / "out.json",
        "mode": "active",
        "noise": None,
        "snr_db": None,
        "jobs": 1,
        "details": None,
    }
    return Job(**{**given, **changes})


def test_every_clip_is_counted_where_it_belongs(manifest, fakes):
    figures = evaluate(CONFIG, job(manifest))
    assert figures == json.loads((manifest.parent / "out.json").read_text())
    assert figures["n"] == 7
    commands = figures["commands"]
    assert commands["hey robot"] == {"n": 1, "correct": 1, "rejected": 0, "confused": {}}
    assert commands["pull less"]["correct"] == 1
    other = {"pull less": 1}
    assert commands["pull more"] == {"n": 1, "correct": 0, "rejected": 0, "confused": other}
    assert commands["tense"]["rejected"] == 1
    assert commands["terminate"]["n"] == 0
    assert figures["accuracy"] == pytest.approx(3 / 5)
    negatives = figures["negatives"]
    assert (negatives["n"], negatives["accepted"]) == (2, 1)
    assert negatives["by_command"] == {"release": 1}
    assert negatives["accepted_per_hour"] == pytest.approx(1 / negatives["hours"])
    assert figures["model"] == "fake"
    assert figures["real_time_factor"] > 0.0


def test_latencies_are_from_the_end_of_speech(manifest, fakes, monkeypatch):
    at_once = lambda _: StreamClock(lambda: 0.0)  # noqa: E731 as if the work took no time
    monkeypatch.setattr("voice_assist.evaluation.evaluator.StreamClock", at_once)
    latency = evaluate(CONFIG, job(manifest))["latency_ms"]
    assert set(latency["stop"]) == {"p50", "p95", "p99"}
    assert -150.0 < latency["stop"]["p50"] < 150.0
    assert 50.0 < latency["pull less"]["p50"] < 500.0
    assert latency["tense"] == {"p50": None, "p95": None, "p99": None}


def test_in_standby_a_motion_is_no_command(manifest, fakes):
    figures = evaluate(CONFIG, job(manifest, mode="standby"))
    assert figures["commands"]["hey robot"]["correct"] == 1
    assert figures["commands"]["stop"]["correct"] == 1
    assert figures["commands"]["pull less"]["n"] == 0
    assert figures["accuracy"] == 1.0
    negatives = figures["negatives"]
    assert (negatives["n"], negatives["accepted"]) == (5, 0)


def test_a_motion_taken_in_standby_is_an_acceptance(manifest, fakes, monkeypatch):
    woken = lambda *given: Evaluator(given[0], "active", *given[2:])  # noqa: E731
    monkeypatch.setattr(evaluate_module, "Evaluator", woken)
    negatives = evaluate(CONFIG, job(manifest, mode="standby"))["negatives"]
    assert negatives["by_command"] == {"pull less": 2, "release": 1}


def test_a_motion_that_is_to_be_said_twice_counts_when_it_is_said_once(manifest, fakes):
    figures = evaluate(load_voice_config(commands__said_twice=True), job(manifest))
    assert figures["commands"]["pull less"]["correct"] == 1
    assert figures["said_twice"] is False


def test_while_the_robot_moves_a_stop_among_other_words_is_one(manifest, fakes):
    spoken = "he said stop now"
    with manifest.open("a") as rows:
        rows.write(f"8,{write(manifest.parent / 'h.wav', spoken)},{spoken},x\n")
    at_rest, moving = (evaluate(CONFIG, job(manifest, mode=m)) for m in ("active", "moving"))
    assert at_rest["commands"]["stop"]["n"] == 1 and moving["commands"]["stop"]["n"] == 2
    assert moving["commands"]["stop"]["correct"] == 2
    assert at_rest["negatives"]["by_command"] == moving["negatives"]["by_command"]
    assert moving["mode"] == "moving"


def claims_by_path(manifest, **changes):
    details = manifest.parent / "details.csv"
    evaluate(CONFIG, job(manifest, details=details, **changes))
    with details.open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == 7
    return {Path(line["path"]).name: json.loads(line["claims"]) for line in lines}


def test_claims_are_what_was_taken_right_or_wrong_or_what_the_words_of_a_refused_one_say(
    manifest, fakes
):
    claims = claims_by_path(manifest)
    assert [c["command"] for c in claims["c.wav"]] == ["pull less"]
    assert [(c["command"], c["is_taken"]) for c in claims["g.wav"]] == [("stop", True)]
    assert 0.0 < claims["g.wav"][0]["confidence"] <= 1.0
    assert claims["d.wav"] == claims["e.ogg"] == []
    claims = claims_by_path(manifest, mode="standby")
    assert claims["d.wav"] == claims["e.ogg"] == []
    assert {(c["command"], c["is_taken"]) for c in claims["b.flac"]} == {("pull less", False)}


def test_noise_is_added_at_the_level_asked_for(manifest, fakes):
    folder = manifest.parent / "noise"
    folder.mkdir()
    soundfile.write(folder / "hiss.wav", 0.1 * np.random.default_rng(0).standard_normal(RATE), RATE)
    figures = evaluate(CONFIG, job(manifest, noise=folder, snr_db=30.0))
    assert figures["snr_db"] == 30.0
    assert figures["commands"]["pull less"]["correct"] == 1


@pytest.mark.parametrize("folder", ["missing", "."])
def test_a_folder_without_noise_is_refused_before_the_model_is_loaded(
    manifest, tmp_path_factory, folder, monkeypatch
):
    monkeypatch.setattr(evaluate_module, "make_recognizer", lambda _: pytest.fail("loaded"))
    made = tmp_path_factory.mktemp("noise")
    (made / "readme.txt").write_text("no sound")
    noise = made / folder
    with pytest.raises(ManifestError, match="no sound files in it"):
        evaluate(CONFIG, job(manifest, noise=noise, snr_db=6.0, jobs=2))


def test_a_process_that_dies_is_named_in_one_line(manifest, fakes, monkeypatch):
    def broken(*_, **__):
        raise BrokenProcessPool

    monkeypatch.setattr(evaluate_module.ProcessPoolExecutor, "map", broken)
    with pytest.raises(VoiceError, match="one of 2 processes ended too early"):
        evaluate(CONFIG, job(manifest, jobs=2))


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("", "no column 'path'"),
        ("file,transcript\na.wav,x\n", "no column 'path'; columns are: file, transcript"),
        ("path,text\na.wav,x\n", "no column 'transcript'"),
        ("path,transcript\n", "has no rows"),
        ("path,transcript\nnone.wav,stop\n", r"row 2: .*none\.wav: no such file"),
        ("path,transcript\n\n,stop\n", "row 3: the path is empty"),
        ("path,transcript\nclips.csv,stop\n", r"row 2: .*not a sound file"),
        ("path,transcript\n.,stop\n", "row 2: .*: not a file"),
    ],
)
def test_a_manifest_that_cannot_be_used_says_why(tmp_path, content, problem):
    path = tmp_path / "clips.csv"
    with pytest.raises(ManifestError, match=r"clips\.csv"):  # it is missing
        read_manifest(path, CONFIG.commands)
    path.write_text(content)
    with pytest.raises(ManifestError, match=problem):
        read_manifest(path, CONFIG.commands)


def test_a_manifest_of_a_spreadsheet_is_read(tmp_path):
    write(tmp_path / "a.wav", "stop")
    path = tmp_path / "clips.csv"
    path.write_bytes('\ufeffTranscript , Path\r\n"Stop, stop!",a.wav\r\n'.encode())
    (clip,) = read_manifest(path, CONFIG.commands)
    assert (clip.row, clip.phrase) == (2, "stop")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"noise": "x"}, "give both"),
        ({"snr_db": 3.0}, "give both"),
        ({"out": Path("/dev/null/out.json")}, "cannot be written"),
    ],
)
def test_noise_without_level_and_a_place_that_cannot_be_written_are_named(manifest, changes, words):
    with pytest.raises(ManifestError, match=words):
        evaluate(CONFIG, job(manifest, **changes))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"out": "clips.csv"}, r"clips\.csv is the manifest, so the file of figures cannot"),
        ({"details": "sub/../a.wav"}, r"a\.wav is the clip of row 2, so the details cannot"),
        ({"details": "out.json"}, r"out\.json is the file of figures, so the details cannot"),
    ],
)
def test_nothing_is_written_over_what_is_read_or_over_the_other_file(manifest, changes, words):
    before = [(path, path.read_bytes()) for path in manifest.parent.iterdir()]
    places = {name: manifest.parent / place for name, place in changes.items()}
    with pytest.raises(ManifestError, match=words):
        evaluate(CONFIG, job(manifest, **places))
    assert [(path, path.read_bytes()) for path, _ in before] == before
    assert not (manifest.parent / "out.json").exists()


def test_sound_damaged_behind_its_header_is_named_by_its_row(tmp_path):
    soundfile.write(tmp_path / "a.flac", say("stop"), RATE)
    whole = (tmp_path / "a.flac").read_bytes()
    (tmp_path / "a.flac").write_bytes(whole[:200] + bytes(len(whole) - 200))
    clip = LabelledClip(5, tmp_path / "a.flac", "stop", "stop")
    hears = FakeRecognizer(), make_detector()
    evaluator = Evaluator(lambda clock: Pipeline(CONFIG, *hears, clock), "active")
    with pytest.raises(ManifestError, match=r"row 5: .*damaged after"):
        evaluator(clip)


def test_the_clock_adds_the_work_to_the_stream():
    timer = SimpleNamespace(now=7.0)  # seconds of work
    clock = StreamClock(lambda: timer.now)
    clock.begin(1.0)
    assert clock() == 1.0
    timer.now += 0.2
    assert clock() == pytest.approx(1.2)
    clock.end()
    clock.begin(1.1)  # arrived while the work before it went on
    assert clock() == pytest.approx(1.2)
    timer.now += 0.1
    clock.end()
    timer.now += 99.0  # between frames nothing is worked
    clock.begin(5.0)
    assert clock() == 5.0
    assert clock.compute == pytest.approx(0.3)


def outcome(phrase, *commands):
    taken = tuple(Taken(c, c, 0.1 * (i + 1), 0.9) for i, c in enumerate(commands))
    return ClipOutcome(LabelledClip(2, None, phrase, phrase), 36.0, taken, (), (), 0.5, 37.0)


def test_a_wrong_command_beside_the_right_one_is_a_confusion():
    assert verdict(outcome("tense", "tense")) == "correct"
    assert verdict(outcome("tense", "tense", "tense")) == "correct"
    assert verdict(outcome("tense", "tense", "stop")) == "stop"
    assert verdict(outcome("tense")) == "rejected"


def test_false_commands_are_counted_per_hour_and_rates_of_nothing_are_none():
    negatives = summarize([outcome("", "stop", "tense"), outcome("")], ("stop",))["negatives"]
    assert negatives["hours"] == pytest.approx(0.02)
    assert negatives["accepted_per_hour"] == pytest.approx(100.0)
    figures = summarize([], ("stop",))
    assert figures["accuracy"] is figures["real_time_factor"] is None
    assert figures["negatives"]["accepted_per_hour"] is None


def test_percentiles_are_those_of_the_clips():
    said = LabelledClip(2, None, "stop", "stop")
    taken = [(Taken("stop", "stop", i / 1e3, 1.0),) for i in range(101)]
    outcomes = [ClipOutcome(said, 1.0, one, (), (), 0, 1) for one in taken]
    latency = summarize(outcomes, ("stop",))["latency_ms"]["stop"]
    assert latency == pytest.approx({"p50": 50.0, "p95": 95.0, "p99": 99.0})
