# SPDX-License-Identifier: BSD-3-Clause
from pathlib import Path

import pytest

from demo.check import ControllerSample, HeardUtterance, Observed, verdicts, worst_rcm_error
from demo.script import Script, ScriptSpeech, ScriptStep, load_script
from typed_config import ConfigError

SPEECH = ScriptSpeech(surgeon="en", people="en", words_per_minute=150, snr_db=15.0, seed=1)


def session(say, effect, heard, before, after, moving=()):
    """One step at 1 s within 5 s: state before it, path speeds while it runs, state after it."""
    script = Script(
        speech=SPEECH,
        duration=5.0,
        steps=(ScriptStep(at=1.0, speaker="surgeon", say=say, effect=effect),),
    )
    observed = Observed()
    base = {
        "state": "active",
        "active": True,
        "halted": False,
        "tissue_held": True,
        "tension": 0.5,
        "path_speed": 0.0,
        "rcm_error": 0.0,
    }
    observed.states.append(ControllerSample(time=0.9, **{**base, **before}))
    for i, speed in enumerate(moving):
        observed.states.append(
            ControllerSample(time=1.5 + 0.1 * i, **{**base, "path_speed": speed, "rcm_error": 2e-6})
        )
    observed.states.append(ControllerSample(time=4.9, **{**base, **after}))
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


def test_silence_of_the_controller_is_a_step_that_did_not_happen():
    script, _ = session("tense", "tense", "tense", {}, {})
    verdict = verdicts(script, Observed())[0]
    assert not verdict.happened and "said nothing" in verdict.found


@pytest.mark.parametrize(("start", "happened"), [(0.85, True), (0.7, False), (4.9, False)])
def test_speech_may_be_told_a_moment_early_and_belongs_to_its_step(start, happened):
    script, observed = session("hey robot", "cleared", None, {"halted": True}, {})
    observed.heard.append(HeardUtterance(start, "hey robot", "hey robot"))
    assert [v.happened for v in verdicts(script, observed)] == [happened]


def test_rcm_error_counts_only_while_moving():
    _, observed = session("tense", "tense", "tense", {"rcm_error": 1.0}, {}, moving=(0.02, 0.02))
    assert worst_rcm_error(observed) == 2e-6


def test_the_shipped_script_names_all_seven_commands_and_talk():
    script = load_script(Path(__file__).parents[3] / "demo" / "session.yaml")
    said = [step.say for step in script.steps]
    commands = {"hey robot", "tense", "pull more", "pull less", "stop", "release", "terminate"}
    assert commands <= set(said)
    assert any(step.effect == "nothing" for step in script.steps)
    assert script.duration < 120.0


def test_steps_out_of_order_are_refused(tmp_path):
    shipped = Path(__file__).parents[3] / "demo" / "session.yaml"
    file = tmp_path / "session.yaml"
    file.write_text(shipped.read_text().replace("at: 2.0,", "at: 60.5,"))
    with pytest.raises(ConfigError, match="rising order"):
        load_script(file)
