# SPDX-License-Identifier: BSD-3-Clause
"""The verbs `enroll` and `profiles` of the command line."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

from voice_assist.config import VoiceConfig
from voice_assist.config.commands import CommandsConfig
from voice_assist.config.enrolment import EnrolmentConfig, load_enrolment_config
from voice_assist.enrolment.takes.checks import Checked, TakeCheck
from voice_assist.enrolment.takes.script import (
    EnrolmentScript,
    EnrolmentStep,
    RecordedTake,
    require_letters,
)
from voice_assist.errors import ManifestError
from voice_assist.intent.confusability import closest_pairs
from voice_assist.profile.deletion import delete_profile, folder_to_delete
from voice_assist.profile.manifest import ACTIVE, COMMAND, TALK
from voice_assist.profile.profile import (
    VoiceProfile,
    VoiceProfileError,
    create_profile,
    missing_profile,
    names,
    open_profile,
    profiles_folder,
)
from voice_assist.recognizer.recognizer import Recognizer

if TYPE_CHECKING:  # it takes time to load
    from voice_assist.recognizer.embedded import EmbeddedRecognizer


@dataclass(frozen=True)
class EnrolRequest:
    """What `enroll` was asked."""

    name: str
    folder: Path | None
    wavs: Path | None
    session: Path | None
    corrections: Path | None
    again: bool
    settings: Path  # folder of enrolment.yaml


def enroll(voice: VoiceConfig, asked: EnrolRequest, ask: Callable[[str], str] = input) -> int:
    """Record or take over what is missing, then learn from it; gives the exit code.

    Raises:
        VoiceError: Something of it cannot be used; says what.
    """
    from voice_assist.assembly import limit_torch
    from voice_assist.enrolment.build import require_adaptable
    from voice_assist.recognizer import load_recognizer

    require_letters(voice.commands.fixed_phrases)
    console, config = _console(), load_enrolment_config(asked.settings)
    _warn_of_alikes(voice.commands, console)
    recorded = _recorded(asked, config.session_reader, voice.commands.fixed_phrases, console)
    limit_torch(voice)
    recognizer = voice.recognizer  # whose device may be another: learning needs none
    loaded = load_recognizer(recognizer.model, precision=recognizer.precision)
    base = require_adaptable(loaded)  # before anybody takes the trouble to record
    profile = _open_or_create(asked, base)
    check = TakeCheck(config.checks, voice.commands, base)
    script = EnrolmentScript(profile, config, voice.commands.fixed_phrases, check)
    if recorded is not None:

        def show_checked(name: str, checked: Checked) -> None:
            problems = "; ".join(checked.problems) or "good"
            console.print(f"{Path(name).name}: {problems}")

        console.print(f"{script.take_over(recorded, show_checked)} takes kept")
    elif not asked.again:
        _guide(script, voice, console, ask)
    return _learn(profile, voice, config, base, console)


def manage(action: str, name: str | None, folder: Path | None, sure: bool) -> int:
    """List, show or delete profiles; gives the exit code.

    Raises:
        VoiceProfileError: The action needs a name, or the profile cannot be used.
    """
    if action != "list" and name is None:
        known = ", ".join(names(profiles_folder(folder))) or "none"
        raise VoiceProfileError(f"profiles {action} needs the name of a profile, there: {known}")
    if action == "delete" and name is not None:
        return delete(name, folder, sure)
    show_profiles(folder, name if action == "show" else None, _console())
    return 0


def show_profiles(folder: Path | None, name: str | None, console: Console) -> None:
    """List all profiles, or show what one holds.

    Raises:
        VoiceProfileError: There is none of that name, or it cannot be read.
    """
    root = profiles_folder(folder)
    if name is not None:
        _show(open_profile(name, root), console)
        return
    found = names(root)
    console.print(f"{len(found)} profiles in {root}")
    for one in found:
        try:
            manifest = open_profile(one, root).manifest
            why = f": {'; '.join(manifest.why)}" if manifest.why else ""
            takes = f"{len(manifest.takes)} takes"
            console.print(f"{one:20} {manifest.state}, {takes}{why}")
        except VoiceProfileError as error:
            console.print(f"{one:20} cannot be used: {error}")


def delete(name: str, folder: Path | None, sure: bool, ask: Callable[[str], str] = input) -> int:
    """Remove a profile with all its recordings, after a question; gives the exit code.

    Raises:
        ConfigError: The name cannot be used.
        VoiceProfileError: There is none of that name, the folder holds something else, it cannot be
            removed, or nobody answers.
    """
    root = profiles_folder(folder)
    place = folder_to_delete(name, root)
    try:
        is_sure = sure or ask(f"Delete {place} with all its recordings? [y/N] ") in ("y", "Y")
    except EOFError as error:
        print()  # ends the line of the question
        words = "no answer; nothing was deleted (--yes deletes without a question)"
        raise VoiceProfileError(words) from error
    if not is_sure:
        print("nothing was deleted")
        return 1
    print(f"{delete_profile(name, root)} files deleted")
    return 0


def _open_or_create(asked: EnrolRequest, base: Recognizer) -> VoiceProfile:
    root = profiles_folder(asked.folder)
    if asked.name in names(root):
        return open_profile(asked.name, root)
    if asked.again:
        raise missing_profile(asked.name, root)
    return create_profile(asked.name, base.model_hash, root)


def _console() -> Console:
    """Prints words as they are: in a name or an error, brackets are no markup."""
    return Console(markup=False, highlight=False)


def _recorded(
    asked: EnrolRequest, reader: str, phrases: tuple[str, ...], console: Console
) -> Iterable[RecordedTake] | None:
    """The recordings that were named, all found already; None: none were named.

    Raises:
        VoiceError: They cannot be used.
    """
    from voice_assist.enrolment.takes import from_files, from_session

    if asked.corrections is not None and asked.session is None:
        raise ManifestError("--corrections needs --from-session")
    if asked.wavs is not None:
        found = from_files.find_recordings(
            asked.wavs, phrases, lambda note: console.print(note, style="yellow")
        )
        return from_files.read_recordings(found)
    if asked.session is not None:
        return from_session.read_takes(asked.session, asked.corrections, phrases, reader)
    return None


def _warn_of_alikes(commands: CommandsConfig, console: Console) -> None:
    """Before anybody takes the trouble to say them: some phrases no recogniser keeps apart."""
    for pair in closest_pairs(commands):
        if pair.verdict == "apart":
            return  # those that follow are further apart
        console.print(f"warning: {pair.words}", style="yellow")


def _guide(
    script: EnrolmentScript, voice: VoiceConfig, console: Console, ask: Callable[[str], str]
) -> None:
    """Record with the microphone of the settings."""
    from voice_assist.assembly import make_source
    from voice_assist.cli.enroll_terminal import guide

    def pause(seconds: float) -> bool:
        time.sleep(seconds)
        return False

    def ready(step: EnrolmentStep) -> None:
        try:
            ask("    Enter when you are ready ")
        except EOFError as error:
            raise VoiceProfileError(
                "the terminal's input has ended where Enter was asked for; what was recorded is "
                "kept, the same command in a terminal goes on from there"
            ) from error

    def report(trouble: str) -> None:
        if trouble:
            console.print(trouble, style="yellow")

    source = make_source(voice.audio, time.time, pause, report)
    console.print("Ctrl-C breaks it off; the same command goes on from there.", style="dim")
    guide(script, source, console, ready)


def _learn(
    profile: VoiceProfile,
    voice: VoiceConfig,
    config: EnrolmentConfig,
    base: EmbeddedRecognizer,
    console: Console,
) -> int:
    from voice_assist.enrolment.build import build

    def noted(note: str) -> None:
        console.print(note, style="yellow")

    with console.status("learning") as status:
        problems = build(profile, voice, config, base, status.update, noted)
    if problems:
        is_kept = profile.manifest.state == ACTIVE
        kept = "stays as it was, active; what was learned anew failed its check"
        outcome = kept if is_kept else "was not activated"
        console.print(f"Profile {profile.name} {outcome}:", style="bold red")
        for problem in problems:
            console.print(f"  {problem}")
        return 1
    console.print(f"Profile {profile.name} is active: profile:={profile.name}", style="green")
    return 0


def _show(profile: VoiceProfile, console: Console) -> None:
    manifest = profile.manifest
    profile.check()
    console.print(f"{profile.folder}: {manifest.state}, made {manifest.created}")
    for reason in manifest.why:
        console.print(f"  {reason}")
    console.print(f"  SHA-256 {profile.digest}")
    talk = sum(take.seconds for take in manifest.takes if take.kind == TALK)
    phrases = [take.phrase for take in manifest.takes if take.kind == COMMAND]
    said = ", ".join(f"{phrase} {phrases.count(phrase)}" for phrase in dict.fromkeys(phrases))
    console.print(f"  takes: {said or 'none'}; talk {talk:.0f} s")
    for file in manifest.files:
        console.print(f"  {file.name} {file.sha256[:12]}")
