"""Run each target of a bench in a process of its own, to measure its memory and time and to survive a crash."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from .lines import Line


def run_in_process(module: str, order: Any, line: Line, timeout: float) -> Line:
    """Run one target in a process of its own, and return its line in every case.

    Args:
        module: Module of this package that reads ORDER.json and writes LINE.json.
        order: The record that the module reads.
        line: Returned, with the error and the CPU seconds, if the process writes no line.
        timeout: Time limit [s].
    """
    before = _children_seconds()
    with tempfile.TemporaryDirectory(prefix="garmentq-bench-") as folder:
        paths = [Path(folder) / name for name in ("order.json", "line.json", "log.txt")]
        paths[0].write_text(json.dumps(asdict(order)), encoding="utf-8")
        process = [sys.executable, "-m", f"garmentq.cli.bench.{module}", str(paths[0]), str(paths[1])]
        status = "no status"
        try:
            with paths[2].open("wb") as log:
                ended = subprocess.run(process, stdout=log, stderr=log, timeout=timeout, env=one_thread())
            status = f"signal {-ended.returncode}" if ended.returncode < 0 else f"status {ended.returncode}"
            finished: Line = json.loads(paths[1].read_text(encoding="utf-8"))
            if not finished["ok"]:
                click.echo(paths[2].read_text(encoding="utf-8", errors="replace"), err=True, nl=False)
            return finished
        except subprocess.TimeoutExpired:
            line["error"] = {"code": "bench.timed_out", "message": f"stopped after {timeout:.0f} s; raise --timeout."}
        except (OSError, ValueError):  # it wrote no line, or an incomplete one
            words = paths[2].read_text(encoding="utf-8", errors="replace").strip().splitlines()
            message = ": ".join([f"the process ended with {status}", *words[-1:]])
            line["error"] = {"code": "bench.crashed", "message": message}
    line["cpu_seconds"] = _children_seconds() - before
    return line


def one_thread() -> dict[str, str]:
    """Return the environment with one thread, so that CPU seconds are comparable between machines."""
    threads = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    return dict(os.environ) | dict.fromkeys(threads, "1")


def _children_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
