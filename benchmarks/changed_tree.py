"""A copy of the checkout in which one place is changed at a time, and what runs in it.

Compiled kernels are copied with the sources, so that a change costs the compilation of what it touches alone.
"""

from __future__ import annotations

import json
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]

COMPILED = (".nbi", ".nbc")
"""Ends of the names of numba's index and code files."""

COLUMNS = "500"
"""Width in which pytest may tell of a failure [letters]: in the usual 80 the test's name has no room for the number."""

WALL_PER_CPU = 6.0
"""A run is stopped after this many times its seconds of CPU, as a share of a core that a busy machine leaves it [1]."""

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def make_environment(root: Path) -> dict[str, str]:
    """Return the variables of a process of one thread that imports the package from a folder named `garmentq`."""
    search = [] if root == ROOT else [str(root.parent)]  # the checkout itself is installed under the package's name
    shared = str(root / "benchmarks")  # the scenes import from it
    path = os.pathsep.join([*search, shared, *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, **dict.fromkeys(THREADS, "1"), "PYTHONPATH": path}


@dataclass(frozen=True)
class Outcome:
    """Describe a run of pytest.

    Attributes:
        is_caught: Whether a test failed.
        is_cut_short: Whether it was stopped before its end.
        told: The line of the first failure, or the last line.
    """

    is_caught: bool
    is_cut_short: bool
    told: str


@dataclass(frozen=True)
class ChangedTree:
    """A copy of the checkout.

    Attributes:
        root: The package's folder, named `garmentq`.
    """

    root: Path

    @classmethod
    def copy(cls, folder: Path) -> ChangedTree:
        """Copy the tracked and the new files of the checkout, with what was compiled of them, into a folder."""
        shutil.rmtree(folder, ignore_errors=True)
        asked = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
        names = subprocess.run(asked, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
        compiled = [path.relative_to(ROOT) for end in COMPILED for path in (ROOT / "core").rglob(f"*{end}")]
        root = folder / "garmentq"
        for name in [*map(Path, names), *compiled]:
            if (ROOT / name).is_file():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, root / name)
        return cls(root)

    @contextmanager
    def changed(self, name: str, text: str, words: Sequence[str] = ()) -> Iterator[None]:
        """Have one file hold another text for a while.

        Args:
            name: Of the file, from the package's folder.
            text: What it holds.
            words: Names whose value changes: kernels of other files that use one are compiled anew.
        """
        path = self.root / name
        before, stat = path.read_bytes(), path.stat()
        users = [path, *self._list_users(words)] if words else [path]
        kept = {each: each.read_bytes() for user in users for each in _list_compiled(user)}
        for each in kept:
            each.unlink()
        path.write_text(text)
        try:
            yield
        finally:
            path.write_bytes(before)
            os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
            for user in users:
                for each in _list_compiled(user):
                    each.unlink()
            for each, content in kept.items():
                each.write_bytes(content)

    def _list_users(self, words: Sequence[str]) -> list[Path]:
        found = []
        for path in (self.root / "core").rglob("*.py"):
            text = path.read_text()
            if "kernel(" in text and any(word in text for word in words):
                found.append(path)
        return found

    def test(self, arguments: Sequence[str], seconds: float) -> Outcome:
        """Run pytest in the copy up to its first failure.

        Args:
            arguments: Files and options.
            seconds: It is stopped after these, of CPU; what its children take does not count.
        """
        environment = {**make_environment(self.root), "COLUMNS": COLUMNS}
        line = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider", *arguments]
        try:
            ran = subprocess.run(
                ["bash", "-c", f'ulimit -t {seconds:.0f}; exec "$@"', "limited", *line],
                cwd=self.root,
                env=environment,
                capture_output=True,
                text=True,
                timeout=WALL_PER_CPU * seconds,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return Outcome(False, True, f"stopped after {WALL_PER_CPU * seconds:.0f} s")
        if -ran.returncode in (signal.SIGXCPU, signal.SIGKILL):
            return Outcome(False, True, f"stopped after {seconds:.0f} s of CPU")
        lines = ran.stdout.strip().splitlines() or [ran.stderr[-200:]]
        failed = next((each for each in lines if re.match(r"(FAILED|ERROR) tests/", each)), lines[-1])
        return Outcome(ran.returncode not in (0, 5), False, failed[:240])  # 5: no test was chosen


def try_all(
    folder: Path,
    names: Sequence[str],
    attempt: Callable[[ChangedTree, str], dict[str, Any]],
    minutes: float,
    processes: int,
) -> dict[str, dict[str, Any]]:
    """Return what each attempt told, by its name; those that were not begun in time are missing.

    Args:
        folder: What was told is kept here in a file of the attempt's name, and not asked again; copies lie beside it.
        names: Of the attempts.
        attempt: Tells of one in a copy of the checkout, as JSON can hold it.
        minutes: No attempt is begun later.
        processes: Attempts at a time, each in a copy of its own.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = {name: folder / f"{name}.json" for name in names}
    end = time.monotonic() + 60.0 * minutes
    trees: queue.Queue[ChangedTree] = queue.Queue()
    for n in range(0 if all(file.exists() for file in files.values()) else processes):
        trees.put(ChangedTree.copy(folder / f"tree{n}"))

    def work(name: str) -> dict[str, Any] | None:
        if files[name].exists():
            told: dict[str, Any] = json.loads(files[name].read_text())
            return told
        if time.monotonic() > end:
            return None
        tree = trees.get()
        try:
            told = attempt(tree, name)
        finally:
            trees.put(tree)
        files[name].write_text(json.dumps(told))
        return told

    with ThreadPoolExecutor(processes) as pool:
        found = dict(zip(names, pool.map(work, names), strict=True))
    return {name: told for name, told in found.items() if told is not None}


def _list_compiled(path: Path) -> list[Path]:
    folder = path.parent / "__pycache__"
    return [each for end in COMPILED for each in folder.glob(f"{path.stem}.*{end}")]
