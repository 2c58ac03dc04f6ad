"""What the tests call in a limited process: sleepers, spinners, and those that take too much."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from garmentq.core.run.errors import BadInput


class Refused(BadInput):
    """The file is cut off; export it again."""

    code = "scan.truncated"


def echo(**arguments: Any) -> dict[str, Any]:
    """Return the arguments and what the process sees of its surroundings; print something beside the answer."""
    sys.stdout.write("not an answer")
    return {"arguments": arguments, "environment": dict(os.environ), "folder": os.getcwd(), "session": os.getsid(0)}


def refuse() -> dict[str, Any]:
    """Refuse with a code of its own."""
    raise Refused()


def divide() -> dict[str, Any]:
    """Have a bug."""
    return {"found": 1 / 0}


def sleep(mark: str = "") -> dict[str, Any]:
    """Wait for ever, after writing the own process id."""
    if mark:
        Path(mark).write_text(str(os.getpid()))
    while True:
        time.sleep(60.0)


def hold(source: str) -> dict[str, Any]:
    """Take a pattern's document for sound once the folder that it names holds a file `go`; note the process there."""
    folder = Path(json.loads(Path(source).read_text())["properties"]["folder"])
    (folder / f"{os.getpid()}.pid").touch()
    while not (folder / "go").exists():
        time.sleep(0.05)
    return {"is_sound": True, "findings": [], "panels": [], "seams": [], "mirrors": []}


def spin() -> dict[str, Any]:
    """Compute for ever."""
    while True:
        pass


def fill(size: int) -> dict[str, Any]:
    """Take memory."""
    return {"size": len(bytearray(size))}


def fill_measured(size: int, limit: int) -> dict[str, Any]:
    """Take memory slowly where the system keeps no limit."""
    from garmentq.core.run.sandbox import limit_memory

    limit_memory(limit, by_system=False)
    held = []
    for _ in range(size >> 20):
        held.append(bytearray(os.urandom(1 << 20)))
        time.sleep(0.005)
    return {"size": len(held)}


def write(path: str, size: int) -> dict[str, Any]:
    """Write a file."""
    Path(path).write_bytes(bytes(size))
    return {}


def talk(size: int) -> dict[str, Any]:
    """Answer at length."""
    return {"words": "a" * size}


def die(number: int) -> dict[str, Any]:
    """Die of a signal."""
    os.kill(os.getpid(), number)
    return {}


def odd() -> dict[str, Any]:
    """Answer with what is no number."""
    return {"size": float("nan")}


def refuse_oddly() -> dict[str, Any]:
    """Name what no database keeps and no terminal should see."""
    raise Refused("the panel 'a\x00\x1b[2J\ud800' is cut off; export it again.")


def leave(mark: str) -> dict[str, Any]:
    """End well, and leave a process behind."""
    left = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    Path(mark).write_text(str(left.pid))
    return {}
