# SPDX-License-Identifier: BSD-3-Clause
"""The settings of docs/how-to/two-hosts.md: the tunnel can connect, the firewall cuts no answer."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "how-to" / "two-hosts.md").read_text(encoding="utf-8")


def test_answers_to_connections_of_the_host_itself_are_accepted_before_ports_are_closed():
    """They come to a random port, as those of the arm's driver: the drop is for others alone."""
    rules = re.findall(r"^nft add rule inet ros input (.*)$", PAGE, re.MULTILINE)
    assert [rule.split()[-1] for rule in rules] == ["accept", "drop"]
    assert rules[0] == "ct state established,related accept"
    assert "32768-60999" in rules[1] and 'iifname != { "lo", "wg0" }' in rules[1]


def test_each_peer_of_the_tunnel_has_an_address_and_a_port_where_it_listens():
    interfaces = re.findall(r"^\[Interface\]\n((?:\w+ = .*\n)+)", PAGE, re.MULTILINE)
    peers = re.findall(r"^\[Peer\]\n((?:\w+ = .*\n)+)", PAGE, re.MULTILINE)
    assert len(peers) == len(interfaces) == PAGE.count("[Peer]") > 0
    for interface, peer in zip(interfaces, peers, strict=True):
        (port,) = re.findall(r"^ListenPort = (\d+)$", interface, re.MULTILINE)
        (endpoint,) = re.findall(r"^Endpoint = (.+)$", peer, re.MULTILINE)
        assert endpoint.endswith(f":{port}") and "10.7.0." not in endpoint
