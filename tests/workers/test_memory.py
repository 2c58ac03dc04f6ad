"""A job's process has a limit of memory of its own, and a job that meets it ends with a code."""

from __future__ import annotations

import subprocess
import sys

import pytest
from garmentq.service.jobs import find_job
from garmentq.workers import recovery

SCRIPT = """
from garmentq.workers.worker import limit_job_memory
import numpy as np
limit_job_memory(400)
try:
    np.ones(100_000_000)
except MemoryError:
    print("refused")
limit_job_memory(0)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not keep the limit")
def test_a_process_is_refused_what_is_beyond_its_limit():
    """Broken where a job takes the memory of the whole machine where no container holds it."""
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert done.stdout == "refused\n"


def test_a_job_without_memory_fails_with_a_code(settings, database, queue_job, monkeypatch):
    """Broken where want of memory is told as a fault of the program, or the job is tried again and again."""

    def eat(*_):
        raise MemoryError

    monkeypatch.setattr(recovery, "unpack", eat)
    job = queue_job()
    assert recovery.run_job(settings, database, job, lambda: False) == "failed"
    row = find_job(database, job)
    assert row.error_code == "job.out_of_memory" and "GARMENTQ_JOB_MEMORY_MB" in row.error_message
