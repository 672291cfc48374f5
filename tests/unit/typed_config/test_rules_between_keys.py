# SPDX-License-Identifier: BSD-3-Clause
"""Settings of which each key alone is allowed, and which contradict each other."""

import pytest

from tests.unit.typed_config.settings_files import at, changed, content, kinds
from typed_config import ConfigError, load_config

KINDS = {path.name: (path, kind) for path, kind in kinds().items()}
PHRASES = ("hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate")
HEY, TENSE, STOP, TERMINATE = (
    PHRASES.index(p) for p in ("hey robot", "tense", "stop", "terminate")
)


def refused(file, place, value):
    """Text of the refusal; empty: it is accepted."""
    path, kind = KINDS[file]
    data = content(path)
    with changed(data, place, value(at(data, place)) if callable(value) else value):
        try:
            load_config(kind, data, file)
        except ConfigError as error:
            return str(error)
    return ""


RULES = [
    ("limits.yaml", ("layer",), "softer", "layer is 'softer', allowed: one of hard, driver_soft"),
    ("limits.yaml", ("layers",), lambda old: [old[0], old[0]], "names that differ"),
    ("rcm.yaml", ("insertion",), [0.25, 0.05], "insertion is [0.25, 0.05], allowed: the smaller"),
    ("rcm.yaml", ("insertion",), [0.05, 0.05], "the smaller number first"),
    ("rcm.yaml", ("measured_tolerance",), 1e-6, "registration.tolerance is 0.001"),
    ("rcm.yaml", ("registration", "tolerance"), 0.0011, "up to measured_tolerance, 0.001"),
    ("rcm.yaml", ("planned_tolerance",), 1e-9, ""),
    ("rcm.yaml", ("solver", "tolerance"), 1e-8, ""),
    ("scene.yaml", ("home",), lambda old: old[:8], "home is ["),
    ("scene.yaml", ("outward",), [0, 0, 0], "outward is [0.0, 0.0, 0.0], allowed: three numbers"),
    ("scene.yaml", ("approach_axis",), [1.0, 0.0], "[] or three numbers, not all 0"),
    ("scene.yaml", ("pull_direction",), [0, 0, 0], "[] or three numbers, not all 0"),
    ("scene.yaml", ("jaw_axis",), [0.0, 0.1, 1.0], "square to approach_axis"),
    ("scene.yaml", ("jaw_axis",), [], ""),
    ("scene.yaml", ("tissue", "along"), [0, 0, 0], "tissue.along is"),
    ("scene.yaml", ("tissue", "across"), [0.0, 0.001, 1.0], "another direction than along"),
    ("scene.yaml", ("tissue", "rim"), [], "tissue.rim is [], allowed: at least one of"),
    ("scene.yaml", ("tissue", "reference_pull"), [0, 0, 0], "tissue.reference_pull is"),
    ("scene.yaml", ("triangulation", "tension"), [2.0, 0.3], "triangulation.tension is [2.0, 0.3]"),
    ("controller.yaml", ("tension", "maximum"), 2.4, "tension.maximum is 2.4, allowed: below 2.4"),
    ("controller.yaml", ("tension", "initial"), 2.1, "tension.initial is 2.1, allowed: 0.1 to 2.0"),
    ("controller.yaml", ("tension", "minimum"), 1.0, ""),
    ("controller.yaml", ("tension", "stiffness_range"), [20.0, 20.0], "stiffness_range is"),
    ("controller.yaml", ("tension", "blind_stiffness"), 600.0, "slack_way is 0.01, allowed: up to"),
    (
        "controller.yaml",
        ("watchdogs", "sensors", "tension_deficit"),
        0.41,
        "tension_deficit is 0.41, allowed: up to 0.40",
    ),
    ("controller.yaml", ("rate",), 50.0, ""),
    ("controller.yaml", ("state_rate",), 200.0, ""),
    ("kinova_bridge.yaml", ("arm", "joints"), ["joint_1"] * 7, "names that differ"),
    ("kinova_bridge.yaml", ("arm", "feedback_age"), 0.02, "above 1 / feedback_rate"),
    ("kinova_bridge.yaml", ("arm", "end_tolerance"), 0.03, "up to following_error"),
    ("kinova_bridge.yaml", ("tool", "signs"), [1.0, 0.5, 1.0], "1 or -1"),
    ("kinova_bridge.yaml", ("tool", "joints"), ["a", "b"], "names that differ"),
    ("kinova_bridge.yaml", ("guard",), lambda g: {**g, "repeat": 0.2, "insist": 0.1}, "repeat on"),
    ("kinova_bridge.yaml", ("guard", "silence"), 0.035, "from two beats"),
    ("kinova_bridge.yaml", ("rate",), 60.0, "at least two"),
    ("plant.yaml", ("drives", "sliding_friction"), [9.0] * 7, "sliding_friction"),
    ("plant.yaml", ("body_wall", "way"), [0.0, 0.0, 0.0], "way"),
    ("kinova_stand_in.yaml", ("driver", "joints"), ["joint_1"] * 7, "seven names that differ"),
    ("kinova_stand_in.yaml", ("driver", "torque", "sign"), 0.5, "sign is 0.5, allowed: 1 or -1"),
    ("kinova_stand_in.yaml", ("tool", "signs"), [1, 1, 0], "allowed: 1 or -1 each"),
    ("kinova_stand_in.yaml", ("tool", "tissue_opening"), 0.05, "below closed_opening below held"),
    ("simulator.yaml", ("start_position",), [0.0] * 8, "a list of 9 angles"),
    ("simulator.yaml", ("physics_rate",), 750.0, "physics_rate is 750.0, allowed: a whole"),
    ("simulator.yaml", ("held_opening",), 0.02, "held_opening is 0.02, allowed: above closed"),
    ("simulator.yaml", ("servo", "lead"), 0.05, "servo.lead is 0.05, allowed: from catch_up on"),
    ("simulator.yaml", ("servo", "stale_after"), 0.002, "servo.stale_after is 0.002"),
    ("simulator.yaml", ("servo", "brake_deceleration"), [5.0] * 9, "a list of 10 numbers"),
    ("gen3_openrst.yaml", ("joints", 1, "upper"), 1.0, "joints[1].upper is 1.0, allowed: 0 where"),
    ("gen3_openrst.yaml", ("joints", 2, "velocity"), 0.0, "joints[2].velocity is 0.0"),
    ("gen3_openrst.yaml", ("links", 9, "mass"), 40.0, "links[9].mass is 40.0, allowed"),
    ("gen3_openrst.yaml", ("visuals", 0, "colour"), "pink", "visuals[0].colour is 'pink'"),
    ("gen3_openrst.yaml", ("visuals", 0, "shape"), "box", "visuals[0].box is"),
    ("audio.yaml", ("source",), "wav", "wav.path is '', allowed: a sound file"),
    ("audio.yaml", ("denoise", "high_pass"), 0.08, "denoise.high_pass is 0.08"),
    ("audio.yaml", ("denoise", "high_pass"), 0, ""),
    ("audio.yaml", ("vad", "stop"), 0.5, "vad.stop is 0.5, allowed: up to resume, 0.4"),
    ("recognizer.yaml", ("early", "settle"), 0.128, "early.settle is 0.128, allowed: below pause"),
    ("recognizer.yaml", ("early", "first_stop_confidence"), 0.7, "from vote_confidence on, 0.75"),
    ("spotter.yaml", ("agree",), 3.0, "agree is 3.0, allowed: up to middle, 2 nat"),
    ("recorder.yaml", ("exclude",), ["/a("], "exclude[0] is '/a(', allowed: a regular expression"),
    ("recorder.yaml", ("wait_for",), ["tension"], "wait_for[0] is 'tension', allowed: the whole"),
    ("recorder.yaml", ("low_space",), 1000, "low_space is 1000, allowed: 0"),
    ("recorder.yaml", ("low_space",), 0, ""),
    ("report.yaml", ("topics", "tension"), "robot tension", "topics.tension is 'robot tension'"),
    ("replay.yaml", ("topics", "mode"), "mode/", "topics.mode is 'mode/'"),
    ("replay.yaml", ("pipeline",), "os", "pipeline is 'os', allowed: module:function"),
    ("experiment.yaml", ("rate",), [1.2, 0.85], "rate is"),
    ("experiment.yaml", ("voices",), lambda old: [old[0], old[0]], "names that differ"),
]

