# SPDX-License-Identifier: BSD-3-Clause
import pytest

from tests.integration.ros_host import Host


@pytest.fixture
def host(tmp_path, monkeypatch):
    """A host on which a test starts masters and launch files; all end with the test."""
    host = Host(tmp_path, monkeypatch)
    yield host
    host.end()
