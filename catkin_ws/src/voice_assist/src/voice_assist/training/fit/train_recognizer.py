# SPDX-License-Identifier: BSD-3-Clause
"""Train the embedded recogniser: python -m voice_assist.training.fit.train_recognizer.

With --from and a file of an earlier run, its checkpoint is trained further.
"""

from __future__ import annotations

import argparse
import json
import logging
import shutil
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import torch
from torch import nn
from whisper.model import disable_sdpa

from typed_config import (
    check_writable,
    count_option,
    number_option,
    replacing,
    repository,
    run_command,
)
from voice_assist.errors import ModelError, VoiceError
from voice_assist.recognizer.checkpoint import find_checkpoint, read_checkpoint
from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.training.data.align import align_clips
from voice_assist.training.data.batches import Batch, Batches
from voice_assist.training.data.corpus import Corpus, load_corpus
from voice_assist.training.data.mixture import RARE, Aligned, Mixture
from voice_assist.training.data.synthesis import SynthesisAmounts, TrainingClip
from voice_assist.training.fit.checkpoints import (
    Average,
    check_same_run,
    load_progress,
    save_progress,
)
from voice_assist.training.fit.curriculum import LESSONS, stage_of
from voice_assist.training.fit.export import export
from voice_assist.training.fit.objective import joint_loss
from voice_assist.training.fit.start import SMALL, start_anew, start_from
from voice_assist.training.options import device_option, speech_option
from voice_assist.training.validation import ValidationFigures, measure

REPOSITORY = repository("voice_assist") or Path.cwd()
MORE = {  # clips that a lesson asks for beyond the usual ones
    "twins": {"twin": 8000},
    "voices": {"twin": 8000},
    "beginnings": {"twin": 8000, "beginning": 4000},
    "amounts": {"twin": 8000, "beginning": 4000, "amount": 4000},
}
WITH_KOKORO = ("voices", "beginnings", "amounts")  # lessons that Kokoro's voices take part in
# Options that make it another run; --steps may grow, and the rest is where and how fast it runs.
_OF_A_RUN = ("lesson", "held", "share", "seed", "batch", "rate", "decay")
LOG = logging.getLogger("fit")


@dataclass(frozen=True)
class Schedule:
    """Learning rate by step."""

    steps: int  # of the whole run
    peak: float = 1.5e-3
    warm_up: int = 300  # steps
    decay: float = 0.35  # share of the steps spent on the way down

    def rate(self, step: int) -> float:
        """Learning rate of a step, never quite zero."""
        rising = min((step + 1) / self.warm_up, 1.0)
        left = (self.steps - step) / max(self.decay * self.steps, 1)
        return self.peak * min(rising, max(left, 0.01), 1.0)


