# SPDX-License-Identifier: BSD-3-Clause
from pathlib import Path

import pytest

from demo.check import (
    ControllerSample,
    Done,
    HeardUtterance,
    Observed,
    verdicts,
    worst_rcm_error,
)
from demo.script import Script, ScriptSpeech, ScriptStep, load_script
from demo.sound import render
from typed_config import ConfigError

SHIPPED = Path(__file__).resolve().parents[3] / "demo" / "session.yaml"
SPEECH = ScriptSpeech(surgeon="en", people="en", words_per_minute=150, snr_db=15.0, seed=1)

REST = {
    "state": "active",
    "active": True,
    "halted": False,
    "tissue_held": True,
    "tension": 0.5,
    "path_speed": 0.0,
    "rcm_error": 0.0,
    "insertion": 0.05,
}


def session(say, effect, heard, before, after, moving=(), speaker="surgeon"):
    """One step at 1 s within 5 s: state before it, path speeds while it runs, state after it."""
    script = Script(
        speech=SPEECH,
        duration=5.0,
        steps=(ScriptStep(at=1.0, speaker=speaker, say=say, effect=effect),),
    )
    observed = Observed()
    observed.states.append(ControllerSample(time=0.9, **{**REST, **before}))
    for i, speed in enumerate(moving):
        observed.states.append(
            ControllerSample(time=1.5 + 0.1 * i, **{**REST, "path_speed": speed, "rcm_error": 2e-6})
        )
    observed.states.append(ControllerSample(time=4.9, **{**REST, **after}))
    if heard is not None:
        observed.heard.append(HeardUtterance(1.1, heard, heard))
    return script, observed


@pytest.mark.parametrize(
    ("say", "effect", "heard", "before", "after", "moving", "happened"),
    [
        ("pull more", "more", "pull more", {}, {"tension": 0.8}, (0.01,), True),
        ("pull more", "more", "pull more", {}, {"tension": 0.5}, (0.01,), False),
        ("pull more", "more", "pull less", {}, {"tension": 0.8}, (0.01,), False),
        ("pull more", "more", None, {}, {"tension": 0.8}, (0.01,), False),
        ("pull less", "less", "pull less", {}, {"tension": 0.3}, (-0.01,), True),
        ("some talk", "nothing", None, {}, {}, (), True),
        ("some talk", "nothing", "stop", {}, {}, (), False),
        ("some talk", "nothing", None, {}, {}, (0.01,), False),
        ("stop", "stopped", "stop", {}, {"halted": True}, (0.01,), True),
        ("stop", "stopped", "stop", {}, {"halted": True}, (), False),
        ("stop", "stopped", "stop", {}, {}, (0.01,), False),
        ("stop", "stopped", "stop", {}, {"halted": True, "tissue_held": False}, (0.01,), False),
        ("hey robot", "cleared", "hey robot", {"halted": True}, {}, (), True),
        ("release", "released", "release", {}, {"tissue_held": False, "tension": 0.0}, (), True),
        ("release", "released", "release", {}, {"tissue_held": False, "tension": 0.2}, (), False),
        ("terminate", "standby", "terminate", {}, {"active": False}, (), True),
    ],
)
def test_a_step_happened_only_when_its_effect_was_seen(
    say, effect, heard, before, after, moving, happened
):
    script, observed = session(say, effect, heard, before, after, moving)
    assert [v.happened for v in verdicts(script, observed)] == [happened]


@pytest.mark.parametrize(("heard_at", "happened"), [(2.0, True), (3.2, True), (4.2, False)])
def test_a_motion_that_is_stopped_next_may_begin_while_that_is_said(heard_at, happened):
    said = ((1.0, "pull more", "moving"), (3.0, "stop", "stopped"), (4.0, "hey robot", "cleared"))
    steps = tuple(ScriptStep(at=t, speaker="surgeon", say=w, effect=e) for t, w, e in said)
    samples = ((0.9, 0.0), (heard_at + 0.1, 0.01), (4.9, 0.0))
    states = [ControllerSample(time=t, **{**REST, "path_speed": v}) for t, v in samples]
    observed = Observed(states, [HeardUtterance(heard_at, "pull more", "pull more")])
    script = Script(speech=SPEECH, duration=5.0, steps=steps)
    assert verdicts(script, observed)[0].happened is happened


