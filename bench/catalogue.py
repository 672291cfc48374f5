# SPDX-License-Identifier: BSD-3-Clause
"""All parts that measure, by area: the one list that `make bench` and docs/measured.md go by.

A new part is a module with `measure() -> list[Figure]` and one row here. Its figures are written to
bench/results/<name>.json, a dot being a folder, and stand on the page after `make figures`. A
figure's target stands beside the code that measures it; what is no figure for a reader (a count
that others already name, a percentile between others) is left to the file by `details`.
"""

from __future__ import annotations

from collections.abc import Iterator

from bench.common.part import HUMAN, SYNTHETIC, Area, Part
from support import product_code as code

_MOTION = Area(
    "Motion",
    "In simulation. **The simulated motors are ideal** within their torque limits: no friction, no "
    "elasticity, no play. The figures prove the controller's arithmetic. A real arm does worse.",
    (
        Part(
            "motion",
            "Planning, execution, tension",
            "motion.suite",
            code.SIMULATION,
            details=(
                r"50 mm/s",
                r"(rms|median|away from ours, max|p95)$",
                r"tool joints.*RCM",
                "settled in all, max$",
                "IK time (p99|max)",
                "time p50$",
                "over processor time",
            ),
            moves="set-points",
        ),
        Part(
            "kinova",
            "Through Kinova's driver, simulated",
            "kinova.suite",
            code.KINOVA,
            details=("speeds times", "median$", "one trajectory goal"),
        ),
        Part(
            "torque_tension",
            "Tension from joint torques",
            "tension.suite",
            code.KINOVA,
            details=("bias$", "no load at all", "friction", r"sigma (as told|told)"),
        ),
    ),
)

_SITE = Area(
    "What a site does",
    "In simulation: failing sensors, tilted bases and lost parts on the way to the arm.",
    (
        Part("site.tension", "A tension sensor that fails", "site.tension", code.SIMULATION),
        Part(
            "site.detection", "Faults seen, by the rate of feedback", "site.detection", code.KINOVA
        ),
        Part("site.stops", "Losses on the way to the arm", "site.stops", code.KINOVA),
        Part(
            "site.turns",
            "Joints without end stops",
            "site.turns",
            code.CONTROLLER,
            moves="set-points",
        ),
        Part(
            "site.plant", "A plant that is not ideal", "site.plant", code.PLANT, moves="set-points"
        ),
        Part(
            "site.plant_velocities",
            "The same, led by velocities",
            "site.plant_velocities",
            code.PLANT,
            moves="velocities",
        ),
        Part(
            "site.near_limits",
            "Joints near their limits",
            "site.near_limits",
            code.CONTROLLER,
            moves="set-points",
        ),
        Part(
            "site.mounting",
            "Tilted bases",
            "site.mounting",
            code.KINOVA,
            details=("session:", "trusted$"),
        ),
    ),
)

_SAFETY = Area(
    "Stop, loss and load",
    "Hazards, guards and tests: [safety.md](safety.md).",
    (
        Part(
            "safety.stops",
            "10,000 stops in process",
            "safety.stops.suite",
            code.CONTROLLER,
            details=(r"at rest p(50|95)$", r"p95$"),
        ),
        Part(
            "safety.stops_system",
            "10,000 stop messages in the running system",
            "safety.stops.system",
            code.ROBOT_NODES,
            details=(r"at rest p(50|95)$", r"p95$"),
        ),
        Part(
            "safety.spoken",
            'A spoken "stop" in motion',
            "safety.spoken.suite",
            code.SYSTEM,
            details=("set-points at rest", r"p99$"),
            decides="motion",
        ),
        Part(
            "safety.losses",
            "A part killed or stopped in motion",
            "safety.losses.suite",
            code.SYSTEM,
            SYNTHETIC,
            (
                r" p\d+$",
                r"movement of the arm",
                r"^load average",
                "way before",
                "return of the part",
            ),
        ),
        Part(
            "safety.network",
            "Two hosts and a bad network",
            "safety.network.suite",
            code.TWO_HOSTS,
            SYNTHETIC,
            (r": trials$", "jaws, max", "rest, measured"),
        ),
        Part(
            "safety.hang",
            "A recogniser that hangs",
            "safety.hang",
            (*code.HEARING, *code.VOICE_NODE),
            details=(r"p(50|95|99)$",),
        ),
        Part(
            "safety.flood",
            "50 callers flood the controller",
            "safety.flood",
            code.ROBOT_NODES,
            details=(r"p(50|95)$",),
        ),
        Part("safety.soak", "A day of session time", "safety.soak.suite", code.SYSTEM, SYNTHETIC),
        Part(
            "safety.sound",
            "Sound that is none",
            "safety.sound.suite",
            code.HEARING,
            SYNTHETIC,
            decides="rest",
        ),
        Part("safety.ends", "Ctrl-C at every moment", "safety.ends", code.ROBOT_NODES),
    ),
)

