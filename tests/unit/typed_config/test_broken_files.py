# SPDX-License-Identifier: BSD-3-Clause
"""Settings files that are broken as files: refused by name, and nothing in them runs."""

import re

import pytest
import yaml

from tests.unit.typed_config.settings_files import files, kinds, shown
from typed_config import ConfigError, load_config, load_yaml

ENTRY = re.compile(r"^  - \{")
SECTION = re.compile(r"^(?=\w)", re.MULTILINE)
# One reader reads all files: what it refuses before it reads keys is tried on these.
SHAPES = ("audio.yaml", "controller.yaml", "gen3_openrst.yaml", "session.yaml")
ON_EACH = {
    *("empty", "a comment only", "null", "a list", "words", "a number"),
    *("two documents", "one alias", "os.system", "base 60"),
}


def short(path):
    """The file with one entry of each long list and without comment lines: quicker to parse."""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        is_more = ENTRY.match(line) and lines and ENTRY.match(lines[-1])
        if not is_more and not line.lstrip().startswith("#"):
            lines.append(line)
    return "\n".join(lines) + "\n"


def load(folder, path, data):
    """What a program does with such a file at its start."""
    file = folder / path.name
    file.write_bytes(data if isinstance(data, bytes) else data.encode())
    return load_config(kinds()[path], load_yaml(file), file.name)


def bomb(depth=12):
    """A kilobyte that stands for ten to the twelfth words."""
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    for level in range(1, depth):
        inside = ", ".join([f"*a{level - 1}"] * 10)
        lines.append(f"a{level}: &a{level} [{inside}]")
    return "\n".join(lines) + "\n"


def damages(text, trace):
    """Name of the damage, and the file after it."""
    half = len(text) // 2
    run = f"['touch {trace}']"
    yield from (("empty", ""), ("a comment only", "# nothing\n"), ("null", "null\n"))
    yield from (("a list", "- 1\n- 2\n"), ("words", "just words\n"), ("a number", "4\n"))
    yield "no UTF-8", text[:half].encode() + b"\xff" + text[half:].encode()
    yield "UTF-16", text.encode("utf-16")
    yield "a zero byte", text[:half] + "\0" + text[half:]
    yield "two documents", text + "---\n{}\n"
    yield "another YAML", "%YAML 9.9\n---\n" + text
    yield "an open list", text + "extra: [1, 2\n"
    yield "a tab", text + "extra:\n\t- 1\n"
    yield "a bomb of aliases", text + bomb()
    yield "one alias", text + "extra: &e 1\nmore: *e\n"
    yield "an alias to itself", text + "extra: &e [*e]\n"
    yield "a merged mapping", text + "<<: {extra: 1}\n"
    yield "a key that is a list", text + "? [a]\n: 1\n"
    yield "os.system", text + f"extra: !!python/object/apply:os.system {run}\n"
    yield "a module", text + "extra: !!python/module:antigravity ''\n"
    yield "subprocess", text + f"extra: !!python/object/new:subprocess.Popen [{run}]\n"
    yield "an own tag", text + "extra: !secret 1\n"
    yield "nested too deeply", text + "extra: " + "[" * 3000 + "\n"
    yield "too large", "#" * 1_000_001 + "\n" + text
    yield "a day that is none", text + "extra: 2026-13-45\n"
    yield "base 60", text + "extra: 1:30\n"
    yield "base 8", text + "extra: 010\n"
    yield "too many digits", text + f"extra: {'9' * 5000}\n"
    yield "a line that does not end", text + "extra: 0.02"


@files
def test_a_damaged_file_is_refused_by_its_name_and_runs_nothing(path, tmp_path):
    trace, failures, cases = tmp_path / "ran", [], 0
    for name, data in damages(short(path), trace):
        if path.name not in SHAPES and name not in ON_EACH:
            continue
        cases += 1
        try:
            load(tmp_path, path, data)
        except ConfigError as error:
            if path.name not in str(error) or ", allowed: " not in str(error):
                failures.append(f"{name}: {error}")
            if len(str(error)) > 600:
                failures.append(f"{name}: an error of {len(str(error))} characters")
        else:
            failures.append(f"{name} is accepted")
    assert not failures, "\n".join(failures)
    assert cases == (29 if path.name in SHAPES else len(ON_EACH)) and not trace.exists()


@files
def test_the_short_form_is_like_the_file(path, tmp_path):
    """Else the tests here would refuse it for another reason than the one they are about."""
    try:
        load(tmp_path, path, short(path))
    except ConfigError as error:  # bodies that are gone may be named elsewhere, and no more
        assert path.name == "gen3_openrst.yaml" or "entries" in str(error)


def keys(node, path=()):
    """Path of each key, its place in the text, its column, and whether its mapping has braces."""
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            mark = key.start_mark
            yield (*path, key.value), mark.index, mark.column, node.flow_style
            yield from keys(value, (*path, key.value))
    elif isinstance(node, yaml.SequenceNode):
        for index, value in enumerate(node.value):
            yield from keys(value, (*path, index))


@files
def test_a_key_given_twice_is_refused_wherever_it_stands(path, tmp_path):
    """YAML itself takes the last one without a word."""
    failures, seen = [], set()
    parts = SECTION.split(short(path))  # each is a file by itself, and sooner read than the whole
    found = [(p, key) for p in parts for key in keys(yaml.compose(p, yaml.SafeLoader))]
    for part, (place, index, column, has_braces) in found:
        schema = tuple(step for step in place if isinstance(step, str))
        if schema in seen:
            continue
        seen.add(schema)
        again = f"{place[-1]}: 0" + (", " if has_braces else "\n" + " " * column)
        try:
            load(tmp_path, path, part[:index] + again + part[index:])
        except ConfigError as error:
            words = f"{path.name}: {shown(place)} is"
            if words not in str(error) or "each key once" not in str(error):
                failures.append(f"{shown(place)}: {error}")
        else:
            failures.append(f"{shown(place)} twice is accepted")
    assert not failures, "\n".join(failures)
    assert len(seen) >= 2


@files
def test_a_file_cut_off_anywhere_is_refused_or_says_the_same(path, tmp_path):
    """But for a cut behind a whole entry of the last list, which leaves a shorter list."""
    text = path.read_text(encoding="utf-8") if path.stat().st_size < 9000 else short(path)
    try:
        whole = load(tmp_path, path, text)
    except ConfigError:
        whole = None
    for cut in sorted({*range(0, len(text), len(text) // 9), len(text) - 1, len(text) - 3}):
        try:
            left = load(tmp_path, path, text[:cut])
        except ConfigError as error:
            assert path.name in str(error)
        else:
            assert left == whole or text[:cut].endswith("\n"), cut


def test_a_bomb_is_refused_before_it_is_opened(tmp_path):
    file = tmp_path / "bomb.yaml"
    file.write_text(bomb(40))
    with pytest.raises(ConfigError, match=r"bomb\.yaml.*alias"):
        load_yaml(file)


def test_a_folder_in_place_of_a_file_is_refused_by_its_name(tmp_path):
    (tmp_path / "rcm.yaml").mkdir()
    with pytest.raises(ConfigError, match=r"rcm\.yaml.*a readable file"):
        load_yaml(tmp_path / "rcm.yaml")
