"""Files kept under the hash of their bytes, in a folder."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from ..core.errors import GarmentqError

BLOCK = 1 << 20
"""Bytes read at a time."""


class ArtifactDamaged(GarmentqError):
    """A stored file is not the one that was put there; restore the store, or run the job again with --force."""

    code = "store.damaged"


class ArtifactMissing(GarmentqError):
    """A stored file is gone; restore the store, or run the job again with --force."""

    code = "store.missing"


class StorageFull(GarmentqError):
    """There is no room left in the store; free some disk space and retry the job."""

    code = "store.full"


@dataclass(frozen=True)
class Stored:
    """Name a stored file.

    Attributes:
        sha256: Hash of its bytes (hex); also its key.
        size: Bytes.
    """

    sha256: str
    size: int


class Store:
    """Put and get files by content. The same bytes are kept once; a half-written file is never seen."""

    def __init__(self, root: Path) -> None:
        """Use a folder; it is made when first written to."""
        self.root = root

    def path(self, sha256: str) -> Path:
        """Give the place of a stored file.

        Raises:
            ArtifactMissing: where the key is no hash, or nothing is there.
        """
        if len(sha256) != 64 or not set(sha256) <= set("0123456789abcdef"):
            raise ArtifactMissing(f"'{sha256[:80]}' is no key of a stored file.")
        path = self.root / sha256[:2] / sha256[2:]
        if not path.is_file():
            raise ArtifactMissing(f"the stored file {sha256[:12]} is gone; restore the store, or run with --force.")
        return path

    def put(self, source: Path) -> Stored:
        """Keep a copy of a file."""
        with source.open("rb") as stream:
            return self._keep(stream)

    def put_bytes(self, content: bytes) -> Stored:
        """Keep some bytes."""
        import io

        return self._keep(io.BytesIO(content))

    def get_bytes(self, sha256: str) -> bytes:
        """Give a stored file's bytes, checked against its key.

        Raises:
            ArtifactDamaged: where the bytes changed.
        """
        content = self.path(sha256).read_bytes()
        if hashlib.sha256(content).hexdigest() != sha256:
            raise ArtifactDamaged()
        return content

    def copy(self, sha256: str, destination: Path) -> Path:
        """Copy a stored file out, checked against its key.

        Raises:
            ArtifactDamaged: where the bytes changed.
        """
        destination.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(self.path(sha256), destination)
        if hash_file(destination).sha256 != sha256:
            destination.unlink()
            raise ArtifactDamaged()
        return destination

    def _keep(self, stream: BinaryIO) -> Stored:
        """Write to a temporary file, flush it to the disk, then rename it to its hash."""
        incoming = self.root / "incoming"
        temporary = ""
        try:
            incoming.mkdir(parents=True, exist_ok=True, mode=0o700)
            descriptor, temporary = tempfile.mkstemp(dir=incoming)
            digest, size = hashlib.sha256(), 0
            with os.fdopen(descriptor, "wb") as out:
                while block := stream.read(BLOCK):
                    digest.update(block)
                    size += len(block)
                    out.write(block)
                out.flush()
                os.fsync(out.fileno())
            folder = self.root / digest.hexdigest()[:2]
            folder.mkdir(exist_ok=True, mode=0o700)
            os.replace(temporary, folder / digest.hexdigest()[2:])
            _flush_folder(folder)
        except OSError as error:
            if temporary and os.path.exists(temporary):
                os.unlink(temporary)
            raise StorageFull(f"the store {self.root} cannot be written: {error.strerror}.") from error
        return Stored(digest.hexdigest(), size)


def hash_file(path: Path) -> Stored:
    """Give a file's hash and size without keeping it."""
    digest, size = hashlib.sha256(), 0
    with path.open("rb") as stream:
        while block := stream.read(BLOCK):
            digest.update(block)
            size += len(block)
    return Stored(digest.hexdigest(), size)


def _flush_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
