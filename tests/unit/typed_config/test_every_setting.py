# SPDX-License-Identifier: BSD-3-Clause
"""Every key of every settings file, wrong in every way, is refused by the call of its program.

The cases are made from the files and from the dataclasses that load them, so that a new key is
tested without another line here. Each test gathers all failures before it reports them.
"""

import pytest

from tests.unit.typed_config.settings_files import (
    FILES,
    GONE,
    NODES,
    OVERLAYS,
    SOURCE,
    WHOLE,
    added,
    at,
    changed,
    content,
    files,
    kinds,
    leaves,
    mappings,
    node_parameters,
    shown,
)
from tests.unit.typed_config.wrong_values import (
    NO_OTHER_UNIT,
    OTHER_UNITS,
    in_other_units,
    wrong_values,
)
from typed_config import ConfigError, load_config, overlaid

# In another unit these stay within what is sensible, so that no range finds them.
UNDETECTED = {
    ("rcm.yaml: solver.damping", "percent"): "0.001 and 0.1 both serve: it only costs iterations",
    ("scene.yaml: tissue.bed_stiffness", "N/mm"): "0 is allowed: nothing need lie around the sheet",
}


def refusal(kind, data, where):
    """The error of a start; None where it is accepted. Any other error fails the test."""
    try:
        load_config(kind, data, where)
    except ConfigError as error:
        return error
    return None


def complaint(error, where, key, value):
    """What an error lacks of file, key, value and what was allowed; empty: nothing."""
    if error is None:
        return "is accepted"
    words = str(error)
    wanted = [where, key, ", allowed: "]
    if value is not GONE and not isinstance(value, (list, dict)):
        wanted.append(repr(value)[:20])
    lacking = [word for word in wanted if word not in words]
    if value is GONE and "missing" not in words and " is [" not in words:  # one of some is needed
        lacking.append("missing")
    return f"says {words!r}, which lacks {lacking}" if lacking else ""


def test_every_settings_file_is_known_here_with_the_dataclass_that_loads_it():
    found = {
        *SOURCE.glob("*/config/*.yaml"),
        *(path for path in WHOLE if SOURCE not in path.parents),
    }
    assert found - set(OVERLAYS) == set(FILES), "name new files in settings_files.py"
    assert len(found) >= 16


@pytest.mark.parametrize("path", OVERLAYS, ids=lambda path: path.name)
def test_what_a_file_changes_of_a_node_is_known_to_it(path):
    kind, _ = NODES[OVERLAYS[path]]
    own, changes = node_parameters(OVERLAYS[path]), content(path)
    load_config(kind, overlaid(own, changes), path.name)
    section = next(iter(changes))
    unknown = {section: {**changes[section], "no_such_key": 1}}
    with pytest.raises(ConfigError, match="no_such_key"):
        load_config(kind, overlaid(own, unknown), path.name)


@files
def test_no_value_in_the_file_escapes_the_generator(path):
    def count(node):
        if isinstance(node, dict):
            return sum(count(value) for value in node.values())
        return sum(map(count, node)) if isinstance(node, list) else 1

    found = [leaf for leaf in leaves(kinds()[path], content(path)) if not leaf.is_list]
    assert len(found) == count(content(path)) > 0


@files
def test_the_shipped_file_is_accepted(path):
    load_config(kinds()[path], content(path), path.name)


@files
def test_every_key_wrong_in_every_way_is_refused_with_file_key_value_and_what_is_allowed(path):
    kind, data, failures, cases = kinds()[path], content(path), [], 0
    for leaf in list(leaves(kind, data)):
        for mistake, value in wrong_values(leaf, at(data, leaf.path)):
            with changed(data, leaf.path, value):
                error = refusal(kind, data, path.name)
            key = shown(leaf.path[:-1]) if leaf.is_optional and value is GONE else leaf.key
            if words := complaint(error, path.name, key, value):
                failures.append(f"{path.name}: {leaf.key}, {mistake}: {words}")
            cases += 1
    assert not failures, f"{len(failures)} of {cases}:\n" + "\n".join(failures[:60])
    assert cases > 40


