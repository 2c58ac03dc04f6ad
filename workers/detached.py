"""Start processes that outlive their parent process."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from ..service.private import make_private
from ..service.signals import defer_stop_signals


def launch(command: Sequence[str], log: Path, environment: Mapping[str, str] | None = None) -> int:
    """Start a command in a session of its own, without input and with its output appended to a log.

    Returns:
        The process id, which is also that of its process group.
    """
    make_private(log.parent)
    actions = [
        (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0),
        (os.POSIX_SPAWN_OPEN, 1, os.fspath(log), os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600),
        (os.POSIX_SPAWN_DUP2, 1, 2),
    ]
    variables = dict(os.environ if environment is None else environment)
    return os.posix_spawn(command[0], list(command), variables, file_actions=actions, setsid=True)


def has_ended(process: int) -> bool:
    """Return whether a process that this process launched has ended."""
    try:
        return os.waitpid(process, os.WNOHANG)[0] == process
    except ChildProcessError:
        return True


def end_group(process: int) -> None:
    """Send SIGTERM to a launched process and all processes that it started."""
    with suppress(ProcessLookupError):
        os.killpg(process, signal.SIGTERM)


def kill_group(process: int) -> None:
    """Kill a launched process and all processes that it started."""
    with suppress(ProcessLookupError):
        os.killpg(process, signal.SIGKILL)


@contextmanager
def launch_or_kill(command: Sequence[str], log: Path, environment: Mapping[str, str] | None = None) -> Iterator[int]:
    """Start a command as `launch` does; kill it if the block raises: the start failed or was interrupted.

    Stop signals are deferred until the process id is known: without the id nothing could end the process.
    """
    process: int | None = None
    try:
        with defer_stop_signals():
            process = launch(command, log, environment)
        yield process
    except BaseException:
        if process is not None:
            kill_group(process)
        raise
