# SPDX-License-Identifier: BSD-3-Clause
"""A profile's own check: it must be better for its person and no worse for anybody else."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from voice_assist.config import VoiceConfig
from voice_assist.config.enrolment import EnrolmentConfig
from voice_assist.enrolment.examples import Example, other_voices
from voice_assist.enrolment.learn import EnrolmentMaterial, LabelledTake, learn
from voice_assist.enrolment.pipeline_probe import PipelineProbe, PipelineResult
from voice_assist.enrolment.takes.checks import Checked
from voice_assist.enrolment.thresholds import (
    ConfidenceEvidence,
    ExpectedErrors,
    choose_threshold,
    expected_errors,
)
from voice_assist.evaluation.evaluator import ClaimedCommand
from voice_assist.profile import spellings
from voice_assist.profile.active import PersonalRecognizer
from voice_assist.profile.manifest import COMMAND
from voice_assist.profile.spellings import Spellings, hear_spellings
from voice_assist.profile.thresholds import Settings, overlay
from voice_assist.recognizer.embedded import EmbeddedRecognizer
from voice_assist.recognizer.vocabulary import spelled
from voice_assist.types import Samples

HeardTake = tuple[LabelledTake, PipelineResult]
_OTHER_SEED = 1000  # added to the seed of what is learned from: another choice of texts


@dataclass(frozen=True)
class SelfCheckTrial:
    """One sound, and what base and profile made of it."""

    phrase: str  # that was said; empty: no command
    base: tuple[str, ...]  # commands taken
    profile: tuple[str, ...]


@dataclass
class SelfCheckResult:
    """What the check came to."""

    own: list[SelfCheckTrial] = field(default_factory=list)  # takes that were not learned from
    talk: list[SelfCheckTrial] = field(default_factory=list)  # likewise
    others: list[SelfCheckTrial] = field(default_factory=list)
    wrong_words: list[str] = field(default_factory=list)
    settings: Settings = field(default_factory=lambda: Settings(commands=()))
    expected: list[ExpectedErrors] = field(default_factory=list)

    def problems(self, config: EnrolmentConfig) -> tuple[str, ...]:
        """Why the profile may not be used; each names value and limit. Empty: it may."""
        limits, found = config.self_check, list(self.wrong_words)
        base, mine = right(self.own, "base"), right(self.own, "profile")
        if mine < base - limits.own_worse:
            found.append(
                f"takes: {mine} of {len(self.own)} right, allowed: at least "
                f"{base - limits.own_worse}, as the base has {base}"
            )
        said = [trial for trial in self.others if trial.phrase]
        rest = [trial for trial in self.others if not trial.phrase]
        more = sum(bool(t.profile) and not t.base for t in rest)
        more -= sum(bool(t.base) and not t.profile for t in rest)
        limited = (
            (
                "takes for another command",
                confused(self.own, "profile"),
                confused(self.own, "base") + limits.own_confused,
            ),
            (
                "commands taken from talk",
                sum(len(trial.profile) for trial in self.talk),
                sum(len(trial.base) for trial in self.talk) + limits.talk_more,
            ),
            (
                f"of {len(said)} commands of other voices lost",
                right(said, "base") - right(said, "profile"),
                _whole(limits.others_worse, len(said)),
            ),
            (
                f"of {len(rest)} near misses and talk of others newly taken",
                more,
                _whole(limits.others_taken, len(rest)),
            ),
        )
        found += [f"{what}: {n}, allowed: up to {most}" for what, n, most in limited if n > most]
        return tuple(found)


class SelfCheck:
    """Hears takes with what was learned from other takes."""

    def __init__(
        self,
        voice: VoiceConfig,
        config: EnrolmentConfig,
        base: EmbeddedRecognizer,
        on_progress: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Check on top of a base.

        Args:
            voice: Active settings, without a profile.
            config: Of enrolment.
            base: Recogniser.
            on_progress: Called with the name of each stage.
        """
        self._voice, self._config, self._base = voice, config, base
        self._on_progress = on_progress
        self._base_probe = PipelineProbe(voice, base)

    def __call__(
        self,
        material: EnrolmentMaterial,
        written: Spellings,
        learned: PersonalRecognizer,
        others: Sequence[Example],
    ) -> SelfCheckResult:
        """Check what was learned from all takes, and set the thresholds.

        Args:
            material: All takes and talk.
            written: Spellings of the commands, learned from all takes.
            learned: From all of it.
            others: That were learned beside it.
        """
        verdict = SelfCheckResult()
        takes, talk = self._folds(material, others)
        strangers = self._strangers(self._probe(learned, written))
        self._set_thresholds(verdict, takes, talk, strangers, material.talked)
        verdict.own = [self._trial(spoken, heard, verdict.settings) for spoken, heard in takes]
        verdict.talk = [self._trial(spoken, heard, verdict.settings) for spoken, heard in talk]
        verdict.others = [self._trial(s, heard, verdict.settings) for s, heard in strangers]
        return verdict

    def _folds(
        self, material: EnrolmentMaterial, others: Sequence[Example]
    ) -> tuple[list[HeardTake], list[HeardTake]]:
        """Each take, and each piece of talk, heard by what was learned without it."""
        own: list[HeardTake] = []
        talk: list[HeardTake] = []
        folds = self._config.self_check.folds
        for fold in range(folds):
            self._on_progress(f"self-check {fold + 1} of {folds}")
            rest, left = material.split(fold, folds)
            if not (rest.takes and (left.takes or left.talk)):
                continue
            state = learn(self._base, rest, others, self._config.adapt).state
            personal = PersonalRecognizer(self._base, state)
            written, _ = hear_spellings(rest.said, personal, self._voice.commands)
            probe = self._probe(personal, written)
            own += [(take, probe(take.samples)) for take in left.takes]
            talk += [(piece, probe(piece.samples)) for piece in left.talk]
        return own, talk

    def _probe(self, personal: PersonalRecognizer, written: Spellings) -> PipelineProbe:
        commands = spellings.overlay(self._voice.commands, written)
        return PipelineProbe(replace(self._voice, commands=commands), personal)

    def _strangers(self, probe: PipelineProbe) -> list[HeardTake]:
        """What other voices say, which neither training nor adaptation heard."""
        self._on_progress("self-check, other voices")
        phrases = self._voice.commands.fixed_phrases
        seed = self._config.adapt.seed + _OTHER_SEED
        spoken = other_voices(phrases, self._config.self_check.others, seed, are_held_out=True)
        phrase_of = {spelled(phrase): phrase for phrase in phrases}
        cast = [LabelledTake(e.text, phrase_of.get(e.text, ""), e.samples) for e in spoken]
        return [(one, probe(one.samples)) for one in cast]

    def _set_thresholds(
        self,
        verdict: SelfCheckResult,
        own: Sequence[HeardTake],
        talk: Sequence[HeardTake],
        strangers: Sequence[HeardTake],
        hours: float,
    ) -> None:
        chosen = []
        for command in self._voice.commands.commands:
            phrase = command.phrase
            mine = [_best(heard, phrase) for spoken, heard in own if spoken.phrase == phrase]
            talked = [s for _, heard in talk if (s := _best(heard, phrase)) is not None]
            nears = [h for spoken, h in strangers if not spoken.phrase]
            against = [s for heard in nears if (s := _best(heard, phrase)) is not None]
            heard_well = tuple(sure for sure in mine if sure is not None)
            evidence = ConfidenceEvidence(heard_well, mine.count(None), (*talked, *against))
            threshold = choose_threshold(command, evidence, self._config.self_check.margin)
            expected = expected_errors(command, threshold, evidence, talked, hours)
            verdict.expected.append(expected)
            chosen.append(expected.to_setting())
        verdict.settings = Settings(commands=tuple(chosen))

    def _trial(
        self, spoken: LabelledTake, heard: PipelineResult, settings: Settings
    ) -> SelfCheckTrial:
        """Taken: what the pipeline took, less motions below the person's own threshold."""
        base = self._base_probe(spoken.samples)
        allowed = overlay(self._voice.commands, settings)

        def is_taken(claim: ClaimedCommand) -> bool:
            command = allowed.get(claim.command)
            is_enough = claim.confidence >= command.min_confidence
            return claim.is_taken and (is_enough or not command.is_motion)

        taken = tuple(claim.command for claim in heard.claims if is_taken(claim))
        return SelfCheckTrial(spoken.phrase, base.taken, taken)


