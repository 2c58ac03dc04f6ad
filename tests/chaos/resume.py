"""Kill a real recovery after its checkpoints, resume it, and compare it with one that was left alone (fault R16).

    python tests/chaos/resume.py [--method deform|hybrid|inverse] [--vertices 500] [--every 1] [--builtin] [--preempt]

Each attempt is a process that claims the job and runs the real pipeline on it; it ends itself by `kill -9` right after
the first checkpoint that it kept (or the second, with `--every 2`), so the job goes on from each of them in turn. The
scan is a flared tube around the built-in body's hips; the body is given as a mesh and registered, or with `--builtin`
not. With `--preempt` no process is killed: the job is marked after that checkpoint, and gives way at the next.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "standin"))

from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import Recovery, Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.run.hooks import Hooks
from garmentq.service.database import Database, open_database
from garmentq.service.jobs import find_job
from garmentq.service.models import JobRow
from garmentq.service.reaper import reap, release_lost_leases
from garmentq.service.requeueing import PREEMPTED_EVENT
from garmentq.service.results import export_files
from garmentq.service.settings import ServiceSettings, read_settings
from garmentq.service.store import Store
from garmentq.service.submission import Order, submit
from garmentq.service.terms import JobTerms

WEARER = "builtin:female,height=1.68,pose=A"
HIPS = 0.85
"""Height [m] of the widest place; below it the skirt only flares."""

MARK = "resume"
ATTEMPTS = 500
"""More than any run has checkpoints: none may be dead here."""


def write_files(folder: Path) -> tuple[Path, Path]:
    """Write the scan of a flared skirt, rings around the wearer's hips that widen below them, and the wearer's mesh."""
    import trimesh

    body = builtin_body(WEARER)
    angles, heights = np.linspace(0.0, 2.0 * np.pi, 73)[:-1], np.linspace(1.03, 0.55, 33)
    around = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    rings = []
    for height in heights:
        level = max(height, HIPS)
        near = (np.abs(body.vertices[:, 1] - level) < 0.03) & (np.abs(body.vertices[:, 0]) < 0.25)
        low, high = body.vertices[near][:, [0, 2]].min(axis=0), body.vertices[near][:, [0, 2]].max(axis=0)
        ring = 0.5 * (low + high) + around * (0.5 * (high - low) + 0.012 + 0.25 * (level - height))
        rings.append(np.insert(ring, 1, height, axis=1))
    count = len(angles)
    one = np.add.outer(count * np.arange(len(heights) - 1), np.arange(count)).ravel()
    next_one = one - one % count + (one + 1) % count
    faces = np.concatenate([np.c_[one, one + count, next_one], np.c_[next_one, one + count, next_one + count]])
    scan, wearer = folder / "skirt.ply", folder / "body.ply"
    trimesh.Trimesh(np.concatenate(rings), faces, process=False).export(scan)
    trimesh.Trimesh(body.vertices, body.faces, process=False).export(wearer)
    return scan, wearer


def recover_and_die(request: Request, hooks: Hooks) -> Recovery:
    """Recover; kill this process after the checkpoint that RESUME_EVERY counts to, or never where that is 0."""
    saved = Counter()

    def save(name: str, arrays) -> None:
        hooks.save_checkpoint(name, arrays)
        saved["all"] += 1
        if saved["all"] == int(os.environ["RESUME_EVERY"]):
            sys.stdout.write(f"{name}\n")
            sys.stdout.flush()
            if os.environ["RESUME_PREEMPTS"]:
                mark_job()
            else:
                os.kill(os.getpid(), signal.SIGKILL)

    return recover(request, replace(hooks, save_checkpoint=save))


def mark_job() -> None:
    """Mark the job as one that is to give way, and wait until its worker has seen that."""
    settings = read_settings()
    database = Database(settings.database)
    with database.write() as session:
        session.get_one(JobRow, os.environ["RESUME_JOB"]).preempt = True
    database.dispose()
    time.sleep(3.0 * settings.poll_seconds)


def write_arrays(recovery: Recovery, folder: Path) -> list[Path]:
    """Write what is compared."""
    path = folder / "arrays.npz"
    arrays = {
        "detail": recovery.meshes.detail,
        "graded": recovery.meshes.graded,
        "simulation": np.zeros((0, 3)) if recovery.meshes.simulation is None else recovery.meshes.simulation,
        "points": recovery.pattern.points,
        "fabric": np.array([recovery.fabric.k, recovery.fabric.density]),
    }
    np.savez(path, **arrays)
    return [path]


def attempt() -> None:
    """Work on one queued job: what a child process does."""
    from garmentq.workers.recovery import run_job

    settings = read_settings()
    database = Database(settings.database)
    outcome = run_job(settings, database, os.environ["RESUME_JOB"], lambda: False, MARK)
    sys.stdout.write(f"{outcome}\n")


def run_to_end(settings: ServiceSettings, database: Database, job: str, every: int, preempts: bool) -> list[str]:
    """Run attempts until one is not killed or preempted, and give the checkpoints after which the others were."""
    path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    told = {"RESUME_EVERY": str(every), "RESUME_JOB": job, "PYTHONPATH": path, "RESUME_PREEMPTS": "1" * preempts}
    command, killed = [sys.executable, "-c", "import resume; resume.attempt()"], []
    while True:
        environment = {**os.environ, **settings.as_environment(), **told}
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=False)
        words = done.stdout.split()
        if done.returncode == 0 and words[-1] == PREEMPTED_EVENT:
            killed.append(words[0])
            continue
        if done.returncode != -signal.SIGKILL:
            return killed
        killed.append(words[-1])
        release_lost_leases(database, MARK, "signal 9 (SIGKILL)")
        assert reap(database, ATTEMPTS) == 1


def compare(
    method: str, vertices: int, every: int, home: Path, is_registered: bool = True, preempts: bool = False
) -> dict[str, object]:
    """Recover twice, once with kills or preemptions, and give the largest differences."""
    settings = ServiceSettings(home=home, pipeline="resume:recover_and_die", writer="resume:write_arrays")
    database, store = open_database(settings), Store(settings.store_path)
    scan, mesh = write_files(home)
    wearer = mesh if is_registered else BuiltinWearer(WEARER)
    wanted = RecoverySettings(method=method, vertex_count=vertices)
    found: dict[str, object] = {"method": method, "vertices": vertices}
    arrays, jobs = [], []
    for name, count in (("alone", 0), ("killed", every)):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        jobs.append(submit(database, store, Order(scan, wearer, settings=wanted, terms=JobTerms(force=True))).job)
        killed = run_to_end(settings, database, jobs[-1], count, preempts)
        row, after = find_job(database, jobs[-1]), resource.getrusage(resource.RUSAGE_CHILDREN)
        assert row.state == "succeeded", f"{row.error_code}: {row.error_message}"
        assert not preempts or (row.attempts, row.preemptions) == (1, len(killed))
        found[f"stages {name}"] = row.result["stage_seconds"]
        found[f"cpu seconds {name}"] = round(after.ru_utime - before.ru_utime, 1)
        [path] = export_files(database, store, jobs[-1], home / name)
        arrays.append(np.load(path))
    found["stopped after"] = dict(Counter(killed))
    for name in arrays[0].files:
        one, other = (np.asarray(each[name]) for each in arrays)
        found[f"difference of {name}"] = (
            float(np.abs(one - other).max(initial=0.0)) if one.shape == other.shape else None
        )
    database.dispose()
    return found


def main() -> int:
    """Compare once; exit status 0 where nothing differs by more than 1e-6."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--method", choices=["deform", "hybrid", "inverse"], default="deform")
    parser.add_argument("--vertices", type=int, default=500)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--builtin", action="store_true", help="take the built-in body, which needs no registration")
    parser.add_argument("--preempt", action="store_true", help="let the job give way instead of killing its process")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="gq-resume-") as folder:
        found = compare(given.method, given.vertices, given.every, Path(folder), not given.builtin, given.preempt)
    for name, value in found.items():
        sys.stdout.write(f"{name:28} {value}\n")
    differences = [value for name, value in found.items() if name.startswith("difference")]
    return int(any(value is None or value > 1e-6 for value in differences))


if __name__ == "__main__":
    sys.exit(main())
