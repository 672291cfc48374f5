# SPDX-License-Identifier: BSD-3-Clause
"""Builds a settings dataclass from a mapping; whatever is wrong is named with what was allowed."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast, get_args, get_origin, get_type_hints

import yaml

from typed_config.fields import RULE, Rule

T = TypeVar("T")


class ConfigError(ValueError):
    """A settings key is unknown, missing or holds what it may not."""

    def __init__(self, key: str, value: object, allowed: str) -> None:
        super().__init__(f"{key} is {_shown(value)}, allowed: {allowed}")
        self.key, self.value, self.allowed = key, value, allowed


class _Missing:
    def __repr__(self) -> str:
        return "missing"


def load_yaml(path: str | Path) -> Mapping[str, Any]:
    """Read one YAML file that holds a mapping.

    Raises:
        ConfigError: The file cannot be read, is not YAML or holds something else.
    """
    try:
        data = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(str(path), error.strerror, "a readable file") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ConfigError(str(path), " ".join(str(error).split()), "valid YAML in UTF-8") from error
    if not isinstance(data, dict):
        raise ConfigError(str(path), data, "a mapping of keys to values")
    return data


def load_config(kind: type[T], data: object, where: str = "") -> T:
    """Build the dataclass `kind` from a mapping.

    Args:
        kind: Frozen dataclass whose fields were declared with `typed_config.fields`.
        data: Mapping from key to value, as YAML or the ROS parameter server gives it.
        where: Prefix of the key in errors, such as the file's name.

    Raises:
        ConfigError: A key is unknown, missing, or its value is not allowed.
    """
    if not isinstance(data, Mapping):
        raise ConfigError(where or kind.__name__, data, "a mapping of keys to values")
    fields = {f.name: f for f in dataclasses.fields(kind)}  # type: ignore[arg-type]
    for key in data:
        if key not in fields:
            close = difflib.get_close_matches(str(key), fields, n=1)
            hint = f"did you mean {close[0]}?" if close else "one of " + ", ".join(fields)
            raise ConfigError(_join(where, str(key)), data[key], f"no such key; {hint}")
    hints = get_type_hints(kind)
    values = {}
    for name, field in fields.items():
        if name not in data and field.default is not dataclasses.MISSING:
            continue
        values[name] = _value(hints[name], field, data.get(name, _Missing()), _join(where, name))
    return kind(**values)


def _value(hint: Any, field: dataclasses.Field[Any], value: object, key: str) -> object:
    rule: Rule | None = field.metadata.get(RULE)
    if dataclasses.is_dataclass(hint):
        if isinstance(value, _Missing):
            raise ConfigError(key, value, "a mapping of keys to values")
        return load_config(hint, value, key)  # type: ignore[arg-type]
    if rule is None:
        raise TypeError(f"{key}: declare the field with typed_config.fields")
    if get_origin(hint) is tuple:
        return _sequence(get_args(hint), rule, value, key)
    if not rule.accepts(value):
        raise ConfigError(key, value, rule.allowed)
    return rule.convert(value)


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


def _join(where: str, key: str) -> str:
    return f"{where}: {key}" if where.endswith((".yaml", ".yml")) else f"{where}.{key}".lstrip(".")


def _shown(value: object) -> str:
    words = repr(value)
    return words if len(words) <= 80 else words[:77] + "..."
