# SPDX-License-Identifier: BSD-3-Clause
"""Reads a settings file; what YAML would take silently for something else is refused by name."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from typed_config.errors import ConfigError, join

LARGEST = 1_000_000  # [B] of a settings file
DEEPEST = 50  # levels of a settings file
_NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")
_MERGE = "tag:yaml.org,2002:merge"
_ODD_NUMBER = re.compile(r".*:.*|[-+]?0[0-9_]+")  # 1:30 is 90 to YAML, and 010 is 8


def load_yaml(path: str | Path) -> Mapping[str, Any]:
    """Read one YAML file that holds a mapping.

    Refused are also: a key given twice (YAML takes the last), aliases and merged mappings, tags
    other than those of plain values, numbers that YAML 1.1 reads to base 60 or 8, and a file that
    ends within a line.

    Raises:
        ConfigError: The file cannot be read, is not such YAML or holds something else.
    """
    name = str(path)
    try:
        data = _parse(_read(Path(path)), name)
    except OSError as error:
        begun = Path(path).stem.partition("_")[0]
        others = ", ".join(sorted(p.name for p in Path(path).parent.glob(f"{begun}_*.yaml")))
        allowed = f"a readable file, such as {others}" if others else "a readable file"
        raise ConfigError(name, error.strerror, allowed) from error
    except ConfigError:
        raise
    except (yaml.YAMLError, ValueError) as error:  # ValueError: no UTF-8, or a day like 2026-13-45
        raise ConfigError(name, _problem(error), "valid YAML in UTF-8") from error
    if not isinstance(data, dict):
        raise ConfigError(name, data, "a mapping of keys to values")
    return data


def _read(path: Path) -> str:
    with path.open("rb") as file:
        data = file.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise ConfigError(str(path), f"larger than {LARGEST} bytes", f"at most {LARGEST} bytes")
    if data and not data.endswith(b"\n"):  # half a number is a number too
        end = data[-40:].decode("utf-8", "replace").splitlines()[-1]
        raise ConfigError(str(path), f"cut off behind {end!r}", "a last line that ends")
    return data.decode("utf-8")


def _problem(error: Exception) -> str:
    if isinstance(error, yaml.MarkedYAMLError) and error.problem_mark is not None:
        return f"{error.problem} in line {error.problem_mark.line + 1}"
    return " ".join(str(error).split())


def _parse(text: str, name: str) -> object:
    _check_events(text, name)
    loader = yaml.CSafeLoader(text)
    try:
        node = loader.get_single_node()
        if node is None:
            return None
        _check(node, name)
        return loader.construct_document(node)
    finally:
        loader.dispose()


def _check_events(text: str, name: str) -> None:
    """Refuse what would fill the memory: few lines of aliases may stand for gigabytes."""
    depth = 0
    for event in yaml.parse(text, Loader=yaml.CSafeLoader):
        if isinstance(event, yaml.AliasEvent):
            problem = "an alias (*name) may not be used"
            raise yaml.composer.ComposerError(None, None, problem, event.start_mark)
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise ConfigError(name, "nested too deeply", f"at most {DEEPEST} levels of keys")


def _check(node: yaml.Node, where: str) -> None:
    """Refuse what stands in the file and would not be seen in its values."""
    if isinstance(node, yaml.ScalarNode):
        if node.tag in _NUMBERS and _ODD_NUMBER.fullmatch(node.value):
            raise ConfigError(where, node.value, "a number without : and without leading 0")
    elif isinstance(node, yaml.SequenceNode):
        for index, entry in enumerate(node.value):
            _check(entry, f"{where}[{index}]")
    else:
        _check_mapping(node, where)


def _check_mapping(node: yaml.MappingNode, where: str) -> None:
    seen: dict[str, yaml.Node] = {}
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode) or key.tag == _MERGE:
            shown = key.value if isinstance(key, yaml.ScalarNode) else "no word"
            raise ConfigError(join(where, "a key"), shown, "a word as key")
        path = join(where, key.value)
        if key.value in seen:
            lines = [n.start_mark.line + 1 for n in (seen[key.value], key)]
            words = f"given in line {lines[0]} and again in line {lines[1]}: {_text(value)}"
            raise ConfigError(path, words, "each key once")
        seen[key.value] = key
        _check(value, path)


def _text(node: yaml.Node) -> str:
    return node.value if isinstance(node, yaml.ScalarNode) else "..."