COMMANDS = [
    (STOP, "is_halt", False, "commands is [", "at least one with is_halt"),
    (
        HEY,
        "mode_after",
        "same",
        "commands is [",
        "at least one that counts in standby and leads to",
    ),
    (HEY, "modes", ["active"], "commands is [", "such as hey robot"),
    (TENSE, "phrase", "Stop!", "commands[5].phrase is 'stop'", "'Stop!' belongs to 'Stop!'"),
    (TENSE, "phrase", "release", "commands[2].phrase is 'release'", "a name given once"),
    (TENSE, "phrase", "", "commands[1].phrase is ''", "not empty"),
    (TENSE, "phrase", "?!", "commands[1].phrase is '?!'", "has no word"),
    (TENSE, "phrase", "натянуть", "commands[1].phrase is", "letters a to z"),
    (TENSE, "phrase", "téndre", "commands[1].phrase is", "letters a to z"),
    (TENSE, "spellings", ["do not relax"], "spellings[0] is 'do not relax'", "never denies"),
    (TENSE, "spellings", ["don't relax"], "spellings[0] is", "never denies"),
    (TENSE, "spellings", ["tense up", ""], "spellings[1] is ''", "not empty"),
    (TENSE, "spellings", ["stop now"], "is 'stop now'", "belongs to 'tense'"),
    (TENSE, "spellings", ["no relax"], "commands[1].spellings[0] is", "never denies"),
    (TENSE, "spellings", ["stop please now"], "is 'stop please'", "further from 'stop please now'"),
    (STOP, "threshold", 0.5, "'hey robot stop'", "further from 'hey robot'"),
    (TENSE, "threshold", 1.1, "commands[1].threshold is 1.1", "0.01 to 1 WER"),
    (STOP, "threshold", 0.0, "commands[5].threshold is 0.0", "0.01 to 1 WER"),
    (TENSE, "modes", ["asleep"], "commands[1].modes[0] is 'asleep'", "standby, active"),
    (TENSE, "modes", [], "commands[1].modes is []", "standby, active or both"),
    (TENSE, "modes", ["standby", "active"], "commands[1].modes is", "[active], as it is a motion"),
    (STOP, "modes", ["active"], "commands[5].modes is ['active']", "[standby, active]: it halts"),
    (TENSE, "mode_after", "asleep", "commands[1].mode_after is 'asleep'", "same, standby, active"),
    (TENSE, "command", "", "commands[1].command is ''", "what moves"),
    (TENSE, "is_motion", False, "commands[1].is_motion is False", "true, as it calls 'tense'"),
    (STOP, "command", "release", "commands[5]", "true, as it calls 'release'"),
    (STOP, "command", "hey robot", "commands[5].command is 'hey robot'", '"" or stop, as it halts'),
    (STOP, "is_motion", True, "commands[5]", "allowed"),
    (STOP, "min_confidence", 1.0, "commands[5].min_confidence is 1.0", "up to 0.95"),
    (TERMINATE, "command", "", "", ""),
    (TENSE, "spellings", ["stretch it"], "", ""),
    (STOP, "spellings", ["do not go on", "no"], "", ""),
]


