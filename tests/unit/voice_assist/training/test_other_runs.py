# SPDX-License-Identifier: BSD-3-Clause
"""A run goes on with what the same run left, and with nothing else."""

from itertools import repeat
from types import SimpleNamespace

import pytest
import torch

from tests.unit.voice_assist.support.small_recognizer import (
    SMALL,
    spotter_material,
    tiny_checkpoint,
)
from voice_assist.errors import ModelError
from voice_assist.spotter.overlap import write_overlap
from voice_assist.training.fit import start, train_recognizer
from voice_assist.training.fit.export import export
from voice_assist.training.fit.train_recognizer import TrainingRun
from voice_assist.training.spotter import train_overlap


def options(tmp_path, *more, out="m.pt"):
    places = ["--cache", str(tmp_path), "--out", str(tmp_path / out)]
    return train_recognizer.parse([*places, "--steps", "1", *map(str, more)])


@pytest.fixture
def finished(tmp_path, monkeypatch):
    """A run that is over, with two measured points, whose first was the better one."""
    monkeypatch.setattr(start, "SMALL", SMALL)
    run = TrainingRun(options(tmp_path), None)
    run.progress.step, run.progress.best_step = 1, 1
    export(run._averaged(), run.folder / "step_00001.pt")
    (run.folder / "step_00002.pt").write_bytes(b"a worse one")
    run._save()
    return run


def test_a_finished_run_whose_output_is_missing_writes_its_best_point(finished, tmp_path):
    TrainingRun(options(tmp_path), None).train()
    best = (finished.folder / "step_00001.pt").read_bytes()
    assert (tmp_path / "m.pt").read_bytes() == best
    (tmp_path / "m.pt").write_bytes(b"of the user")
    TrainingRun(options(tmp_path), None).train()
    assert (tmp_path / "m.pt").read_bytes() == b"of the user"


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--rate", 3e-4), "rate 0.0015 (now 0.0003)"),
        (
            ("--from", "{}/run_m/step_00001.pt", "--lesson", "twins", "--seed", 2),
            "lesson mending (now twins), seed 1 (now 2)",
        ),
        (("--from", "{}/run_m/step_00001.pt"), "from nothing (now "),
        (("--speech", "{}"), "(now "),
    ],
)
def test_another_run_of_the_same_name_is_refused_before_its_corpus_is_made(
    finished, tmp_path, monkeypatch, refused, more, said
):
    monkeypatch.setattr(train_recognizer, "load_corpus", lambda *_: pytest.fail("corpus made"))
    (tmp_path / "manifest.csv").touch()
    more = [str(word).format(tmp_path) for word in more]
    places = ("--cache", str(tmp_path), "--out", str(tmp_path / "m.pt"))
    before = (finished.folder / "progress.pt").read_bytes()
    line = refused(train_recognizer, *places, *more)
    assert line.count("\n") == 1
    assert line.startswith(f"train_recognizer: {finished.folder} holds a run with ")
    assert said in line
    assert (finished.folder / "progress.pt").read_bytes() == before
    with pytest.raises(ModelError):
        TrainingRun(options(tmp_path, *more), None)


def test_other_steps_another_machine_and_another_folder_go_on(finished, tmp_path):
    more = ("--steps", 9, "--workers", 3, "--threads", 1, "--measure-every", 7)
    run = TrainingRun(options(tmp_path, *more, out="other/m.pt"), None)
    assert run.progress.step == 1


def test_a_run_that_replaces_what_it_began_from_goes_on(finished, tmp_path):
    more = ("--from", tmp_path / "own.pt")
    for point in ("step_00001.pt", "step_00003.pt"):
        export(finished._averaged(), finished.folder / point)
        (tmp_path / "own.pt").write_bytes((finished.folder / point).read_bytes())
        TrainingRun(options(tmp_path, *more, out="own.pt"), None)._save()
        finished.average.weights["ctc.bias"] += 1.0


def test_progress_of_an_earlier_version_is_refused(finished, tmp_path):
    path = finished.folder / "progress.pt"
    state = torch.load(path, weights_only=True)
    del state["asked"]
    torch.save(state, path)
    with pytest.raises(ModelError, match="options that it does not say"):
        TrainingRun(options(tmp_path), None)


