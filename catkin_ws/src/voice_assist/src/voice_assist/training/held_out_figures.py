# SPDX-License-Identifier: BSD-3-Clause
"""Figures of the model card: python -m voice_assist.training.held_out_figures."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from typed_config import run_command
from voice_assist.errors import VoiceError
from voice_assist.evaluation.exact_bounds import share_interval
from voice_assist.recognizer.checkpoint import find_checkpoint, read_checkpoint
from voice_assist.recognizer.embedded import restore
from voice_assist.training.data.corpus import Corpus
from voice_assist.training.data.human import load_sounds, load_speech, read_manifest
from voice_assist.training.data.noise import Surroundings
from voice_assist.training.data.synthesis import TrainingClip, plan_held_out, synthesise
from voice_assist.training.data.texts import COMMANDS
from voice_assist.training.fit.train_recognizer import REPOSITORY
from voice_assist.training.options import speech_option
from voice_assist.training.transcribe import TranscriptTally, in_noise, tally, transcripts
from voice_assist.types import RATE


def row(name: str, found: TranscriptTally) -> str:
    """One line of the card's table."""
    low, high = share_interval(found.right, found.n)
    share = f"{found.accuracy:.1%} ({low:.1%} to {high:.1%})"
    return f"| {name} | {found.n} | {share} | {found.taken} |"


def parse(description: str | None) -> argparse.Namespace:
    """Options of what is measured on the held-out voices: model, speech, cache and seed."""
    parser = argparse.ArgumentParser(description=description)
    add = parser.add_argument
    add("--model", default="embedded")
    add("--speech", type=speech_option, default=REPOSITORY.parent / "shared" / "speech")
    add("--cache", type=Path, default=REPOSITORY / ".cache" / "training")
    add("--seed", type=int, default=1)
    return parser.parse_args()


def main() -> None:
    """Run the command line; ends with 2 where what was asked cannot be done."""
    if status := run_command(_run, "held_out_figures", (VoiceError,), failed=2):
        sys.exit(status)


def _run() -> None:
    """Print a table of exact transcripts, synthetic voices and people apart."""
    options = parse(__doc__)
    model = restore(read_checkpoint(find_checkpoint(options.model))).eval()
    corpus = held_out_corpus(options.speech, options.cache, options.seed)

    def show(name: str, clips: list[TrainingClip], snr: float | None = None) -> None:
        written = transcripts(model, in_noise(clips, snr, corpus.around))
        print(row(name, tally(clips, written)), flush=True)

    commands = [clip for clip in corpus.held_out if clip.kind == "command"]
    print("| set | clips | written exactly (95 % interval) | wrongly a command |")
    print("|---|---|---|---|")
    for phrase in COMMANDS:
        show(f'synthetic "{phrase}", quiet', [c for c in commands if c.text == phrase])
    for engine in ("espeak", "flite", "festival"):
        show(f"{engine}, quiet", [c for c in commands if c.speaker.startswith(engine)])
    show("synthetic commands, quiet", commands)
    for snr in (20.0, 10.0, 6.0, 0.0):
        show(f"synthetic commands, {snr:.0f} dB", commands, snr)
    show("synthetic near misses", [c for c in corpus.held_out if c.kind != "command"])
    stops = [c for c in corpus.people if c.text == "stop"]
    words = [c for c in corpus.people if c.text != "stop"]
    show('human "stop" (dev)', stops)
    show("other human words (dev)", words)
    for snr in (10.0, 6.0, 0.0):
        show(f'human "stop", {snr:.0f} dB', stops, snr)
        show(f"every second other human word, {snr:.0f} dB", words[::2], snr)
    show("human talk (false_accept_dev)", corpus.talk)
    hours = sum(len(c.samples) for c in corpus.talk) / RATE / 3600
    print(f"human talk measured: {hours:.2f} h")


def held_out_corpus(speech: Path, cache: Path, seed: int) -> Corpus:
    """What is measured on, without anything to train on."""
    rows, recordings = read_manifest(speech), cache / "recordings"
    talkers = [clip.samples for clip in load_speech(rows, "dev", recordings)]
    return Corpus(
        train=[],
        around=Surroundings(load_sounds(rows, "noise"), [], talkers),
        held_out=synthesise(plan_held_out(seed), cache / "held_out"),
        people=load_speech(rows, "dev", recordings),
        talk=load_speech(rows, "false_accept_dev", recordings, longest=10.0),
    )


if __name__ == "__main__":
    main()
