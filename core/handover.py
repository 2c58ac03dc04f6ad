"""How a limited process hands over what it read: as a file of plain arrays, which is not believed."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from .checkpoints import pack, unpack
from .limited import ReaderCrashed

T = TypeVar("T")


def hand_over(value: Any, path: Path) -> None:
    """Write a frozen dataclass as plain arrays, as `checkpoints.pack` makes them of it."""
    with path.open("wb") as file:
        np.savez(file, **pack(value))  # type: ignore[arg-type]


@contextmanager
def doubting() -> Iterator[None]:
    """Return from the block, or tell of what was handed over that it is something else.

    Raises:
        ReaderCrashed: where it is not what `hand_over` writes.
    """
    try:
        yield
    except (ValueError, KeyError, TypeError, OSError, EOFError, zipfile.BadZipFile, RecursionError) as error:
        raise ReaderCrashed() from error


def take_over(kind: type[T], path: Path) -> T:
    """Read a dataclass that `hand_over` wrote in a limited process: no pickle, nothing compressed.

    Raises:
        ReaderCrashed: where it is something else.
    """
    with doubting():
        with zipfile.ZipFile(path) as archive:
            if any(entry.compress_type != zipfile.ZIP_STORED for entry in archive.infolist()):
                raise ValueError("compressed")
        with np.load(path, allow_pickle=False) as arrays:
            value = unpack(kind, {name: arrays[name] for name in arrays.files})
        if value is None:
            raise ValueError("not whole")
        return value
