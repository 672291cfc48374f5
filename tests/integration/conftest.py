# SPDX-License-Identifier: BSD-3-Clause
from contextlib import closing

import pytest

from tests.integration.install_space import InstallSpace
from tests.support.ros_host import Host


@pytest.fixture
def host(tmp_path, monkeypatch):
    """A host on which a test starts masters and launch files; all end with the test."""
    host = Host(tmp_path)
    for name in ("ROS_IP", "ROS_MASTER_URI", "ROS_LOG_DIR"):
        monkeypatch.setenv(name, host.environment[name])
    yield host
    host.close()


@pytest.fixture(scope="session", autouse=True)
def install_space(request, tmp_path_factory):
    """Begun before the first test where one is to come that uses it; half a minute of work."""
    if not any(item.path.name == "test_install_space.py" for item in request.session.items):
        yield None
        return
    with closing(InstallSpace(tmp_path_factory.mktemp("install"))) as space:
        yield space
