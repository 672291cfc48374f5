# SPDX-License-Identifier: BSD-3-Clause
"""Makes a profile of its takes: learns, checks, writes, and activates it or says why not."""

from __future__ import annotations

import resource
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import replace

from typed_config import ConfigError
from voice_assist.config import VoiceConfig
from voice_assist.config.enrolment import EnrolmentConfig
from voice_assist.config.profile import NOBODY
from voice_assist.config.speaker import OFF, SpeakerConfig
from voice_assist.enrolment import report
from voice_assist.enrolment.adapt import Adapted
from voice_assist.enrolment.learn import EnrolmentMaterial, learn, material_of, others_for
from voice_assist.enrolment.self_check import SelfCheck, SelfCheckResult, wrong_words
from voice_assist.enrolment.takes.checks import TakeCheck
from voice_assist.enrolment.voiceprint import put_voiceprint
from voice_assist.errors import VoiceError
from voice_assist.evaluation.evaluator import said_once
from voice_assist.profile import model_file, spellings, thresholds
from voice_assist.profile.active import PersonalRecognizer, personalise, with_profile
from voice_assist.profile.manifest import ACTIVE, RECORDING, REFUSED, to_bytes
from voice_assist.profile.profile import VoiceProfile, VoiceProfileError
from voice_assist.profile.spellings import hear_spellings
from voice_assist.recognizer.embedded import EmbeddedRecognizer
from voice_assist.recognizer.recognizer import Recognizer
from voice_assist.speaker.voiceprint import FILE as VOICEPRINT

MIN_TAKES = 3  # takes of each command
Report = Callable[[str], None]  # takes a line of text


def require_adaptable(base: Recognizer) -> EmbeddedRecognizer:
    """The recogniser, if profiles can be made on top of it.

    Raises:
        VoiceProfileError: It cannot be adapted.
    """
    if not isinstance(base, EmbeddedRecognizer):
        allowed = "the embedded model, or one trained by make train"
        raise VoiceProfileError(f"recogniser {base.name!r} cannot be adapted, allowed: {allowed}")
    return base


def build(
    profile: VoiceProfile,
    voice: VoiceConfig,
    config: EnrolmentConfig,
    base: EmbeddedRecognizer,
    on_progress: Report = lambda _: None,
    on_note: Report = lambda _: None,
) -> tuple[str, ...]:
    """Learn from the takes of a profile; whatever fails before it is written leaves it as it was.

    An active profile that serves with this base and these commands is replaced only by one that
    passes its check.

    Args:
        profile: With all its takes.
        voice: Active settings. Their profile and speaker gate are ignored.
        config: Of enrolment.
        base: Recogniser that it is made on top of.
        on_progress: Called with the name of each stage.
        on_note: Called with what else was learned, such as a voiceprint, and what was not.

    Returns:
        Why what was learned was refused; empty: the profile is active. It is ACTIVE in spite of
        reasons where it was kept as it was.

    Raises:
        VoiceProfileError: Takes are missing or damaged, or the profile cannot be written.
        ModelError: espeak-ng, whose voices are learned beside the person's, is not installed.
    """
    material = _of_commands(material_of(profile), voice.commands.fixed_phrases, on_note)
    _require_takes(material, voice.commands.fixed_phrases, config)
    wall, cpu = time.monotonic(), time.process_time()
    voice, check = _plain(voice), TakeCheck(config.checks, voice.commands, base)
    check_all = SelfCheck(voice, config, base, on_progress)
    learned = spelled = None
    verdict = SelfCheckResult(wrong_words=wrong_words(material, check))
    if not verdict.wrong_words:
        on_progress("other voices")
        others = others_for(voice.commands.fixed_phrases, config.adapt)
        on_progress("learning")
        learned = learn(base, material, others, config.adapt)
        personal = PersonalRecognizer(base, learned.state)
        spelled, refused = hear_spellings(material.said, personal, voice.commands)
        for one in refused:
            on_note(f"{one.phrase!r} written as {one.spelling!r} is not learned: {one.why}")
        verdict = check_all(material, spelled, personal, others)
    problems = verdict.problems(config)
    if problems and _serves(profile, voice, base):
        return problems
    profile.rebase(base.model_hash)
    profile.judge(RECORDING)
    if spelled is not None:
        profile.put(spellings.NAME, to_bytes(spelled))
        _put_voiceprint(profile, voice.speaker, on_note)
    spent = time.monotonic() - wall, time.process_time() - cpu
    effort = report.Effort(learned.seconds if learned else 0.0, *spent, _memory())
    _write(profile, learned, verdict, problems, effort)
    profile.judge(REFUSED if problems else ACTIVE, problems)
    return problems


