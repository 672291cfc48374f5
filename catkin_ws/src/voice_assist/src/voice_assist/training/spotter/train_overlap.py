# SPDX-License-Identifier: BSD-3-Clause
"""Train the spotter that hears over talk: python -m voice_assist.training.spotter.train_overlap."""

from __future__ import annotations

import argparse
import logging
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits

from typed_config import check_writable, count_option, number_option, run_command
from voice_assist.errors import VoiceError
from voice_assist.recognizer.checkpoint import EMBEDDED_PATH, read_checkpoint
from voice_assist.recognizer.hybrid import encode_short
from voice_assist.recognizer.mel import log_mel
from voice_assist.recognizer.safe_weights import write_weights
from voice_assist.spotter.overlap import (
    PATH,
    TRAINED,
    OverlapNetwork,
    read_overlap,
    untrained,
    write_overlap,
)
from voice_assist.training.ahead import ahead
from voice_assist.training.cache_key import digest
from voice_assist.training.data.kokoro import plan_words, spoken
from voice_assist.training.fit.checkpoints import check_same_run, kept_share
from voice_assist.training.fit.train_recognizer import REPOSITORY, progress_file
from voice_assist.training.options import device_option, speech_option
from voice_assist.training.precision import cheap_numbers
from voice_assist.training.spotter.dataset import LOG, SpotterAmounts, load_material, training_rows
from voice_assist.training.spotter.overlap_mixture import Batch, OverlapMaterial, arrange, draw
from voice_assist.training.spotter.streams import WORD

AMOUNTS = SpotterAmounts(synthetic=240, near=420, recorded=5)
_SHARE_OF_FRAMES = 0.3  # of the loss
_PLAIN = 0.4  # of the steps have the full rate; then it falls in a line
_SAVE_EVERY = 50  # steps


def parse(arguments: list[str] | None = None) -> argparse.Namespace:
    """Options of a run; the defaults are those of `make train`."""
    parser = argparse.ArgumentParser(description=__doc__)
    add, rate = parser.add_argument, number_option(0.0)
    add("--check", action="store_true", help="only find out whether all it needs is there")
    add("--speech", type=speech_option, default=REPOSITORY.parent / "shared" / "speech")
    add("--cache", type=Path, default=REPOSITORY / ".cache" / "training" / "overlap")
    add("--packages", type=Path, default=REPOSITORY / ".cache" / "training" / "openai")
    add("--recogniser", type=Path, default=EMBEDDED_PATH, help="whose encoder it takes")
    add("--out", type=Path, default=PATH)
    add("--from", dest="start", type=Path, help="file of an earlier run to train further")
    add("--seed", type=int, default=1)
    add("--steps", type=count_option, default=4000)
    add("--batch", type=count_option, default=24, help="windows of a step")
    add("--head-rate", type=rate, default=1e-3, help="peak learning rate of the head")
    add("--rate", type=rate, default=1e-4, help="peak learning rate of the encoder's last blocks")
    add("--threads", type=count_option, default=1)
    add("--workers", type=count_option, default=1, help="processes that mix windows")
    help_ = "that the network is trained on, such as cuda"
    add("--device", type=device_option, default="cpu", help=help_)
    return parser.parse_args(arguments)


def load_overlap_material(speech: Path, cache: Path, packages: Path, seed: int) -> OverlapMaterial:
    """People, synthetic voices and surroundings; spoken once, and kept in the cache.

    Raises:
        ManifestError: The manifest cannot be read.
        ModelError: Too few people are in it, or an engine or a package of synthesis is missing.
    """
    material = load_material(speech, cache, seed, AMOUNTS)
    kokoro = spoken(plan_words(), packages, cache / "kokoro")
    said = [clip for clip in kokoro if clip.text == WORD]
    near = [clip for clip in kokoro if clip.text != WORD]
    # Kokoro's clips count twice, since its voices are the most like people.
    synthetic = [*material.synthetic, *said, *said]
    return arrange(
        material.stops, synthetic, material.words, [*material.near, *near, *near], material.around
    )


def freeze(network: OverlapNetwork) -> None:
    """Keep what is the recogniser's as it is."""
    own = network.own_state().keys()
    for name, weight in network.named_parameters():
        weight.requires_grad = name in own


def loss_of(network: OverlapNetwork, batch: Batch) -> Tensor:
    """Cross entropy of the windows, and some of their frames."""
    device = next(network.parameters()).device
    parts = (batch.sound, batch.is_word, batch.frames)
    sound, is_word, frames = (torch.from_numpy(part).to(device) for part in parts)
    with cheap_numbers(device.type):
        odds, there = network.judge(encode_short(network.encoder, log_mel(sound)))
    said = binary_cross_entropy_with_logits(odds.float(), is_word)
    where = binary_cross_entropy_with_logits(there.float(), frames)
    return said + _SHARE_OF_FRAMES * where


