# SPDX-License-Identifier: BSD-3-Clause
"""Commands, near misses and other words of other languages, in voices of their own.

No threshold was chosen, and no background of a phrase measured, with any of these voices.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from bench.voice.material.foreign_clips import in_kokoro
from bench.voice.material.foreign_words import LANGUAGES as WORDS
from bench.voice.material.foreign_words import Spoken
from bench.voice.material.held_out_voices import SyntheticVoice, spread
from bench.voice.material.synthesis import SpokenClip, spoken
from voice_assist.config import load_voice_config
from voice_assist.text.phonetic_distance import espeak_language

SEED = 41
VARIANTS = ("Alex", "Marco", "boris", "zac")  # of espeak-ng


@dataclass(frozen=True)
class LanguageVoices:
    """Who speaks a language, and what comes near to its commands."""

    mbrola: tuple[str, ...]  # diphones of one person each
    kokoro: tuple[str, ...]  # styles; ff_siwis is French, ef_dora Spanish, jm_kumo Japanese
    near: str  # separated by "|"
    others: Spoken  # words and short talk


LANGUAGES = {
    "de": LanguageVoices(
        ("mb-de4", "mb-de5"),
        ("af_sky", "bm_fable"),
        "mehr Licht|mehr zeigen|mehr saugen|weniger saugen|weniger Druck|wenig ziehen|"
        "nicht ziehen|noch mehr|Gewebe|Gewebeprobe|Gewebe spülen|das Gewebe schonen|spannend|"
        "jetzt los|jetzt lassen wir das|noch nicht loslassen|lass los|Sitzung|Sitzung beginnen|"
        "Sitzungsende|die Sitzung endet|hallo Doktor|hallo zusammen|Roboter|Haltung|halten|"
        "Altstadt|Stoff|Stock|gestoppt",
        WORDS["German"],
    ),
    "es": LanguageVoices(
        ("mb-es1",),
        ("ef_dora", "af_sky", "bm_fable"),
        "más luz|tira la gasa|tira|más fuerte|no tires fuerte|tijera fuerte|afloja|un poco|"
        "afloja la venda|aspira un poco|espera un poco|el tejido|tensa|tensa la sutura|"
        "corta el tejido|suelta|suelta la pinza|no sueltes ahora|vuelta ahora|ahora|"
        "terminar|terminar la sutura|empezar sesión|la sesión|hola doctor|hola a todos|robot|"
        "asalto|salto|está en alto",
        WORDS["Spanish"],
    ),
    "fr": LanguageVoices(
        ("mb-fr1", "mb-fr4"),
        ("ff_siwis", "bm_fable"),
        "plus de force|la force|augmenter la lumière|augmenter le débit|diminuer la force|"
        "moins fort|tirer|tirer plus fort|ne pas tirer fort|parler moins fort|tendre|"
        "tendre la main|le tissu|prendre le tissu|fendre le tissu|ouvrir|la pince|"
        "fermer la pince|ouvrir la peau|ne pas ouvrir|terminer|la séance|terminer la suture|"
        "commencer la séance|bonjour docteur|bonjour à tous|robot|arrivez|arrière|un arrêt",
        WORDS["French"],
    ),
    "ja": LanguageVoices(
        ("mb-jp3",),
        ("jm_kumo", "af_sky", "bm_fable"),
        "もっと ひらいて|もっと ひろげて|もっと ひかりを|ひっぱって|ひっぱらないで|もっと おして|"
        "すこし ひいて|すこし あげて|すこし まって|ゆるめないで|しめて|そしき|そしきを あらって|"
        "そしきを はさんで|そしきを とって|はなして いい|テンション|テンションが たかい|"
        "でんわを かけて|ライトを かけて|セッション|セッションを はじめます|しゅうりょう|"
        "こんにちは せんせい|こんにちは みなさん|ロボット|ストック|トップ|とまって いる|たまに",
        WORDS["Japanese"],
    ),
}


def commands(language: str) -> list[SpokenClip]:
    """Each phrase of a language by each voice; the text is the command that it calls."""
    called = {c.phrase: c.command for c in load_voice_config(language=language).commands.commands}
    said = _by_engines(language, tuple(called)) + _by_kokoro(language, tuple(called))
    return [replace(clip, text=called[clip.text]) for clip in said]


def near_misses(language: str) -> list[SpokenClip]:
    """What comes near to a command, each text by one voice."""
    return _in_turn(language, LANGUAGES[language].near)


def other_words(language: str) -> list[SpokenClip]:
    """Words that sound like English commands, of a theatre, and short talk; each by one voice."""
    words = LANGUAGES[language].others
    return _in_turn(language, "|".join((words.near, words.words, words.talk)))


def _in_turn(language: str, texts: str) -> list[SpokenClip]:
    """One text after the other, each by the next voice that is no style of Kokoro."""
    cast, every = _voices(language), texts.split("|")
    turns = [every[number :: len(cast)] for number in range(len(cast))]
    prompts = [p for v, some in zip(cast, turns, strict=True) for p in spread(some, [v], 1, SEED)]
    return spoken(sorted(prompts, key=lambda p: (p.engine, p.voice, p.text)))


def _by_engines(language: str, texts: tuple[str, ...]) -> list[SpokenClip]:
    return spoken(spread(texts, _voices(language), 1, SEED))


def _by_kokoro(language: str, texts: tuple[str, ...]) -> list[SpokenClip]:
    sounds, styles = espeak_language(language), LANGUAGES[language].kokoro
    return in_kokoro([(text, sounds, style) for style in styles for text in texts])


def _voices(language: str) -> list[SyntheticVoice]:
    sounds = espeak_language(language)
    people = [SyntheticVoice("mbrola", name) for name in LANGUAGES[language].mbrola]
    return [SyntheticVoice("espeak", f"{sounds}+{name}") for name in VARIANTS] + people
