# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rst_control.admission import callers
from rst_control.admission.callers import CallLimiter, family
from rst_control.config import load_motion_config
from rst_control.config.callers import CallersConfig
from typed_config import ConfigError, load_config
from typed_config.node_names import MAX_NAME, UNNAMED, caller_name, is_allowed

VOICE = "/voice_assist"


def config(allowed=(), rate=20.0, burst=50):
    return CallersConfig(allowed=allowed, rate=rate, burst=burst)


class Clocked:
    """A limiter whose time goes on by hand."""

    def __init__(self, settings=None):
        self.now = 100.0
        self.limiter = CallLimiter(settings or config(), lambda: self.now)

    def of(self, caller, count, is_stop=False):
        return [self.limiter.admit(caller, is_stop) for _ in range(count)]


@pytest.fixture
def calls():
    return Clocked()


def test_with_the_settings_as_they_come_anybody_may_call():
    calls = Clocked(load_motion_config().controller.callers)
    for caller in (VOICE, "/rosservice_4711_1700000000000", "/my_panel", UNNAMED):
        assert calls.limiter.admit(caller).refusal is None


@pytest.mark.parametrize(
    ("caller", "is_in"),
    [
        (VOICE, True),
        ("/rosservice_4711_1700000000000", True),
        ("/rosservice", False),
        ("/voice_assist2", False),
        ("/voice", False),
        ("voice_assist", False),
        ("/v\u043eice_assist", False),
        ("", False),
    ],
)
def test_the_list_names_callers_or_their_beginnings(caller, is_in):
    assert is_allowed(caller, (VOICE, "/rosservice_*")) is is_in


def test_a_caller_who_is_not_on_the_list_is_refused_with_the_list_and_may_still_stop():
    calls = Clocked(config(allowed=(VOICE, "/rosservice_*")))
    refusal = calls.limiter.admit("/stray_script").refusal.words
    assert "/stray_script" in refusal and VOICE in refusal and "/rosservice_*" in refusal
    assert calls.limiter.admit("/stray_script", is_stop=True).refusal is None
    assert calls.limiter.admit(VOICE).refusal is None


@pytest.mark.parametrize("pattern", ["voice_assist", "/a*b", "*", ""])
def test_a_pattern_that_can_fit_no_name_is_refused_with_what_is_allowed(pattern):
    with pytest.raises(ConfigError, match="allowed"):
        load_config(CallersConfig, {"allowed": [pattern], "rate": 20.0, "burst": 50}, "here")


def test_a_burst_is_taken_and_what_is_beyond_is_refused_with_the_limits_and_waits(calls):
    admissions = calls.of("/panel", 60)
    assert [a.refusal is None for a in admissions] == [True] * 50 + [False] * 10
    assert "20 per second after 50 at once" in admissions[-1].refusal.words
    assert all(a.pause == callers.PAUSE for a in admissions[50:])
    assert all(a.pause == 0.0 for a in admissions[:50])
    calls.now += 1.0
    assert sum(a.refusal is None for a in calls.of("/panel", 60)) == 20


def test_a_stop_is_never_refused_however_many_come(calls):
    assert all(a.refusal is None for a in calls.of("/panel", 2000, is_stop=True))


def test_one_caller_who_floods_takes_nothing_from_another(calls):
    calls.of("/flood", 2000)
    assert calls.limiter.admit(VOICE).refusal is None


def test_nodes_started_anew_for_each_call_are_one_caller(calls):
    names = [f"/rosservice_{n}_{n * 1000}" for n in range(60)]
    assert sum(calls.limiter.admit(name).refusal is None for name in names) == 50
    assert family("/rosservice_12_345") == family("/rosservice_9_8") != family("/rosservice_x")


def test_callers_without_end_are_not_remembered_without_end_and_known_ones_keep_their_budget(calls):
    calls.limiter.admit(VOICE)
    taken = 0
    for n in range(1000):
        taken += calls.limiter.admit(f"/stray{n}").refusal is None
        assert calls.limiter.counted <= callers.MAX_CALLERS
    assert taken <= callers.MAX_CALLERS + 50
    assert calls.limiter.admit(VOICE).refusal is None
    calls.now += 60.0
    calls.of("/newcomer", 1)
    assert calls.limiter.counted <= callers.MAX_CALLERS
    assert sum(a.refusal is None for a in calls.of("/newcomer", 60)) == 49


def test_a_flood_of_refusals_is_news_once_a_second():
    calls = Clocked(config(allowed=(VOICE,)))
    assert [a.is_news for a in calls.of("/stray", 5)] == [True] + [False] * 4
    calls.now += callers.NEWS_PERIOD
    assert calls.limiter.admit("/stray").is_news
    assert not calls.limiter.admit(VOICE).is_news


def test_a_clock_that_goes_back_gives_nothing_away(calls):
    calls.of("/panel", 50)
    calls.now -= 1000.0
    assert calls.limiter.admit("/panel").refusal.words


@given(st.one_of(st.none(), st.integers(), st.binary(max_size=9), st.text(max_size=150)))
def test_any_name_is_short_and_printable(claimed):
    name = caller_name(claimed)
    assert 0 < len(name) <= MAX_NAME and name.isprintable()


@given(
    st.lists(
        st.tuples(st.sampled_from(["/a", "/b", "/c_1_2", "/c_3_4"]), st.floats(0.0, 2.0)),
        max_size=40,
    )
)
def test_no_caller_ever_gets_more_than_burst_and_rate_allow(sent):
    calls = Clocked(replace(config(), rate=2.0, burst=3))
    begin, taken = calls.now, {}
    for caller, pause in sent:
        calls.now += pause
        name = family(caller)
        taken[name] = taken.get(name, 0) + (calls.limiter.admit(caller).refusal is None)
        assert taken[name] <= 3 + 2.0 * (calls.now - begin) + 1e-6