def train(material: OverlapMaterial, options: argparse.Namespace) -> tuple[OverlapNetwork, str]:
    """Run all steps.

    Returns:
        The running mean of the network, and the digest of the recogniser it began from.

    Raises:
        ModelError: A checkpoint cannot be read, or another run has the name of this one.
    """
    torch.manual_seed(options.seed)
    checkpoint = read_checkpoint(options.recogniser)
    progress = progress_file(options)
    asked = _asked(checkpoint.sha256, material, options)
    check_same_run(progress, asked)
    progress.parent.mkdir(parents=True, exist_ok=True)
    network = (
        read_overlap(options.start, options.recogniser)[0].train()
        if options.start
        else untrained(checkpoint)
    ).to(options.device)
    mean = untrained(checkpoint).to(options.device)
    mean.load_state_dict(network.state_dict())
    freeze(network)
    blocks = [w for w in network.encoder.parameters() if w.requires_grad]
    groups = [
        {"params": blocks, "lr": options.rate, "peak": options.rate},
        {"params": network.head.parameters(), "lr": options.head_rate, "peak": options.head_rate},
    ]
    optimiser = torch.optim.AdamW(groups, weight_decay=0.01)
    done = _resume(progress, network, mean, optimiser)
    began, sum_ = time.monotonic(), 0.0
    batches = ahead(lambda step: _batch(material, options, step), done + 1, options.workers)
    for step in range(done + 1, options.steps + 1):
        left = (options.steps - step + 1) / options.steps
        for group in optimiser.param_groups:
            group["lr"] = group["peak"] * min(1.0, step / 50, left / (1.0 - _PLAIN))
        loss = loss_of(network, next(batches))
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_([w for w in network.parameters() if w.requires_grad], 1.0)
        optimiser.step()
        average(mean, network, step)
        sum_ += loss.item()
        if step % 50 == 0:
            LOG.info("step %d: %.4f, %.0f s", step, sum_ / 50, time.monotonic() - began)
            sum_ = 0.0
        if step % _SAVE_EVERY == 0:
            _save(progress, step, network, mean, optimiser, asked)
            write_overlap(mean, checkpoint.sha256, progress.parent / f"step_{step:05d}.pt")
    return mean, checkpoint.sha256


def _batch(material: OverlapMaterial, options: argparse.Namespace, step: int) -> Batch:
    """The windows of a step, the same after a break."""
    return draw(material, options.batch, np.random.default_rng([options.seed, step]))


def average(mean: OverlapNetwork, network: OverlapNetwork, step: int) -> None:
    """Move the running mean of the trained weights on; faster in the first steps."""
    keep = kept_share(step)
    newest, held = network.own_state(), mean.own_state()
    for name, weight in held.items():
        weight.mul_(keep).add_(newest[name].detach(), alpha=1.0 - keep)


def _asked(
    encoder: str, material: OverlapMaterial, options: argparse.Namespace
) -> dict[str, object]:
    """All that the weights depend on, for the progress file."""
    start = digest(options.start.read_bytes())[:12] if options.start else "nothing"
    names = ("seed", "steps", "batch", "rate", "head_rate")
    made_of = {"encoder": encoder[:12], "from": start, "material": digest(material)[:12]}
    return {**made_of, **{name: getattr(options, name) for name in names}}


def _save(
    path: Path,
    step: int,
    network: OverlapNetwork,
    mean: OverlapNetwork,
    optimiser: torch.optim.Optimizer,
    asked: Mapping[str, object],
) -> None:
    """Write all that going on needs; a crash leaves the old file."""
    own = {"network": network.own_state(), "mean": mean.own_state(), "asked": dict(asked)}
    write_weights({"step": step, "optimiser": optimiser.state_dict(), **own}, path)


def _resume(
    path: Path,
    network: OverlapNetwork,
    mean: OverlapNetwork,
    optimiser: torch.optim.Optimizer,
) -> int:
    """Go on where the run was broken off; gives the steps that are done."""
    if not path.exists():
        return 0
    state = torch.load(path, map_location="cpu", weights_only=True)
    network.load_state_dict(state["network"], strict=False)
    mean.load_state_dict(state["mean"], strict=False)
    optimiser.load_state_dict(state["optimiser"])
    done: int = state["step"]
    return done


def main() -> None:
    """Run the command line; ends with 2 where what was asked cannot be done."""
    if status := run_command(lambda: _run(parse()), "train_overlap", (VoiceError,), failed=2):
        sys.exit(status)


def _run(options: argparse.Namespace) -> None:
    """Gather the material, train, write the file."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(message)s")
    read_checkpoint(options.recogniser)
    if options.start:
        read_overlap(options.start, options.recogniser)
    check_writable(options.out)
    training_rows(options.speech, AMOUNTS)
    if options.check:
        return
    torch.set_num_threads(options.threads)
    material = load_overlap_material(options.speech, options.cache, options.packages, options.seed)
    counts = (material.human, material.synthetic, material.others, material.near, material.talk)
    LOG.info("said, synthetic, others, near, talk: %s; blocks %d", [*map(len, counts)], TRAINED)
    network, encoder = train(material, options)
    write_overlap(network, encoder, options.out)
    LOG.info("%s", options.out)


if __name__ == "__main__":
    main()
