"""Kernels compiled ahead of the first job."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from garmentq.workers.kernels import KernelCall, KernelTableBad, read_table
from kernel_calls import list_kernels
from numba import njit, types
from numba.core.dispatcher import Dispatcher

RECOVER = """
import sys, numpy as np, trimesh
from pathlib import Path
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.deliver.export.result import write_recovery
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings

angles, heights = np.linspace(0.0, 2.0 * np.pi, 73)[:-1], np.linspace(1.03, 0.55, 33)
around = np.stack([np.sin(angles), np.cos(angles)], axis=1)
rings = [np.c_[r * around[:, 0], np.full(72, y), 0.8 * r * around[:, 1]]
         for y, r in zip(heights, 0.17 + 0.22 * (1.03 - heights))]
a = np.arange(72)
b = (a + 1) % 72
faces = [f for n in range(32) for f in (np.c_[a, a + 72, b] + 72 * n, np.c_[b, a + 72, b + 72] + 72 * n)]
folder = Path(sys.argv[1])
trimesh.Trimesh(np.concatenate(rings), np.concatenate(faces), process=False).export(folder / "skirt.ply")
settings = RecoverySettings(method=sys.argv[2], vertex_count=500)
wearer = BuiltinWearer("builtin:female,height=1.68,pose=A")
write_recovery(recover(Request(folder / "skirt.ply", wearer, settings=settings)), folder / "out")
assert "open3d" not in sys.modules, "only clouds need it"
"""
"""Recovers a small skirt, rings around the built-in wearer, and writes its files."""


def test_every_kernel_is_compiled_ahead():
    """Broken where a kernel is added that the first job compiles, or one is gone that the table still names."""
    kernels = list(list_kernels())
    called = {name for one in kernels for name in one.py_func.__code__.co_names}
    named = {call.kernel for call in read_table()}
    assert all(isinstance(call.dispatcher, Dispatcher) for call in read_table())
    names = {f"{one.py_func.__module__.removeprefix('garmentq.')}:{one.py_func.__name__}" for one in kernels}
    assert {name for name in names - named if name.partition(":")[2] not in called} == set()


def test_a_call_is_written_and_read():
    """Broken where the table names a type otherwise than the kernel is called with: it would be compiled in vain."""
    for call in read_table():
        assert KernelCall.of(call.dispatcher, call.arguments) == call


def test_a_type_that_the_table_cannot_name_is_refused():
    """Broken where a kernel that is called with a list, or a view of a mesh, drops out of the table unnoticed."""
    kernel = njit(lambda x: x)
    for kind in (types.ListType(types.int64), types.Array(types.float64, 1, "C", readonly=True)):
        with pytest.raises(KernelTableBad, match="cannot name"):
            KernelCall.of(kernel, [kind])


def test_doctor_says_whether_kernels_are_compiled(cli, tmp_path):
    """Broken where an empty folder passes for compiled, or a client of a service is told of kernels."""

    def ask(*words: str, **variables: str) -> dict[str, str]:
        told = cli.start("doctor", "--json", *words, **variables).stdout.splitlines()
        return {row["check"]: row["message"] for row in map(json.loads, told)}

    (folder := tmp_path / "cache").mkdir()
    assert "are not compiled" in ask(NUMBA_CACHE_DIR=str(folder), NUMBA_CPU_NAME="generic")["kernels"]
    assert "kernels" not in ask(GARMENTQ_URL="http://127.0.0.1:9")
    assert "kernels" not in ask("--worker")


@pytest.mark.nightly
@pytest.mark.parametrize("method", ["deform", "hybrid"])
def test_the_first_job_compiles_nothing(cli, tmp_path, method):
    """Broken where `doctor --warm` leaves a kernel to the first recovery, or compiles what is there again."""
    # for another processor, since what the package's own folder holds would be read
    fresh = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "NUMBA_CPU_NAME": "generic"}

    def read_files() -> dict[Path, tuple[int, int]]:
        files = (tmp_path / "cache").rglob("*.nb?")
        return {path: (path.stat().st_mtime_ns, path.stat().st_size) for path in files}

    for told in (r"\d+ compiled in", "all "):
        done = cli.start("doctor", "--warm", "--json", **fresh)
        assert done.returncode == 0 and re.match(told, json.loads(done.stdout)["message"])
    before = read_files()
    subprocess.run([sys.executable, "-c", RECOVER, str(tmp_path), method], env={**os.environ, **fresh}, check=True)
    assert before and read_files() == before
