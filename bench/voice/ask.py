# SPDX-License-Identifier: BSD-3-Clause
"""Commands that are won back by asking, and what asking could let through.

Every scene is a word and, about 2 s later, an answer. Commands and strange words are answered by
"yes" in the same voice; strange words by other words as well, which must do nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import Label, SceneRecord
from bench.voice.hearing.replay_stream import SoundScene
from bench.voice.material.foreign_clips import by_espeak
from bench.voice.material.held_out_voices import SyntheticVoice, foreigners, natives, spread
from bench.voice.material.mixing import PER_CHUNK, StreamedTrial, stream_of, trials_of
from bench.voice.material.synthesis import SpokenClip, spoken
from bench.voice.no_commands import armed
from bench.voice.outcomes import hours, motions
from bench.voice.trials import MOTIONS
from support.figures import Figure, rate, share
from support.product_code import HEARING, identity
from voice_assist.types import Mode

SEED = 23
YES, OTHERS = "yes", ("no", "okay", "thank you", "next one please")
SNR = 0.0  # [dB] of commands over the noise of a theatre
PEOPLE = "human speech, armed"
ASKED = "nearly sure;"  # how the reason of a question begins


@dataclass(frozen=True)
class AskTrial:
    """A word and the answer to what may be asked then; None: nobody answers."""

    said: StreamedTrial
    answer: StreamedTrial | None

    def scene(self) -> tuple[Label, SoundScene]:
        """What to stream, and what is known of it."""
        sound, _, seconds = stream_of(self.said)
        if self.answer is not None:
            answer, _, more = stream_of(self.answer)
            sound, seconds = np.concatenate([sound, answer]), seconds + more
        label: Label = {**asdict(self.said.clip), "seconds": seconds}  # without what is around it
        return label, SoundScene(sound, Mode.ACTIVE, keeps_mode=False, asks=True)


def measure() -> list[Figure]:
    """Commands won back, false motions, and questions about nothing."""
    plans = _plans()
    # The key of other pieces knows nothing of questions, which count as refusals there.
    found, count = pieces.found(f"ask-{identity(HEARING)}", plans, PER_CHUNK)
    figures = [count]
    for name, records in found.items():
        figures += _of(name, records)
    return figures


def _of(name: str, records: Sequence[SceneRecord]) -> list[Figure]:
    asked = [r for r in records if any(one.why.startswith(ASKED) for one in r.heard.said)]
    n = len(records)
    if name == PEOPLE:
        moved = [r for r in records if not motions().isdisjoint(r.heard.taken)]
        questions = rate(f"{name}: questions", len(asked), hours(records), note=_words(asked))
        return [questions, _moved(name, moved, n, 0.0)]
    figures = [Figure(f"{name}: asked for", len(asked), "", note=f"(of {n})")]
    if name.startswith("commands"):
        right = [r for r in records if r.label["text"] in r.heard.taken]
        won = [r for r in right if r in asked]
        wrong = [r for r in records if (motions() - {r.label["text"]}) & set(r.heard.taken)]
        note = f"(of {n}: {len(right)} right with them, {len(right) - len(won)} without)"
        figures.append(Figure(f"{name}: won back", len(won), "", note=note))
        return [*figures, _moved(name, wrong, n)]
    moved = [r for r in records if not motions().isdisjoint(r.heard.taken)]
    through = [r for r in moved if r in asked]
    note = "of these after a question"
    figures.append(Figure(f"{name}: {note}", len(through), ""))
    return [*figures, _moved(name, moved, n, 0.0 if "others" in name else None)]


def _moved(name: str, moved: Sequence[SceneRecord], n: int, target: float | None = None) -> Figure:
    note = _words(moved)
    return share(f"{name}: false motions", len(moved), n, target, at_most=True, note=note)


def _words(records: Sequence[SceneRecord]) -> str:
    """What was said in them."""
    return ", ".join(sorted({str(r.label["text"] or "talk") for r in records}))


def _plans() -> dict[str, list[AskTrial]]:
    strange = by_espeak()
    words = [*strange["near words"], *strange["named"]]
    accents = spoken(spread(MOTIONS, foreigners().present, 2, SEED))
    native = spoken(spread(MOTIONS, natives().present, 2, SEED))
    noisy = [StreamedTrial(c, i, background="theatre", snr=SNR) for i, c in enumerate(native)]
    return {
        "commands, accents": _answered(trials_of(accents), (YES,)),
        "commands, 0 dB": _answered(noisy, (YES,)),
        "strange words, then yes": _answered(trials_of(words), (YES,)),
        "strange words, then others": _answered(trials_of(words), OTHERS),
        PEOPLE: [AskTrial(trial, None) for trial in trials_of(armed.clips())],
    }


def _answered(said: Sequence[StreamedTrial], answers: Sequence[str]) -> list[AskTrial]:
    """Each with one answer in the same voice, where it speaks English, or in a native one."""
    speakers = {SyntheticVoice(t.clip.engine, t.clip.voice) for t in said}
    cast = sorted(v for v in speakers if v in (*natives().present, *foreigners().present))
    cast = cast or list(natives().present)
    by_voice: dict[str, list[SpokenClip]] = {}
    for clip in spoken(spread(answers, cast, 1, SEED)):
        by_voice.setdefault(clip.voice, []).append(clip)
    every = [clip for clips in by_voice.values() for clip in clips]
    trials = []
    for index, trial in enumerate(said):
        own = by_voice.get(trial.clip.voice, every)
        trials.append(AskTrial(trial, StreamedTrial(own[index % len(own)], index)))
    return trials
