# SPDX-License-Identifier: BSD-3-Clause
"""Networks in ONNX files inside installed packages, each run on one thread."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import onnxruntime
from onnxruntime.capi import onnxruntime_pybind11_state as state

from voice_assist.errors import ModelError

_DAMAGED = (state.Fail, state.InvalidArgument, state.InvalidGraph, state.InvalidProtobuf)


def read_network(package: str, name: str) -> bytes:
    """A network file of a package, which is not imported: that may change or need much else.

    Args:
        package: Name of the package.
        name: Path of the file inside it.

    Raises:
        ModelError: It is not there.
    """
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise ModelError(
            f"the package {package!r} with {name} is missing; `make setup` installs it"
        )
    path = Path(spec.submodule_search_locations[0]) / name
    if not path.is_file():
        raise ModelError(f"{path} is missing; allowed: the wheel pinned in requirements.txt")
    return path.read_bytes()


def packaged_session(package: str, name: str) -> onnxruntime.InferenceSession:
    """A network of a package, ready to run on one thread; arguments as of `read_network`.

    Raises:
        ModelError: It is not there, or damaged.
    """
    network = read_network(package, name)
    try:
        return onnx_session(network)
    except _DAMAGED as error:
        raise ModelError(f"{name} of the package {package!r} is damaged: {error}") from error


def onnx_session(network: bytes) -> onnxruntime.InferenceSession:
    """Make a network ready to run on one thread."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    return onnxruntime.InferenceSession(network, options, providers=["CPUExecutionProvider"])
