"""The store in an S3 bucket, with the same interface as the folder; Amazon's, or any server that implements S3."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import urlsplit

from .database import DriverMissing
from .private import make_private
from .settings import ServiceSettingBad
from .store import (
    STORE_BLOCK_SIZE,
    ArtifactMissing,
    StorageFull,
    Store,
    StoredFile,
    StoreEntry,
    StoreUnreachable,
    check_key,
)

S3_CONNECT_TIMEOUT = 5
"""Time limit for the server to accept a connection [s]."""

READ_SECONDS = 30
"""Longest silence of the server [s]; a response for a block takes milliseconds."""

MAX_S3_ATTEMPTS = 4
"""Largest number of attempts of one request; a server that restarts is back within them."""

S3_PART_SIZE = 16 << 20
"""Size of one part of an upload [bytes]; S3 requires at least 5 MB and at most 10 000 parts."""

MISSING = ("404", "NoSuchKey", "NotFound")

BUCKET_MISSING_CODE = "NoSuchBucket"
"""The code of a server's answer about a file of a bucket that does not exist."""


class BucketMissing(StoreUnreachable):
    """The store's bucket does not exist; run `garmentq db upgrade`, which creates it, or correct GARMENTQ_STORE."""

    code = "store.bucket_missing"


class S3Store(Store):
    """Put and get files by content in a bucket. A partial put is never visible: S3 guarantees that."""

    def __init__(self, address: str, endpoint: str, cache: Path) -> None:
        """Prepare a client; nothing is sent yet.

        Args:
            address: `s3://bucket` or `s3://bucket/prefix`.
            endpoint: The server's address, or empty for Amazon's.
            cache: Folder for uploads that are not hashed yet, and for files that are needed as a path.

        Raises:
            ServiceSettingBad: if no bucket is named.
            DriverMissing: if boto3 is missing.
        """
        super().__init__(cache)
        parts = urlsplit(address)
        if not parts.netloc or parts.username or parts.query:
            raise ServiceSettingBad("GARMENTQ_STORE must be a folder, or s3://BUCKET or s3://BUCKET/PREFIX.")
        self.bucket, self.prefix = parts.netloc, parts.path.strip("/")
        self._client = _make_client(endpoint)

    def prepare(self) -> None:
        """Create the bucket if it does not exist."""
        try:
            self.check_bucket()
        except BucketMissing:
            region = self._client.meta.region_name
            place = {} if region == "us-east-1" else {"CreateBucketConfiguration": {"LocationConstraint": region}}
            with _translate_s3_errors(""):
                self._client.create_bucket(Bucket=self.bucket, **place)

    def check(self, free_bytes: int = 0) -> None:
        """Check that the bucket responds and the cache has room; a bucket itself has no limit."""
        make_private(self.root)
        super().check(free_bytes)
        self.check_bucket()

    def check_bucket(self) -> None:
        """Check that the bucket exists.

        Raises:
            BucketMissing: if it does not.
        """
        try:
            with _translate_s3_errors("bucket"):
                self._client.head_bucket(Bucket=self.bucket)
        except ArtifactMissing as error:
            raise BucketMissing() from error

    def path(self, sha256: str) -> Path:
        """Return a checked copy of a stored file in the cache.

        Raises:
            ArtifactMissing, ArtifactDamaged: as for a folder.
        """
        path = self.root / check_key(sha256)
        if not path.is_file():
            make_private(self.root)
            with tempfile.TemporaryDirectory(dir=self.root) as folder:
                os.replace(self.copy(sha256, Path(folder) / sha256), path)
        return path

    def renew(self, file: StoredFile) -> bool:
        """Return False: a bucket cannot update a file's time, so every file is put again."""
        return False

    def put_stream(self, stream: BinaryIO) -> StoredFile:
        """Hash the bytes into a temporary file, then upload it under its hash, in parts if it is large."""
        from boto3.s3.transfer import TransferConfig

        digest, size = hashlib.sha256(), 0
        with _spool(self.root) as out:
            while block := stream.read(STORE_BLOCK_SIZE):
                digest.update(block)
                size += len(block)
                out.write(block)
            out.seek(0)
            config = TransferConfig(
                multipart_threshold=S3_PART_SIZE, multipart_chunksize=S3_PART_SIZE, use_threads=False
            )
            with _translate_s3_errors(digest.hexdigest()):
                self._client.upload_fileobj(out, self.bucket, self._name(digest.hexdigest()), Config=config)
        return StoredFile(digest.hexdigest(), size)

    def size(self, sha256: str) -> int:
        """Return a stored file's size [bytes]."""
        with _translate_s3_errors(sha256):
            return int(self._client.head_object(Bucket=self.bucket, Key=self._name(sha256))["ContentLength"])

    def read(self, sha256: str, start: int = 0, stop: int | None = None) -> Iterator[bytes]:
        """Return a stored file's bytes in [start, stop); only these are requested."""
        stop = self.size(sha256) if stop is None else min(stop, self.size(sha256))
        if start >= stop:
            return iter(())
        with _translate_s3_errors(sha256):
            answer = self._client.get_object(
                Bucket=self.bucket, Key=self._name(sha256), Range=f"bytes={start}-{stop - 1}"
            )
        return _read_body(sha256, answer["Body"])

    def list_files(self) -> Iterator[StoreEntry]:
        """Yield every stored file."""
        base = f"{self.prefix}/" if self.prefix else ""
        with _translate_s3_errors(""):
            for page in self._client.get_paginator("list_objects_v2").paginate(Bucket=self.bucket, Prefix=base):
                for found in page.get("Contents", ()):
                    key = found["Key"].removeprefix(base).replace("/", "")
                    if len(key) == 64:
                        yield StoreEntry(key, found["Size"], found["LastModified"].timestamp())

    def remove(self, sha256: str, before: float) -> bool:
        """Delete a stored file unless it was put (again) at `before` or later.

        S3 has no conditional delete by age: a put between check and delete would be lost. The check is repeated right
        before the delete, so the gap is milliseconds, against a grace time of hours.
        """
        with _translate_s3_errors(sha256):
            found = self._client.head_object(Bucket=self.bucket, Key=self._name(sha256))
            if found["LastModified"].timestamp() >= before:
                return False
            self._client.delete_object(Bucket=self.bucket, Key=self._name(sha256))
        return True

    def _name(self, sha256: str) -> str:
        key = check_key(sha256)
        return "/".join(part for part in (self.prefix, key[:2], key[2:]) if part)


