"""`garmentq status` tells which jobs failed, and why."""

from __future__ import annotations

import json

from garmentq.service.jobs import claim, fail


def test_failed_jobs_are_listed_with_their_reason(cli, database, queue_job):
    """Broken where a studio has to open each of a hundred jobs to learn why it failed."""
    bad, good = queue_job("bad"), queue_job("good")
    held = claim(database, bad, "a", 30.0)
    fail(database, held, "scan.empty", "The scan has no points.", bad_input=True)
    shown = cli("status", "--state", "failed").stdout
    assert bad in shown and "scan.empty: The scan has no points." in shown and good not in shown
    assert [json.loads(line)["job"] for line in cli("status", "--state", "queued", "--json").stdout.splitlines()] == [
        good
    ]
    none = cli("status", "--tag", "nosuch")
    assert none.returncode == 0 and "no job has tag nosuch" in none.stderr
    assert cli("status", bad, "--state", "failed").returncode == 2
