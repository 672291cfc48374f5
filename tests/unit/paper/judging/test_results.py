# SPDX-License-Identifier: BSD-3-Clause
import math

import pytest

from paper.config import PaperVoiceConfig, chosen_voices, load_experiment
from paper.folders import finish, is_finished, set_aside, settings_of
from paper.judging.outcomes import PhraseOutcome
from paper.judging.results import VoiceResult, figures, row
from paper.play.plan import COMMANDS
from typed_config import ConfigError

PAPER = {"pull more": 2.39, "stop": 1.29}
NATIVE = PaperVoiceConfig(name="a", engine="flite", voice="rms", accent="American", is_native=True)
OTHER = PaperVoiceConfig(name="b", engine="phonemes", voice="de", accent="German", is_native=False)


def said(command, taken=None, decided=0.3, acted=0.5, **other):
    values = {
        "command": command,
        "words": command or "rowboat",
        "taken": ((command,) if command else ()) if taken is None else taken,
        "refusal": "",
        "is_counted": True,
        "is_whole": True,
        "decided": decided,
        "acted": acted,
    }
    return PhraseOutcome(**{**values, **other})


def missed(command, *taken):
    return said(command, taken=taken, decided=math.nan, acted=math.nan)


def named(results):
    return {f.name: f for f in figures(results, PAPER, "RTX A6000")}


def test_a_command_is_counted_right_wrong_and_missed():
    result = VoiceResult(
        NATIVE,
        (
            said("pull more"),
            said("pull more", decided=0.5, acted=0.9),
            missed("pull more"),
            missed("pull more", "pull less"),
            said("stop"),
        ),
    )
    r = row("pull more", [result])
    assert (r.said, r.correct) == (4, 2)
    assert r.others == {"nothing": 1, "pull less": 1}
    assert r.decided == (0.3, 0.5) and r.acted == (0.5, 0.9)


def test_what_the_prompter_said_and_torn_sound_are_left_out_and_said_so():
    results = [
        VoiceResult(
            NATIVE, (said("stop"), said("stop", is_counted=False), said("stop", (), is_whole=False))
        )
    ]
    assert row("stop", results).said == 1
    found = named(results)
    assert found["phrases left out: sound torn by the player"].value == 1
    assert found["phrases left out: said so that the dialogue goes on"].value == 1


def test_the_figures_stand_beside_the_papers():
    results = [VoiceResult(NATIVE, (said("pull more", acted=0.5), said("pull more", acted=0.7)))]
    found = named(results)["pull more: end of sound to the robot's first motion, mean"]
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


def test_native_and_other_voices_are_counted_apart():
    results = [
        VoiceResult(NATIVE, (said("stop"), said("tense"))),
        VoiceResult(OTHER, (said("stop"), missed("tense"))),
    ]
    found = named(results)
    assert found["all voices: commands recognised"].value == 75.0
    assert found["native voices: commands recognised"].value == 100.0
    assert found["non-native voices: commands recognised"].value == 50.0
    assert found["b (German): commands recognised"].value == 50.0


def test_bounds_are_those_of_voices_that_differ():
    clear = VoiceResult(NATIVE, (said("stop"),) * 30 + (said(""),) * 30)
    unclear = (missed("stop"),) * 30 + (said("", taken=("stop",)),) * 30
    found = named([clear, VoiceResult(OTHER, unclear)])
    for name in ("stop: recognised", "all voices: commands recognised"):
        assert (found[name].value, found[name].lower) == (50.0, 0.0)
    taken = found["talk taken for any command"]
    assert (taken.value, taken.upper) == (50.0, 100.0)


def test_talk_that_was_taken_is_counted_and_named():
    results = [VoiceResult(NATIVE, (said(""), said("", taken=("hey robot",)), said("stop")))]
    found = named(results)
    assert found["talk taken for a motion"].value == 0.0
    wrong = found["talk taken for any command"]
    assert wrong.value == 50.0 and "'rowboat' for hey robot" in wrong.note
    assert wrong.is_met is False


def test_a_refused_command_is_right_but_counted_as_refused():
    results = [VoiceResult(NATIVE, (said("pull more", refusal="tension limit", acted=math.nan),))]
    found = named(results)
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
