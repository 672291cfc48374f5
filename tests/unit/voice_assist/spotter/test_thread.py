# SPDX-License-Identifier: BSD-3-Clause
import threading

import pytest

from support.waiting import PATIENCE
from tests.unit.voice_assist.support.fake_speech import quiet_frame
from voice_assist.side_inputs import SideInputKind, ignore
from voice_assist.spotter.spotter import Spotted
from voice_assist.spotter.thread import SpotterThread


class Scripted:
    """Gives the next of its results for each frame, once it is let go."""

    def __init__(self, *script):
        self.script, self.heard = list(script), []
        self.go, self.done = threading.Event(), threading.Event()

    def __call__(self, frame):
        assert self.go.wait(PATIENCE)
        self.heard.append(frame.first_sample)
        result = self.script.pop(0) if self.script else None
        if not self.script:
            self.done.set()
        if isinstance(result, Exception):
            raise result
        return result

    def best(self, since, until):
        self.shown_until = until
        return 1.0

    def reset(self):
        raise AssertionError("the stream of a thread is its own")


@pytest.fixture
def start():
    threads = []

    def begin(spotter, capacity=4, patience=0.0, observer=ignore):
        spotted, failed = [], []
        callbacks = spotted.append, failed.append
        thread = SpotterThread(spotter, capacity, *callbacks, patience, observer)
        thread.start()
        threads.append((thread, spotter))
        return thread, spotted, failed

    yield begin
    for thread, spotter in threads:
        spotter.go.set()
        thread.close()


def test_what_is_spotted_is_reported_at_once_and_to_the_pipeline_once(start):
    spotter = Scripted(None, Spotted(1.0, 9.0))
    thread, spotted, failed = start(spotter)
    spotter.go.set()
    thread.feed(quiet_frame(0))
    thread.feed(quiet_frame(512))
    thread.reset()  # by the pipeline: it cannot reset the stream of the thread
    thread.close()
    assert spotted == [Spotted(1.0, 9.0)]
    assert thread(quiet_frame(512)) == Spotted(1.0, 9.0, is_sent=True)
    assert thread(quiet_frame(1024)) is None
    assert failed == []


def test_a_full_queue_drops_the_oldest_and_counts_them(start):
    spotter = Scripted(*[None] * 4)
    thread, _, _ = start(spotter, capacity=3)
    for number in range(10):  # the thread may have taken one of them already
        thread.feed(quiet_frame(number * 512))
    assert thread.dropped in (6, 7)
    spotter.go.set()
    thread.close()
    assert spotter.heard[-1] == 9 * 512


def test_a_failure_is_reported_and_the_recogniser_is_alone(start):
    spotter = Scripted(ValueError("bad sound"))
    thread, _, failed = start(spotter)
    assert thread.best(0.0) == 1.0
    spotter.go.set()
    thread.feed(quiet_frame())
    thread.close()
    assert [str(error) for error in failed] == ["bad sound"]
    thread.feed(quiet_frame(512))
    assert thread(quiet_frame(512)) is None
    assert thread.best(0.0) is None


def test_the_pipeline_waits_for_the_thread_to_hear_the_frame(start):
    spotter = Scripted(Spotted(1.0, 9.0))
    noted = []
    thread, _, _ = start(spotter, patience=PATIENCE, observer=noted.append)
    threading.Timer(0.05, spotter.go.set).start()
    thread.feed(quiet_frame(0))
    assert thread(quiet_frame(0)) == Spotted(1.0, 9.0, is_sent=True)
    assert noted == []


def test_what_the_thread_heard_ahead_of_the_pipeline_stays_hidden(start):
    spotter = Scripted(None, Spotted(1.0, 9.0))
    thread, _, _ = start(spotter, patience=PATIENCE)
    spotter.go.set()
    thread.feed(quiet_frame(0))
    thread.feed(quiet_frame(512))
    assert spotter.done.wait(PATIENCE)
    assert thread(quiet_frame(0)) is None
    thread.best(0.0)
    assert spotter.shown_until == 512
    assert thread(quiet_frame(512)) == Spotted(1.0, 9.0, is_sent=True)


def test_a_late_thread_is_noted_frame_by_frame_and_not_waited_for_again(start):
    noted = []
    thread, _, _ = start(Scripted(), patience=0.01, observer=noted.append)
    for first in (0, 512):
        thread.feed(quiet_frame(first))
        assert thread(quiet_frame(first)) is None
    late = [(SideInputKind.SPOTTER_LATE, sample, 0) for sample in (0, 512)]
    assert [(n.kind, n.sample, n.heard_until) for n in noted] == late


def test_a_late_thread_does_not_keep_the_recogniser_from_deciding(start):
    spotter = Scripted(None, None)
    thread, _, _ = start(spotter, patience=0.01)
    thread.feed(quiet_frame(0))
    thread(quiet_frame(0))
    assert thread.best(0.0) is None  # nobody listens in time
    spotter.go.set()
    thread.feed(quiet_frame(512))
    assert spotter.done.wait(PATIENCE)
    while thread.best(0.0) is None:  # the thread has yet to say that it has heard the frame
        thread(quiet_frame(512))
    assert thread.best(0.0) == 1.0


def test_dropped_frames_and_a_failure_are_noted(start):
    noted = []
    spotter = Scripted(ValueError("bad sound"))
    thread, _, _ = start(spotter, capacity=1, observer=noted.append)
    for number in range(3):  # the thread may have taken one of them already
        thread.feed(quiet_frame(number * 512))
    spotter.go.set()
    thread.close()
    thread(quiet_frame(1024))
    thread(quiet_frame(1536))
    kinds = [n.kind for n in noted]
    assert SideInputKind.SPOTTER_DROPPED in kinds and SideInputKind.SPOTTER_LATE not in kinds
    assert kinds.count(SideInputKind.SPOTTER_FAILED) == 1