def _make_client(endpoint: str) -> Any:
    try:
        import boto3
        from botocore.config import Config
    except ImportError as error:
        raise DriverMissing("an s3:// store needs boto3; pip install 'garmentq[s3]'.") from error
    config = Config(
        connect_timeout=S3_CONNECT_TIMEOUT,
        read_timeout=READ_SECONDS,
        retries={"total_max_attempts": MAX_S3_ATTEMPTS, "mode": "standard"},
        s3={"addressing_style": "path"} if endpoint else {},
        request_checksum_calculation="when_required",  # other servers than Amazon's may refuse the newer checksums
        response_checksum_validation="when_required",
    )
    region = os.environ.get("AWS_REGION") or os.environ.get("AWS_DEFAULT_REGION") or "us-east-1"
    try:
        return boto3.client("s3", endpoint_url=endpoint or None, region_name=region, config=config)
    except ValueError as error:
        raise ServiceSettingBad(f"GARMENTQ_S3_ENDPOINT is '{endpoint}', which is not an address.") from error


def _read_body(sha256: str, body: Any) -> Iterator[bytes]:
    with _translate_s3_errors(sha256):
        try:
            yield from body.iter_chunks(STORE_BLOCK_SIZE)
        finally:
            body.close()


@contextmanager
def _spool(folder: Path) -> Iterator[Any]:
    try:
        make_private(folder)
        with tempfile.TemporaryFile(dir=folder) as stream:
            yield stream
    except OSError as error:
        raise StorageFull(f"the cache {folder} cannot be written: {error.strerror}.") from error


@contextmanager
def _translate_s3_errors(sha256: str) -> Iterator[None]:
    """Convert boto3's errors into our errors; its messages name bucket and key, never a credential."""
    from botocore.exceptions import BotoCoreError, ClientError

    try:
        yield
    except ClientError as error:
        code = error.response.get("Error", {}).get("Code", "")
        if code == BUCKET_MISSING_CODE:
            raise BucketMissing() from error
        if sha256 and code in MISSING:
            raise ArtifactMissing(f"the stored file {sha256[:12]} is missing; restore it, or use --force.") from error
        raise StoreUnreachable(f"the store refused: {code}; check the bucket's name and the credentials.") from error
    except BotoCoreError as error:
        raise StoreUnreachable(f"the store does not respond: {type(error).__name__}.") from error
