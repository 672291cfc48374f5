# SPDX-License-Identifier: BSD-3-Clause
import math

import pytest

from paper.config import PaperVoiceConfig, chosen_voices, load_experiment
from paper.folders import finish, is_finished, set_aside, settings_of
from paper.judging.outcomes import PhraseOutcome
from paper.judging.recording import VERDICT, Recorded
from paper.judging.results import VoiceResult, figures, row
from paper.judging.trials import SpokenTrial
from paper.play.demonstration import ATTEMPTS, ORDER, InOrder, shown
from paper.play.plan import COMMANDS, DialogueState
from typed_config import ConfigError

PAPER = {"pull more": 2.39, "stop": 1.29}
NATIVE = PaperVoiceConfig(name="a", engine="flite", voice="rms", accent="American", is_native=True)
OTHER = PaperVoiceConfig(name="b", engine="phonemes", voice="de", accent="German", is_native=False)


def said(command, taken=None, decided=0.3, acted=0.5, **other):
    values = {
        "command": command,
        "words": command or "rowboat",
        "taken": ((command,) if command else ()) if taken is None else taken,
        "transcript": "",
        "reason": "",
        "refusal": "",
        "interrupts": "",
        "is_counted": True,
        "is_whole": True,
        "decided": decided,
        "acted": acted,
        "rested": math.nan,
        "detected": 0.1,
        "sounded": 0.05,
        "confidence": 0.9,
    }
    return PhraseOutcome(**{**values, **other})


def missed(command, *taken):
    return said(command, taken=taken, decided=math.nan, acted=math.nan)


def named(told):
    return {f.name: f for f in figures(told, PAPER, "RTX A6000")}


def test_a_command_is_counted_right_wrong_and_missed():
    told = VoiceResult(
        NATIVE,
        (
            said("pull more"),
            said("pull more", decided=0.5, acted=0.9),
            missed("pull more"),
            missed("pull more", "pull less"),
            said("stop"),
        ),
    )
    r = row("pull more", [told])
    assert (r.said, r.correct) == (4, 2)
    assert r.others == {"nothing": 1, "pull less": 1}
    assert r.decided == (0.3, 0.5) and r.acted == (0.5, 0.9)


def test_what_the_prompter_said_and_torn_sound_are_left_out_and_said_so():
    told = [
        VoiceResult(
            NATIVE, (said("stop"), said("stop", is_counted=False), said("stop", (), is_whole=False))
        )
    ]
    assert row("stop", told).said == 1
    found = named(told)
    assert found["phrases left out: sound torn by the player"].value == 1
    assert found["phrases left out: said by the prompter"].value == 1


def test_the_figures_stand_beside_the_papers():
    told = [VoiceResult(NATIVE, (said("pull more", acted=0.5), said("pull more", acted=0.7)))]
    found = named(told)["pull more: end of sound to the robot's first motion, mean"]
    assert found.value == pytest.approx(0.6)
    assert (found.target, found.unit, found.is_met) == (2.39, "s", True)
    assert "synthetic" in found.note and "RTX A6000" in found.note


def test_the_mean_over_commands_weighs_each_command_once_on_both_sides():
    outcomes = [said("pull more", acted=1.0)] * 3 + [
        said("stop", acted=0.5),
        said("tense", acted=9.0),
    ]
    found = named([VoiceResult(NATIVE, tuple(outcomes))])
    mean = found["mean over commands: end of sound to the robot's action"]
    assert mean.value == pytest.approx(0.75)
    assert mean.target == pytest.approx((2.39 + 1.29) / 2)


def test_native_and_other_voices_are_told_apart():
    told = [
        VoiceResult(NATIVE, (said("stop"), said("tense"))),
        VoiceResult(OTHER, (said("stop"), missed("tense"))),
    ]
    found = named(told)
    assert found["all voices: commands recognised"].value == 75.0
    assert found["native voices: commands recognised"].value == 100.0
    assert found["non-native voices: commands recognised"].value == 50.0
    assert found["b (German): commands recognised"].value == 50.0


def test_talk_that_was_taken_is_counted_and_named():
    told = [VoiceResult(NATIVE, (said(""), said("", taken=("hey robot",)), said("stop")))]
    found = named(told)
    assert found["talk taken for a motion"].value == 0.0
    wrong = found["talk taken for any command"]
    assert wrong.value == 0.5 and "'rowboat' for hey robot" in wrong.note
    assert wrong.is_met is False


