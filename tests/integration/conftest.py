# SPDX-License-Identifier: BSD-3-Clause
import pytest

from tests.support.ros_host import Host


@pytest.fixture
def host(tmp_path, monkeypatch):
    """A host on which a test starts masters and launch files; all end with the test."""
    host = Host(tmp_path)
    for name in ("ROS_IP", "ROS_MASTER_URI", "ROS_LOG_DIR"):
        monkeypatch.setenv(name, host.environment[name])
    yield host
    host.close()