_HEARING = Area(
    "Hearing",
    "The whole streaming pipeline. Synthetic voices are of engines or styles that training never "
    'used. **Of the commands only "stop" is measured on people.** Checkpoint and thresholds were '
    "chosen on parts of these sets, which flatters them a little. Times count from the end of the "
    "word, below 0 from before it. They include the processor's time. A word ends with its last "
    "10 ms that are within 35 dB of the loudest and 10 dB over the background of the recording. "
    "Where a third of the recording is within 10 dB of its quietest 10 ms, the background is the "
    "median of that part. Elsewhere it is the quietest 10 ms. The networks' own figures are in "
    "their cards in `catkin_ws/src/voice_assist/models`.",
    (
        Part(
            "voice.trials",
            "Commands in quiet and noise",
            "voice.trials",
            code.HEARING,
            SYNTHETIC,
            details=(
                r"^(tense|release|pull more|pull less|hey robot|terminate), ",
                "p99$",
            ),
            decides="rest",
        ),
        Part(
            "voice.stop",
            'The word "stop"',
            "voice.stop",
            code.HEARING,
            details=(r"(alone|standby|dB|below): p50$",),
            decides="rest",
        ),
        Part(
            "voice.overlap",
            '"stop" while others talk',
            "voice.overlap",
            code.HEARING,
            SYNTHETIC,
            decides="motion",
        ),
        Part(
            "voice.foreign",
            "Other languages and accents",
            "voice.no_commands.foreign",
            code.HEARING,
            SYNTHETIC,
            details=(r"^(tense|release|pull more|pull less), ", "trained voices"),
            decides="rest",
        ),
        Part(
            "voice.languages",
            "Commands in other languages",
            "voice.languages",
            code.LANGUAGES,
            SYNTHETIC,
            details=("p99$", "max$"),
        ),
        Part(
            "voice.near",
            "Words that are nearly a command",
            "voice.no_commands.near_misses",
            code.HEARING,
            SYNTHETIC,
            decides="rest",
        ),
        Part("voice.amounts", "Amounts in words", "voice.amounts", code.HEARING, SYNTHETIC),
        Part(
            "voice.armed",
            "Talk and single words, armed",
            "voice.no_commands.armed",
            code.HEARING,
            HUMAN,
            details=(r"^(talk without|single words|other devices).*(hey robot|terminate) taken",),
            decides="rest",
        ),
        Part(
            "voice.moving",
            "Talk and single words, in motion",
            "voice.no_commands.moving",
            code.HEARING,
            HUMAN,
            details=(r"^(talk without|single words|other devices).*(hey robot|terminate) taken",),
            decides="motion",
        ),
        Part(
            "voice.unarmed",
            "Talk, unarmed",
            "voice.no_commands.unarmed",
            code.HEARING,
            decides="rest",
        ),
        Part(
            "voice.nothing",
            "Nobody speaks",
            "voice.no_commands.false_alarms",
            code.HEARING,
            decides="rest",
        ),
        Part("voice.answers", '"stop" over spoken answers', "voice.answers", code.ANSWERS),
        Part("voice.ask", "Asking again", "voice.ask", code.HEARING, SYNTHETIC),
        Part(
            "voice.overlap_network",
            "Spotter over talk, the network alone",
            "voice.overlap_network",
            code.HEARING,
        ),
        Part("voice.calibration", "Confidence", "voice.calibration", code.HEARING, decides="rest"),
        Part("voice.sizes", "Whisper's sizes", "voice.sizes", code.HEARING, SYNTHETIC),
        Part("voice.precision", "Numbers of networks", "voice.precision", code.HEARING),
        Part("voice.soak", "An hour of load", "voice.soak.suite", code.HEARING, SYNTHETIC),
    ),
)

