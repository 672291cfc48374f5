# SPDX-License-Identifier: BSD-3-Clause
"""The namespaces in which the topics of the report lie."""

import pytest

from session_log.report.session.namespaces import namespaces_of

WANTED = ("/rst_control/state", "/joint_states", "/voice_assist/intended")


@pytest.mark.parametrize(
    ("recorded", "found"),
    [
        (["/rst_control/state", "/joint_states"], []),
        (["/left/rst_control/state", "/left/joint_states"], ["/left"]),
        (["/right/joint_states", "/a/b/rst_control/state"], ["/a/b", "/right"]),
        (["/left/joint_states", "/joint_states"], []),  # that of the report is there, too
        (["/left_joint_states", "/other"], []),
        ([], []),
    ],
)
def test_only_what_is_missing_under_its_own_name_is_looked_for(recorded, found):
    assert namespaces_of(WANTED, recorded) == found
