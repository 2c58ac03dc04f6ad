"""What a command writes: its home for its user alone, and what the user asked for with the rights of the user's files.

A path that cannot be made or written to ends in one line with a code, and before anything long is begun.
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
"""Where a command's context holds the mask of the user's own files."""


class OutputUnwritable(BadInput):
    """What was asked for cannot be written there; name another file or folder."""

    code = "output.unwritable"


class FileUnusable(BadInput):
    """A file cannot be read or written; check its path, its rights and the room on its disk."""

    code = "file.unusable"


def keep_private(context: click.Context, _: click.Parameter, home: Path | None) -> Path | None:
    """Make everything that the command writes its user's alone, for it works on a home; but for what `writing` writes.

    Returns:
        The option's value as it is.
    """
    context.meta.setdefault(OWN_MASK, os.umask(PRIVATE_UMASK))
    return home


@contextmanager
def keep_mask() -> Iterator[None]:
    """Return to the mask that it had before the block."""
    before = os.umask(PRIVATE_UMASK)
    os.umask(before)
    try:
        yield
    finally:
        os.umask(before)


@contextmanager
def writing(path: Path, is_private: bool = False) -> Iterator[None]:
    """Write what the user asked for in the block.

    Args:
        path: The file or folder that was named.
        is_private: It is for its user alone: a backup, and what lies in the home.

    Raises:
        OutputUnwritable: where that fails.
    """
    context = click.get_current_context(silent=True)
    own = None if context is None or is_private else context.meta.get(OWN_MASK)
    before = None if own is None else os.umask(own)
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
    """Take the path of a file to be written, in a folder that is there."""

    def __init__(self) -> None:
        """Refuse folders."""
        super().__init__(dir_okay=False, path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path.

        Raises:
            OutputUnwritable: where no file can be written there.
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
    """Take the path of a folder for files, which is made where it is missing."""

    def __init__(self) -> None:
        """Refuse files."""
        super().__init__(file_okay=False, path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path.

        Raises:
            OutputUnwritable: where no folder can be made there, or no file in it.
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
            for folder in reversed(made):  # only tried: the command may end without a file
                with suppress(OSError):
                    folder.rmdir()
        return path


def _refuse(path: Path, error: OSError) -> OutputUnwritable:
    return OutputUnwritable(f"'{path}' cannot be written: {error.strerror or error}; name another place.")
