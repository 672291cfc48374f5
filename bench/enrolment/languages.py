# SPDX-License-Identifier: BSD-3-Clause
"""`make bench ONLY=languages`: phrases of other languages, and new ones, learned from five takes.

A person is one synthetic voice of the language. What the recogniser writes for five takes of each
phrase becomes spellings; tried are other renderings of that voice, at other speeds and pitches,
and the other voices of the language, who never enrolled. Decided is as in the pipeline, by
recogniser, mapping and second opinion, on whole clips: endpointing is not part of it.
`languages.adapted` adapts the recogniser's weights instead, as enrolment does, to PERSONS (1) of
each set: voices of MBROLA, which are diphones of people.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from random import Random

import numpy as np

from bench.voice.material.held_out_voices import SyntheticVoice
from session_log.report.bounds import at_least, at_most
from support.figures import Figure
from typed_config import load_config, load_yaml
from voice_assist.config import CONFIG_DIR, CommandsConfig, VoiceConfig, load_voice_config
from voice_assist.intent.mapper import Mapper
from voice_assist.profile.spellings import learn_spellings, overlay
from voice_assist.recognizer import load_recognizer
from voice_assist.recognizer.recognizer import Recognizer
from voice_assist.text.normalize import normalize
from voice_assist.training.data.voices import Prompt, speak
from voice_assist.types import RATE, Match, Samples

PERSONS = int(os.environ.get("PERSONS", "1"))
TAKES = 5  # of each phrase
TRIED = 4  # renderings of each phrase by the person, not enrolled
STRANGE = 2  # of each phrase by each of the other voices
QUIET = 10.0 ** (-70.0 / 20.0)  # of full scale, around and under the speech
BEFORE, AFTER = 0.2, 0.4  # [s] of it


@dataclass(frozen=True)
class Set:
    """One language or set of phrases."""

    name: str
    file: str  # of config/
    language: str  # of espeak-ng
    cast: tuple[SyntheticVoice, ...]
    talk: tuple[str, ...]  # that is no command
    said: tuple[tuple[str, str], ...] = ()  # how a phrase is written for a voice, where it differs


SETS = (
    Set(
        "German",
        "commands_de.yaml",
        "de",
        (
            *(SyntheticVoice("espeak", name) for name in ("de", "de+f3", "de+m5")),
            *(SyntheticVoice("mbrola", f"mb-de{n}") for n in (4, 5, 6)),
            SyntheticVoice("pico", "de-DE"),
        ),
        (
            "wir haben mehr Zeit als gestern|bitte die Lampe etwas weiter nach links|heute nicht",
            "der Patient ist wach|halten Sie das bitte|wie lange dauert es noch|ziehen wir um",
            "das Gewebe ist gespannt|einen Moment noch|nicht mehr ziehen|weniger Licht|guten Tag",
        ),
    ),
    Set(
        "Spanish",
        "commands_es.yaml",
        "es",
        (
            *(SyntheticVoice("espeak", name) for name in ("es", "es-419+f2", "es+m3")),
            SyntheticVoice("mbrola", "mb-es1"),
            SyntheticVoice("pico", "es-ES"),
        ),
        (
            "tenemos más tiempo que ayer|la lámpara un poco más a la izquierda|hoy no|buenos días",
            "el paciente está despierto|un momento por favor|cuánto falta todavía|no tira más",
            "el tejido está tenso|hay menos luz|vamos a terminar pronto|está muy alto|otra vez",
        ),
        (("tira mas", "tira más"),),
    ),
    Set(
        "endoscope, English",
        "endoscope_commands.yaml",
        "en-us",
        (
            SyntheticVoice("espeak", "en-gb-x-gbcwmd"),
            *(SyntheticVoice("flite", name) for name in ("awb", "rms")),
            SyntheticVoice("rhvoice", "alan"),
            SyntheticVoice("pico", "en-US"),
            *(SyntheticVoice("mbrola", f"mb-{name}") for name in ("us1", "us2", "en1")),
        ),
        (
            "we go left at the next corner|the lower right quadrant|zoom call at noon|good morning",
            "the patient is awake|one moment please|go and get it|turn the light up|do not go left",
            "her upper arm hurts|how long does it take|no not that one|it went down|not today",
        ),
    ),
)


@dataclass(frozen=True)
class PhraseClip:
    """What was said, and by whom."""

    phrase: str  # command; empty: none
    samples: Samples


class Ear:
    """Decides what a clip is, as the pipeline does with an utterance that is over."""

    def __init__(
        self, config: VoiceConfig, commands: CommandsConfig, recognizer: Recognizer
    ) -> None:
        """Use these commands."""
        self._commands, self._recognizer = commands, recognizer
        self._worth, self._map = config.recognizer.confidence, Mapper(commands)

    def __call__(self, samples: Samples) -> str:
        """The command that is taken; empty: none."""
        heard = self._recognizer.transcribe(samples)
        outcome = self._map(heard.text)
        if not isinstance(outcome, Match):
            return ""
        command = self._commands.get(outcome.command)
        if command.is_halt:
            return command.phrase if heard.confidence >= command.min_confidence else ""
        texts = self._commands.scored(command.phrase, normalize(heard.text))
        scores = self._recognizer.score(samples, tuple(texts.values()))
        best = max(texts, key=lambda phrase: scores[texts[phrase]])
        confidence = self._worth.scores(scores[texts[command.phrase]])
        is_sure = best == command.phrase and confidence >= command.min_confidence
        return command.phrase if is_sure else ""


class PhraseTally:
    """Counts of what came of clips."""

    def __init__(self) -> None:
        """Nothing so far."""
        self.counts: Counter[str] = Counter()

    def add(self, ear: Ear, clips: Sequence[PhraseClip]) -> None:
        """Let an ear hear clips."""
        for clip in clips:
            taken = ear(clip.samples)
            kind = "right" if taken == clip.phrase else "missed" if not taken else "wrong"
            self.counts[kind] += 1

    @property
    def total(self) -> int:
        """Of all clips."""
        return self.counts.total()

    def figures(self, name: str) -> Iterator[Figure]:
        """Share that was right, and share taken for another command."""
        for kind, bound in (("right", at_least), ("wrong", at_most)):
            count = self.counts[kind]
            side = "at least" if kind == "right" else "at most"
            share = 100.0 * bound(count, self.total)
            note = f"({count} of {self.total}, {side} {share:.1f} % with 95 %)"
            yield Figure(f"{name}: {kind}", 100.0 * count / self.total, "%", note=note)


def measure() -> list[Figure]:
    """What spellings learned from takes do, in all sets."""
    recognizer = load_recognizer("embedded", "cpu")
    return [figure for one in SETS for figure in _measure_set(one, recognizer)]


def measure_adapted() -> list[Figure]:
    """What adapting the recogniser's weights does, in all sets."""
    recognizer = load_recognizer("embedded", "cpu")
    return [figure for one in SETS for figure in _adapted_set(one, recognizer)]