@files
def test_a_value_in_another_unit_is_refused(path):
    kind, data, failures = kinds()[path], content(path), []
    for leaf in list(leaves(kind, data)):
        if leaf.is_entry:
            continue  # people write the whole list in one unit
        value = at(data, leaf.path)
        is_known = leaf.rule.unit in OTHER_UNITS or leaf.rule.unit in NO_OTHER_UNIT
        assert is_known, f"{leaf.key}: say in wrong_values.py how people write {leaf.rule.unit}"
        for unit, scaled in in_other_units(leaf, value):
            with changed(data, leaf.path, scaled):
                error = refusal(kind, data, path.name)
            known = (f"{path.name}: {leaf.schema}", unit) in UNDETECTED
            last = leaf.schema.rpartition(".")[2].rstrip("[]")
            if error is None and not known:
                failures.append(f"{path.name}: {leaf.key} = {scaled} ({unit}) is accepted")
            elif error is not None and (known or last not in str(error)):
                failures.append(f"{path.name}: {leaf.key} ({unit}): {error}; known: {known}")
    assert not failures, "\n".join(failures)


@files
def test_a_key_that_is_not_known_is_refused_beside_every_key(path):
    kind, data, failures = kinds()[path], content(path), []
    for place, _ in list(mappings(kind, data)):
        for key in list(at(data, place)):
            with added(data, place, f"{key}x", at(data, (*place, key))):
                words = str(refusal(kind, data, path.name))
            unknown = shown((*place, f"{key}x"))
            if unknown not in words or "no such key; did you mean" not in words:
                failures.append(f"{unknown}: {words}")
    assert not failures, "\n".join(failures)


@files
def test_a_former_key_is_refused_and_the_error_names_the_present_one(path):
    kind, data, failures = kinds()[path], content(path), []
    for place, inner in list(mappings(kind, data)):
        for former, present in getattr(inner, "RENAMED", {}).items():
            if present and present not in at(data, place):
                failures.append(f"{inner.__name__}: there is no {present}")
            with added(data, place, former, 1):
                words = str(refusal(kind, data, path.name))
            hint = f"its name is now {present}" if present else "it is gone"
            wanted = (shown((*place, former)), hint)
            if not all(part in words for part in wanted):
                failures.append(f"{shown((*place, former))}: {words}")
    assert not failures, "\n".join(failures)


@files
def test_what_stands_in_place_of_a_mapping_is_refused(path):
    kind, data, failures = kinds()[path], content(path), []
    for place, _ in list(mappings(kind, data)):
        for value in (GONE, None, "wrong", 3.0, True, [], [1.0]):
            if value is GONE and (not place or isinstance(place[-1], int)):
                continue  # no key: the whole file, or a shorter list
            if not place:
                error = refusal(kind, value, path.name)
            else:
                with changed(data, place, value):
                    error = refusal(kind, data, path.name)
            is_optional = place and place[-1] == "body" and value is GONE
            key = shown(place[:-1]) if is_optional else shown(place)
            if words := complaint(error, path.name, key, value):
                failures.append(f"{shown(place)} = {value!r}: {words}")
    assert not failures, "\n".join(failures)


@pytest.mark.parametrize("where", NODES, ids=["controller", "robot", "voice_assist"])
def test_a_node_refuses_its_parameters_with_the_path_of_the_key(where):
    kind, _ = NODES[where]
    data, failures, cases = node_parameters(where), [], 0
    assert refusal(kind, data, where) is None
    for leaf in list(leaves(kind, data)):
        if leaf.is_first and not leaf.is_entry:
            with changed(data, leaf.path, None):
                error = refusal(kind, data, where)
            if words := complaint(error, where, f"{where}.{leaf.key}".lstrip("."), None):
                failures.append(f"{leaf.key}: {words}")
            cases += 1
    assert not failures, "\n".join(failures)
    assert cases > 60


def test_units_and_exceptions_that_nothing_uses_are_not_kept():
    used = {leaf.rule.unit for p in FILES for leaf in leaves(kinds()[p], content(p))}
    assert used >= {"m", "rad", "s", "N"}
    assert set(NO_OTHER_UNIT) <= used and set(OTHER_UNITS) - used <= {"m/s^3"}
    keys = {f"{p.name}: {leaf.schema}" for p in FILES for leaf in leaves(kinds()[p], content(p))}
    assert {key for key, _ in UNDETECTED} <= keys