class TrainingRun:
    """One training run: model, optimiser and where it stands."""

    def __init__(self, options: argparse.Namespace, corpus: Corpus) -> None:
        """Build the model, or restore it where the run was broken off."""
        torch.manual_seed(options.seed)
        self.options, self.corpus, self.asked = options, corpus, asked_of_a_run(options)
        start = start_from(options.start, options.lesson) if options.start else start_anew()
        self.model, self.stages = start.model.to(options.device), start.stages
        hold_lower(self.model, options.held)
        self.schedule = Schedule(options.steps, options.rate, decay=options.decay)
        self.optimiser = torch.optim.AdamW(
            [weight for weight in self.model.parameters() if weight.requires_grad],
            betas=(0.9, 0.98),
            weight_decay=0.02,
            fused=True,
        )
        self.average = Average(self.model)
        path = progress_file(options)
        self.folder = path.parent
        self.folder.mkdir(parents=True, exist_ok=True)
        check_same_run(path, self.asked)
        self.progress = load_progress(path, self.model, self.optimiser, self.average)
        self.measured = WhisperCtc(self.model.dims).eval()
        if not path.exists():
            self._save()  # else another run could go on with the word times of this one

    def train(self) -> None:
        """Step until the schedule ends, measuring and saving on the way."""
        if self.progress.step >= self.options.steps:
            LOG.info("already trained; to begin anew, remove %s", self.folder)
        while self.progress.step < self.options.steps:
            number, stage = stage_of(self.progress.step, self.stages)
            LOG.info("stage %d from step %d", number, self.progress.step)
            corpus = self.corpus
            aligned = self._word_times(number) if stage.needs_word_times else []
            mixture = Mixture(corpus.train, aligned, stage.weights, stage.longest)
            batches = Batches(
                mixture,
                corpus.around,
                stage.how,
                self.options.seed,
                stage.seconds * self.options.batch,
                self.options.workers,
            )
            self._stage(batches, min(stage.until, self.options.steps))
        if not self.options.out.exists():
            self._write_best()

    def _write_best(self) -> None:
        """Make the output of a run that is over; it was removed, or is wanted elsewhere."""
        if not self.progress.best_step:
            self._measure()
            return
        with replacing(self.options.out, ".tmp") as temporary:
            shutil.copyfile(self._point(self.progress.best_step), temporary)

    def _point(self, step: int) -> Path:
        """File of a measured point."""
        return self.folder / f"step_{step:05d}.pt"

    def _stage(self, batches: Batches, until: int) -> None:
        """Train until a step; a stage starts a pool of its own."""
        progress, began, losses = self.progress, time.monotonic(), []
        for pool, batch in batches.pools(progress.pool, progress.batch):
            losses.append(self._step(batch))
            progress.step += 1
            is_over = progress.step >= until
            done = progress.batch + 1 if pool == progress.pool else 1
            progress.pool, progress.batch = (pool + 1, 0) if is_over else (pool, done)
            if progress.step % 50 == 0:
                progress.seconds += time.monotonic() - began
                began = time.monotonic()
                self._note(losses)
                losses = []
            is_last = progress.step == self.options.steps
            if is_last or progress.step % self.options.measure_every == 0:
                self._measure()
            if is_over:
                break
        self._save()

    def _step(self, batch: Batch) -> tuple[float, float]:
        for group in self.optimiser.param_groups:
            group["lr"] = self.schedule.rate(self.progress.step)
        loss = joint_loss(self.model, batch.to(self.options.device))
        loss.total.backward()
        torch.nn.utils.clip_grad_norm_(self.model.parameters(), 1.0)
        self.optimiser.step()
        self.optimiser.zero_grad(set_to_none=True)
        self.average.update(self.model, self.progress.step)
        return loss.ctc, loss.decoder

    def _note(self, losses: list[tuple[float, float]]) -> None:
        ctc, decoder = (sum(part) / len(losses) for part in zip(*losses, strict=True))
        progress = self.progress
        rate = self.schedule.rate(progress.step)
        at = (progress.step, progress.seconds)
        LOG.info("step %d, %.0f s: ctc %.3f, decoder %.3f, rate %.1e", *at, ctc, decoder, rate)

    def _averaged(self) -> WhisperCtc:
        self.measured.load_state_dict(self.average.weights)
        return self.measured

    def _measure(self) -> None:
        """Log figures, keep the checkpoint; it becomes the output where it is the best so far."""
        figures: ValidationFigures = measure(self._averaged(), self.corpus, thin=3)
        at = {"step": self.progress.step, "seconds": round(self.progress.seconds)}
        line: dict[str, object] = {**at, **figures.flat()}
        LOG.info("measured %s", json.dumps(line))
        with (self.folder / "figures.jsonl").open("a") as file:
            file.write(json.dumps(line) + "\n")
        export(self.measured, self._point(self.progress.step))
        if figures.score > self.progress.best:
            self.progress.best, self.progress.best_step = figures.score, self.progress.step
            export(self.measured, self.options.out)
        self._save()

    def _save(self) -> None:
        save_progress(
            self.folder / "progress.pt",
            self.model,
            self.optimiser,
            self.average,
            self.progress,
            self.asked,
        )

    def _word_times(self, stage: int) -> list[Aligned]:
        """Clips with the times of their words, found as the stage begins."""
        path = self.folder / f"word_times_{stage}.npz"
        aligned = align_clips(self._averaged(), _to_align(self.corpus.train), path)
        LOG.info("%d clips aligned", len(aligned))
        return aligned


def progress_file(options: argparse.Namespace) -> Path:
    """Where a run keeps how far it has come; its folder is named after the output."""
    cache: Path = options.cache
    return cache / f"run_{options.out.stem}" / "progress.pt"


def asked_of_a_run(options: argparse.Namespace) -> dict[str, object]:
    """The options by which a run is known again, and the digest of what it starts from.

    Raises:
        ModelError: The checkpoint to start from is missing or damaged, or has fewer blocks than
            are to be held.
    """
    start, blocks = "nothing", SMALL.n_audio_layer
    if options.start:
        path = find_checkpoint(options.start)
        checkpoint = read_checkpoint(path)
        blocks = checkpoint.dims.n_audio_layer
        found = checkpoint.sha256[:12]  # the run itself replaces its output
        start = "its own output" if path.resolve() == options.out.resolve() else found
    if not 0 <= options.held <= blocks:
        raise ModelError(f"--held {options.held}, allowed: 0 to {blocks} blocks of the encoder")
    speech = str(options.speech.resolve())
    return {"from": start, "speech": speech, **{n: getattr(options, n) for n in _OF_A_RUN}}


