"""A frozen dataclass as a file of plain arrays; a file from a limited process is checked before it is used."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from .checkpoints import pack, unpack
from .sandbox import ReaderCrashed

T = TypeVar("T")


def write_record(record: Any, path: Path) -> None:
    """Write a dataclass as uncompressed arrays.

    Raises:
        TypeError: where a field is of a type that `pack` does not take.
    """
    with path.open("wb") as file:
        np.savez(file, **pack(record))  # type: ignore[arg-type]


def read_record(kind: type[T], path: Path) -> T:
    """Read a dataclass that a limited process wrote: no pickle, nothing compressed, exactly its fields.

    Raises:
        ReaderCrashed: where the file is something else.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            if any(entry.compress_type != zipfile.ZIP_STORED for entry in archive.infolist()):
                raise ValueError("compressed")
        with np.load(path, allow_pickle=False) as arrays:
            found = unpack(kind, {name: arrays[name] for name in arrays.files})
        if found is None:
            raise ValueError("not whole")
    except (ValueError, KeyError, TypeError, OSError, EOFError, zipfile.BadZipFile, RecursionError) as error:
        raise ReaderCrashed() from error
    return found