def _measure_set(one: Set, recognizer: Recognizer) -> Iterator[Figure]:
    commands = _commands(one)
    config = replace(load_voice_config(), commands=commands)
    names = ("own voice before", "own voice after", "others after", "talk before", "talk after")
    tallies = {name: PhraseTally() for name in names}
    base, learned, refused = Ear(config, commands, recognizer), 0, 0
    tried = {voice: _clips(one, commands, voice, TRIED, seed=2) for voice in one.cast}
    strange = {voice: clips[: STRANGE * len(commands.phrases)] for voice, clips in tried.items()}
    for person in one.cast:
        takes = _clips(one, commands, person, TAKES, seed=1)
        written: dict[str, list[str]] = {}
        for take in takes:
            written.setdefault(take.phrase, []).append(recognizer.transcribe(take.samples).text)
        spellings, not_learned = learn_spellings(written, commands, one.language)
        learned += sum(len(s.learned) for s in spellings.commands)
        refused += len(not_learned)
        ear = Ear(config, overlay(commands, spellings), recognizer)
        talk = _talk(one, person)
        for name, who, clips in (
            ("own voice before", base, tried[person]),
            ("own voice after", ear, tried[person]),
            ("talk before", base, talk),
            ("talk after", ear, talk),
        ):
            tallies[name].add(who, clips)
        for other in one.cast:
            if other != person:
                tallies["others after"].add(ear, strange[other])
    note = f"({refused} refused; {len(one.cast)} voices, {TAKES} takes of each phrase)"
    yield Figure(f"{one.name}: spellings learned", learned, "", note=note)
    for name in names[:3]:
        yield from tallies[name].figures(f"{one.name}, {name}")
    for name in names[3:]:
        yield list(tallies[name].figures(f"{one.name}, {name}"))[1]


