# SPDX-License-Identifier: BSD-3-Clause
from types import SimpleNamespace

import pytest

from session_log.report.figures import SessionMaterial
from session_log.report.session.analysis import CommandRow
from session_log.report.session.session_data import NodeHealth
from session_log.report.tables.session_tables import health_table, reasons_table


@pytest.mark.parametrize(("caller", "shown"), [("/pedal", "by\u00a0pedal"), ("", "by\u00a0hand")])
def test_a_refusal_names_the_node_that_asked(caller, shown):
    row = CommandRow("pull more", None, 1.0, "refused", "nothing is held", None, caller)
    material = SessionMaterial(None, [row], None, None, ())
    assert reasons_table(material, "refused").rows == [
        ("1.0\u00a0s", "pull more", shown, "nothing is held")
    ]


@pytest.mark.parametrize(("level", "mark"), [(0, ""), (1, "warning"), (2, "bad"), (3, "bad")])
def test_a_part_that_fell_silent_is_marked_as_one_with_an_error(level, mark):
    health = NodeHealth("arm", level, "", 1.0, "", {})
    data = SimpleNamespace(health=[health])
    assert health_table(SessionMaterial(data, [], None, None, ())).marks == (mark,)
