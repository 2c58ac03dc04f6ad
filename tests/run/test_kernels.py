"""Compiled kernels on the disk and the update of the package."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

SOURCE = """
from typing import NamedTuple
from garmentq.core.run.kernels import kernel

class {name}(NamedTuple):
    first: int
    second: int

@kernel()
def add(pair):
    return {factor} * pair.first + pair.second

print(add({name}(3, 4)), sum(add.stats.cache_hits.values()))
"""


def run(folder: Path, name: str, factor: int) -> list[int]:
    """Return what a process that writes the module and calls its kernel prints: the result, and the cache's hits."""
    path = folder / "measured.py"
    text = SOURCE.format(name=name, factor=factor)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)
    variables = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache")}
    done = subprocess.run([sys.executable, "-c", "import measured"], cwd=folder, env=variables, capture_output=True,
                          text=True)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return [int(word) for word in done.stdout.split()]


def test_kernels_are_loaded_or_compiled_anew_after_an_update(tmp_path: Path) -> None:
    """Broken where a kernel is compiled in each process, one of an older version is used, or its lost type raises."""
    assert run(tmp_path, "Pair", 10) == [34, 0]
    assert run(tmp_path, "Pair", 10) == [34, 1]
    assert run(tmp_path, "Couple", 100) == [304, 0]
    assert run(tmp_path, "Couple", 100) == [304, 1]