def _adapted_set(one: Set, recognizer: Recognizer) -> Iterator[Figure]:
    config, commands = load_voice_config(), _commands(one)
    names = ("own voice adapted", "others adapted", "talk adapted")
    tallies, seconds = {name: PhraseTally() for name in names}, []
    tried = {voice: _clips(one, commands, voice, TRIED, seed=2) for voice in one.cast}
    persons = [voice for voice in one.cast if voice.engine == "mbrola"][:PERSONS]
    for person in persons:
        talk = _talk(one, person)
        half = len(talk) // 2  # is enrolled, as whatever the base writes for it
        takes = _clips(one, commands, person, TAKES, seed=1)
        personal, spent = _adapted(takes, talk[:half], commands, recognizer)
        ear = Ear(config, commands, personal)
        seconds.append(spent)
        strangers = [c for v in one.cast if v != person for c in tried[v][: len(commands.phrases)]]
        for name, clips in zip(names, (tried[person], strangers, talk[half:]), strict=True):
            tallies[name].add(ear, clips)
        print(f"{one.name}, {person}: {dict(tallies[names[0]].counts)}", flush=True)
    for name in names[:2]:
        yield from tallies[name].figures(f"{one.name}, {name}")
    yield list(tallies[names[2]].figures(f"{one.name}, {names[2]}"))[1]
    note = f"(CPU time, mean of {len(persons)} voices)"
    yield Figure(f"{one.name}: adaptation", float(np.mean(seconds)), "s", note=note)


def _adapted(
    takes: Sequence[PhraseClip],
    talk: Sequence[PhraseClip],
    commands: CommandsConfig,
    recognizer: Recognizer,
) -> tuple[Recognizer, float]:
    """The recogniser as enrolment adapts it, and the CPU time that it took [s]."""
    from voice_assist.config.enrolment import load_enrolment_config
    from voice_assist.enrolment.learn import EnrolmentMaterial, LabelledTake, learn, others_for
    from voice_assist.profile.active import PersonalRecognizer
    from voice_assist.recognizer.embedded import EmbeddedRecognizer

    if not isinstance(recognizer, EmbeddedRecognizer):
        raise TypeError(f"{type(recognizer).__name__}, allowed: EmbeddedRecognizer")
    how = load_enrolment_config().adapt
    said = tuple(LabelledTake("", take.phrase, take.samples) for take in takes)
    other = tuple(LabelledTake("", "", clip.samples) for clip in talk)
    learned = learn(
        recognizer, EnrolmentMaterial(said, other), others_for(commands.phrases, how), how
    )
    return PersonalRecognizer(recognizer, learned.state), learned.seconds


def _commands(one: Set) -> CommandsConfig:
    return load_config(CommandsConfig, load_yaml(CONFIG_DIR / one.file), one.file)


def _clips(
    one: Set, commands: CommandsConfig, voice: SyntheticVoice, each: int, seed: int
) -> list[PhraseClip]:
    """Renderings of every phrase, all phrases once before any comes again."""
    rng, said = Random(f"{voice}{seed}"), dict(one.said)
    plan = [
        (phrase, Prompt(said.get(phrase, phrase), voice.engine, voice.name, *_style(rng)))
        for _ in range(each)
        for phrase in commands.phrases
    ]
    sounds = speak([prompt for _, prompt in plan])
    pairs = zip(plan, sounds, strict=True)
    return [PhraseClip(phrase, _room(s, rng)) for (phrase, _), s in pairs if s is not None]


def _talk(one: Set, voice: SyntheticVoice) -> list[PhraseClip]:
    rng = Random(f"{voice} talks")
    texts = [text for line in one.talk for text in line.split("|")]
    sounds = speak([Prompt(text, voice.engine, voice.name, *_style(rng)) for text in texts])
    return [PhraseClip("", _room(s, rng)) for s in sounds if s is not None]


def _style(rng: Random) -> tuple[float, float]:
    """Speed and pitch, as they differ between two times that a person says a thing."""
    return rng.uniform(0.85, 1.15), rng.uniform(0.42, 0.58)


def _room(sound: np.ndarray, rng: Random) -> Samples:
    count = len(sound) + round((BEFORE + AFTER) * RATE)
    samples = QUIET * np.random.default_rng(rng.randrange(2**32)).standard_normal(count)
    start = round(BEFORE * RATE)
    samples[start : start + len(sound)] += sound / 32768.0
    return samples.astype(np.float32)


PARTS = {"adapted": measure_adapted}
