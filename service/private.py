"""Folders and files that only their user may open: scans of bodies, names and hashes of keys are confidential."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

PRIVATE_FOLDER_MODE = 0o700
"""Permission bits of a folder of a home: only its user opens it."""

PRIVATE_FILE_MODE = 0o600
"""Permission bits of a file of a home: only its user reads and writes it."""

PRIVATE_UMASK = 0o077
"""Permission bits that a process on a home removes from all files that it creates (umask)."""


def make_private(folder: Path) -> Path:
    """Create a folder, and every missing one above it, for one user only, and return it; existing ones are not changed.

    `Path.mkdir(parents=True, mode=...)` gives the mode to the last folder only.

    Raises:
        OSError: if it cannot be created.
    """
    for above in reversed(folder.parents):
        if not above.exists():
            above.mkdir(mode=PRIVATE_FOLDER_MODE, exist_ok=True)
    folder.mkdir(mode=PRIVATE_FOLDER_MODE, exist_ok=True)
    return folder


def make_private_all(path: Path) -> None:
    """Remove other users' permissions on a file, or a folder with all below it; links and others' files are skipped."""
    _close(path)
    if path.is_dir() and not path.is_symlink():
        for folder, folders, files in os.walk(path):
            for name in (*folders, *files):
                _close(Path(folder, name))


def _close(path: Path) -> None:
    with suppress(FileNotFoundError, PermissionError):
        if not path.is_symlink():
            mode = path.stat().st_mode & 0o777
            path.chmod(mode & ~PRIVATE_UMASK)
