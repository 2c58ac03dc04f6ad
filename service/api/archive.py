"""A job's files as one .zip, written while it is sent, without compression or a temporary file."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Generator, Sequence
from datetime import UTC, datetime

from ..records import Artifact
from ..store import Store

TIME_FIELD = "<HHBl"
"""Form of a member's extra field with its time in UTC: id, size, flags, seconds since 1970 (APPNOTE of Info-ZIP); the
date of the ZIP format itself has no zone."""

TIME_FIELD_ID, TIME_FIELD_SIZE = 0x5455, 5
"""Index of that field among all kinds [1], and its length [bytes]."""


class _Pipe(io.RawIOBase):
    """Collect the blocks that a writer writes until they are taken."""

    def __init__(self) -> None:
        self.blocks: list[bytes] = []

    def writable(self) -> bool:
        """Return that it can be written to."""
        return True

    def write(self, block: bytes) -> int:  # type: ignore[override]
        """Keep a block until it is taken."""
        self.blocks.append(bytes(block))
        return len(block)

    def take(self) -> bytes:
        """Return what was written since the last call."""
        content = b"".join(self.blocks)
        self.blocks.clear()
        return content


def pack_files(store: Store, files: Sequence[Artifact], time: float) -> Generator[bytes]:
    """Yield an archive of some files block by block; each file is read from the store when its turn comes.

    Args:
        store: Where the files are.
        files: Names and hashes.
        time: When they were made [s since 1970]; a result's archive is the same each time.

    Raises:
        ArtifactMissing, ArtifactDamaged: in place of the next block; the blocks before it are an incomplete archive.
    """
    pipe, made = _Pipe(), int(time)
    utc = datetime.fromtimestamp(made, UTC)
    with zipfile.ZipFile(pipe, "w", zipfile.ZIP_STORED) as archive:
        for file in files:
            member = zipfile.ZipInfo(file.name, utc.timetuple()[:6])
            member.extra = struct.pack(TIME_FIELD, TIME_FIELD_ID, TIME_FIELD_SIZE, 1, made)
            member.file_size = file.size
            with archive.open(member, "w", force_zip64=file.size > 2**31) as out:
                for block in store.read_checked(file.sha256, file.size):
                    out.write(block)
                    yield pipe.take()
    yield pipe.take()
