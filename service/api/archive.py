"""A job's files as one .zip, written while it is sent, without compression or a temporary file."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Generator, Sequence

from ..records import Artifact
from ..store import Store

ARCHIVE_MEMBER_TIME = (1980, 1, 1, 0, 0, 0)
"""Date and time of every file in an archive [year to second]: equal results give equal archives."""


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


def pack_files(store: Store, files: Sequence[Artifact]) -> Generator[bytes]:
    """Yield an archive of some files block by block; each file is read from the store when its turn comes.

    Raises:
        ArtifactMissing, ArtifactDamaged: in place of the next block; the blocks before it are an incomplete archive.
    """
    pipe = _Pipe()
    with zipfile.ZipFile(pipe, "w", zipfile.ZIP_STORED) as archive:
        for file in files:
            member = zipfile.ZipInfo(file.name, ARCHIVE_MEMBER_TIME)
            member.file_size = file.size
            with archive.open(member, "w", force_zip64=file.size > 2**31) as out:
                for block in store.read_checked(file.sha256, file.size):
                    out.write(block)
                    yield pipe.take()
    yield pipe.take()
