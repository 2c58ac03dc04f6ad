"""Call one function in a limited process of its own; files from outside are read this way.

The child gets no variable of our environment (no key, no address of a database), has limits of memory, CPU time,
written bytes and open files, no network where the system permits that, and is killed at a deadline. It returns one JSON
object of limited size; larger results are written to a file that the arguments name.
"""

from __future__ import annotations

import errno
import importlib
import json
import logging
import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

from .clock import peak_bytes
from .errors import BadInput, Cancelled, GarmentqError, NotFound, keep_printable

log = logging.getLogger(__name__)

CHILD_POLL_INTERVAL = 0.1
"""Interval at which `is_stopped` is called [s]."""

MEMORY_EXIT_STATUS = 70
"""Exit status of a child that ended itself for lack of memory."""

ORPHAN_SECONDS = 5
"""Time after the deadline at which a child ends itself [s]; it is only reached if its parent was killed."""

LONGEST_MESSAGE = 2000
"""Largest number of letters of an error's message."""

IsStopped = Callable[[], bool]
"""Called repeatedly during a call; True kills the process."""

_BOOT = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from {} import answer; answer()"
_CLONE_NEWNET, _CLONE_NEWUSER = 0x40000000, 0x10000000
"""Flags of Linux' `unshare` for a network namespace and a user namespace of the process's own."""
_DIE_WITH_PARENT = 1
"""Code of Linux' PR_SET_PDEATHSIG."""


class InputTooLarge(BadInput):
    """Reading the file needs more memory or room than it may have; decimate the mesh first."""

    code = "input.too_large"


class InputTookTooLong(BadInput):
    """Reading the file took longer than it may; decimate the mesh, or export it again."""

    code = "input.took_too_long"


class ReaderCrashed(BadInput):
    """The reader crashed at this file; export it again from another program, and report it if that does not help."""

    code = "input.reader_crashed"


@dataclass(frozen=True)
class Bounds:
    """Describe the limits of a process.

    Attributes:
        memory_bytes: Address space [bytes]; 4 GiB are several times enough for the largest mesh that is read.
        cpu_seconds: CPU time [s]; an 80K-vertex scan takes about 2.
        output_bytes: Largest file it may write [bytes].
        wall_seconds: Time after which it is killed [s], for a process that sleeps.
        answer_bytes: Largest answer [bytes].
        files: Largest number of open files.
    """

    memory_bytes: int = 4 * 1024**3
    cpu_seconds: int = 120
    output_bytes: int = 2 * 1024**3
    wall_seconds: float = 240.0
    answer_bytes: int = 1024**2
    files: int = 64


@dataclass(frozen=True)
class Answer:
    """Describe the answer of a limited process: the function's value, CPU time with the start [s], and peak memory
    [MB]."""

    result: dict[str, Any]
    cpu_seconds: float
    peak_mb: float


def never_stopped() -> bool:
    """Return False: the call continues."""
    return False


def call_limited(
    function: str,
    arguments: Mapping[str, Any],
    bounds: Bounds | None = None,
    is_stopped: IsStopped = never_stopped,
    folder: Path | None = None,
) -> Answer:
    """Call a function of JSON values in a fresh limited process.

    Args:
        function: `package.module:name`; it returns a JSON object.
        arguments: Keyword arguments, JSON values.
        bounds: The limits of the process.
        is_stopped: Called repeatedly; True kills the process.
        folder: Parent of the process's own folder, which is removed afterwards; None: the system's.

    Raises:
        GarmentqError: as the function raised it, with its code and message; a `BadInput` remains one.
        InputTooLarge, InputTookTooLong, ReaderCrashed: where it met a limit or died.
        Cancelled: where `is_stopped` returned True.
    """
    bounds = bounds or Bounds()
    own_bounds = {field.name: getattr(bounds, field.name) for field in fields(Bounds)}
    paths = json.dumps([path for path in sys.path if os.path.isabs(path)])
    command = [sys.executable, "-I", "-c", _BOOT.format(__name__), paths]
    own_folder = tempfile.TemporaryDirectory(prefix="garmentq-limited-", dir=folder, ignore_cleanup_errors=True)
    with own_folder as home, tempfile.TemporaryFile() as question:
        question.write(json.dumps({"function": function, "arguments": arguments, "bounds": own_bounds}).encode())
        question.seek(0)
        with tempfile.TemporaryFile() as answers, tempfile.TemporaryFile() as said:
            process = subprocess.Popen(
                command, stdin=question, stdout=answers, stderr=said, cwd=home, env=_environment(home),
                start_new_session=True,
            )  # fmt: skip
            try:
                status = _wait(process, bounds.wall_seconds, is_stopped)
            finally:
                with suppress(ProcessLookupError, PermissionError):  # macOS: not permitted where only zombies are left
                    os.killpg(process.pid, signal.SIGKILL)  # also its own children, where it ended by itself
                process.wait()
            answers.seek(0)
            content = answers.read(bounds.answer_bytes + 1)
            said.seek(max(0, said.seek(0, os.SEEK_END) - 4000))
            return _parse_answer(status, content, said.read().decode(errors="replace"), bounds)


def _environment(home: str) -> dict[str, str]:
    """Return the whole environment of a limited process."""
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
    return {"PATH": os.defpath, "LANG": "C.UTF-8", "HOME": home, "TMPDIR": home, **threads}


def _wait(process: subprocess.Popen[bytes], seconds: float, is_stopped: IsStopped) -> int:
    deadline = time.monotonic() + seconds
    while True:
        left = deadline - time.monotonic()
        if left <= 0:
            raise InputTookTooLong(f"reading took more than {seconds:g} s; decimate the mesh, or export it again.")
        try:
            return process.wait(min(CHILD_POLL_INTERVAL, left))
        except subprocess.TimeoutExpired:
            if is_stopped():
                raise Cancelled() from None


