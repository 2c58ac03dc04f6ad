"""Read one array of an untrusted `.npy` file or `.npz` entry; its header is checked first, and nothing is unpickled."""

from __future__ import annotations

from collections.abc import Callable
from typing import IO

import numpy as np

NPY_READ_BLOCK_BYTES = 1024**2
"""Size of one read [bytes]: reading a compressed entry at once takes quadratic time."""


def read_array(file: IO[bytes], judge: Callable[[tuple[int, ...], np.dtype], None]) -> np.ndarray:
    """Read an array whose shape and type are checked before memory is allocated.

    Args:
        file: Open at the array's magic.
        judge: Raises where the shape or type is not acceptable.

    Raises:
        ValueError: where the version is unknown, the array has objects, or the file ends too early.
    """
    version = np.lib.format.read_magic(file)
    if version not in ((1, 0), (2, 0)):
        raise ValueError("it is of an unknown version of the format")
    header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, is_fortran, kind = header(file)
    judge(shape, kind)
    if kind.hasobject:
        raise ValueError("it holds objects")
    size = int(np.prod(shape, dtype=object)) * kind.itemsize
    content = bytearray()
    while len(content) < size:  # in blocks: one `read` of a compressed entry takes quadratic time
        block = file.read(min(NPY_READ_BLOCK_BYTES, size - len(content)))
        if not block:
            raise ValueError("it is shorter than its header says")
        content += block
    return np.frombuffer(content, dtype=kind).reshape(shape, order="F" if is_fortran else "C")
