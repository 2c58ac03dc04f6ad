"""A container's health check is light, and says of a worker that hangs or ended that none is alive."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

from garmentq.workers.alive import MAX_HEARTBEAT_AGE
from garmentq_home import make_environment, wait_for
from patience import WAIT_SECONDS


def test_the_check_of_a_worker(settings, cli):
    """Broken where a working worker is unhealthy, or one that has ended or hangs is healthy."""
    away = cli("worker", "--check")
    assert away.returncode == 9 and away.stderr.startswith("error service.worker_away")
    with settings.home.joinpath("worker.log").open("w") as log:
        command = [sys.executable, "-m", "garmentq.cli.main", "worker", "--workers", "1"]
        variables = make_environment(settings)
        worker = subprocess.Popen(command, env=variables, stdout=log, stderr=log)
    try:
        wait_for(lambda: cli("worker", "--check").returncode == 0)
        heartbeat, old = settings.home / "worker.alive", time.time() - 2 * MAX_HEARTBEAT_AGE
        os.utime(heartbeat, (old, old))
        wait_for(lambda: heartbeat.stat().st_mtime > old + MAX_HEARTBEAT_AGE)  # it is renewed without any job
        os.kill(worker.pid, signal.SIGSTOP)
        os.utime(heartbeat, (old, old))
        hanging = cli("worker", "--check")
        assert hanging.returncode == 9 and "see its log" in hanging.stderr
        os.kill(worker.pid, signal.SIGCONT)
    finally:
        worker.send_signal(signal.SIGTERM)
        assert worker.wait(timeout=WAIT_SECONDS) == 0
        cli("down")
    assert cli("worker", "--check").returncode == 9


def test_the_checks_import_nothing_heavy(settings):
    """Broken where a health check takes a second of a busy core, and a working container is called unhealthy."""
    script = (
        "import sys, runpy\n"
        "sys.argv = ['garmentq', sys.argv[1], '--check']\n"
        "try:\n    runpy.run_module('garmentq.cli.main', run_name='__main__')\n"
        "except SystemExit as end:\n    print(end.code)\n"
        "heavy = 'torch numpy scipy numba open3d igl trimesh celery sqlalchemy rich redis fastapi alembic'.split()\n"
        "print(sorted(set(heavy) & set(sys.modules)))\n"
    )
    for name in ("worker", "courier"):
        command = [sys.executable, "-c", script, name]
        done = subprocess.run(
            command, capture_output=True, text=True, check=True, env=make_environment(settings), timeout=WAIT_SECONDS
        )
        assert done.stdout.splitlines() == ["9", "[]"], done
