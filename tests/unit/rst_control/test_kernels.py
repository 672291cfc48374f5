# SPDX-License-Identifier: BSD-3-Clause
import importlib.util
import subprocess
import sys

import pytest
from numba.core.caching import InTreeCacheLocator

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


def check_again():
    kernels.drop_stale_code.cache_clear()
    kernels.drop_stale_code()


@pytest.mark.parametrize("folder", [".", "below"])
def test_cached_code_goes_when_a_kernel_that_it_may_call_changes(package, folder):
    code = package / folder / "__pycache__" / "outer.nbc"
    code.parent.mkdir(parents=True, exist_ok=True)
    kernels.drop_stale_code()
    code.write_bytes(b"old")
    check_again()
    assert code.exists()
    (package / "deep.py").write_text("@kernel\ndef inner(): return 2\n")
    check_again()
    assert not code.exists()


def test_cached_code_stays_when_something_else_changes(package):
    kernels.drop_stale_code()
    code = package / "__pycache__" / "outer.nbi"
    code.write_bytes(b"good")
    (package / "plain.py").write_text("x = 2\n")
    check_again()
    assert code.exists()


def test_a_source_tree_that_cannot_be_written_to_is_no_error(package, monkeypatch):
    monkeypatch.setattr(kernels, "STAMP", package / "deep.py" / "kernels.stamp")
    kernels.drop_stale_code()


DOUBLE = """from rst_control.kernels import kernel

@kernel
def double(x):
    return 2.0 * x
"""


def compiled_here(package):
    """The kernel of a package, as a new process loads it; how often it was compiled."""
    file = package / "room" / "arithmetic.py"
    file.parent.mkdir(exist_ok=True)
    file.write_text(DOUBLE)
    check_again()
    spec = importlib.util.spec_from_file_location("arithmetic", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.double(2.0) == 4.0
    return sum(module.double.stats.cache_misses.values())


@pytest.fixture
def closed(monkeypatch):
    """Makes all sources read-only for this account."""

    def refuse(locator):
        if "/room/" in locator.get_cache_path():
            raise PermissionError(locator.get_cache_path())
        return original(locator)

    original = InTreeCacheLocator.ensure_cache_path

    def close():
        monkeypatch.setattr(InTreeCacheLocator, "ensure_cache_path", refuse)

    return close


def test_code_is_compiled_once(package):
    assert [compiled_here(package), compiled_here(package)] == [1, 0]


def test_an_account_that_may_only_read_uses_the_code_beside_the_sources(package, closed):
    assert compiled_here(package) == 1
    closed()
    assert compiled_here(package) == 0


def test_it_keeps_what_is_missing_there_in_its_own_cache(package, closed, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "own"))
    closed()
    assert [compiled_here(package), compiled_here(package)] == [1, 0]
    assert list((tmp_path / "own").rglob("*.nbc"))


@pytest.mark.parametrize("home", ["/proc/self/nowhere", "/dev/null"])
def test_without_a_home_it_compiles_each_time(package, closed, monkeypatch, home):
    monkeypatch.setenv("XDG_CACHE_HOME", "")
    monkeypatch.setenv("HOME", home)
    closed()
    assert [compiled_here(package), compiled_here(package)] == [1, 1]


def test_stale_code_beside_sources_that_may_only_be_read_is_not_used(package, closed, monkeypatch):
    assert compiled_here(package) == 1
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    monkeypatch.setattr(kernels, "STAMP", package / "deep.py" / "kernels.stamp")
    closed()
    assert compiled_here(package) == 1


def test_code_that_another_account_has_closed_is_compiled_anew(package, closed, monkeypatch):
    assert compiled_here(package) == 1
    index = next(package.rglob("*.nbi"))
    index.unlink()
    index.mkdir()  # an error of the system for every account, root included
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    closed()
    assert compiled_here(package) == 1


def test_a_full_disk_stops_no_kernel(package):
    (package / "room" / "__pycache__").mkdir(parents=True)
    compiled_here(package)
    index = next(package.rglob("*.nbi"))
    index.unlink()
    index.mkdir()
    assert compiled_here(package) == 1


WITHOUT_SCIPY = """
import sys
from rst_control.kernels import kernel
def double(x):
    return 2.0 * x
assert kernel(double)(2.0) == 4.0
print(*sorted(name for name in sys.modules if name.startswith("scipy.linalg")))
"""


def test_a_kernel_runs_without_the_import_of_scipys_linear_algebra(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(WITHOUT_SCIPY)
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
