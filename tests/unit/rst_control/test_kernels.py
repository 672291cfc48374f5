# SPDX-License-Identifier: BSD-3-Clause
from __future__ import annotations

import pytest

from rst_control import kernels


@pytest.fixture
def package(tmp_path, monkeypatch):
    (tmp_path / "__pycache__").mkdir()
    (tmp_path / "deep.py").write_text("@kernel\ndef inner(): ...\n")
    (tmp_path / "plain.py").write_text("x = 1\n")
    monkeypatch.setattr(kernels, "SOURCES", tmp_path)
    monkeypatch.setattr(kernels, "STAMP", tmp_path / "__pycache__" / "kernels.stamp")
    kernels.drop_stale_code.cache_clear()
    yield tmp_path
    kernels.drop_stale_code.cache_clear()


def look_again():
    kernels.drop_stale_code.cache_clear()
    kernels.drop_stale_code()


def test_cached_code_goes_when_any_kernel_changes(package):
    kernels.drop_stale_code()
    code = package / "__pycache__" / "outer.nbc"
    code.write_bytes(b"old")
    look_again()
    assert code.exists()
    (package / "deep.py").write_text("@kernel\ndef inner(): return 2\n")
    look_again()
    assert not code.exists()


def test_cached_code_in_a_folder_below_goes_when_a_kernel_that_it_calls_changes(package):
    code = package / "below" / "__pycache__" / "outer.nbc"
    code.parent.mkdir(parents=True)
    kernels.drop_stale_code()
    code.write_bytes(b"old")
    look_again()
    assert code.exists()
    (package / "deep.py").write_text("@kernel\ndef inner(): return 2\n")
    look_again()
    assert not code.exists()


def test_cached_code_stays_when_something_else_changes(package):
    kernels.drop_stale_code()
    code = package / "__pycache__" / "outer.nbi"
    code.write_bytes(b"good")
    (package / "plain.py").write_text("x = 2\n")
    look_again()
    assert code.exists()


def test_a_source_tree_that_cannot_be_written_to_is_no_error(package, monkeypatch):
    monkeypatch.setattr(kernels, "STAMP", package / "deep.py" / "kernels.stamp")
    kernels.drop_stale_code()
