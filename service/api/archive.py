"""A job's files as one .zip, written while it is sent: nothing is packed, so nothing waits."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Generator, Sequence

from ..records import Artifact
from ..store import Store

ARCHIVE_MEMBER_TIME = (1980, 1, 1, 0, 0, 0)
"""Date and time of every file in an archive: the same result gives the same archive."""


class _Pipe(io.RawIOBase):
    """Take what a writer writes, and hand it on."""

    def __init__(self) -> None:
        self.blocks: list[bytes] = []

    def writable(self) -> bool:
        """Describe that it can be written to."""
        return True

    def write(self, block: bytes) -> int:  # type: ignore[override]
        """Keep a block until it is taken."""
        self.blocks.append(bytes(block))
        return len(block)

    def take(self) -> bytes:
        """Return what was written since the last time."""
        content = b"".join(self.blocks)
        self.blocks.clear()
        return content


def pack_files(store: Store, files: Sequence[Artifact]) -> Generator[bytes]:
    """Return an archive of some files, block by block; each is read from the store when its turn comes.

    Raises:
        ArtifactMissing, ArtifactDamaged: in place of the next block; what came until then is no whole archive.
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
