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
from voice_assist.errors import ManifestError, ModelError, VoiceError
from voice_assist.evaluation import command as evaluate_module
from voice_assist.evaluation.command import Job, evaluate
from voice_assist.evaluation.evaluator import Evaluator, LabelledClip, StreamClock
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.types import RATE

CONFIG = load_voice_config()


def write(path, text):
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


@pytest.fixture
def noise(tmp_path):
    folder = tmp_path / "noise"
    folder.mkdir()
    hiss = 0.1 * np.random.default_rng(0).standard_normal(RATE)
    soundfile.write(folder / "hiss.wav", hiss, RATE)
    soundfile.write(folder / "fan", hiss, RATE, format="FLAC")
    (folder / "readme.txt").write_text("no sound")
    return folder


def test_noise_is_added_at_the_level_asked_for(manifest, fakes, noise):
    figures = evaluate(CONFIG, job(manifest, noise=noise, snr_db=30.0))
    assert figures["snr_db"] == 30.0
    assert figures["noise_files"] == [str(noise / "fan"), str(noise / "hiss.wav")]
    assert figures["commands"]["pull less"]["correct"] == 1


def test_noise_that_is_damaged_or_silent_is_named(manifest, fakes, noise):
    whole = (noise / "fan").read_bytes()
    (noise / "hiss.wav").write_bytes(b"RIFF")
    (noise / "fan").write_bytes(whole[: len(whole) // 2])
    soundfile.write(noise / "silent.ogg", np.zeros(RATE), RATE)
    with pytest.raises(ManifestError) as refused:
        evaluate(CONFIG, job(manifest, noise=noise, snr_db=30.0))
    first, *each = str(refused.value).splitlines()
    assert first == f"{noise}: 3 sound files cannot be used"
    names = ("fan: damaged", "hiss.wav: not a sound file", "silent.ogg: silent")
    assert len(each) == len(names)
    for line, name in zip(each, names, strict=True):
        assert line.startswith(f"  {noise}/{name}")


@pytest.mark.parametrize(
    ("folder", "said"),
    [
        ("missing", "missing: no such folder"),
        (".", "no sound files in it"),
        ("readme.txt", "readme.txt: not a folder"),
    ],
)
def test_a_folder_without_noise_is_refused_before_the_model_is_loaded(
    manifest, tmp_path_factory, folder, said, monkeypatch
):
    monkeypatch.setattr(evaluate_module, "make_recognizer", lambda _: pytest.fail("loaded"))
    made = tmp_path_factory.mktemp("noise")
    (made / "readme.txt").write_text("no sound")
    noise = made / folder
    with pytest.raises(ManifestError, match=said):
        evaluate(CONFIG, job(manifest, noise=noise, snr_db=6.0, jobs=2))


def test_a_damaged_network_is_named_before_a_process_begins(manifest, fakes, monkeypatch):
    def damaged(*_):
        raise ModelError("spotter.pt is damaged")

    monkeypatch.setattr(evaluate_module, "make_pipeline", damaged)
    with pytest.raises(ModelError, match=r"spotter\.pt is damaged"):
        evaluate(CONFIG, job(manifest, jobs=2))


def test_figures_that_cannot_be_written_leave_the_old_ones(manifest, fakes, monkeypatch):
    old = manifest.parent / "out.json"
    old.write_text("of an earlier run")

    def full(path, *_, **__):
        path.touch()
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    before = sorted(manifest.parent.iterdir())
    with pytest.raises(ManifestError, match=r"out\.json cannot be written: No space left"):
        evaluate(CONFIG, job(manifest))
    assert old.read_text() == "of an earlier run"
    assert sorted(manifest.parent.iterdir()) == before


def test_figures_go_to_the_file_behind_a_link_and_to_a_device(manifest, fakes):
    link, behind = manifest.parent / "link.json", manifest.parent / "behind.json"
    behind.touch()
    link.symlink_to(behind)
    evaluate(CONFIG, job(manifest, out=link))
    assert link.is_symlink() and json.loads(behind.read_text())["n"] == 7
    evaluate(CONFIG, job(manifest, out=Path("/dev/null")))
    assert not Path("/dev/null").is_file()


def test_a_process_that_dies_is_named_in_one_line(manifest, fakes, monkeypatch):
    def broken(*_, **__):
        raise BrokenProcessPool

    monkeypatch.setattr(evaluate_module.ProcessPoolExecutor, "map", broken)
    with pytest.raises(VoiceError, match="one of 2 processes ended too early"):
        evaluate(CONFIG, job(manifest, jobs=2))


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
