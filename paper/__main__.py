# SPDX-License-Identifier: BSD-3-Clause
"""`make paper`: the paper's experiment in synthetic voices, and the same by a pedal.

Each session is a process of its own, since one process can join only one ROS master.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import rospy
from rich.console import Console

from paper.config import (
    ExperimentConfig,
    PaperVoiceConfig,
    chosen_voices,
    load_experiment,
)
from paper.folders import (
    code_of,
    finish,
    is_finished,
    note_code,
    set_aside,
    settings_of,
)
from paper.judging.comparison import comparison
from paper.judging.outcomes import PhraseOutcome, judge, keep, kept
from paper.judging.results import VoiceResult, figures
from paper.judging.trials import read
from paper.play import pedal_session, session
from paper.play.speaker import installed_voices
from session_log.cli import CONFIG as REPORT
from session_log.config import ReportConfig
from session_log.errors import SessionLogError
from support.figures import RESULTS, ROOT, SEVERAL, decided_now, keys, machine, show, write
from support.interrupt import end_as_by_ctrl_c
from support.process_groups import STOP_TIME, end_group, start_group
from support.product_code import PAPER, bench_identity, identity
from typed_config import ConfigError, count_option, load_file

VOICES = "4"
VOICE, PEDAL = "voice", "pedal"  # inputs
INTERRUPTED = 130  # exit status of a session that Ctrl-C ended
END_TIME = 2.5 * STOP_TIME  # [s] for a session to end its launches one after the other
RESULT = "paper.json"


def main(words: Sequence[str] | None = None) -> int:
    """Run the experiment; returns the exit status: 0 when every session came to its end."""
    options = _parse(words)
    console = Console()
    try:
        config = load_experiment()
        repetitions = options.repetitions or config.repetitions
        out = (options.out or ROOT / "sessions" / f"paper_{repetitions}").resolve()
        voices = chosen_voices(config, options.voices, installed_voices(config))
        out.mkdir(parents=True, exist_ok=True)
    except ConfigError as error:
        console.print(f"[red]{error}[/red]", highlight=False)
        return 2
    except OSError as error:
        words = f"The folder of the sessions cannot be made: {error.filename}: {error.strerror}"
        console.print(words, style="red", highlight=False, markup=False)
        return 2
    if options.session:
        if PEDAL in options.input:
            return _press(config, repetitions, out, console)
        return _play(voices[0], config, repetitions, out, console)
    status = 0
    if VOICE in options.input:
        status = _play_all(voices, config, repetitions, out, console)
    if PEDAL in options.input and status != INTERRUPTED:
        status = _press_all(config, repetitions, out, console) or status
    finished = [v for v in voices if is_finished(out / v.name, settings_of(config, v, repetitions))]
    is_whole = status == 0 and len(finished) >= int(VOICES)
    result = RESULT if repetitions == config.repetitions else ""
    _conclude(voices, out, result if is_whole else "", console)
    return status


def _parse(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="make paper", description=__doc__)
    parser.add_argument("--repetitions", type=count_option, help="of each command and voice")
    parser.add_argument("--voices", default=VOICES, help="how many, or names with commas between")
    parser.add_argument(
        "--input", type=_inputs, default=(VOICE,), help="voice, pedal, or both with a comma between"
    )
    parser.add_argument("--out", type=Path, help="folder of all sessions (sessions/paper_<n>)")
    parser.add_argument("--session", action="store_true", help=argparse.SUPPRESS)  # in here
    return parser.parse_args(words)


def _inputs(word: str) -> tuple[str, ...]:
    found = tuple(word.split(","))
    if not set(found) <= {VOICE, PEDAL} or len(set(found)) < len(found):
        raise argparse.ArgumentTypeError(f"{word!r}: allowed are voice, pedal and voice,pedal")
    return found


def _press_all(config: ExperimentConfig, repetitions: int, out: Path, console: Console) -> int:
    """Press the pedal's session, unless it is there."""
    console.rule("pedal")
    if is_finished(out / PEDAL, settings_of(config, None, repetitions)):
        console.print("  finished before, kept")
        return 0
    if aside := set_aside(out / PEDAL):
        console.print(f"  begun before and not finished, or otherwise; now in {aside}")
    return _child("1", repetitions, out, PEDAL)


def _press(config: ExperimentConfig, repetitions: int, out: Path, console: Console) -> int:
    """Press one session."""
    folder = out / PEDAL
    try:
        folder.mkdir(parents=True, exist_ok=True)
        note_code(folder, identity(PAPER))
        keep(folder, pedal_session.run(config, repetitions, folder, console))
    except KeyboardInterrupt:
        return INTERRUPTED
    except (OSError, RuntimeError, rospy.ROSException) as error:
        console.print(f"The session could not be played: {error}", style="red", markup=False)
        return 1
    finish(folder, settings_of(config, None, repetitions))
    return 0


