"""A limited process: what it sees, what stops it, and what comes back of what it says."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from garmentq.core.run.errors import BadInput, Cancelled
from garmentq.core.run.sandbox import (
    Bounds,
    InputTookTooLong,
    InputTooLarge,
    ReaderCrashed,
    call_limited,
)

MB = 1024**2


def call(name: str, bounds: Bounds | None = None, **arguments):
    """Call one of the stand-ins."""
    return call_limited(f"limited_calls:{name}", arguments, bounds)


def wait_gone(mark: Path) -> None:
    """Wait until the process whose id is in a file is gone; the suite's own limit ends a test that hangs."""
    while True:
        try:
            os.kill(int(mark.read_text()), 0)
        except ProcessLookupError:
            return
        stat = Path(f"/proc/{mark.read_text()}/stat")
        if stat.exists() and stat.read_text().rsplit(")", 1)[1].split()[0] == "Z":
            return
        time.sleep(0.02)


def test_it_sees_nothing_of_ours(monkeypatch):
    """Broken where a reader that a file took over finds a key, or our folder; or where print garbles the answer."""
    monkeypatch.setenv("GARMENTQ_DATABASE_URL", "postgresql://secret")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "secret")
    found = call("echo", word="é", number=1.5, nothing=None).result
    assert found["arguments"] == {"word": "é", "number": 1.5, "nothing": None}
    assert {name for name in found["environment"] if not name.endswith("_NUM_THREADS")} <= {
        "PATH", "LANG", "LC_CTYPE", "HOME", "TMPDIR", "__CF_USER_TEXT_ENCODING",
    }  # fmt: skip
    assert "secret" not in str(found) and found["folder"] != os.getcwd() and not Path(found["folder"]).exists()
    assert found["session"] != os.getsid(0)


@pytest.mark.parametrize(
    ("name", "arguments", "bounds", "code"),
    [
        ("sleep", {}, Bounds(wall_seconds=0.5), InputTookTooLong.code),
        ("spin", {}, Bounds(cpu_seconds=1), InputTookTooLong.code),
        ("fill", {"size": 800 * MB}, Bounds(memory_bytes=400 * MB), InputTooLarge.code),
        ("fill_measured", {"size": 800 * MB, "limit": 100 * MB}, Bounds(), InputTooLarge.code),
        ("write", {"size": MB}, Bounds(output_bytes=MB // 2), InputTooLarge.code),
        ("talk", {"size": MB}, Bounds(answer_bytes=MB // 2), ReaderCrashed.code),
        ("die", {"number": signal.SIGSEGV}, Bounds(), ReaderCrashed.code),
        ("die", {"number": signal.SIGKILL}, Bounds(), InputTooLarge.code),
        ("divide", {}, Bounds(), ReaderCrashed.code),
        ("nosuch", {}, Bounds(), ReaderCrashed.code),
        ("odd", {}, Bounds(), ReaderCrashed.code),
        ("refuse", {}, Bounds(), "scan.truncated"),
        ("refuse_oddly", {}, Bounds(), "scan.truncated"),
    ],
)
def test_every_end_has_a_code(tmp_path, name, arguments, bounds, code):
    """Broken where a bomb, an endless reader or a crash is a traceback, a wrong code, or no refusal at all."""
    more = {"path": str(tmp_path / "out")} if name == "write" else {}
    with pytest.raises(BadInput) as refused:
        call(name, bounds, **arguments, **more)
    assert refused.value.code == code
    assert refused.value.message.endswith((".", "help.")) and ";" in refused.value.message
    assert refused.value.message.isprintable()


def test_what_is_no_longer_wanted_is_killed(tmp_path):
    """Broken where a cancelled job waits for its reader, or the reader lives on."""
    mark = tmp_path / "pid"
    with pytest.raises(Cancelled):
        call_limited("limited_calls:sleep", {"mark": str(mark)}, is_stopped=mark.exists)
    with pytest.raises(ProcessLookupError):
        os.kill(int(mark.read_text()), 0)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere an alarm ends it a while after its deadline")
def test_it_dies_with_its_parent(tmp_path):
    """Broken where a reader outlives the worker that was killed above it."""
    mark = tmp_path / "pid"
    code = "from test_limited import call; call('sleep', mark=" + repr(str(mark)) + ")"
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    parent = subprocess.Popen([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": path})
    try:
        while not (mark.exists() and mark.read_text()):
            time.sleep(0.02)
    finally:
        parent.kill()
        parent.wait()
    wait_gone(mark)


def test_what_it_started_ends_with_it(tmp_path):
    """Broken where a reader that ends well leaves a process behind that goes on without any deadline."""
    mark = tmp_path / "pid"
    call("leave", mark=str(mark))
    wait_gone(mark)


def test_its_folder_is_where_it_is_wanted(tmp_path):
    """Broken where what a killed worker's reader wrote is left in the system's folder, where nobody removes it."""
    found = call_limited("limited_calls:echo", {}, folder=tmp_path).result
    assert Path(found["folder"]).parent == tmp_path and not list(tmp_path.iterdir())


def test_a_lower_limit_of_ours_is_no_crash():
    """Broken where a worker whose own CPU time is limited cannot read any file."""
    limit = "import resource; resource.setrlimit(resource.RLIMIT_CPU, (60, 60))"
    code = f"{limit}; from test_limited import call; call('echo')"
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": path}, check=True)
