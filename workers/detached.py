"""Start a process that outlives the one that started it."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from ..service.private import make_private
from ..service.signals import defer_stop_signals


def launch(command: Sequence[str], log: Path, environment: Mapping[str, str] | None = None) -> int:
    """Start a command in a session of its own, with nothing to read and its output added to a log.

    Returns:
        The process id, which is also that of its group.
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
    """Return whether a process that this one launched has ended."""
    try:
        return os.waitpid(process, os.WNOHANG)[0] == process
    except ChildProcessError:
        return True


def end_group(process: int) -> None:
    """Tell a launched process and all it started to end."""
    with suppress(ProcessLookupError):
        os.killpg(process, signal.SIGTERM)


def kill_group(process: int) -> None:
    """Kill a launched process and all it started."""
    with suppress(ProcessLookupError):
        os.killpg(process, signal.SIGKILL)


@contextmanager
def launch_or_kill(command: Sequence[str], log: Path, environment: Mapping[str, str] | None = None) -> Iterator[int]:
    """Start a command as `launch` does; kill it where the block does not find it up: it failed, or was told to stop.

    A signal that comes while the process starts is handled when its id is known: else nobody could end it.
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