def _plain(voice: VoiceConfig) -> VoiceConfig:
    """The settings without any profile and without the gate, which would ask for a voiceprint.

    Each take says its command once, so none is asked for twice.
    """
    nobody = replace(voice.profile, name=NOBODY, sha256="")
    plain = replace(voice, profile=nobody, speaker=replace(voice.speaker, gate=OFF))
    return said_once(plain)


def _serves(profile: VoiceProfile, voice: VoiceConfig, base: EmbeddedRecognizer) -> bool:
    """Whether the profile on file is active, and can be used with this base and these commands."""
    folder = str(profile.folder.parent)
    named = replace(voice.profile, name=profile.name, folder=folder)
    try:
        with_profile(replace(voice, profile=named))
        personalise(replace(voice, profile=named), base)
    except (VoiceError, ConfigError):
        return False
    return True


def _put_voiceprint(profile: VoiceProfile, config: SpeakerConfig, on_note: Report) -> None:
    """The voiceprint of the speaker gate; the profile serves without it, too."""
    try:
        known = put_voiceprint(profile, config)
    except VoiceError as error:
        profile.drop(VOICEPRINT)
        on_note(f"no voiceprint, so the speaker gate cannot be used: {error}")
    else:
        on_note(f"voiceprint of {known.takes} takes, of which it would refuse {known.missed:.0%}")


def _write(
    profile: VoiceProfile,
    learned: Adapted | None,
    verdict: SelfCheckResult,
    problems: tuple[str, ...],
    effort: report.Effort,
) -> None:
    """Write all that was learned; of a refused profile too, for inspection."""
    if learned is None:
        profile.drop(model_file.NAME)
    else:
        data = model_file.to_bytes(learned.state, profile.manifest.base_sha256)
        profile.put(model_file.NAME, data)
    profile.put(thresholds.NAME, to_bytes(verdict.settings))
    facts = profile.manifest, verdict, problems, effort
    profile.put(report.JSON, report.as_json(*facts))
    profile.put(report.MARKDOWN, report.as_markdown(*facts))


def _of_commands(
    material: EnrolmentMaterial, phrases: tuple[str, ...], on_note: Report
) -> EnrolmentMaterial:
    """Without the takes of phrases that are no command any more."""
    allowed = ", ".join(phrases)
    for phrase in sorted({take.phrase for take in material.takes}.difference(phrases)):
        on_note(f"takes of {phrase!r} are left out: it is no command; allowed: {allowed}")
    return replace(material, takes=tuple(t for t in material.takes if t.phrase in phrases))


def _require_takes(
    material: EnrolmentMaterial, phrases: tuple[str, ...], config: EnrolmentConfig
) -> None:
    """Refuse what is too little to be checked.

    Raises:
        VoiceProfileError: Names the commands that lack takes, or the talk.
    """
    said = Counter(take.phrase for take in material.takes)
    short = [f"{phrase!r} {said[phrase]}" for phrase in phrases if said[phrase] < MIN_TAKES]
    if short:
        allowed = f"allowed: at least {MIN_TAKES} of each"
        raise VoiceProfileError(f"too few takes of {', '.join(short)}; {allowed}")
    talked, min_talk = 3600.0 * material.talked, config.talk / 2.0
    if talked < min_talk:
        raise VoiceProfileError(f"{talked:.0f} s of free talk, allowed: at least {min_talk:.0f}")


def _memory() -> float:
    """Largest resident set of this process so far [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