def test_a_refused_command_is_right_but_counted_as_refused():
    told = [VoiceResult(NATIVE, (said("pull more", refusal="tension limit", acted=math.nan),))]
    found = named(told)
    assert found["pull more: recognised"].value == 100.0
    assert found["commands heard and refused by the robot"].value == 1


def test_the_shipped_settings_have_native_and_other_voices_first():
    config = load_experiment()
    assert [v.is_native for v in config.voices[:4]].count(True) == 2
    assert not set(config.talk) & set(COMMANDS)


def test_voices_are_chosen_by_number_or_name_among_those_installed():
    config = load_experiment()
    names = [v.name for v in config.voices]
    some = frozenset(names[1:])
    assert [v.name for v in chosen_voices(config, "2", some)] == names[1:3]
    assert [v.name for v in chosen_voices(config, f"{names[3]}, {names[1]}", some)] == [
        names[3],
        names[1],
    ]
    for wrong in ("0", str(len(names)), names[0], "nobody"):
        with pytest.raises(ConfigError):
            chosen_voices(config, wrong, some)


def test_a_finished_session_is_kept_only_for_the_same_settings(tmp_path):
    config = load_experiment()
    folder = tmp_path / "paper_3" / "a"
    folder.mkdir(parents=True)
    settings = settings_of(config, NATIVE, 3)
    assert not is_finished(folder, settings)
    finish(folder, settings)
    assert is_finished(folder, settings)
    assert not is_finished(folder, settings_of(config, NATIVE, 4))
    assert not is_finished(folder, settings_of(config, OTHER, 3))


def test_an_unfinished_session_is_moved_away_and_not_lost(tmp_path):
    folder = tmp_path / "paper_3" / "a"
    assert set_aside(folder) is None
    folder.mkdir(parents=True)
    (folder / "session.mcap").write_bytes(b"sound")
    aside = set_aside(folder)
    assert not folder.exists() and (aside / "session.mcap").read_bytes() == b"sound"
    assert folder.parent not in aside.parents


def test_the_demonstration_says_every_command_once_in_order():
    plan, now, order = InOrder(), DialogueState(False, False, False, False), []
    after = {
        "hey robot": DialogueState(True, True, False, False),
        "tense": DialogueState(True, True, False, True, 1.0),
        "pull more": DialogueState(True, True, False, True, 1.2),
        "pull less": DialogueState(True, True, False, True, 1.0),
        "release": DialogueState(True, True, True, False),
        "terminate": DialogueState(False, False, True, False),
    }
    while planned := plan.next(now):
        order.append(planned.command)
        if planned.stop_at:
            order.append(plan.interrupt().command)
        now = after[planned.command]
    assert tuple(order) == ORDER


def test_a_command_without_effect_is_said_again_but_not_for_ever():
    plan, standby = InOrder(), DialogueState(False, False, False, False)
    said_ = []
    while planned := plan.next(standby):
        said_.append(planned.command)
    assert said_ == ["hey robot"] * ATTEMPTS


def test_a_stop_that_was_not_heard_in_the_release_is_said_at_rest():
    plan = InOrder()
    held = DialogueState(True, True, False, True, 1.0)
    order = [plan.next(DialogueState(False, False, False, False)), plan.next(held), plan.next(held)]
    order += [plan.next(DialogueState(True, True, False, True, 1.3)), plan.next(held)]
    assert order[-1].command == "release"
    plan.interrupt()
    assert plan.next(DialogueState(True, True, False, False)).command == "stop"
    assert plan.next(DialogueState(True, True, True, False)).command == "terminate"


def test_the_tissue_is_shown_as_it_was_before_the_next_command():
    trials = [SpokenTrial(i, c, c, "", t, t + 1.0, 1.0, 0.5, True, "") for i, c, t in
              ((1, "tense", 10.0), (2, "release", 30.0))]  # fmt: skip
    tissue = [(t, {VERDICT: w}) for t, w in ((9.0, "free"), (20.0, "held"), (29.0, "triangulated"))]
    states = shown(trials, Recorded(tissue=tissue))
    assert [(s.command, s.tissue[VERDICT]) for s in states] == [
        ("tense", "triangulated"),
        ("release", "unknown"),
    ]
