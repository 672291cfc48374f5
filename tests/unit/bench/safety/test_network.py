# SPDX-License-Identifier: BSD-3-Clause
"""The judge of bad networks on traces made by hand; the relay and what is missing, without root."""

from dataclasses import replace

import numpy as np
import pytest

from bench.common.part import MEASURED
from bench.safety.network import hosts, suite
from bench.safety.network.judge import NetworkTrial, figures, judge, rest
from bench.safety.network.relay import LinkConditions, RelayDirection, RelayLink, from_line, to_line
from bench.safety.stops.judge import SetpointCourse

PERIOD = 0.002
FAULT = 1.0  # [s]
END = 5.0  # [s]


def course(brakes=FAULT + 0.14, brake_time=0.045, resumes=END, joint=3, end=END):
    """One joint that cruises, slows down evenly from a time on and rests, and may move again."""
    stamps = np.arange(0.0, end, PERIOD)
    speed = 0.1 * np.clip(1.0 - (stamps - brakes) / brake_time, 0.0, 1.0)
    speed = np.where(speed > 1e-9, speed, 0.0) + np.where(stamps > resumes, 0.1, 0.0)
    velocities = np.zeros((len(stamps), 10))
    velocities[:, joint] = speed
    return SetpointCourse(stamps, np.cumsum(velocities, axis=0) * PERIOD, velocities)


def trial(**changes):
    seen = changes.pop("seen", course())
    fields = {
        "fault": "link cut",
        "moment": FAULT,
        "since": "fault",
        "setpoints": seen,
        "measured": seen,
        "halted": True,
        "reason": "voice_silent",
        "rearmed": 1.5,
        "moved": 1.8,
    }
    return NetworkTrial(**{**fields, **changes})


def test_a_robot_that_rests_in_time_and_comes_back_is_as_it_should_be():
    verdict = judge(trial())
    assert verdict.objections == ()
    assert verdict.held == pytest.approx(0.185, abs=2 * PERIOD)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"brakes": FAULT + 0.5}, "moved for 546 ms, allowed 200 ms"),
        ({"brakes": END + 1}, "moved for inf ms"),  # it never rests
        ({"resumes": FAULT + 3.2}, "moved for"),  # it goes on when the network is good again
    ],
)
def test_a_robot_that_moves_on_for_longer_than_allowed_is_named_with_both_numbers(changes, words):
    assert any(words in o for o in judge(trial(seen=course(**changes))).objections)


@pytest.mark.parametrize(("brakes", "is_well"), [(0.150, True), (0.160, False)])
def test_the_limit_is_that_of_the_rest_not_of_the_beginning_of_braking(brakes, is_well):
    assert (judge(trial(seen=course(brakes=FAULT + brakes))).objections == ()) is is_well


def test_a_set_point_that_jumps_without_a_velocity_is_seen():
    jumped = course()
    jumped.positions[jumped.stamps > FAULT + 2.0] += 1e-3
    assert judge(trial(seen=jumped)).objections == ("moved again, by 0.001 rad at once",)


def test_a_pause_between_two_phases_is_no_rest():
    stamps = np.arange(0.0, 1.0, PERIOD)
    speeds = np.where((stamps < 0.3) | ((stamps > 0.5) & (stamps < 0.7)), 1.0, 0.0)
    assert rest(stamps, speeds, 0.1, 0.1) == pytest.approx(0.6, abs=PERIOD)


def test_what_rested_before_was_held_at_once():
    verdict = judge(trial(seen=course(brakes=0.5)))
    assert verdict.held is None and verdict.objections == ()


def test_opening_jaws_count_apart_from_the_tool():
    opening = course(brakes=FAULT + 0.14, brake_time=0.3, joint=8)
    opening.velocities[:, 9] = opening.velocities[:, 8]
    verdict = judge(trial(seen=opening))
    assert verdict.held is None and verdict.objections == ()
    assert verdict.jaws == pytest.approx(0.44, abs=2 * PERIOD)


