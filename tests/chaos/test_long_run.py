"""Fault R9, the short way: blows by chance at everything while jobs run. `long.py` is the long way, by hand."""

from __future__ import annotations

import gc
import os
from dataclasses import replace

import pytest
from long import Pace, run


@pytest.mark.nightly
@pytest.mark.filterwarnings("ignore:.*was deleted while still open:ResourceWarning")  # its server went away under it
def test_r9_blows_by_chance(settings, marks, nursery, database_kind, request):
    """Broken where a job is lost or done twice while processes, broker, database and store go away at random."""
    server = request.getfixturevalue("postgres_server") if database_kind == "postgresql" else None
    quick = replace(settings, lease_seconds=2.0, republish_seconds=1.0, max_attempts=20)
    environment = {**os.environ, **quick.as_environment()}

    def start():
        return nursery.start(["--workers", "1"], environment, quick.home / "worker.log")

    found = run(quick, start, jobs=15, workers=2, seed=1, pace=Pace(0.0, 3, 1.0, 1.0), server=server)
    assert (found["results"], found["duplicates"], found["lost"], found["blows left"]) == (15, 0, 0, 0)
    assert found["kills of parents"] + found["kills of children"] >= 3
    gc.collect()
