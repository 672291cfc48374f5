# SPDX-License-Identifier: BSD-3-Clause
"""What hangs is distinguished from what gets no processor."""

import os
import re
import subprocess
import sys
import threading
import time

import pytest

from support.waiting import wait_until
from voice_assist.pipeline.hang_detection import HangWatch, stolen, waits

ALLOWED = 0.3  # [s]
TICK = 0.05  # [s] between checks


class Machine:
    """Threads that wait for a processor by a share of the time."""

    def __init__(self, **shares):
        self.now, self.shares = 100.0, shares
        self.stolen = {"cpu0": 0.0, "cpu1": 0.0}  # shares of the time

    def read(self):
        return {name: share * self.now for name, share in self.shares.items()}

    def read_stolen(self):
        return {name: share * self.now for name, share in self.stolen.items()}

    def objection_after(self, seconds):
        watch, since = HangWatch(ALLOWED, self.read, self.read_stolen), self.now
        words = ""
        for _ in range(round(seconds / TICK)):
            words = words or watch.objection(since, self.now)
            self.now += TICK
        return words or watch.objection(since, self.now)


def test_what_stands_still_on_a_free_machine_hangs_once_the_time_is_over():
    assert Machine(hear=0.0, heartbeat=0.01).objection_after(0.95 * ALLOWED) == ""
    words = Machine(hear=0.0, heartbeat=0.01).objection_after(ALLOWED + 2 * TICK)
    assert re.fullmatch(r"recognition hangs: 0\.3\d s on one frame, allowed 0\.3 s", words)


@pytest.mark.parametrize("who", ["hear", "holder_of_the_lock"])
def test_what_gets_a_tenth_of_a_processor_does_not_hang(who):
    shares = {"hear": 0.0, "heartbeat": 0.0, who: 0.9}
    assert Machine(**shares).objection_after(9 * ALLOWED) == ""


def test_what_hangs_on_a_busy_machine_is_found_too_only_later():
    shares = {"hear": 0.0, "heartbeat": 0.5}
    assert Machine(**shares).objection_after(1.5 * ALLOWED) == ""
    assert "hangs" in Machine(**shares).objection_after(2.5 * ALLOWED)


@pytest.mark.parametrize("processor", ["cpu0", "cpu1"])
def test_what_the_host_takes_from_a_processor_does_not_count(processor):
    machine = Machine(hear=0.3)
    machine.stolen[processor] = 0.4
    assert machine.objection_after(3 * ALLOWED) == ""
    assert "hangs" in machine.objection_after(4 * ALLOWED)


def test_where_the_kernel_counts_nothing_all_time_counts():
    assert "hangs" in Machine().objection_after(ALLOWED + 2 * TICK)


def test_work_that_goes_on_from_frame_to_frame_never_adds_up():
    watch, now = HangWatch(ALLOWED, dict, dict), 0.0
    for _ in range(100):
        since, now = now, now + 0.8 * ALLOWED
        assert watch.objection(since, since) == watch.objection(since, now) == ""
        assert watch.objection(None, now) == ""


def test_waits_are_read_only_for_work_that_is_seen_twice():
    reads = []
    watch = HangWatch(ALLOWED, lambda: reads.append(1) or {}, dict)
    for now in range(100):
        assert watch.used(float(now), now + 0.001) == 0.0
    assert not reads
    assert watch.used(99.0, 99.011) == 0.0
    assert watch.used(99.0, 99.021) == pytest.approx(0.01)
    assert len(reads) == 1


def test_a_thread_that_is_new_brings_no_wait_of_its_life_along():
    times = iter([{"hear": 1.0}, {"hear": 1.0, "new": 50.0}])
    watch = HangWatch(ALLOWED, lambda: next(times), dict)
    for _ in range(2):  # read once the work is seen again
        watch.objection(5.0, 5.0)
    assert "hangs" in watch.objection(5.0, 6.0)


def test_a_missing_or_damaged_record_is_passed_over(tmp_path):
    for name, text in (("1", "5 2000000000 3"), ("2", ""), ("3", "x y z")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "schedstat").write_text(text)
    (tmp_path / "4").mkdir()
    assert waits(tmp_path) == {"1": 2.0}
    assert waits(tmp_path / "none") == {}


BURN = "import time\nend = time.monotonic() + 600\nwhile time.monotonic() < end: pass"
WORK = 0.3  # [s] of a processor
SHARES = 6  # processes that want the same processor as this one


@pytest.fixture
def busy():
    """Other processes that burn the one processor that this one may use."""
    if not waits():
        pytest.skip("this kernel counts no waits (/proc/self/task/*/schedstat)")
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(allowed)})
    burners = [subprocess.Popen((sys.executable, "-c", BURN)) for _ in range(SHARES)]
    yield
    for burner in burners:
        burner.kill()
        burner.wait()
    os.sched_setaffinity(0, allowed)


def test_on_a_machine_that_others_keep_busy_little_of_the_time_counts(busy):
    def work():
        end = time.thread_time() + WORK
        while time.thread_time() < end:
            pass

    watch, since, used = HangWatch(0.0), time.monotonic(), [0.0]
    thread = threading.Thread(target=work)
    thread.start()
    while thread.is_alive():
        used.append(watch.used(since, time.monotonic()))
        time.sleep(TICK)
    assert max(used) < 0.75 * (time.monotonic() - since)  # a seventh of the processor was its own


def test_on_that_machine_a_thread_that_hangs_is_found_in_the_end(busy):
    over = threading.Event()
    thread = threading.Thread(target=over.wait, daemon=True)
    thread.start()
    watch, since = HangWatch(ALLOWED), time.monotonic()
    words = wait_until(lambda: watch.objection(since, time.monotonic()), every=TICK)
    over.set()
    thread.join()
    assert "hangs" in words


def test_only_single_processors_are_read_and_damage_is_passed_over(tmp_path):
    file = tmp_path / "stat"
    line = "1 2 3 4 5 6 7 {} 0 0"
    file.write_text(
        f"cpu {line.format(700)}\ncpu0 {line.format(200)}\ncpu1 {line.format(500)}\nintr 5\n"
    )
    tick = 1.0 / os.sysconf("SC_CLK_TCK")
    assert stolen(file) == {"cpu0": pytest.approx(200 * tick), "cpu1": pytest.approx(500 * tick)}
    file.write_text("cpu0 1 2\n")
    assert stolen(file) == stolen(tmp_path / "none") == {}


def test_this_machine_counts_each_processor():
    assert len(stolen()) == os.cpu_count()