def wrong_words(
    material: EnrolmentMaterial, check_take: Callable[[str, str, Samples], Checked]
) -> list[str]:
    """Takes in which the base clearly hears another command; nothing is learned from them.

    Args:
        material: All takes.
        check_take: As while recording.
    """
    found = []
    for take in material.takes:
        if (checked := check_take(COMMAND, take.phrase, take.samples)).is_other:
            found += [f"{take.file}: {text}" for text in checked.problems]
    return found


def _best(heard: PipelineResult, phrase: str) -> float | None:
    """Highest confidence with which a command was named; None: its words were not heard."""
    claims = [claim.confidence for claim in heard.claims if claim.command == phrase]
    return max(claims, default=None)


def right(trials: Sequence[SelfCheckTrial], who: str) -> int:
    """Trials in which the command, and no other, was taken; who: "base" or "profile"."""
    return sum(set(getattr(trial, who)) == {trial.phrase} for trial in trials)


def confused(trials: Sequence[SelfCheckTrial], who: str) -> int:
    """Trials in which another command was taken."""
    return sum(bool(set(getattr(trial, who)) - {trial.phrase}) for trial in trials)


def _whole(share: float, count: int) -> int:
    """A share of a count, at least one: a single trial cannot be distinguished from chance."""
    return max(round(share * count), 1) if share > 0.0 and count else 0
