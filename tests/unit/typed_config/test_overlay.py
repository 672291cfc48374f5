# SPDX-License-Identifier: BSD-3-Clause
"""One settings file over another, as roslaunch loads them."""

from copy import deepcopy

from typed_config import overlaid


def test_mappings_are_merged_at_any_depth_all_else_is_replaced_and_neither_file_is_changed():
    under = {"a": {"b": {"c": 1, "d": [1, 2]}, "e": 3}, "f": 4}
    over = {"a": {"b": {"d": [5]}, "g": 6}, "h": {"i": 7}}
    before = deepcopy((under, over))
    assert overlaid(under, over) == {
        "a": {"b": {"c": 1, "d": [5]}, "e": 3, "g": 6},
        "f": 4,
        "h": {"i": 7},
    }
    assert (under, over) == before


def test_a_mapping_and_a_value_replace_each_other():
    assert overlaid({"a": {"b": 1}}, {"a": 2}) == {"a": 2}
    assert overlaid({"a": 2}, {"a": {"b": 1}}) == {"a": {"b": 1}}
