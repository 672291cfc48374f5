# SPDX-License-Identifier: BSD-3-Clause
import pytest

from session_log.report.figures import SessionMaterial
from session_log.report.session.analysis import CommandRow
from session_log.report.tables.session_tables import reasons_table


@pytest.mark.parametrize(("caller", "shown"), [("/pedal", "by\u00a0pedal"), ("", "by\u00a0hand")])
def test_a_refusal_names_the_node_that_asked(caller, shown):
    row = CommandRow("pull more", None, 1.0, "refused", "nothing is held", None, caller)
    material = SessionMaterial(None, [row], None, None, ())
    assert reasons_table(material, "refused").rows == [
        ("1.0\u00a0s", "pull more", shown, "nothing is held")
    ]
