"""The time that kernels take to compile is told apart."""

from __future__ import annotations

import time

import numba
from garmentq.cli.bench.compiling import time_compiling


def test_compiling_is_timed_once_and_running_is_not():
    """Breaks if a compilation is missed, a nested one counts twice, or work that is already compiled counts."""

    @numba.njit
    def inner(x):
        return x + 1

    @numba.njit
    def outer(x):
        return 2 * inner(x)

    before = time.process_time()
    with time_compiling() as first:
        assert outer(1.0) == 4.0
    spent = time.process_time() - before
    assert 0.5 * spent < first.seconds <= spent
    with time_compiling() as second:
        outer(2.0)
    assert second.seconds == 0.0