_PAPER = Area(
    "From speech to motion",
    "The experiment of the paper in the whole running system. Times count from the end of the "
    "word, as under Hearing. Ours are synthetic voices on the processor; the paper's are "
    "people, on an RTX A6000. Training had the accents of the non-native voices, in other variants "
    "of espeak-ng's voices. Accents that it never had are in `voice.trials` and `voice.foreign`.",
    (
        Part(
            "paper",
            "All repetitions",
            "",
            code.PAPER,
            SYNTHETIC,
            command="make paper INPUT=voice,pedal",
            details=(r"p95$", "median$"),
            decides="motion",
            module="paper.__main__",
        ),
    ),
)

_PROFILES = Area(
    "Profiles and speakers",
    "",
    (
        Part(
            "enrolment",
            "Enrolment",
            "enrolment.suite",
            code.ENROLMENT,
            SYNTHETIC,
            details=("another command", r"(5|10) repetitions: .*base$", "mean$", "refused$"),
        ),
        Part("speaker", "Speaker gate", "voice.speaker_gate", code.SPEAKER, HUMAN),
    ),
)

_RECORDING = Area(
    "Recording",
    "",
    (
        Part("sessions.flood", "Writing", "recording.suite:flood", code.RECORDING),
        Part("sessions.reading", "Reading and report", "recording.suite:reading", code.REPORT),
    ),
)

_COST = Area(
    "Cost of running",
    "The whole simulated system on this machine.",
    (
        Part("system.cost", "Each node, and the start", "system.cost", code.SYSTEM),
        Part("system.setup", "Set-up in a fresh clone", "system.setup", code.SET_UP),
        Part("system.loop", "The control loop under load", "system.loop", code.SYSTEM),
        Part("system.display", "The operator's page", "system.display", code.SYSTEM),
    ),
)

_GONE = Area(
    "Measured once, by benches that are gone",
    "Choices were made by these figures, or tests and other benches now guard the same.",
    (
        Part(
            "voice.keywords",
            "pocketsphinx",
            "",
            (),
            last_in="f0b07c5",
            details=(r"1e-(5|10|30)",),
        ),
        Part("voice.denoise", "Noise reduction", "", (), SYNTHETIC, last_in="f0b07c5"),
        Part(
            "languages",
            "Spellings learned",
            "",
            (),
            SYNTHETIC,
            last_in="23d7195",
            details=("before", "talk", "others", "spellings"),
        ),
        Part(
            "languages.adapted",
            "Weights adapted",
            "",
            (),
            SYNTHETIC,
            last_in="23d7195",
            details=("talk", "wrong", "others"),
        ),
        Part("enrolment_people", "Profiles of people", "", (), HUMAN, last_in="23d7195"),
        Part(
            "safety.losses_earlier",
            "Killed masters, earlier",
            "",
            (),
            SYNTHETIC,
            last_in="5b838d4",
            details=(
                r" p\d+, earlier$",
                r"movement of the arm",
                "way before",
                "return of the part",
            ),
        ),
        Part(
            "safety.losses_thousand",
            "A thousand losses, by the bench of 23 November",
            "",
            (),
            SYNTHETIC,
            last_in="985b503",
            details=(
                r" p\d+$",
                r"movement of the arm",
                r"^load average",
                "way before",
                "return of the part",
            ),
        ),
        Part("voice.idle", "Load of the pipeline alone", "", (), last_in="c1d9c95"),
        Part("sessions.kills", "200 killed recorders", "", (), last_in="c1d9c95"),
        Part("sessions.node", "Recorder and `rosbag record`", "", (), last_in="23d7195"),
        Part("sessions.loop", "Loop beside a recorder", "", (), last_in="23d7195"),
        Part("sessions.many", "Report over a folder", "", (), last_in="23d7195"),
    ),
)

AREAS = (
    *(_MOTION, _SITE, _SAFETY, _HEARING, _PAPER, _PROFILES, _RECORDING, _COST),
    _GONE,
)


def parts() -> Iterator[Part]:
    """All parts, in the page's order."""
    return (part for area in AREAS for part in area.parts)


def measurable() -> dict[str, Part]:
    """Parts that `make bench` can measure, by name."""
    return {part.name: part for part in parts() if part.place}


def named(name: str) -> list[Part]:
    """Parts of a name: one, or all of a family such as "voice"; empty where there is none."""
    every = measurable()
    return [part for key, part in every.items() if name in (key, key.partition(".")[0])]
