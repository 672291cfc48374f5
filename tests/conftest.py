# SPDX-License-Identifier: BSD-3-Clause
"""Of all tests: their markers, the examples of property tests, and one thread for each library."""

import os
from pathlib import Path

TESTS = Path(__file__).resolve().parent
# scripts that tests start import `support` and `tests` as well
os.environ["PYTHONPATH"] = os.pathsep.join((str(TESTS.parent), os.environ.get("PYTHONPATH", "")))
for _library in ("OMP", "OPENBLAS", "MKL", "NUMBA"):  # small arrays: threads are in the way
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import hypothesis  # noqa: E402  # after the number of threads is set

# The same examples each time, so that a failure says something of the change at hand; EXPLORE=1
# looks at others, and many more of them.
hypothesis.settings.register_profile("fixed", derandomize=True, deadline=None)
hypothesis.settings.register_profile("explore", max_examples=2000, deadline=None)
hypothesis.settings.load_profile("explore" if os.environ.get("EXPLORE") else "fixed")


SLOW = frozenset((TESTS / "slow_tests.txt").read_text(encoding="utf-8").splitlines())


def pytest_ignore_collect(collection_path, config):
    """What is slow as a whole is not even imported where it is left out."""
    is_left_out = config.getoption("markexpr") == "not slow"
    is_ours = collection_path.is_relative_to(TESTS)
    if is_left_out and is_ours and str(collection_path.relative_to(TESTS)) in SLOW:
        return True
    return None  # the others decide


def pytest_collection_modifyitems(items):
    """Each test bears the name of its folder, as `-m property`, and `slow` where it is listed."""
    for item in items:
        path = item.path.relative_to(TESTS)
        item.add_marker(path.parts[0])
        names = {str(parent) for parent in path.parents}
        test = item.name.partition("[")[0]
        if SLOW & {*names, str(path), f"{path}::{test}"}:
            item.add_marker("slow")
