"""Locks between processes of one machine, on a file; the system releases a lock when its holder dies."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .private import make_private


@contextmanager
def hold_lock(path: Path) -> Iterator[None]:
    """Wait for the lock on a file and hold it for the block."""
    descriptor = _open(path)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def share_lock(path: Path) -> int | None:
    """Take a shared lock for as long as this process lives; return None if another process has the exclusive one.

    Returns:
        The descriptor to keep open.
    """
    return _take(path, fcntl.LOCK_SH)


def take_lock(path: Path) -> int | None:
    """Take the exclusive lock for as long as this process lives, or return None if another process has a lock.

    Returns:
        The descriptor to keep open.
    """
    return _take(path, fcntl.LOCK_EX)


def _take(path: Path, kind: int) -> int | None:
    """Take a lock of a kind without waiting; return the descriptor to keep open, or None if it is not available."""
    descriptor = _open(path)
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        return None
    return descriptor


def is_locked(path: Path) -> bool:
    """Return whether another process holds the lock."""
    if not path.exists():
        return False
    descriptor = take_lock(path)
    if descriptor is None:
        return True
    os.close(descriptor)
    return False


def _open(path: Path) -> int:
    make_private(path.parent)
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
