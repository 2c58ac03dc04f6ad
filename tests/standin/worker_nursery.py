"""Fork workers from a process that has imported all they need: a start takes 50 ms, not a second of a core.

A worker that starts here runs `garmentq worker` in a session of its own, as one that was started by its command does;
only the imports are done. `tests/workers` starts some by the command itself.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import traceback
from pathlib import Path

from patience import WAIT_SECONDS

PRELOADED = (
    "garmentq.cli.main", "garmentq.cli.worker", "garmentq.workers.worker", "garmentq.workers.embedded",
    "garmentq_standin", "celery.apps.worker", "celery.worker.components", "celery.worker.consumer",
    "celery.concurrency.prefork", "celery.fixups.django", "kombu.transport.redis", "redis", "psycopg", "sqlite3",
    "sqlalchemy.dialects.postgresql.psycopg", "sqlalchemy.dialects.sqlite",
)  # fmt: skip
"""What a worker imports until its first job; none of it starts a thread or opens anything."""


class Nursery:
    """Own the process that forks; its workers are asked for by `start`."""

    def __init__(self, environment: dict[str, str]) -> None:
        """Start it; the imports go on while the caller does other things."""
        single = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        command = [sys.executable, __file__]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, env=environment | single, stdin=pipe, stdout=pipe, text=True)

    def start(self, arguments: list[str], environment: dict[str, str], log: Path) -> Worker:
        """Start `garmentq worker` with some arguments, and its output added to a log."""
        return Worker(self, self.ask({"arguments": arguments, "environment": environment, "log": str(log)}))

    def ask(self, question: dict[str, object]) -> int | None:
        """Send one question and give its answer."""
        self._process.stdin.write(json.dumps(question) + "\n")
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())

    def end(self) -> None:
        """End it; workers that still run are left alone."""
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()


class Worker:
    """Stand for a started worker as `subprocess.Popen` does."""

    def __init__(self, nursery: Nursery, pid: int) -> None:
        self._nursery, self.pid, self.returncode = nursery, pid, None

    def poll(self) -> int | None:
        """Return the exit status (minus the signal's number), or None while it runs."""
        if self.returncode is None:
            self.returncode = self._nursery.ask({"poll": self.pid})
        return self.returncode

    def wait(self, timeout: float = WAIT_SECONDS) -> int:
        """Wait for its end."""
        deadline = time.monotonic() + timeout
        while self.poll() is None:
            assert time.monotonic() < deadline, "the worker does not end"
            time.sleep(0.01)
        return self.returncode

    def terminate(self) -> None:
        """Tell it to stop."""
        if self.poll() is None:
            os.kill(self.pid, signal.SIGTERM)


def be_worker(arguments: list[str], environment: dict[str, str], log: str) -> None:
    """Become a worker."""
    os.setsid()
    for descriptor, path, flags in ((0, os.devnull, os.O_RDONLY), (1, log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)):
        opened = os.open(path, flags, 0o600)
        os.dup2(opened, descriptor)
        os.close(opened)
    os.dup2(1, 2)
    os.environ.clear()
    os.environ.update(environment)
    from garmentq.cli.main import main

    try:
        main(["worker", *arguments])
    except SystemExit as end:
        sys.stderr.flush()
        os._exit(int(end.code or 0))
    except BaseException:
        traceback.print_exc()
    os._exit(1)


def serve() -> None:
    """Answer questions until there are no more."""
    import importlib

    for name in PRELOADED:
        importlib.import_module(name)
    for line in sys.stdin:
        question = json.loads(line)
        if "poll" in question:
            pid, status = os.waitpid(question["poll"], os.WNOHANG)
            answer = os.waitstatus_to_exitcode(status) if pid else None
        else:
            answer = os.fork()
            if answer == 0:
                be_worker(**question)
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    serve()
