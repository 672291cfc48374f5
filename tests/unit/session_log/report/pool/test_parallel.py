# SPDX-License-Identifier: BSD-3-Clause
"""Items on workers of which some are lost."""

import pytest

from session_log.report.pool.parallel import Unfinished, run_parallel


def inverse(number):
    """A value, or what as_completed gives for a worker that was killed: an error of its future."""
    return 1 / number


def test_an_item_whose_worker_fails_costs_no_other():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        done = list(run_parallel(inverse, [1, 0, 2, 4, 8], cluster=cluster.scheduler_address))
    lost = Unfinished(0, "ZeroDivisionError: division by zero")
    assert lost in done and {value for value in done if value != lost} == {1.0, 0.5, 0.25, 0.125}
