# SPDX-License-Identifier: BSD-3-Clause
"""`session_log replay`: one recording or a folder of them, differences one by one, exit code."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from session_log.errors import OutputFailed, SessionLogError
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.session_folder import recordings
from session_log.replay.compare import Difference
from session_log.replay.config import ReplayConfig
from session_log.replay.pipeline_plugin import Decided, MakePipeline, find_plugin
from session_log.replay.replay import ReplayFailed, ReplayResult, replay
from typed_config import (
    ConfigError,
    check_writable,
    load_file,
    numbered_recordings,
    package_folder,
)

REPLAY_CONFIG = package_folder("session_log") / "config" / "replay.yaml"
SAME, DIFFERENT, FAILED = 0, 1, 2  # exit status
_FIELDS = (
    *("transcript", "command", "reason", "nearest_command", "confidence", "mode"),
    *("decided_by", "is_partial"),
    *("speech_start", "speech_end", "decision"),
)


def run(arguments: argparse.Namespace) -> int:
    """Replay; gives 0 if all is the same, 1 if anything differs, 2 if anything failed."""
    named: Path = arguments.session
    try:
        config = load_file(ReplayConfig, arguments.config)
        paths = [named] if numbered_recordings(named) else recordings([named])
        make = find_plugin(config.pipeline)
        if arguments.json is not None:
            _check_out(arguments.json)
    except (SessionLogError, ConfigError, OSError) as error:
        print(f"session_log: {error}", file=sys.stderr)
        return FAILED
    done: list[ReplayResult] = []
    failed: dict[str, str] = {}
    for path in paths:
        try:
            result = _replayed(path, config, make, arguments.model)
        except SessionLogError as error:
            failed[str(path)] = str(error)
            print(f"session_log: {error}", file=sys.stderr)
            continue
        done.append(result)
        _show(result)
    if len(paths) > 1:
        _show_total(done, len(failed))
    return _conclude(done, failed, arguments.json)


def _replayed(
    path: Path, config: ReplayConfig, make: MakePipeline, model: str | None
) -> ReplayResult:
    try:
        return replay(SessionReader(path), config, make, model)
    except OSError as error:  # of the disk, while it is read
        raise ReplayFailed(path, error) from error


def _check_out(out: Path) -> None:
    if out.suffix == ".mcap" and out.exists():
        raise OutputFailed(out, FileExistsError(0, "it is a recording"))
    try:
        check_writable(out)
    except OSError as error:
        raise OutputFailed(out, error) from error


def _conclude(done: Sequence[ReplayResult], failed: dict[str, str], out: Path | None) -> int:
    if out is not None:
        content = {"sessions": [_as_json(result) for result in done], "failed": failed}
        try:
            out.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
        except OSError as error:
            print(f"session_log: {OutputFailed(out, error)}", file=sys.stderr)
            return FAILED
    if failed:
        return FAILED
    return SAME if all(result.is_same for result in done) else DIFFERENT


def _show(result: ReplayResult) -> None:
    for warning in result.warnings:
        print(f"{result.path}: warning: {warning}", file=sys.stderr)
    for loss in result.losses:
        print(f"{result.path}: lost: {loss}")
    for difference in result.differences:
        print("\n".join(_lines(difference, result.start)))
    print(f"{result.path}: {_summary(result)}")


def _lines(difference: Difference, start: float) -> list[str]:
    is_extra = difference.recorded is None
    number = f"after #{difference.number}" if is_extra else f"#{difference.number}"
    head = f"{number} at {difference.decision - start:.2f} s: {', '.join(difference.kinds)}"
    if difference.excuse:
        head += f" (not counted: {difference.excuse})"
    return [
        head,
        f"  recorded  {_words(difference.recorded)}",
        f"  now       {_words(difference.now)}",
    ]


def _words(decided: Decided | None) -> str:
    if decided is None:
        return "nothing"
    taken = decided.command or f"no command ({decided.reason})"
    wer = decided.wer.get(decided.command or decided.nearest_command)
    shown = "" if wer is None else f", WER {wer:.2f}"
    by = "" if decided.decided_by == "recognizer" else f", by the {decided.decided_by}"
    sure = f"confidence {decided.confidence:.3f}, in {decided.mode} mode"
    return f"{decided.transcript!r}: {taken}{shown}, {sure}{by}"


def _summary(result: ReplayResult) -> str:
    counted, excused = len(result.counted), len(result.differences) - len(result.counted)
    verdict = "the same" if not counted else f"{counted} differ"
    more = f", {excused} more where the recording has losses" if excused else ""
    lengths = f"{result.recorded} utterances in {result.sound:.1f} s of sound"
    return f"{lengths}, {result.heard} now: {verdict}{more} (model {result.model})"


def _show_total(done: Sequence[ReplayResult], failed: int) -> None:
    same = sum(result.is_same for result in done)
    utterances = sum(result.recorded for result in done)
    counted = sum(len(result.counted) for result in done)
    sound = sum(result.sound for result in done)
    print(
        f"total: {same} of {len(done)} sessions the same, {counted} differences in {utterances}"
        f" utterances, {sound / 60.0:.1f} min of sound, {failed} sessions failed"
    )


def _as_json(result: ReplayResult) -> dict[str, Any]:
    content = asdict(result)
    content["path"], content["is_same"] = str(result.path), result.is_same
    content["differences"] = [
        {
            "number": entry.number,
            "time": entry.decision - result.start,
            "kinds": list(entry.kinds),
            "excuse": entry.excuse,
            "recorded": _plain(entry.recorded),
            "now": _plain(entry.now),
        }
        for entry in result.differences
    ]
    return content


def _plain(decided: Decided | None) -> dict[str, Any] | None:
    if decided is None:
        return None
    return {**{name: getattr(decided, name) for name in _FIELDS}, "wer": dict(decided.wer)}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options beside the session."""
    parser.add_argument("--model", help="recogniser to hear with; default: the recorded one")
    parser.add_argument("--json", type=Path, help="file to write all differences to")
    help_ = "settings of the replay: the pipeline, and what counts as the same"
    parser.add_argument("--config", type=Path, default=REPLAY_CONFIG, help=help_)