def _play_all(
    voices: Sequence[PaperVoiceConfig],
    config: ExperimentConfig,
    repetitions: int,
    out: Path,
    console: Console,
) -> int:
    """Play every session that is not there yet."""
    console.print(f"All voices are synthetic. Sessions, figures and report: {out}")
    status = 0
    for i, voice in enumerate(voices, 1):
        console.rule(f"{i} of {len(voices)}: {voice.name} ({voice.accent})")
        if is_finished(out / voice.name, settings_of(config, voice, repetitions)):
            console.print("  finished before, kept")
            continue
        if aside := set_aside(out / voice.name):
            console.print(f"  begun before and not finished, or otherwise; now in {aside}")
        code = _child(voice.name, repetitions, out, VOICE)
        if code == INTERRUPTED:
            console.print("Interrupted: the same command goes on with this voice.")
            return code
        status = status or code
    return status


def _child(voices: str, repetitions: int, out: Path, input_: str) -> int:
    command = [sys.executable, "-m", "paper", "--session", "--voices", voices, "--input", input_]
    command += ["--repetitions", str(repetitions), "--out", str(out)]
    process = start_group(command, cwd=ROOT)
    try:
        return process.wait()
    except KeyboardInterrupt:
        end_group(process, END_TIME)
        return INTERRUPTED


def _play(
    voice: PaperVoiceConfig,
    config: ExperimentConfig,
    repetitions: int,
    out: Path,
    console: Console,
) -> int:
    """Play one session and judge it."""
    folder = out / voice.name
    try:
        folder.mkdir(parents=True, exist_ok=True)
        note_code(folder, identity(PAPER))
        session.run(voice, config, repetitions, folder, console)
        judge(folder, _report_config())
    except KeyboardInterrupt:
        return INTERRUPTED
    except (OSError, RuntimeError, SessionLogError, rospy.ROSException) as error:
        console.print(f"The session could not be played: {error}", style="red", markup=False)
        console.print(f"What the nodes said is in {folder / 'launch.log'}")
        return 1
    finish(folder, settings_of(config, voice, repetitions))
    return 0


def _conclude(
    voices: Sequence[PaperVoiceConfig],
    out: Path,
    result: str,
    console: Console,
) -> None:
    """Show and write what there is; under the name of a result among those of the repository, too.

    Args:
        voices: Chosen.
        out: Folder of all sessions.
        result: Its file in bench/results; empty: none.
        console: To show it on.
    """
    found = [VoiceResult(v, tuple(_outcomes(out / v.name))) for v in voices]
    heard = [result for result in found if result.repetitions]
    pressed = kept(out / PEDAL)
    if not heard and not pressed:
        console.print("No phrase was played: there is nothing to show.")
        return
    theirs = _report_config().paper
    paper = {entry.command: entry.latency for entry in theirs.latency}
    console.rule()
    listed = figures(heard, paper, theirs.hardware) if heard else []
    listed += comparison({VOICE: [r.repetitions for r in heard], PEDAL: [pressed]})
    show(listed, console)
    code = keys(PAPER, decided_now("motion"))
    played = [out / r.voice.name for r in heard] + ([out / PEDAL] if pressed else [])
    if {code_of(folder) for folder in played} != {code["code"]}:
        code = {"code": SEVERAL}  # what was decided is of the code of each session
    code["bench"] = bench_identity("paper.__main__")
    facts = {**code, "voices": [asdict(result.voice) for result in heard]}
    for path in [out / RESULT, *([RESULTS / result] if result else [])]:
        write(path, listed, machine(), **facts)
        console.print(f"Figures: {path}")
    _report(out, console)


def _outcomes(folder: Path) -> list[PhraseOutcome]:
    """What came of a session, also of one that was interrupted."""
    outcomes = kept(folder)
    if outcomes or not read(folder):
        return outcomes
    try:
        return judge(folder, _report_config())
    except (OSError, SessionLogError):
        return []


def _report_config() -> ReportConfig:
    return load_file(ReportConfig, REPORT)


def _report(out: Path, console: Console) -> None:
    """Make the report over all sessions, and a page of each, by the command that a user has."""
    command = [sys.executable, "-m", "session_log.cli", "report", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    console.print(done.stdout.strip(), highlight=False, markup=False)
    if done.returncode:
        words = f"No report of all sessions: {done.stderr.strip()}"
        console.print(words, style="red", highlight=False, markup=False)


if __name__ == "__main__":
    end_as_by_ctrl_c()
    sys.exit(main())
