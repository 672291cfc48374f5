# SPDX-License-Identifier: BSD-3-Clause
from collections import Counter
from dataclasses import replace
from random import Random

import pytest

from paper.play.plan import (
    COMMANDS,
    HEY_ROBOT,
    MOTIONS,
    PULL_LESS,
    PULL_MORE,
    RELEASE,
    STOP,
    TENSE,
    TERMINATE,
    PhrasePlan,
    RobotDialogue,
    TensionRange,
    allowed,
)

LIMITS = TensionRange(minimum=0.1, maximum=2.0, step=0.25)
TALK = ("pull over", "we release him tomorrow", "a tense moment")
STANDBY = RobotDialogue(False, False, False, False)


def plan(repetitions=30, share=0.125, seed="1"):
    return PhrasePlan(repetitions, share, TALK, LIMITS, seed)


EFFECTS = {  # what a command changes, as the table of commands says
    HEY_ROBOT: lambda now: {"is_listening": True, "is_active": True, "is_halted": False},
    TENSE: lambda now: {"is_held": True, "tension": 1.0},
    RELEASE: lambda now: {"is_held": False, "tension": 0.0},
    PULL_MORE: lambda now: {"tension": now.tension + LIMITS.step},
    PULL_LESS: lambda now: {"tension": now.tension - LIMITS.step},
    STOP: lambda now: {"is_halted": True},
    TERMINATE: lambda now: {"is_listening": False, "is_active": False},
}


class Robot:
    """Does what the table of commands says; misses some words, refuses some motions."""

    def __init__(self, misses=0.0, refuses=0.0, seed=1, deaf_to=()):
        self.now, self.rng = STANDBY, Random(seed)
        self.misses, self.refuses, self.deaf_to = misses, refuses, deaf_to
        self.broken = []  # commands that the table does not allow

    def hear(self, planned, in_motion=False):
        """Returns whether a motion began."""
        if not planned.command:
            return False
        if not (in_motion and planned.command == STOP) and planned.command not in allowed(
            self.now, LIMITS
        ):
            self.broken.append((planned, self.now))
        missed = self.rng.random() < self.misses or planned.command in self.deaf_to
        if planned.is_counted and missed:
            return False
        is_motion = planned.command in MOTIONS
        if is_motion and self.rng.random() < self.refuses:
            return False
        self.now = replace(self.now, **EFFECTS[planned.command](self.now))
        return is_motion


def talk_through(plan, robot):
    """Say all that the plan wants; returns every phrase said."""
    said = []
    while planned := plan.next(robot.now):
        said.append(planned)
        if robot.hear(planned) and planned.stop_at:
            said.append(plan.interrupt())
            robot.hear(said[-1], in_motion=True)
    return said


def counted(said):
    return Counter(p.command for p in said if p.is_counted and p.command)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("repetitions", [1, 3, 30])
def test_every_command_gets_its_repetitions_where_it_is_allowed(repetitions, seed):
    robot = Robot()
    said = talk_through(plan(repetitions, seed=str(seed)), robot)
    assert robot.broken == []
    assert counted(said) == dict.fromkeys(COMMANDS, repetitions)


@pytest.mark.parametrize("seed", range(20))
def test_few_phrases_are_said_more_often_than_asked_for(seed):
    said = [p for p in talk_through(plan(30, seed=str(seed)), Robot()) if p.command]
    assert len(said) <= 1.25 * 30 * len(COMMANDS)


@pytest.mark.parametrize("seed", range(20))
def test_the_plan_recovers_from_missed_words_and_refused_motions(seed):
    robot = Robot(misses=0.15, refuses=0.15, seed=seed)
    said = talk_through(plan(30, seed=str(seed)), robot)
    assert robot.broken == []
    assert counted(said) == dict.fromkeys(COMMANDS, 30)


@pytest.mark.parametrize("seed", range(5))
def test_what_is_missed_and_said_again_counts_no_more_often_than_what_is_heard(seed):
    said = talk_through(plan(30, seed=str(seed)), Robot(misses=0.3, seed=seed))
    assert counted(said) == dict.fromkeys(COMMANDS, 30)
    assert any(p.command == TENSE and not p.is_counted for p in said)


def test_stops_are_said_in_motions():
    said = talk_through(plan(), Robot())
    stops = [i for i, p in enumerate(said) if p.command == STOP]
    assert len(stops) >= 30
    assert all(said[i - 1].command in MOTIONS and said[i - 1].stop_at for i in stops)
    assert len({said[i - 1].command for i in stops}) == len(MOTIONS)


def test_one_in_eight_phrases_is_no_command_and_each_is_said_before_any_is_said_again():
    said = talk_through(plan(share=0.125), Robot())
    talk = [p.words for p in said if not p.command]
    assert len(talk) == 30
    assert Counter(talk) == dict.fromkeys(TALK, 10)
    assert {*talk[:3]} == {*TALK}


def test_without_talk_only_commands_are_said():
    assert all(p.command for p in talk_through(plan(3, share=0.0), Robot()))


def test_same_seed_same_order_other_seed_other_order():
    orders = [[p.words for p in talk_through(plan(seed=seed), Robot())] for seed in ("1", "1", "2")]
    assert orders[0] == orders[1] != orders[2]


@pytest.mark.parametrize("word", [HEY_ROBOT, TENSE, RELEASE])
def test_a_word_that_is_never_heard_is_said_by_the_prompter_and_not_counted(word):
    robot = Robot(deaf_to=(word,))
    said = talk_through(plan(10), robot)
    assert robot.broken == []
    assert any(p.command == word and not p.is_counted for p in said)
    assert counted(said) == dict.fromkeys(COMMANDS, 10)


def test_the_plan_gives_up_where_nothing_is_ever_heard():
    silent = plan(5, share=0.0)
    said = 0
    while silent.next(STANDBY):
        said += 1
    assert said == 4 * 5 * len(COMMANDS)


@pytest.mark.parametrize(
    ("situation", "commands"),
    [
        (STANDBY, {HEY_ROBOT}),
        (RobotDialogue(False, True, False, False), {HEY_ROBOT}),
        (RobotDialogue(True, False, False, False), {HEY_ROBOT}),
        (RobotDialogue(True, True, True, True, 1.0), {HEY_ROBOT, TERMINATE}),
        (RobotDialogue(False, False, True, True, 1.0), {HEY_ROBOT}),
        (RobotDialogue(True, True, False, False), {TENSE, TERMINATE}),
        (
            RobotDialogue(True, True, False, True, 1.0),
            {RELEASE, TERMINATE, PULL_MORE, PULL_LESS},
        ),
        (RobotDialogue(True, True, False, True, 2.0), {RELEASE, TERMINATE, PULL_LESS}),
        (RobotDialogue(True, True, False, True, 0.4), {RELEASE, TERMINATE, PULL_MORE}),
    ],
)
def test_what_is_allowed_follows_the_table_of_commands(situation, commands):
    assert set(allowed(situation, LIMITS)) == commands
