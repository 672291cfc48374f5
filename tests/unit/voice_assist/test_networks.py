# SPDX-License-Identifier: BSD-3-Clause
"""A network that a package should bring is refused by name where it is missing or damaged."""

import sys

import numpy as np
import pytest

from voice_assist.errors import ModelError
from voice_assist.networks import packaged_session, read_network


def test_a_network_of_a_package_runs_without_importing_it():
    session = packaged_session("openwakeword", "resources/models/melspectrogram.onnx")
    (lines,) = session.run(None, {"input": np.zeros((1, 1760), np.float32)})
    assert lines.size == 8 * 32
    assert "openwakeword" not in sys.modules


@pytest.mark.parametrize(
    ("package", "name", "words"),
    [
        ("no_such_package", "x.onnx", "package 'no_such_package' with x.onnx is missing"),
        ("math", "x.onnx", "package 'math' with x.onnx is missing"),
        ("openwakeword", "x.onnx", "x.onnx is missing; allowed: the wheel pinned in"),
    ],
)
def test_what_is_not_there_is_named(package, name, words):
    with pytest.raises(ModelError, match=words):
        read_network(package, name)


@pytest.mark.parametrize("damage", [b"", b"no network", "half", "changed"])
def test_a_damaged_network_is_refused_by_name(damage, tmp_path, monkeypatch):
    whole = read_network("openwakeword", "resources/models/melspectrogram.onnx")
    damaged = {"half": whole[: len(whole) // 2], "changed": whole[:100] + bytes(200) + whole[300:]}
    (tmp_path / "hears").mkdir()
    (tmp_path / "hears" / "__init__.py").touch()
    (tmp_path / "hears" / "x.onnx").write_bytes(damaged.get(damage, damage))
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ModelError, match=r"x\.onnx of the package 'hears' is damaged"):
        packaged_session("hears", "x.onnx")
