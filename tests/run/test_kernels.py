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


LENGTH = """
from garmentq.core.run.kernels import kernel

@kernel()
def double(x):
    return {factor} * x
"""

USER = """
from garmentq.core.run.kernels import kernel
from length import double
from constant import OFFSET

@kernel()
def move(x):
    return double(x) + OFFSET

print(move(3), sum(move.stats.cache_hits.values()))
"""


def test_a_kernel_is_compiled_anew_where_what_it_uses_changed(tmp_path: Path) -> None:
    """Broken where a kernel keeps the code of another file's kernel, or another file's constant, as it was before."""
    variables = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    (tmp_path / "user.py").write_text(USER)
    for factor, offset, told in ((2, 1, "7 0"), (2, 1, "7 1"), (3, 1, "10 0"), (3, 2, "11 0"), (3, 2, "11 1")):
        (tmp_path / "length.py").write_text(LENGTH.format(factor=factor))
        (tmp_path / "constant.py").write_text(f"OFFSET = {offset}\n")
        done = subprocess.run([sys.executable, "-B", "-c", "import user"], cwd=tmp_path, env=variables,
                              capture_output=True, text=True)  # fmt: skip
        assert done.stdout.strip() == told, done.stderr


def test_what_an_administrator_compiled_is_read(tmp_path: Path) -> None:
    """Broken where a user with an own cache compiles what the package's folder holds, or one without any fails."""
    variables = {**os.environ, "HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null/cache"}
    variables.pop("NUMBA_CACHE_DIR", None)
    (tmp_path / "length.py").write_text(LENGTH.format(factor=2) + "import sys; print(double(3 if sys.argv[1:] else 1.0)"
                                        ", sum(double.stats.cache_hits.values()))")  # fmt: skip

    def call(word: str = "", **changes: str) -> str:
        line = [sys.executable, "-B", "-c", "import length", *word.split()]
        done = subprocess.run(line, cwd=tmp_path, env=variables | changes, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    assert call() == "2.0 0"
    assert call(NUMBA_CACHE_DIR=str(tmp_path / "own")) == "2.0 1"
    (tmp_path / "__pycache__").rename(tmp_path / "kept")
    (tmp_path / "__pycache__").write_text("where nothing can be written, not even by root")
    assert call("whole") == "6 0" and call("whole") == "6 0"