def _parse_answer(status: int, content: bytes, answer: str, bounds: Bounds) -> Answer:
    """Parse a process's answer, without trust in it; raise the error that it reported or of which it died."""
    if status in (MEMORY_EXIT_STATUS, -signal.SIGKILL):
        needed = f"{bounds.memory_bytes >> 20} MiB of memory or {bounds.output_bytes >> 20} MiB written"
        raise InputTooLarge(f"reading needs more than {needed}; decimate the mesh.")
    if status == -signal.SIGXCPU:
        raise InputTookTooLong(f"reading took more than {bounds.cpu_seconds} s of CPU time; decimate the mesh.")
    try:
        if status != 0 or len(content) > bounds.answer_bytes:
            raise ValueError("no answer")
        found = json.loads(content)
        if "error" in found:
            kind, code, message = (str(found["error"][name]) for name in ("kind", "code", "message"))
        else:
            result = found["result"]
            if not isinstance(result, dict):
                raise ValueError("no object")
            json.dumps(found, allow_nan=False)  # nan and inf are neither stored nor shown
            return Answer(result, float(found["cpu_seconds"]), float(found["peak_mb"]))
    except (ValueError, TypeError, KeyError, RecursionError):
        log.error("a limited process ended with status %d:\n%s", status, answer)
        raise ReaderCrashed() from None
    if code == ReaderCrashed.code:
        log.error("a limited process failed:\n%s", answer)
    raise _make_error(kind, code, keep_printable(message)[:LONGEST_MESSAGE])


_KINDS: dict[str, type[GarmentqError]] = {"bad_input": BadInput, "not_found": NotFound, "fault": GarmentqError}


def _make_error(kind: str, code: str, message: str) -> GarmentqError:
    """Return an error of the class with this code if it is loaded here, else of its base class."""
    base = _KINDS.get(kind, GarmentqError)
    chosen = next((each for each in _subclasses(base) if each.code == code), base)
    error = chosen.__new__(chosen)
    GarmentqError.__init__(error, message)
    error.code = code
    return error


T = TypeVar("T", bound=GarmentqError)


def _subclasses(kind: type[T]) -> Iterator[type[T]]:
    for each in kind.__subclasses__():
        yield each
        yield from _subclasses(each)


def answer() -> None:
    """Run in the limited process: answer the call on standard input."""
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as out:
        os.dup2(2, 1)  # a library's prints are not part of the answer
        question = json.load(sys.stdin)
        bounds = Bounds(**question["bounds"])
        _restrict_process(bounds)
        module, _, name = question["function"].partition(":")
        try:
            found = {"result": getattr(importlib.import_module(module), name)(**question["arguments"])}
        except GarmentqError as error:
            kind = next(kind for kind, base in _KINDS.items() if isinstance(error, base))
            found = {"error": {"kind": kind, "code": error.code, "message": error.message}}
        except Exception as error:
            if is_memory_short(error):
                os._exit(MEMORY_EXIT_STATUS)
            traceback.print_exc()
            found = {"error": {"kind": "bad_input", "code": ReaderCrashed.code, "message": ReaderCrashed().message}}
        usage = resource.getrusage(resource.RUSAGE_SELF)
        used = {"cpu_seconds": usage.ru_utime + usage.ru_stime, "peak_mb": peak_bytes() / 1e6}
        json.dump({**found, **used}, out)


def is_memory_short(error: BaseException) -> bool:
    """Check whether an error is for lack of memory or space: a library that cannot be mapped fails as an import."""
    words = str(error).lower()
    return (
        isinstance(error, MemoryError)
        or (isinstance(error, ImportError) and ("allocate memory" in words or "map segment" in words))
        or (isinstance(error, OSError) and error.errno in (errno.EFBIG, errno.ENOMEM))
    )


def _restrict_process(bounds: Bounds) -> None:
    """Set the limits of this process before it reads any file."""
    if sys.platform == "linux":
        import ctypes

        system = ctypes.CDLL(None)
        system.prctl(_DIE_WITH_PARENT, signal.SIGKILL)
        _ = (
            system.unshare(_CLONE_NEWNET) == 0 or system.unshare(_CLONE_NEWNET | _CLONE_NEWUSER) == 0
        )  # not permitted everywhere
    signal.alarm(int(bounds.wall_seconds) + ORPHAN_SECONDS)
    limits = {
        resource.RLIMIT_FSIZE: bounds.output_bytes,
        resource.RLIMIT_NOFILE: bounds.files,
        resource.RLIMIT_CORE: 0,
    }
    for name, value in limits.items():
        _set_limit(name, value)
    hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
    if hard == resource.RLIM_INFINITY or hard > bounds.cpu_seconds:
        resource.setrlimit(resource.RLIMIT_CPU, (bounds.cpu_seconds, bounds.cpu_seconds + 1))  # SIGXCPU, then SIGKILL
    limit_memory(bounds.memory_bytes)


def _set_limit(name: int, value: int) -> None:
    hard = resource.getrlimit(name)[1]
    value = value if hard == resource.RLIM_INFINITY else min(value, hard)
    resource.setrlimit(name, (value, value))


def limit_memory(size: int, by_system: bool = sys.platform != "darwin") -> None:
    """Limit this process to an address space of `size` bytes, or to as much resident memory where limits have no
    effect: on macOS a thread measures, and ends the process."""
    if by_system:
        for name in (resource.RLIMIT_AS, resource.RLIMIT_DATA):
            _set_limit(name, size)
        return

    def measure() -> None:
        while peak_bytes() <= size:
            time.sleep(0.02)
        os._exit(MEMORY_EXIT_STATUS)

    threading.Thread(target=measure, daemon=True).start()
