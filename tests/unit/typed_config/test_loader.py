# SPDX-License-Identifier: BSD-3-Clause
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import pytest

from typed_config import (
    ConfigError,
    choice,
    flag,
    integer,
    items,
    load_config,
    load_yaml,
    number,
    text,
)


@dataclass(frozen=True, kw_only=True)
class Inner:
    RENAMED: ClassVar[Mapping[str, str]] = {"strength": "gain", "colour": ""}

    gain: float = number(0.0, 10.0, "1/s")


@dataclass(frozen=True, kw_only=True)
class Outer:
    inner: Inner
    trocar: tuple[float, float, float] = number(-2.0, 2.0, "m")
    weights: tuple[float, ...] = number(0.0, 1.0, "")
    count: int = integer(1, 8)
    name: str = text()
    solver: str = choice("newton", "damped")
    verbose: bool = flag()
    entries: tuple[Inner, ...] = items(1, 3)


def settings(**changes):
    good = {
        "inner": {"gain": 4},
        "trocar": [0.4, 0.0, 0.4],
        "weights": [0.5, 1],
        "count": 3,
        "name": "x",
        "solver": "newton",
        "verbose": False,
        "entries": [{"gain": 1.0}],
    }
    return {**good, **changes}


def test_good_settings_become_a_frozen_dataclass():
    config = load_config(Outer, settings())
    assert config.inner.gain == 4.0 and isinstance(config.inner.gain, float)
    assert config.trocar == (0.4, 0.0, 0.4) and config.entries == (Inner(gain=1.0),)
    with pytest.raises(AttributeError):
        config.count = 4


@pytest.mark.parametrize(
    ("changes", "key", "allowed"),
    [
        ({"inner": {"gain": -1}}, "outer.yaml: inner.gain", "0 to 10 1/s"),
        ({"inner": {"gain": float("nan")}}, "inner.gain", "0 to 10"),
        ({"inner": {"gain": True}}, "inner.gain", "0 to 10"),
        ({"inner": {"gain": "4 1/s"}}, "inner.gain", "0 to 10"),
        ({"inner": {}}, "inner.gain is missing", "0 to 10"),
        ({"inner": {"gain": 1, "gian": 1}}, "inner.gian", "did you mean gain?"),
        ({"inner": {"strength": 1}}, "inner.strength", "no such key; its name is now gain"),
        ({"entries": [{"strength": 1}]}, "entries[0].strength", "its name is now gain"),
        ({"entries": [{"colour": 1}]}, "entries[0].colour", "it is gone; leave it out"),
        ({"trocar": [0.1, 0.2]}, "trocar", "a list of 3"),
        ({"trocar": [0.1, 0.2, 400]}, "trocar[2]", "-2 to 2 m"),
        ({"count": 2.5}, "count", "whole number"),
        ({"count": 9}, "count", "1 to 8"),
        ({"name": "  "}, "name", "not empty"),
        ({"solver": "magic"}, "solver", "newton, damped"),
        ({"verbose": "yes"}, "verbose", "true or false"),
        ({"entries": []}, "entries", "1 to 3"),
        ({"entries": [{"gain": 99}]}, "entries[0].gain", "0 to 10"),
        ({"inner": None}, "inner", "a mapping"),
    ],
)
def test_a_wrong_value_is_refused_with_its_key_and_what_was_allowed(changes, key, allowed):
    with pytest.raises(ConfigError) as error:
        load_config(Outer, settings(**changes), "outer.yaml")
    assert key in str(error.value) and allowed in str(error.value)


def test_a_missing_file_is_refused_by_name(tmp_path):
    with pytest.raises(ConfigError, match=r"none\.yaml"):
        load_yaml(tmp_path / "none.yaml")
