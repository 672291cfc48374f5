# SPDX-License-Identifier: BSD-3-Clause
"""Which joints the report shows where messages name different ones."""

import numpy as np
import pytest

from session_log.report.session.joint_tables import JointTables
from support.story_script import joint_text

ARM, GRIPPER = ("joint_1", "joint_2"), ("finger", "thumb", "wrist")
URDF = f"<robot name='r'>{''.join(joint_text(n, 'revolute', 'a', 'b') for n in ARM)}</robot>"


def tables_of(*rows):
    """Each message alone; its positions are zero unless they are given."""
    tables = JointTables()
    for time, (names, *position) in enumerate(rows):
        column = np.empty(1, object)
        column[0] = names
        q = position[0] if position else [0.0] * len(names)
        tables.add(np.array([float(time)]), column, np.array([q]))
    return tables


def columns_of(best):
    table, other = best
    return table.columns[1:], list(table["time"]), other


def test_the_joints_of_the_robot_model_are_shown_however_few_their_messages():
    tables = tables_of((GRIPPER,), (GRIPPER,), (ARM,), (GRIPPER,))
    assert columns_of(tables.best(URDF)) == (ARM, [2.0], 3)


@pytest.mark.parametrize("urdf", ["", "<robot", "<robot name='r'/>"])
def test_without_a_model_the_joints_of_most_messages_are_shown(urdf):
    tables = tables_of((ARM,), (GRIPPER,), (GRIPPER,))
    assert columns_of(tables.best(urdf)) == (GRIPPER, [1.0, 2.0], 1)


def test_positions_that_do_not_fit_their_names_are_counted():
    tables = tables_of((ARM,), (ARM, [0.0]), ((), [0.0]), (ARM, []))
    assert columns_of(tables.best(URDF)) == (ARM, [0.0], 3)


def test_without_a_position_there_is_no_table_and_nothing_to_count():
    assert tables_of((ARM, []), ((),)).best(URDF) == (None, 0)
