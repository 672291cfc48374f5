# SPDX-License-Identifier: BSD-3-Clause
"""The command `session_log`: look into recordings, mend them, take things out, report."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from datetime import datetime
from pathlib import Path

from session_log.config import ReportConfig
from session_log.errors import OutputFailed, SessionLogError, SessionMissing
from session_log.export.export import FORMATS, export_topics, seconds
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.recover import recover
from session_log.mcap_file.session_folder import RECOVERED, report_folder
from session_log.mcap_file.summary import RecordingSummary, read_summary
from session_log.recording.metadata import PARAMETERS
from session_log.recording.recorder import MANY_PUBLISHERS
from session_log.replay import command as replay_command
from session_log.report import command as report_command
from session_log.report.notes import Note, add_note
from typed_config import (
    ConfigError,
    add_common_options,
    load_file,
    number_option,
    package_folder,
    require,
    run_command,
)

CONFIG = package_folder("session_log") / "config" / "report.yaml"


def main(words: Sequence[str] | None = None) -> None:
    """Run the command line.

    Exits with 0; with 1 and what is wrong; with 2 for words that it does not take. `export` gives 1
    where rows may be lacking, `replay` what its own `run` says. A recording that was not closed is
    named, and is no failure.
    """
    refusals = (SessionLogError, ConfigError)
    sys.exit(run_command(lambda: _run(words), "session_log", refusals, failed=1))


def _run(words: Sequence[str] | None) -> int:
    arguments = _parser().parse_args(words)
    status: int = arguments.run(arguments)
    return status


def _info(arguments: argparse.Namespace) -> int:
    result = read_summary(SessionReader(arguments.session))
    if arguments.json:
        print(json.dumps(_as_json(result), indent=2))
    else:
        _print_summary(result, arguments.session)
    return 0


def _recover(arguments: argparse.Namespace) -> int:
    reader = SessionReader(arguments.session, tolerant=True)
    target = arguments.out or reader.path.with_name(f"{reader.path.stem}{RECOVERED}.mcap")
    if target.exists():
        raise OutputFailed(target, FileExistsError(0, "it exists already"))
    result = recover(reader, target)
    if not (result.messages or result.condition.metadata):
        target.unlink()
        raise SessionMissing(reader.path, "holds no readable message; nothing was written")
    print(f"{target}: {result.messages} messages, {result.duration:.1f} s")
    for line in _losses(result):
        print(line)
    return 0


def _export(arguments: argparse.Namespace) -> int:
    topics = load_file(ReportConfig, arguments.config).topics
    wanted = [topics.utterance, topics.event, topics.state, topics.mode]
    if arguments.topic:
        wanted = ["/" + topic.strip("/") for topic in arguments.topic]
    reader = SessionReader(arguments.session)
    folder = arguments.out or report_folder(reader.path) / "export"
    result = export_topics(reader, folder, wanted, topics.audio, FORMATS[arguments.format])
    for path, rows in result.rows.items():
        print(f"{path}: {rows} rows")
    without = set(wanted) - result.topics
    for topic in sorted(without - result.unfit.keys()):
        print(f"{topic}: nothing recorded")
    if result.sound:
        short = result.unfilled_samples
        more = f", {short} of them without silence in their place" if short else ""
        print(f"{result.sound}: {result.samples} samples, {result.lost_samples} lost{more}")
        print(f"{result.sound}: begins at {seconds(result.sound_start)} s, the time of the tables")
    if result.undecodable:
        print(f"{result.undecodable} messages do not fit their definition")
        for reason in result.unfit.values():
            print(reason)
    for line in _troubles(result.recording):
        print(line)
    is_whole = not result.recording.lacks({*wanted, topics.audio}) and not result.undecodable
    return 0 if is_whole and not (arguments.topic and without) else 1


def _note(arguments: argparse.Namespace) -> int:
    note = Note(" ".join(arguments.words), arguments.at)
    reader = SessionReader(arguments.session)
    if not note.words.strip():
        raise SessionLogError("the note is empty; nothing was written")
    if note.time is not None:
        _require_within(reader, note.time)
    print(add_note(reader.path, note))
    return 0


def _require_within(reader: SessionReader, moment: float) -> None:
    """Refuse a moment [s] after the end; a recording that was not closed may go on."""
    found = read_summary(reader)
    length = math.ceil(found.duration * 10.0) / 10.0
    if found.condition.is_closed:
        allowed = f"0 to {length:.1f} s, the length of the recording"
        require(moment <= length, "--at", moment, allowed)


def _report(arguments: argparse.Namespace) -> int:
    return report_command.run(arguments, load_file(ReportConfig, arguments.config))


def _print_summary(result: RecordingSummary, path: Path) -> None:
    began = datetime.fromtimestamp(result.start * 1e-9).astimezone() if result.start else None
    print(f"{path}: {result.messages} messages, {result.duration:.1f} s")
    if began:
        print(f"began {began:%Y-%m-%d %H:%M:%S %Z}")
    for line in _losses(result):
        print(line)
    width = max((len(name) for name in result.topics), default=5)
    print(f"\n{'topic':{width}}  {'messages':>9}  {'rate':>9}  {'missing':>7}  type")
    for name, topic in sorted(result.topics.items()):
        rate = f"{topic.rate:.1f} Hz" if topic.messages > 1 else "-"
        print(f"{name:{width}}  {topic.messages:9}  {rate:>9}  {topic.missing:7}  {topic.datatype}")
    latest = dict(result.condition.metadata)
    for name in (n for n in latest if n != PARAMETERS):
        print(f"\n[{name}]")
        for key, value in latest[name].items():
            print(f"{key}: {_first_line(value)}")


def _first_line(value: str) -> str:
    lines = value.splitlines()
    return value if len(lines) < 2 else f"{lines[0]} (and {len(lines) - 1} more lines)"


def _losses(result: RecordingSummary) -> list[str]:
    """Say in words what is wrong with a recording; sound ones say so too."""
    good = ", checksum good" if result.condition.checksum == "good" else ""
    return _troubles(result) or [f"complete{good}"]


def _troubles(result: RecordingSummary) -> list[str]:
    lines = [*result.condition.troubles, *result.cuts]
    if result.missing:
        lines.append(f"{result.missing} messages were received but are not in the file")
    lines += [f"lost on {name}: {loss}" for name, loss in result.dropped.items()]
    lines += [str(step) for step in result.clock_steps]
    for name, topic in result.topics.items():
        if MANY_PUBLISHERS in topic.publishers:
            lines.append(f"{name}: {MANY_PUBLISHERS} published it; later ones share a channel")
    return lines


def _as_json(result: RecordingSummary) -> dict[str, object]:
    topics = {
        name: {**asdict(topic), "publishers": sorted(topic.publishers), "rate": topic.rate}
        for name, topic in result.topics.items()
    }
    condition = asdict(result.condition)
    condition["metadata"] = dict(result.condition.metadata)
    return {
        "start": result.start * 1e-9,
        "duration": result.duration,
        "clock_steps": [asdict(step) for step in result.clock_steps],
        "condition": condition,
        "topics": topics,
    }


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="session_log", description=__doc__)
    add_common_options(parser, "session_log")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    info = _command(commands, "info", _info, "say what a recording holds and what it lost")
    info.add_argument("--json", action="store_true", help="as JSON")
    copy = _command(commands, "recover", _recover, "copy what is readable to a sound file")
    copy.add_argument("--out", type=Path, help="file to write; default: beside the recording")
    words = "hear again, and list what comes out differently"
    replay_command.add_options(_command(commands, "replay", replay_command.run, words))
    export = _command(commands, "export", _export, "topics to CSV or Parquet, sound to WAV")
    where = "folder; default: export beside the recording, below its name where others lie there"
    export.add_argument("--out", type=Path, help=where)
    export.add_argument("--format", choices=FORMATS, default="csv")
    export.add_argument("--topic", action="append", help="a topic to write, instead of the usual")
    note = _command(commands, "note", _note, "write a note on a recording, for its report")
    note.add_argument("words", nargs="+", help="what to note")
    time = number_option(0.0, unit="s")
    note.add_argument("--at", type=time, metavar="S", help="of a moment of it, in seconds")
    words = "one HTML page and its figures as PNG, of one session or over many"
    report = commands.add_parser("report", help=words, description=words)
    report.set_defaults(run=_report)
    report_command.add_options(report)
    for command in (export, report):
        command.add_argument("--config", type=Path, default=CONFIG, help="settings of the report")
    return parser


def _command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser],
    name: str,
    run: Callable[[argparse.Namespace], int],
    words: str,
) -> argparse.ArgumentParser:
    parser = commands.add_parser(name, help=words, description=words)
    parser.add_argument("session", type=Path, help="an MCAP file, or the folder of a session")
    parser.set_defaults(run=run)
    return parser


if __name__ == "__main__":
    main()
