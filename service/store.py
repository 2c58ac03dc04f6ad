"""Files stored under the hash of their bytes: in a folder (here), or in an S3 bucket (`s3.py`), chosen by address."""

from __future__ import annotations

import errno
import hashlib
import io
import os
import shutil
import tempfile
from collections.abc import Generator, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from ..core.run.errors import GarmentqError, Unavailable
from .private import make_private

STORE_BLOCK_SIZE = 1 << 18
"""Number of bytes read at a time; each download holds three or four blocks of memory."""


class ArtifactDamaged(GarmentqError):
    """A stored file has changed since it was stored; restore the store, or run the job again with --force."""

    code = "store.damaged"


class ArtifactMissing(GarmentqError):
    """A stored file is missing; restore the store, or run the job again with --force."""

    code = "store.missing"


class StorageFull(Unavailable):
    """The store has no room left; free some disk space, and the jobs continue."""

    code = "store.full"


class StoreUnreachable(Unavailable):
    """The store does not respond; check GARMENTQ_STORE, GARMENTQ_S3_ENDPOINT and the bucket's credentials."""

    code = "store.unreachable"


@dataclass(frozen=True)
class StoredFile:
    """Describe a stored file.

    Attributes:
        sha256: Hash of its bytes (hex); also its key.
        size: Its size [bytes].
    """

    sha256: str
    size: int


@dataclass(frozen=True)
class StoreEntry:
    """Describe a file that is in the store.

    Attributes:
        sha256: Its key.
        size: Its size [bytes].
        modified: When it was last put, by the store's clock [s since 1970].
    """

    sha256: str
    size: int
    modified: float


def check_key(sha256: str) -> str:
    """Return a key if it is a hash, so that no key can name a path.

    Raises:
        ArtifactMissing: if it is not.
    """
    if len(sha256) != 64 or not set(sha256) <= set("0123456789abcdef"):
        raise ArtifactMissing(f"'{sha256[:80]}' is not the key of a stored file.")
    return sha256


