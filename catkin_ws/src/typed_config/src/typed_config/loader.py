# SPDX-License-Identifier: BSD-3-Clause
"""Builds a settings dataclass from a mapping; whatever is wrong is named with what was allowed."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, TypeVar, cast, get_args, get_origin, get_type_hints

from typed_config.errors import ConfigError, Missing, join
from typed_config.fields import RULE, Rule
from typed_config.strict_yaml import load_yaml

T = TypeVar("T")
MISSING = Missing()


def load_config(kind: type[T], data: object, where: str = "") -> T:
    """Build the dataclass `kind` from a mapping.

    A key that is a word of Python has an underscore behind it in the dataclass: `from_`. What a
    dataclass finds wrong in its `__post_init__` is named from `where` on too. A dataclass may map
    former keys to their present names: `RENAMED: ClassVar[Mapping[str, str]]`. A former key is
    refused, and the error names the present one, or says that it is gone where that is "".

    Args:
        kind: Frozen dataclass whose fields were declared with `typed_config.fields`.
        data: Mapping from key to value, as YAML or the ROS parameter server gives it.
        where: Prefix of the key in errors, such as the file's name.

    Raises:
        ConfigError: A key is unknown, missing, or its value is not allowed.
    """
    if not isinstance(data, Mapping):
        raise ConfigError(where or kind.__name__, data, "a mapping of keys to values")
    fields = _fields(cast("Hashable", kind))
    for key in data:
        if key not in fields:
            hint = _hint(kind, str(key), fields)
            raise ConfigError(join(where, str(key)), data[key], f"no such key; {hint}")
    values = {}
    for key, field in fields.items():
        if field.may_be_left_out and key not in data:
            continue
        found = data.get(key, MISSING)
        values[field.name] = _value(field.hint, field.rule, found, join(where, key))
    try:
        return kind(**values)
    except ConfigError as error:
        raise error.under(where) from error


def load_file(kind: type[T], path: Path) -> T:
    """Build the dataclass `kind` from a YAML file.

    Raises:
        ConfigError: The file or a key is not as it must be; names both.
    """
    return load_config(kind, load_yaml(path), path.name)


def with_present_keys(kind: type[Any], data: Mapping[str, Any]) -> dict[str, Any]:
    """The same settings with each former key under its present name, or without it if it is gone.

    In nested ones too.

    For settings that were recorded by an older version; `load_config` refuses a former key.

    Args:
        kind: Dataclass of the settings.
        data: Mapping as `load_config` takes it; what it does not know stays as it is.
    """
    fields, renamed = _fields(cast("Hashable", kind)), getattr(kind, "RENAMED", {})
    found = {}
    for former, value in data.items():
        key = renamed.get(former, former)
        if not key:
            continue
        hint = fields[key].hint if key in fields else None
        found[key] = _with_present_keys(hint, value)
    return found


def _with_present_keys(hint: Any, value: Any) -> Any:
    if dataclasses.is_dataclass(hint) and isinstance(value, Mapping):
        return with_present_keys(cast("type[Any]", hint), value)
    args = get_args(hint)
    if get_origin(hint) is tuple and isinstance(value, (list, tuple)):
        return [_with_present_keys(args[0], entry) for entry in value]
    return value


def _hint(kind: type[Any], key: str, fields: Mapping[str, _Field]) -> str:
    """What the user may have meant by an unknown key."""
    renamed: Mapping[str, str] = getattr(kind, "RENAMED", {})
    if key in renamed:
        present = renamed[key]
        return f"its name is now {present}" if present else "it is gone; leave it out"
    close = difflib.get_close_matches(key, fields, n=1)
    return f"did you mean {close[0]}?" if close else "one of " + ", ".join(fields)


@dataclass(frozen=True)
class _Field:
    """One key of a settings dataclass."""

    name: str
    hint: Any  # without the None of those that may be left out
    rule: Rule | None
    may_be_left_out: bool


@lru_cache(maxsize=256)
def _fields(kind: type[Any]) -> dict[str, _Field]:
    """Fields by key; to find them out takes longer than to load them."""
    hints = get_type_hints(kind)
    return {
        f.name.rstrip("_"): _Field(
            f.name,
            _without_none(hints[f.name]),
            f.metadata.get(RULE),
            f.default is not dataclasses.MISSING,
        )
        for f in dataclasses.fields(kind)
    }


def _without_none(hint: Any) -> Any:
    if get_origin(hint) is UnionType:
        (hint,) = (part for part in get_args(hint) if part is not NoneType)
    return hint


def _value(hint: Any, rule: Rule | None, value: object, key: str) -> object:
    if dataclasses.is_dataclass(hint):
        if isinstance(value, Missing):
            raise ConfigError(key, value, "a mapping of keys to values")
        return load_config(hint, value, key)  # type: ignore[arg-type]
    if rule is None:
        raise TypeError(f"{key}: declare the field with typed_config.fields")
    if get_origin(hint) is tuple:
        return _sequence(get_args(hint), rule, value, key)
    if get_origin(hint) is Mapping:
        return _named(get_args(hint)[1], rule, value, key)
    if not rule.accepts(value):
        raise ConfigError(key, value, rule.allowed)
    return rule.convert(value)


def _named(hint: Any, rule: Rule, value: object, key: str) -> dict[str, object]:
    """Values by names that the file chooses."""
    if not isinstance(value, Mapping):
        raise ConfigError(key, value, f"a mapping of names, each to {rule.allowed}")
    for name in value:
        if not isinstance(name, str):
            raise ConfigError(join(key, str(name)), value[name], "a word as name")
    return {name: _value(hint, rule, entry, join(key, name)) for name, entry in value.items()}


def _sequence(args: tuple[Any, ...], rule: Rule, value: object, key: str) -> tuple[object, ...]:
    if args and dataclasses.is_dataclass(args[0]):
        if not rule.accepts(value):
            raise ConfigError(key, value, rule.allowed)
        entries: Sequence[object] = value  # type: ignore[assignment]
        kind = cast("type[Any]", args[0])
        return tuple(load_config(kind, v, f"{key}[{i}]") for i, v in enumerate(entries))
    size = None if args[-1] is Ellipsis else len(args)
    count = "a list" if size is None else f"a list of {size}"
    if not isinstance(value, (list, tuple)) or (size is not None and len(value) != size):
        raise ConfigError(key, value, f"{count}, each {rule.allowed}")
    for i, entry in enumerate(value):
        if not rule.accepts(entry):
            raise ConfigError(f"{key}[{i}]", entry, rule.allowed)
    return tuple(rule.convert(entry) for entry in value)