def hold_lower(model: WhisperCtc, blocks: int) -> None:
    """Keep the encoder as it is up to a block, and with it the networks that are built on it.

    Args:
        model: To be trained.
        blocks: Held ones, from the input on; 0 holds nothing.
    """
    for part in lower_parts(model, blocks) if blocks else ():
        part.requires_grad_(False)


def lower_parts(model: WhisperCtc, blocks: int) -> tuple[nn.Module, ...]:
    """The encoder up to a block."""
    encoder = model.whisper.encoder
    return encoder.conv1, encoder.conv2, *encoder.blocks[:blocks]


def _to_align(clips: list[TrainingClip]) -> list[TrainingClip]:
    """Sentences with wanted words, a third of the others, and some synthesis."""
    sentences = [clip for clip in clips if clip.kind == "sentence"]
    wanted = [clip for clip in sentences if set(RARE) & set(clip.text.split())]
    others = [clip for clip in sentences if not set(RARE) & set(clip.text.split())]
    synthetic = [clip for clip in clips if clip.kind in ("command", "variant", "near")]
    return wanted + others[::3] + synthetic[::10]


def parse(arguments: list[str] | None = None) -> argparse.Namespace:
    """Options of a run; the Makefile has those of the runs behind the shipped checkpoint."""
    parser = argparse.ArgumentParser(description=__doc__)
    add = parser.add_argument
    add("--speech", type=speech_option, default=REPOSITORY.parent / "shared" / "speech")
    add("--cache", type=Path, default=REPOSITORY / ".cache" / "training")
    add("--out", type=Path, required=True, help="checkpoint to write; its name is that of the run")
    add("--from", dest="start", help="checkpoint to continue, or Whisper model such as base.en")
    help_ = f"with which --from continues a run; default: {LESSONS[0]}"
    add("--lesson", choices=LESSONS, help=help_)
    add("--held", type=int, default=0, help="blocks of the encoder that stay as they are")
    add("--packages", type=Path, default=REPOSITORY / ".cache" / "training" / "openai")
    share = number_option(0.001)
    add("--share", type=share, default=1.0, help="of the synthetic corpus that is spoken")
    add("--seed", type=int, default=1)
    add("--steps", type=count_option, default=4000)
    add("--batch", type=share, default=1.0, help="times the sound of the lesson in a batch")
    add("--rate", type=number_option(0.0), default=1.5e-3, help="peak learning rate")
    decay = number_option(0.0, 1.0)
    add("--decay", type=decay, default=0.5, help="share of steps on the way down")
    add("--measure-every", type=count_option, default=400, help="steps")
    add("--threads", type=count_option, default=2)
    add("--workers", type=count_option, default=1, help="processes that make batches")
    help_ = "that the network is trained on, such as cuda"
    add("--device", type=device_option, default="cpu", help=help_)
    options = parser.parse_args(arguments)
    if options.lesson and not options.start:
        parser.error(f"--lesson {options.lesson} without --from, allowed: the two together")
    options.lesson = options.lesson or LESSONS[0]
    return options


def main() -> None:
    """Run the command line; ends with 2 where what was asked cannot be done."""
    if status := run_command(lambda: _run(parse()), "train_recognizer", (VoiceError,), failed=2):
        sys.exit(status)


def _run(options: argparse.Namespace) -> None:
    """Train, say how long it took, and leave the checkpoint in place."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(message)s")
    check_same_run(progress_file(options), asked_of_a_run(options))
    check_writable(options.out)
    torch.set_num_threads(options.threads)
    said = SynthesisAmounts(**MORE.get(options.lesson, {})).part(options.share)
    packages = options.packages if options.lesson in WITH_KOKORO else None
    where = (options.speech, options.cache, options.seed)
    corpus = load_corpus(*where, said, options.threads, packages)
    LOG.info("%d training clips", len(corpus.train))
    run = TrainingRun(options, corpus)
    with disable_sdpa():  # its backward pass is slow on processors
        run.train()
    LOG.info("trained %.0f s; %s", run.progress.seconds, options.out)


if __name__ == "__main__":
    main()