class Store:
    """Put and get files by content. Equal bytes are stored once; a partial file is never visible."""

    def __init__(self, root: Path, must_exist: bool = False) -> None:
        """Use a folder; it is created by the first write.

        Args:
            root: The folder.
            must_exist: The folder must exist: if it does not, its disk is unavailable, and it is not created.
        """
        self.root = root
        self.must_exist = must_exist

    def prepare(self) -> None:
        """Create the folder, or the bucket, if it does not exist.

        Raises:
            StorageFull, StoreUnreachable: if that is not possible.
        """
        try:
            make_private(self.root)
        except OSError as error:
            raise StorageFull(f"the store {self.root} cannot be created: {error.strerror}.") from error

    def check(self, free_bytes: int = 0) -> None:
        """Check that the store can be used, without writing to it.

        Args:
            free_bytes: Required free space [bytes].

        Raises:
            StorageFull, StoreUnreachable: if it cannot.
        """
        try:
            check_room(self.root, free_bytes)
        except OSError as error:
            raise StoreUnreachable(f"the store {self.root} is unavailable ({error.strerror}); mount it.") from error
        if not os.access(self.root, os.W_OK | os.X_OK):
            raise StoreUnreachable(f"the store {self.root} is not writable; check its permissions.")

    def path(self, sha256: str) -> Path:
        """Return the path of a stored file.

        Raises:
            ArtifactMissing: if the key is not a hash, or there is no file.
        """
        check_key(sha256)
        path = self.root / sha256[:2] / sha256[2:]
        if not path.is_file():
            if not self.root.is_dir():
                raise StoreUnreachable(f"the store {self.root} is unavailable; mount it again, and the jobs continue.")
            raise ArtifactMissing(f"the stored file {sha256[:12]} is missing; restore the store, or run with --force.")
        return path

    def put(self, source: Path) -> StoredFile:
        """Store a copy of a file; if it is stored and undamaged, only its time is updated."""
        known = hash_file(source)
        if self.renew(known):
            return known
        with source.open("rb") as stream:
            return self.put_stream(stream)

    def renew(self, file: StoredFile) -> bool:
        """Set a stored file's time to now, so that `remove` keeps it; return False if it is missing or damaged."""
        path = self.root / file.sha256[:2] / file.sha256[2:]
        try:
            os.utime(path)  # first: from here on `remove` restores the file
            if hash_file(path) != file:
                return False
            _flush_folder(path.parent)  # another process may have renamed it into place a moment ago
        except OSError:
            return False
        return True

    def put_bytes(self, content: bytes) -> StoredFile:
        """Store some bytes."""
        return self.put_stream(io.BytesIO(content))

    def get_bytes(self, sha256: str) -> bytes:
        """Return a stored file's bytes, checked against its key.

        Raises:
            ArtifactDamaged: if the bytes changed.
        """
        content = b"".join(self.read(sha256))
        if hashlib.sha256(content).hexdigest() != sha256:
            raise ArtifactDamaged()
        return content

    def copy(self, sha256: str, destination: Path) -> Path:
        """Copy a stored file, checked against its key.

        Raises:
            ArtifactDamaged: if the bytes changed.
        """
        destination.parent.mkdir(parents=True, exist_ok=True)
        digest, blocks = hashlib.sha256(), self.read(sha256)
        with destination.open("wb") as out:
            for block in blocks:
                digest.update(block)
                out.write(block)
        if digest.hexdigest() != sha256:
            destination.unlink()
            raise ArtifactDamaged()
        return destination

    def size(self, sha256: str) -> int:
        """Return a stored file's size [bytes].

        Raises:
            ArtifactMissing: if there is no file.
        """
        return self.path(sha256).stat().st_size

    def read(self, sha256: str, start: int = 0, stop: int | None = None) -> Iterator[bytes]:
        """Return a stored file's bytes in [start, stop), one block at a time, unchecked.

        Raises:
            ArtifactMissing: at once, if there is no file.
            ArtifactDamaged: if it is a symbolic link, which may lead to any file.
        """
        try:
            descriptor = os.open(self.path(sha256), os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
        except FileNotFoundError:
            raise ArtifactMissing() from None
        except OSError as error:
            if error.errno == errno.ELOOP:
                raise ArtifactDamaged() from None
            raise StoreUnreachable(f"the store {self.root} cannot be read: {error.strerror}.") from error
        return _read_blocks(os.fdopen(descriptor, "rb"), start, stop)

    def read_checked(self, sha256: str, size: int) -> Generator[bytes]:
        """Yield a stored file's bytes one block at a time, the last block only if the hash of all of them is right.

        A reader that has received all of `size` has the stored file unchanged. Nothing is opened before the first
        block.

        Raises:
            ArtifactMissing: in place of the first block.
            ArtifactDamaged: in place of the last block, if the bytes changed.
        """
        digest, last = hashlib.sha256(), b""
        for block in self.read(sha256, 0, size):
            digest.update(block)
            if last:
                yield last
            last = block
        if digest.hexdigest() != sha256:
            raise ArtifactDamaged()
        if last:
            yield last

    def list_files(self) -> Iterator[StoreEntry]:
        """Yield every stored file, in no order, without partial ones."""
        for path in self.root.glob("[0-9a-f][0-9a-f]/*"):
            with suppress(ArtifactMissing, FileNotFoundError):
                key, found = check_key(path.parent.name + path.name), path.stat()
                yield StoreEntry(key, found.st_size, found.st_mtime)

    def remove(self, sha256: str, before: float) -> bool:
        """Delete a stored file unless it was put (again) at `before` [s since 1970] or later.

        The file is moved aside first: if it is put at the same time, it is restored or written again, never lost.
        """
        path = self.path(sha256)
        aside = self.root / "incoming" / f"removed-{sha256}"
        aside.parent.mkdir(exist_ok=True, mode=0o700)
        os.rename(path, aside)
        if aside.stat().st_mtime >= before:
            os.rename(aside, path)
            return False
        aside.unlink()
        return True

    def put_stream(self, stream: BinaryIO) -> StoredFile:
        """Write to a temporary file, flush it to the disk, then rename it to its hash."""
        incoming = self.root / "incoming"
        if self.must_exist:
            self.check()
        temporary = ""
        try:
            make_private(incoming)
            descriptor, temporary = tempfile.mkstemp(dir=incoming)
            digest, size = hashlib.sha256(), 0
            with os.fdopen(descriptor, "wb") as out:
                while block := stream.read(STORE_BLOCK_SIZE):
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
        return StoredFile(digest.hexdigest(), size)


def _read_blocks(stream: BinaryIO, start: int, stop: int | None) -> Iterator[bytes]:
    with stream:
        stream.seek(start)
        left = None if stop is None else max(stop - start, 0)
        while block := stream.read(STORE_BLOCK_SIZE if left is None else min(STORE_BLOCK_SIZE, left)):
            left = None if left is None else left - len(block)
            yield block


def check_room(folder: Path, free_bytes: int) -> None:
    """Check that a folder's disk has room.

    Args:
        folder: The folder.
        free_bytes: Required free space [bytes].

    Raises:
        StorageFull: if it has less.
        OSError: if the folder does not exist.
    """
    free = shutil.disk_usage(folder).free
    if free < free_bytes:
        raise StorageFull(
            f"the disk of {folder} has {free >> 20} MiB of room, less than the {free_bytes >> 20} MiB of "
            "GARMENTQ_FREE_BYTES; free some disk space, and the jobs continue."
        )


def hash_file(path: Path) -> StoredFile:
    """Return a file's hash and size without storing it."""
    digest, size = hashlib.sha256(), 0
    with path.open("rb") as stream:
        while block := stream.read(STORE_BLOCK_SIZE):
            digest.update(block)
            size += len(block)
    return StoredFile(digest.hexdigest(), size)


def _flush_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
