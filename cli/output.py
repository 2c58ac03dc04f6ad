"""Permissions of what a command writes: its home is private, exported files have the user's own permissions.

A path that cannot be created or written ends in one line with a code, before a long computation begins.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import click

from ..core.run.errors import BadInput
from ..service.private import PRIVATE_UMASK

OWN_MASK = "garmentq.own_mask"
"""Key of a command's context for the umask of the user's own files."""


class OutputUnwritable(BadInput):
    """The output cannot be written there; name another file or folder."""

    code = "output.unwritable"


class FileUnusable(BadInput):
    """A file cannot be read or written; check its path, its permissions and the free space on its disk."""

    code = "file.unusable"


def keep_private(context: click.Context, _: click.Parameter, home: Path | None) -> Path | None:
    """Set a private umask for a command that works on a home; `writing` uses the user's own umask.

    Returns:
        The option's value unchanged.
    """
    context.meta.setdefault(OWN_MASK, os.umask(PRIVATE_UMASK))
    return home


@contextmanager
def keep_mask() -> Iterator[None]:
    """Restore the umask after the block."""
    before = os.umask(PRIVATE_UMASK)
    os.umask(before)
    try:
        yield
    finally:
        os.umask(before)


@contextmanager
def writing(path: Path, is_private: bool = False) -> Iterator[None]:
    """Write the user's output within the block.

    Args:
        path: The named file or folder.
        is_private: Make it readable only by its user: a backup, and files in the home.

    Raises:
        OutputUnwritable: if that fails.
    """
    context = click.get_current_context(silent=True)
    mask = None if context is None or is_private else context.meta.get(OWN_MASK)
    before = None if mask is None else os.umask(mask)
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise _refuse(path, error) from error
    finally:
        if before is not None:
            os.umask(before)


class NewFile(click.Path):
    """Accept the path of a file to be written, in an existing folder."""

    def __init__(self) -> None:
        """Refuse folders."""
        super().__init__(dir_okay=False, path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path.

        Raises:
            OutputUnwritable: if no file can be written there.
        """
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        try:
            is_new = not path.exists()
            os.close(os.open(path, os.O_WRONLY | os.O_CREAT, 0o600))
            if is_new:
                path.unlink()
        except OSError as error:
            raise _refuse(path, error) from error
        return path


class NewFolder(click.Path):
    """Accept the path of a folder for files, which is created if it is missing."""

    def __init__(self) -> None:
        """Refuse files."""
        super().__init__(file_okay=False, path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path.

        Raises:
            OutputUnwritable: if no folder can be created there, or no file in it.
        """
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        made: list[Path] = []
        try:
            for folder in (*reversed(path.absolute().parents), path.absolute()):
                if not folder.is_dir():
                    folder.mkdir()
                    made.append(folder)
            if not os.access(path, os.W_OK | os.X_OK):
                raise PermissionError(13, os.strerror(13))
        except OSError as error:
            raise _refuse(path, error) from error
        finally:
            for folder in reversed(made):  # only a test: the command may end without a file
                with suppress(OSError):
                    folder.rmdir()
        return path


def _refuse(path: Path, error: OSError) -> OutputUnwritable:
    return OutputUnwritable(f"'{path}' cannot be written: {error.strerror or error}; name another place.")
