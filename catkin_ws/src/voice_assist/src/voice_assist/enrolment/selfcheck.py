# SPDX-License-Identifier: BSD-3-Clause
"""A profile's own check: it must be better for its person and no worse for anybody else."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from voice_assist.config import VoiceConfig
from voice_assist.config.enrolment import EnrolmentConfig
from voice_assist.enrolment.checks import Checked
from voice_assist.enrolment.examples import Example, other_voices
from voice_assist.enrolment.learn import Material, Spoken, learn
from voice_assist.enrolment.pipeline_probe import Ear, Heard
from voice_assist.enrolment.thresholds import Evidence, Expected, choose, expect
from voice_assist.evaluation.evaluator import Claim
from voice_assist.profile.active import PersonalRecognizer
from voice_assist.profile.manifest import COMMAND
from voice_assist.profile.thresholds import Settings, overlay
from voice_assist.recognizer.embedded import EmbeddedRecognizer
from voice_assist.types import Samples

_OTHER_SEED = 1000  # added to the seed of what is learned from: other texts, other voices


@dataclass(frozen=True)
class Trial:
    """One sound, and what base and profile made of it."""

    name: str  # of the take, or text of another voice
    phrase: str  # that was said; empty: no command
    base: tuple[str, ...]  # commands taken
    profile: tuple[str, ...]


@dataclass
class Verdict:
    """What the check came to."""

    own: list[Trial] = field(default_factory=list)  # takes that were not learned from
    talk: list[Trial] = field(default_factory=list)  # likewise
    others: list[Trial] = field(default_factory=list)
    wrong_words: list[str] = field(default_factory=list)
    settings: Settings = field(default_factory=lambda: Settings(commands=()))
    expected: list[Expected] = field(default_factory=list)

    def problems(self, config: EnrolmentConfig) -> tuple[str, ...]:
        """Why the profile may not be used; each names value and limit. Empty: it may."""
        limits, found = config.self_check, list(self.wrong_words)
        base, mine = _right(self.own, "base"), _right(self.own, "profile")
        if mine < base - limits.own_worse:
            found.append(
                f"takes: {mine} of {len(self.own)} right, allowed: at least "
                f"{base - limits.own_worse}, as the base has {base}"
            )
        _limit(
            found,
            "takes for another command",
            _confused(self.own, "profile"),
            _confused(self.own, "base") + limits.own_confused,
        )
        _limit(
            found,
            "commands taken from talk",
            sum(len(trial.profile) for trial in self.talk),
            sum(len(trial.base) for trial in self.talk) + limits.talk_more,
        )
        said = [trial for trial in self.others if trial.phrase]
        rest = [trial for trial in self.others if not trial.phrase]
        lost = _right(said, "base") - _right(said, "profile")
        allowed = _whole(limits.others_worse, len(said))
        _limit(found, f"of {len(said)} commands of other voices lost", lost, allowed)
        more = sum(bool(t.profile) and not t.base for t in rest)
        more -= sum(bool(t.base) and not t.profile for t in rest)
        allowed = _whole(limits.others_taken, len(rest))
        _limit(found, f"of {len(rest)} near misses and talk of others newly taken", more, allowed)
        return tuple(found)


class SelfCheck:
    """Hears takes with what was learned from other takes."""

    def __init__(
        self,
        voice: VoiceConfig,
        config: EnrolmentConfig,
        base: EmbeddedRecognizer,
        told: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Check on top of a base.

        Args:
            voice: Settings in force, without a profile.
            config: Of enrolment.
            base: Recogniser.
            told: Says how far it is.
        """
        self._voice, self._config, self._base = voice, config, base
        self._told = told
        self._base_ear, self._own = Ear(voice, base), voice

    def __call__(
        self,
        material: Material,
        own: VoiceConfig,
        learned: PersonalRecognizer,
        others: Sequence[Example],
    ) -> Verdict:
        """Check what was learned from all takes, and set the thresholds.

        Args:
            material: All takes and talk.
            own: Settings with what else was learned of the person, such as spellings.
            learned: From all of it.
            others: That were learned beside it.
        """
        verdict, self._own = Verdict(), own
        takes, talk = self._folds(material, others)
        strangers = self._strangers(learned)
        self._set_thresholds(verdict, takes, talk, strangers, material.talked)
        verdict.own = [self._trial(spoken, heard, verdict.settings) for spoken, heard in takes]
        verdict.talk = [self._trial(spoken, heard, verdict.settings) for spoken, heard in talk]
        verdict.others = [self._trial(s, heard, verdict.settings) for s, heard in strangers]
        return verdict

    def _folds(
        self, material: Material, others: Sequence[Example]
    ) -> tuple[list[tuple[Spoken, Heard]], list[tuple[Spoken, Heard]]]:
        """Each take, and each piece of talk, heard by what was learned without it."""
        own: list[tuple[Spoken, Heard]] = []
        talk: list[tuple[Spoken, Heard]] = []
        folds = self._config.self_check.folds
        for fold in range(folds):
            self._told(f"self-check {fold + 1} of {folds}")
            rest, left = material.without(fold, folds), material.only(fold, folds)
            if not (rest.takes and (left.takes or left.talk)):
                continue
            state = learn(self._base, rest, others, self._config.adapt).state
            ear = Ear(self._own, PersonalRecognizer(self._base, state))
            own += [(take, ear(take.samples)) for take in left.takes]
            talk += [(piece, ear(piece.samples)) for piece in left.talk]
        return own, talk

    def _strangers(self, learned: PersonalRecognizer) -> list[tuple[Spoken, Heard]]:
        self._told("self-check, other voices")
        phrases = self._voice.commands.phrases
        seed = self._config.adapt.seed + _OTHER_SEED
        spoken = other_voices(phrases, self._config.self_check.others, seed)
        ear = Ear(self._own, learned)
        cast = [Spoken(e.text, e.text if e.text in phrases else "", e.samples) for e in spoken]
        return [(one, ear(one.samples)) for one in cast]

    def _set_thresholds(
        self,
        verdict: Verdict,
        own: Sequence[tuple[Spoken, Heard]],
        talk: Sequence[tuple[Spoken, Heard]],
        strangers: Sequence[tuple[Spoken, Heard]],
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
            evidence = Evidence(heard_well, mine.count(None), (*talked, *against))
            least = choose(command, evidence, self._config.self_check.margin)
            expected = expect(command, least, evidence, talked, hours)
            verdict.expected.append(expected)
            chosen.append(expected.to_setting())
        verdict.settings = Settings(commands=tuple(chosen))

    def _trial(self, spoken: Spoken, heard: Heard, settings: Settings) -> Trial:
        """Taken: what the pipeline took, less motions below the person's own threshold."""
        base = self._base_ear(spoken.samples)
        allowed = overlay(self._voice.commands, settings)

        def is_taken(claim: Claim) -> bool:
            command = allowed.get(claim.command)
            is_enough = claim.confidence >= command.least_confidence
            return claim.is_taken and (is_enough or not command.is_motion)

        taken = tuple(claim.command for claim in heard.claims if is_taken(claim))
        return Trial(spoken.file, spoken.phrase, base.taken, taken)


def wrong_words(
    material: Material, check_take: Callable[[str, str, Samples], Checked]
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


def _best(heard: Heard, phrase: str) -> float | None:
    """Highest confidence with which a command was named; None: its words were not heard."""
    claims = [claim.confidence for claim in heard.claims if claim.command == phrase]
    return max(claims, default=None)


def _right(trials: Sequence[Trial], who: str) -> int:
    """Trials in which the command, and no other, was taken."""
    return sum(set(getattr(trial, who)) == {trial.phrase} for trial in trials)


def _confused(trials: Sequence[Trial], who: str) -> int:
    return sum(bool(set(getattr(trial, who)) - {trial.phrase}) for trial in trials)


def _limit(found: list[str], what: str, value: int, allowed: int) -> None:
    if value > allowed:
        found.append(f"{what}: {value}, allowed: up to {allowed}")


def _whole(share: float, count: int) -> int:
    """A share of so many, at least one where there are any: fewer cannot be told from chance."""
    return max(round(share * count), 1) if share > 0.0 and count else 0
