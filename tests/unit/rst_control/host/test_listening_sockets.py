# SPDX-License-Identifier: BSD-3-Clause
import socket
from pathlib import Path

import pytest

from rst_control.host.listening_sockets import (
    Listener,
    inodes_of,
    is_loopback,
    listeners,
    parse_table,
    warnings,
)

HEAD = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when uid inode"
LOOPBACK = "http://127.0.0.1:11311"


def row(local, remote="00000000:0000", state="0A", inode=77):
    return f" 0: {local} {remote} {state} 00000000:00000000 00:00000000 00000000 0 0 {inode} 1 0"


@pytest.fixture
def opened():
    """A socket that listens on an address of this host."""
    sockets = []

    def listen(address):
        sockets.append(socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET))
        sockets[-1].bind((address, 0))
        sockets[-1].listen()
        return sockets[-1].getsockname()[1]

    yield listen
    for one in sockets:
        one.close()


@pytest.mark.parametrize("address", ["127.0.0.1", "127.0.0.2", "0.0.0.0", "::1", "::"])
def test_what_the_kernel_lists_is_what_was_opened(opened, address):
    if ":" in address and not Path("/proc/net/if_inet6").exists():
        pytest.skip("no IPv6 here")
    port, inodes = opened(address), inodes_of()
    (found,) = [one for one in listeners() if one.inode in inodes and one.port == port]
    assert found.address == address
    assert found.is_loopback is (address not in ("0.0.0.0", "::"))


def test_connections_are_no_listeners_and_other_words_are_passed_over():
    lines = [HEAD, row("0100007F:1F90", "0100007F:9999", "01"), row("00000000:1F90"), "", "junk"]
    assert [one.port for one in parse_table("tcp", lines)] == [8080]
    bound = [HEAD, row("00000000:0035", state="07"), row("0100007F:0035", "0100007F:1", "01")]
    assert [one.address for one in parse_table("udp", bound)] == ["0.0.0.0"]


@pytest.mark.parametrize(
    ("address", "is_it"),
    [
        ("127.0.0.1", True),
        ("127.1.2.3", True),
        ("::1", True),
        ("::ffff:127.0.0.1", True),
        ("0.0.0.0", False),
        ("::", False),
        ("192.168.1.7", False),
        ("::ffff:192.168.1.7", False),
    ],
)
def test_loopback_is_distinguished_from_the_rest(address, is_it):
    assert is_loopback(address) is is_it


def test_a_system_on_loopback_is_not_warned_of():
    found = [
        Listener("tcp", "127.0.0.1", 11311, 1),
        Listener("tcp", "0.0.0.0", 22, 2),
        Listener("udp", "0.0.0.0", 68, 3),
        Listener("tcp6", "::1", 4000, 4),
    ]
    assert warnings(LOOPBACK, found, {1, 4}) == []


def test_a_master_that_others_can_reach_is_named_with_what_to_do():
    (words,) = warnings(LOOPBACK, [Listener("tcp", "0.0.0.0", 11311, 1)], set())
    assert "master" in words and "0.0.0.0:11311" in words and "ROS_IP=127.0.0.1" in words
    (words,) = warnings("http://192.0.2.1:11311", [], set())
    assert "192.0.2.1" in words and "two-hosts.md" in words


def test_a_socket_of_the_node_itself_is_named():
    (words,) = warnings(LOOPBACK, [Listener("tcp6", "::", 40_000, 9)], {9})
    assert "this node" in words and "40000" in words


@pytest.mark.parametrize("uri", ["", "http://", "nonsense", "http://127.0.0.1:x", "http://[::1"])
def test_a_master_that_cannot_be_read_is_warned_of(uri):
    assert len(warnings(uri, [], set())) == 1


def test_where_there_is_no_proc_nothing_is_found(tmp_path):
    assert listeners(tmp_path) == ()
    assert inodes_of("self", tmp_path) == set()
