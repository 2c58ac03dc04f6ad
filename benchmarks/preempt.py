"""How soon an edit begins beside a batch on one worker.

    python benchmarks/preempt.py HOME [--edits 8] [--pause 30] [--persons 50]

A preview of the example's garment is made in a fresh home, and a batch of the example's person is queued. While the
worker works on it, an edit is queued time and again, and followed until its drape begins. For each edit one line has
what ran then, the wall time until the edit was claimed and until its drape began, the CPU time of the job's process in
between, and the load of the machine; a wait at full use of a core is that CPU time.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

from garmentq.core.body.spec import read_wearer
from garmentq.core.recover.settings import LATER, RecoverySettings, complete_by_quality
from garmentq.service.derived import DerivedOrder
from garmentq.service.local import LocalBackend
from garmentq.service.order import Order
from garmentq.service.settings import read_settings
from garmentq.service.states import ENDED, State
from garmentq.service.terms import JobTerms

DATA = Path(__file__).parents[1] / "examples" / "data"


def main() -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("home", type=Path)
    parser.add_argument("--edits", type=int, default=8)
    parser.add_argument("--pause", type=float, default=30.0)
    parser.add_argument("--persons", type=int, default=50)
    chosen = parser.parse_args()
    backend = LocalBackend(read_settings(home=chosen.home))
    garmentq = [sys.executable, "-m", "garmentq.cli.main"]
    os.environ["GARMENTQ_HOME"] = str(chosen.home)
    subprocess.run([*garmentq, "up", "--workers", "1"], check=True)
    try:
        measure(backend, chosen)
    finally:
        subprocess.run([*garmentq, "down"], check=False)


def measure(backend: LocalBackend, chosen: argparse.Namespace) -> None:
    """Queue the jobs, and print a line for each edit."""
    preview = RecoverySettings(**complete_by_quality("preview", {}))
    garment = Order(DATA / "garment.ply", read_wearer(str(DATA / "body.ply")), settings=preview)
    base = backend.submit(garment).job
    wait(backend, base)
    (pattern,) = backend.export_files(base, chosen.home / "base", ["pattern.json"])
    content = (DATA / "person.ply").read_bytes()
    for number in range(chosen.persons):
        scan = chosen.home / "base" / f"person{number}.ply"
        scan.write_bytes(content.replace(b"\nend_header", b"\ncomment %d\nend_header" % number, 1))
        later = RecoverySettings(redrape=LATER)
        backend.submit(Order(scan, None, settings=later, terms=JobTerms(tags=("batch",))))
    print("running  stage  overall  claimed_s  drape_s  cpu_s  load", flush=True)
    for _ in range(chosen.edits):
        time.sleep(chosen.pause)
        running = [job for job in backend.list_jobs() if job.state == State.RUNNING]
        edit = DerivedOrder("edit", base, files={"pattern": pattern}, terms=JobTerms(force=True))
        begun, spent = time.monotonic(), read_cpu(chosen.home)
        job = backend.submit_derived(edit).job
        claimed = draped = None
        while draped is None:
            kinds = {(event.kind, event.data.get("stage")) for event in backend.poll_events(job).events}
            now = time.monotonic() - begun
            claimed = now if claimed is None and ("started", None) in kinds else claimed
            draped = now if ("progress", "drape") in kinds else None
            time.sleep(0.05)
        shown = [(one.kind, one.stage, round(one.overall, 2)) for one in running] or [("-", "-", 0.0)]
        print(
            *shown[0],
            f"{claimed:.1f} {draped:.1f} {read_cpu(chosen.home) - spent:.1f} {os.getloadavg()[0]:.1f}",
            flush=True,
        )
        wait(backend, job)


def wait(backend: LocalBackend, job: str) -> None:
    """Wait until a job has ended."""
    while backend.find_job(job).state not in ENDED:
        time.sleep(0.5)


def read_cpu(home: Path) -> float:
    """Return the CPU time of all living processes of a home [s]."""
    spent, mark = 0, f"GARMENTQ_HOME={home}".encode()
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if mark in (folder / "environ").read_bytes():
                words = (folder / "stat").read_text().rsplit(")", 1)[1].split()
                spent += int(words[11]) + int(words[12])  # user and system
    return spent / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()