def test_settings_that_contradict_each_other_are_refused_and_their_neighbours_are_not():
    failures = []
    for file, place, value, words in RULES:
        found = refused(file, place, value)
        if words not in found or bool(words) != bool(found) or (found and file not in found):
            failures.append(f"{file}: {place} = {value}: {found or 'accepted'}")
    assert not failures, "\n".join(failures)


def test_commands_that_contradict_each_other_are_refused_with_the_place_of_the_key():
    failures = []
    for index, key, value, words, allowed in COMMANDS:
        found = refused("commands.yaml", ("commands", index, key), value)
        is_right = words in found and allowed in found and bool(words) == bool(found)
        if not is_right or (found and "commands.yaml: commands" not in found):
            failures.append(f"{PHRASES[index]}: {key} = {value!r}: {found or 'accepted'}")
    assert not failures, "\n".join(failures)


def test_a_margin_that_leaves_a_joint_no_room_is_refused():
    path, kind = KINDS["limits.yaml"]
    data = content(path) | {"arm_lower": [0.0] * 7, "arm_upper": [0.0] * 7}
    with pytest.raises(ConfigError, match=r"position_margin is 0\.02, allowed: .*joint_1"):
        load_config(kind, data, path.name)


def test_a_body_has_one_shape_and_a_link_one_inertia():
    path, kind = KINDS["gen3_openrst.yaml"]
    data = content(path)
    data["links"][9]["body"]["box"] = [0.1, 0.1, 0.1]
    with pytest.raises(ConfigError, match=r"links\[9\]\.body\.shape is .*one of box, cylinder"):
        load_config(kind, data, path.name)
    data = content(path)
    data["links"][9]["inertia"] = [0.1, 0, 0, 0.1, 0, 0.1]
    with pytest.raises(ConfigError, match=r"links\[9\]\.inertia is .*one of inertia, body"):
        load_config(kind, data, path.name)
