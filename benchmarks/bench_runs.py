"""Run `garmentq bench` with a commit's own code over packs of any kind, one target at a time; what was run stays.

A checkout of each commit and the line of each target are kept below a folder: a second call goes on where a first one
was stopped. All commits run in the environment of the caller.
"""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from changed_tree import ROOT, make_environment
from garmentq.core.scan.open3d_library import load_open3d

MOVED = 1e-12
"""Standard deviation by which a scan is moved to see what rounding does to a recovery [m]."""

MODES: Mapping[str, tuple[str, ...]] = {
    "base": (), "library": ("--library",), "preview": ("--library", "--method", "deform"),
}  # fmt: skip
"""Options of the bench by which base pattern is given: the maker's, or none, so that the library's are taken; and
without a fit through the simulator."""

Line = dict[str, Any]


@dataclass(frozen=True)
class Version:
    """A state of the project's code.

    Attributes:
        name: Ten digits of the commit, or of a hash of the tree where that is not committed.
        root: The package's folder.
    """

    name: str
    root: Path


@dataclass(frozen=True)
class Job:
    """Run one target once.

    Attributes:
        version: Whose code.
        pack: Its folder.
        mode: One of `MODES`.
        shift: 0: as it is; else the seed by which the scan is moved by `MOVED`.
    """

    version: Version
    pack: Path
    mode: str
    shift: int = 0

    @property
    def place(self) -> Path:
        """Return where its line and its results are, below the folder of all."""
        shifted = f"-moved{self.shift}" if self.shift else ""
        return Path(self.version.name) / f"{self.mode}{shifted}" / self.pack.name


def find_version(commit: str | None, out: Path) -> Version:
    """Return a commit's code, checked out below a folder; without a commit HEAD's, or the tree where that differs."""
    changed = _git("diff", "HEAD", "--", "core", "service", "workers", "cli", "pyproject.toml")
    if commit is None and changed:
        return Version("tree-" + hashlib.sha256(changed.encode()).hexdigest()[:10], ROOT)
    name = _git("rev-parse", "--short=10", commit or "HEAD").strip()
    root = out / "commits" / name / "garmentq"
    if not root.exists():
        root.parent.mkdir(parents=True, exist_ok=True)
        _git("worktree", "prune")
        _git("worktree", "add", "--detach", str(root.resolve()), name)
    return Version(name, root)


def _git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout


def run_jobs(jobs: Iterable[Job], out: Path, processes: int) -> list[Line]:
    """Run what has no line yet and return the lines of all, in the order of the jobs.

    Args:
        jobs: What to run.
        out: Folder of lines and results.
        processes: How many run at a time.
    """
    with ThreadPoolExecutor(processes) as pool:
        return list(pool.map(lambda job: run_job(job, out), jobs))


def run_job(job: Job, out: Path) -> Line:
    """Return the line of a target, of an earlier run where there is one."""
    path = out / job.place / "line.json"
    if path.exists():
        found: Line = json.loads(path.read_text())
        return found
    folder = path.parent
    folder.mkdir(parents=True, exist_ok=True)
    pack = move_pack(job.pack, folder / "moved" / job.pack.name, job.shift) if job.shift else job.pack
    line = [sys.executable, "-m", "garmentq.cli.main", "bench", pack.parent, "--only", pack.name, *MODES[job.mode]]
    ran = subprocess.run(
        [*map(str, line), "--json", "--out", str(folder / "result")],
        env=make_environment(job.version.root), cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    (folder / "log.txt").write_text(ran.stderr)
    told = [json.loads(each) for each in ran.stdout.splitlines() if each.startswith("{")]
    if not told:
        raise RuntimeError(f"the bench of {job.place} told nothing: {ran.stderr[-600:]}")
    found = told[0] | {"mode": job.mode, "shift": job.shift, "version": job.version.name}
    path.write_text(json.dumps(found))
    print(f"{job.place}: {found['cpu_seconds']:.0f} s", file=sys.stderr, flush=True)
    return found


def move_pack(pack: Path, out: Path, seed: int) -> Path:
    """Copy a pack with the points of its scan moved by rounding, which double precision keeps, and return the copy."""
    if out.exists():
        return out
    out.mkdir(parents=True)
    for path in pack.iterdir():
        if path.name != "preview.png":
            (out / path.name).symlink_to(path.resolve())
    name = "scan.ply" if (pack / "scan.ply").exists() else "garment.ply"
    (out / name).unlink()
    rng = np.random.default_rng(seed)
    open3d = load_open3d()
    mesh = open3d.io.read_triangle_mesh(str(pack / name))
    if len(mesh.triangles):
        points = np.asarray(mesh.vertices)
        mesh.vertices = open3d.utility.Vector3dVector(points + rng.normal(0.0, MOVED, points.shape))
        open3d.io.write_triangle_mesh(str(out / name), mesh)
        return out
    cloud = open3d.io.read_point_cloud(str(pack / name))
    points = np.asarray(cloud.points)
    cloud.points = open3d.utility.Vector3dVector(points + rng.normal(0.0, MOVED, points.shape))
    open3d.io.write_point_cloud(str(out / name), cloud)
    return out