def test_silence_of_the_controller_is_a_step_that_did_not_happen():
    script, _ = session("tense", "tense", "tense", {}, {})
    verdict = verdicts(script, Observed())[0]
    assert not verdict.happened and "said nothing" in verdict.found


@pytest.mark.parametrize(("start", "happened"), [(0.85, True), (0.7, False), (4.9, False)])
def test_speech_may_be_reported_a_moment_early_and_belongs_to_its_step(start, happened):
    script, observed = session("hey robot", "cleared", None, {"halted": True}, {})
    observed.heard.append(HeardUtterance(start, "hey robot", "hey robot"))
    assert [v.happened for v in verdicts(script, observed)] == [happened]


def test_rcm_error_counts_only_while_moving():
    _, observed = session("tense", "tense", "tense", {"rcm_error": 1.0}, {}, moving=(0.02, 0.02))
    assert worst_rcm_error(observed) == 2e-6


def test_rcm_error_counts_only_in_the_patient():
    outside = {"rcm_error": 1.0, "insertion": -0.001, "path_speed": 0.02}
    _, observed = session("tense", "tense", "tense", outside, {}, moving=(0.02, 0.02))
    assert worst_rcm_error(observed) == 2e-6


def test_the_shipped_script_names_all_seven_commands_and_talk():
    script = load_script(SHIPPED)
    said = [step.say for step in script.steps]
    commands = {"hey robot", "tense", "pull more", "pull less", "stop", "release", "terminate"}
    assert commands <= set(said)
    assert any(step.effect == "nothing" for step in script.steps)
    assert script.duration < 120.0


def test_steps_out_of_order_are_refused(tmp_path):
    file = tmp_path / "session.yaml"
    file.write_text(SHIPPED.read_text().replace("at: 2.0,", "at: 60.5,"))
    with pytest.raises(ConfigError, match="rising order"):
        load_script(file)


@pytest.mark.parametrize(
    ("speaker", "say", "done", "happened"),
    [
        ("pedal", "pull more", [Done(1.2, "pull more", "pulls more")], True),
        ("hand", "pull more 0.2 N", [Done(1.2, "pull more", "pulls more")], True),
        ("hand", "pull more 0.2 N", [Done(1.2, "pull less", "pulls less")], False),
        ("pedal", "pull more", [Done(0.5, "pull more", "of the step before")], False),
        ("pedal", "pull more", [], False),
    ],
)
def test_what_nobody_says_is_judged_by_what_the_robot_accepted(speaker, say, done, happened):
    script, observed = session(say, "more", None, {}, {"tension": 0.8}, (0.01,), speaker)
    observed.done += done
    assert verdicts(script, observed)[0].happened is happened


@pytest.mark.parametrize(
    ("heard", "done", "happened"),
    [
        ("light on", [Done(1.4, "light on", "")], True),
        ("light on", [], False),
        (None, [Done(1.4, "light on", "")], False),
    ],
)
def test_a_light_is_heard_and_switched(heard, done, happened):
    script, observed = session("light on", "light", heard, {}, {})
    observed.done += done
    assert script.has_devices and verdicts(script, observed)[0].happened is happened


def test_a_pedal_and_a_hand_make_no_sound():
    script, _ = session("pull more", "more", None, {}, {}, speaker="pedal")
    spoken, _ = session("pull more", "more", None, {}, {})
    after = slice(16_000, 32_000)
    power = [float((render(one)[after] ** 2).mean()) for one in (script, spoken)]
    assert power[0] < 0.2 * power[1]


def test_the_shipped_demo_has_every_way_and_four_pictures_of_the_page():
    script = load_script(SHIPPED)
    assert {step.speaker for step in script.steps} == {"surgeon", "people", "pedal", "hand"}
    moments = [step.moment for step in script.steps if step.moment]
    assert moments == ["tense", "light", "pedal", "stopped"]
