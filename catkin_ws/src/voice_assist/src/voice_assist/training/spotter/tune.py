# SPDX-License-Identifier: BSD-3-Clause
"""Choose the thresholds of spotter.yaml: python -m voice_assist.training.spotter.tune.

Streams clips through the real pipeline once, keeps what recogniser and spotter believed of them,
and compares thresholds on that. Run it again whenever either model changes.
"""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import torch

from typed_config import ConfigError, count_option, number_option, run_command
from voice_assist.assembly import make_recognizer
from voice_assist.config import SpotterConfig, load_voice_config
from voice_assist.errors import ModelError, VoiceError
from voice_assist.evaluation.evaluator import read_noises
from voice_assist.training.data.human import load_speech, read_manifest, speech_rows
from voice_assist.training.data.synthesis import plan_held_out, synthesise
from voice_assist.training.data.texts import normalise_text
from voice_assist.training.fit.train_recognizer import REPOSITORY
from voice_assist.training.options import speech_option
from voice_assist.training.spotter import rule
from voice_assist.training.spotter.streams import WORD
from voice_assist.training.spotter.trials import LOG, SpotterTrial, TrialRunner, as_float
from voice_assist.types import Samples

_RATES = (0.3, 0.5, 1.0, 2.0, 5.0, 10.0)  # [per h] of the printed curve
_HELD_OUT_SEED = 1  # of the recogniser's training, whose held-out voices these are
_WEIGHTS = {"human": 3.0, "synthetic": 2.0, "10 dB": 1.0, "0 dB": 1.0}
Sets = dict[str, list[SpotterTrial]]


def main() -> None:
    """Run the command line; ends with 2 where what was asked cannot be done."""
    refusals = VoiceError, ConfigError
    if status := run_command(lambda: _run(_parse()), "tune", refusals, failed=2):
        sys.exit(status)


def _run(options: argparse.Namespace) -> None:
    """Print the curves and the thresholds that fit best."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(message)s")
    check_people(options.speech)
    config = load_voice_config(recognizer__model=options.model)
    recognizer = make_recognizer(config)
    torch.set_num_threads(1)
    trials = TrialRunner(config, recognizer, options.cache, options.floor)
    said = _synthetic(trials, options)
    human, talk = _people(trials, options)
    said |= human
    chosen = rule.choose(
        config.spotter, said, {n: w for n, w in _WEIGHTS.items() if n in said}, talk,
        options.alone_rate, options.rate,
    )  # fmt: skip
    _print_curve(config.spotter, said, talk)
    ways = {
        "recogniser alone": rule.recogniser_alone(config.spotter),
        "spotter alone": rule.spotter_alone(config.spotter, chosen.alone),
        "both, as configured": config.spotter,
        "both, as chosen": chosen,
    }
    for name, way in ways.items():
        _print_way(name, way, said, talk)
    print("\nfor config/spotter.yaml:")
    for key in ("alone", "middle", "near", "agree", "sure"):
        print(f"  {key}: {getattr(chosen, key):.2f}")


def check_people(speech: Path) -> None:
    """Find out before long work whether there are people to choose thresholds by.

    Raises:
        ManifestError: The manifest cannot be read.
        ModelError: Nobody says the word, or nobody anything else.
    """
    rows = read_manifest(speech)
    said = [normalise_text(row.transcript) for row in speech_rows(rows, "dev")]
    talk = [normalise_text(row.transcript) for row in speech_rows(rows, "false_accept_dev")]
    words = said.count(WORD)
    others = len(said) - words + sum(WORD not in text.split() for text in talk)
    if not (words and others):
        held = f"{words} recordings of {WORD!r} in split dev, {others} of other speech in"
        needed = "thresholds need at least 1 of each"
        raise ModelError(f"{speech}: {held} dev and false_accept_dev; {needed}")


def _people(trials: TrialRunner, options: argparse.Namespace) -> tuple[Sets, list[SpotterTrial]]:
    rows = read_manifest(options.speech)
    recordings = options.cache / "recordings"
    words = load_speech(rows, "dev", recordings)
    talk = load_speech(rows, "false_accept_dev", recordings)
    said = [(c.speaker, as_float(c.samples)) for c in words if c.text == WORD]
    others = [(c.text, as_float(c.samples)) for c in words if c.text != WORD]
    spoken = [(c.text, as_float(c.samples)) for c in talk if WORD not in c.text.split()]
    LOG.info("%d of the word, %d other words, %d of talk", len(said), len(others), len(spoken))
    thin = options.thin
    false = trials("words", others, thin=thin) + trials("talk", spoken, thin=thin)
    return {"human": trials("human", said)}, false


def _synthetic(trials: TrialRunner, options: argparse.Namespace) -> Sets:
    prompts = [p for p in plan_held_out(_HELD_OUT_SEED) if p.text == WORD]
    clips = synthesise(prompts, options.cache / "held_out", workers=1)
    said = [(c.speaker, as_float(c.samples)) for c in clips]
    found = {"synthetic": trials("synthetic", said)}
    if options.noise is not None:
        noises: list[Samples] = read_noises(options.noise)
        found |= {f"{snr} dB": trials(f"at_{snr}_dB", said, noises, snr) for snr in (10, 0)}
    return found


def _print_curve(
    config: SpotterConfig, said: Mapping[str, Sequence[SpotterTrial]], talk: Sequence[SpotterTrial]
) -> None:
    print("\nspotter alone, by false stops per hour of people who do not say the word:")
    for rate, threshold in rule.thresholds(talk, _RATES).items():
        way = rule.spotter_alone(config, threshold)
        found = ", ".join(f"{name} {rule.fired(t, way).share:.1%}" for name, t in said.items())
        print(f"  {rate:4.1f}/h from {threshold:6.2f}: {found}")


def _print_way(
    name: str,
    way: SpotterConfig,
    said: Mapping[str, Sequence[SpotterTrial]],
    talk: Sequence[SpotterTrial],
) -> None:
    false, hours = rule.false_stops(talk, way), rule.hours(talk)
    print(
        f"\n{name}: {false:.0f} false stops in {hours:.2f} h of people, {false / hours:.2f} per h"
    )
    for trial in talk:
        if (time := rule.fired_at(trial, way)) is not None:
            print(f"    {trial.name[:40]!r} at {time:.2f} s, counts {trial.weight:.0f}")
    for kind, trials in said.items():
        late = rule.latencies(trials, way)
        times = ""
        if late:
            p50, p99 = (1e3 * float(np.percentile(late, q)) for q in (50, 99))
            times = f"; p50 {p50:.0f} ms, p99 {p99:.0f} ms after the word, less computing"
        print(f"  {kind}: {rule.fired(trials, way)}{times}")


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    add = parser.add_argument
    add("--speech", type=speech_option, default=REPOSITORY.parent / "shared" / "speech")
    add("--cache", type=Path, default=REPOSITORY / ".cache" / "spotter" / "tune")
    add("--model", default="embedded", help="recogniser, as in recognizer.yaml")
    add("--noise", type=Path, help="folder of noise for the sets at 10 and 0 dB")
    help_ = "see TrialRunner: share of what the spotter ignores"
    add("--thin", type=count_option, default=8, help=help_)
    add("--floor", type=float, default=-2.0, help="score below which the spotter ignores a clip")
    rate = number_option(0.0)
    help_ = "false stops per hour of the spotter alone"
    add("--alone-rate", type=rate, default=0.3, help=help_)
    add("--rate", type=rate, default=0.5, help="false stops per hour of both together")
    return parser.parse_args()


if __name__ == "__main__":
    main()