@pytest.fixture
def steps_of(tmp_path, monkeypatch):
    """Trains the spotter over talk for two steps at most; gives how many it took."""
    monkeypatch.setattr(train_overlap, "_SAVE_EVERY", 1)
    monkeypatch.setattr(train_overlap, "ahead", lambda *_: repeat(None))
    monkeypatch.setattr(train_overlap, "loss_of", lambda network, _: network.head[0].bias.sum())
    taken = []
    monkeypatch.setattr(train_overlap, "average", lambda *given: taken.append(given))

    def run(more=(), recogniser="a" * 64, pitch=1000):
        monkeypatch.setattr(train_overlap, "read_checkpoint", lambda _: tiny_checkpoint(recogniser))
        words = ("--cache", tmp_path, "--steps", 2, "--batch", 2, *more)
        taken.clear()
        train_overlap.train(spotter_material(pitch), train_overlap.parse(list(map(str, words))))
        return len(taken)

    return run


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"recogniser": "b" * 64}, "encoder aaaaaaaaaaaa (now bbbbbbbbbbbb)"),
        ({"pitch": 900}, "material "),
        ({"more": ("--rate", 3e-4)}, "rate 0.0001 (now 0.0003)"),
        ({"more": ("--head-rate", 3e-4)}, "head_rate 0.001 (now 0.0003)"),
        ({"more": ("--steps", 1)}, "steps 2 (now 1)"),
    ],
)
def test_another_run_of_the_spotter_over_talk_is_refused_and_overwrites_nothing(
    steps_of, tmp_path, other, said
):
    assert steps_of() == 2
    kept = {path.name: path.read_bytes() for path in (tmp_path / "run_overlap").iterdir()}
    assert kept.keys() == {"progress.pt", "step_00001.pt", "step_00002.pt"}
    with pytest.raises(ModelError) as refused:
        steps_of(**other)
    assert str(refused.value).startswith(f"{tmp_path / 'run_overlap'} holds a run with ")
    assert said in str(refused.value)
    assert kept == {path.name: path.read_bytes() for path in (tmp_path / "run_overlap").iterdir()}
    assert steps_of() == 0  # the same run is over


def test_the_spotter_over_talk_from_another_file_is_another_run(steps_of, tmp_path, monkeypatch):
    earlier = tmp_path / "earlier.pt"
    network = train_overlap.untrained(tiny_checkpoint("a" * 64))
    monkeypatch.setattr(train_overlap, "read_overlap", lambda *_: (network, ""))
    write_overlap(network, "a" * 64, earlier)
    more = ("--from", earlier)
    assert steps_of() == 2
    with pytest.raises(ModelError, match="from nothing"):
        steps_of(more)
    more = (*more, "--out", tmp_path / "further.pt")
    assert [steps_of(more), steps_of(more)] == [2, 0]


def test_a_second_start_with_another_checkpoint_does_not_get_the_firsts_word_times(finished):
    """The first one had not come to its first measurement."""
    places = ("--from", finished.folder / "step_00001.pt")
    TrainingRun(options(finished.folder, *places), None)
    with pytest.raises(ModelError, match=r"from \w+ \(now nothing\)"):
        TrainingRun(options(finished.folder), None)


def of_three(first, done=0):
    """Pools of three batches, as `Batches.pools` gives them."""
    for number in range(3 * first + done, 99):
        yield number // 3, number


def test_the_batches_after_a_break_are_those_that_would_have_come(tmp_path, monkeypatch):
    monkeypatch.setattr(start, "SMALL", SMALL)
    monkeypatch.setattr(TrainingRun, "_measure", TrainingRun._save)

    def trained(name, breaks_at):
        def step(self, batch):
            if self.progress.step in breaks_at:
                breaks_at.remove(self.progress.step)
                raise KeyboardInterrupt
            seen[self.progress.step] = batch
            return 0.0, 0.0

        monkeypatch.setattr(TrainingRun, "_step", step)
        seen, more = {}, ("--steps", 11, "--measure-every", 2)
        while len(seen) < 11:
            run = TrainingRun(options(tmp_path, *more, out=f"{name}.pt"), None)
            try:
                for until in (5, 11):  # two stages
                    if run.progress.step < until:
                        run._stage(SimpleNamespace(pools=of_three), until)
            except KeyboardInterrupt:
                pass
        return seen

    whole = trained("whole", [])
    assert list(whole.values()) == [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11]
    assert trained("broken", [1, 5, 7, 10]) == whole