def test_a_wrist_that_turns_counts_as_the_tool():
    turning = course(brakes=FAULT + 0.5, joint=8)
    turning.velocities[:, 9] = -turning.velocities[:, 8]
    assert judge(trial(seen=turning)).held == pytest.approx(0.545, abs=2 * PERIOD)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"halted": False}, "not halted"),
        ({"reason": "joint_states_stale"}, "halted for another reason: joint_states_stale"),
        ({"seen": course(end=FAULT + 0.3)}, "not watched long enough after it"),
        ({"rearmed": None, "moved": None}, '"hey robot" was never accepted again'),
        ({"moved": None}, "no command was carried out any more"),
        ({"moved": 12.0}, "back after 12.0 s, allowed 10 s"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_each_other_way_to_fail_is_named(changes, words):
    assert judge(trial(**changes)).objections == (words,)


def test_a_command_that_sets_off_long_after_it_was_said_is_missed():
    late = course(brakes=0.0, resumes=FAULT + 3.1)
    asked = {"since": "command said", "halted": False, "reason": ""}
    assert judge(trial(seen=late, **asked)).objections == ("set off 3.1 s after it was said",)
    soon = course(brakes=0.0, resumes=FAULT + 0.4)
    assert judge(trial(seen=soon, **asked)).objections == ()
    never = course(brakes=0.0)
    assert judge(trial(seen=never, **asked)).objections == ()


def test_each_fault_has_its_own_figures_and_what_was_missed_in_it():
    slow = trial(fault="20 % loss", seen=course(brakes=FAULT + 0.5), moved=2.5)
    found = {figure.name: figure for figure in figures([trial(), trial(), slow], 1, "")}
    good, bad = "two hosts, link cut: ", "two hosts, 20 % loss: "
    assert found[good + "trials"].value == 2 and found[bad + "trials"].value == 1
    assert found[good + "not as it should be"].is_met
    assert found[bad + "not as it should be"].is_met is False
    assert "allowed 200 ms" in found[bad + "not as it should be"].note
    assert found[bad + "to rest, set-points, max"].is_met is False
    assert found[bad + "good network to the next motion, max"].value == 2.5
    assert found["two hosts: trials made anew"].value == 1


def carried(way, packets, now=0.0, until=10.0):
    for packet in packets:
        way.take(packet, now)
    return way.due(until)


PACKETS = [bytes([n % 256, n // 256]) for n in range(2000)]


def test_a_good_link_carries_all_in_order_and_at_once():
    assert carried(RelayDirection(1), PACKETS, until=0.0) == PACKETS


def test_a_link_that_is_cut_carries_nothing_not_even_what_was_on_its_way():
    way = RelayDirection(1)
    way.conditions = LinkConditions(delay=0.5)
    way.take(b"before", 0.0)
    way.conditions = LinkConditions(loss=1.0)
    assert carried(way, PACKETS) == []


def test_loss_is_about_as_much_as_asked_for_and_the_same_for_the_same_seed():
    counts = []
    for seed in (1, 1, 2):
        way = RelayDirection(seed)
        way.conditions = LinkConditions(loss=0.2)
        counts.append(carried(way, PACKETS))
    assert 0.17 < 1 - len(counts[0]) / len(PACKETS) < 0.23
    assert counts[0] == counts[1] != counts[2]


def test_a_delayed_packet_comes_when_it_is_due_and_no_sooner():
    way = RelayDirection(1)
    way.conditions = LinkConditions(delay=0.5)
    way.take(b"late", 1.0)
    assert way.due(1.499) == [] and way.next_due == pytest.approx(1.5)
    assert way.due(1.5) == [b"late"] and way.next_due == float("inf")


def test_conditions_reach_the_relay_as_they_are():
    link = RelayLink(LinkConditions(0.2, 0.5), LinkConditions(1.0))
    assert from_line(to_line(link)) == link
    assert from_line(to_line(replace(link, to_voice=LinkConditions()))) != link


@pytest.mark.parametrize("lacking", ["iproute2", "root"])
def test_what_is_missing_is_said_and_nothing_is_measured(monkeypatch, capsys, lacking):
    if lacking == "iproute2":
        monkeypatch.setattr(hosts.shutil, "which", lambda _: None)
    else:
        monkeypatch.setattr(hosts.shutil, "which", lambda _: "ip")
        monkeypatch.setattr(hosts.os, "geteuid", lambda: 1000)
    monkeypatch.setattr(suite, "Hosts", None)  # making them would raise
    rests, skipped = suite.measure()
    assert lacking in skipped.note and skipped.is_met is None
    assert (rests.name, rests.value, rests.target) == (MEASURED, 0.0, suite.FULL)
    assert "not measured" in capsys.readouterr().out
