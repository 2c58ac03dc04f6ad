"""Check that every stored file that a row names exists and is unchanged."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from .damage import DamagedRow
from .database import Database
from .models import ArtifactRow, JobRow, ScanRow, TemplateRow, UploadRow
from .named_files import find_hashes
from .store import ArtifactMissing, Store


@dataclass(frozen=True)
class FileReference:
    """Describe a reference to a stored file: `owner` is a job, a template or an upload, `name` the file's own."""

    sha256: str
    owner: str
    name: str


@dataclass(frozen=True)
class Fault:
    """Describe a file that is `missing` or `damaged`, with all references to it."""

    sha256: str
    fault: str
    named: tuple[FileReference, ...]


@dataclass(frozen=True)
class VerificationResult:
    """Describe what was checked, and the faults: files, and rows that cannot be read."""

    files: int
    size: int
    faults: tuple[Fault, ...]
    rows: tuple[DamagedRow, ...] = ()


def verify_store(database: Database, store: Store, is_data_read: bool) -> VerificationResult:
    """Check every file that a row names, and find rows that cannot be read; it continues after each fault.

    Args:
        database: The database whose rows name the files.
        store: The store of the files.
        is_data_read: Read every byte and compare its hash with the key; otherwise check only that it exists.

    Raises:
        StoreUnreachable: if the store is unavailable.
    """
    rows = database.find_damaged()
    with (database.intact if rows else database).read() as session:
        owners: dict[str, list[FileReference]] = {}
        for one in find_file_references(session):
            owners.setdefault(one.sha256, []).append(one)
    store.check()
    size, faults = 0, list[Fault]()
    for key, named in sorted(owners.items()):
        try:
            size += store.size(key)
            fault = "" if not is_data_read or is_sound(store, key) else "damaged"
        except ArtifactMissing:
            fault = "missing"
        if fault:
            faults.append(Fault(key, fault, tuple(named)))
    return VerificationResult(len(owners), size, tuple(faults), tuple(rows))


def is_sound(store: Store, sha256: str) -> bool:
    """Return whether a stored file's bytes are unchanged.

    Raises:
        ArtifactMissing: if it does not exist.
    """
    digest = hashlib.sha256()
    try:
        for block in store.read(sha256):
            digest.update(block)
    except OSError:
        return False  # a sector that cannot be read
    return digest.hexdigest() == sha256


def find_file_references(session: Session) -> Iterator[FileReference]:
    """Yield every reference of a row to a stored file."""
    artifacts = select(ArtifactRow.sha256, ArtifactRow.job, ArtifactRow.kind, ArtifactRow.name)
    for sha256, job, kind, name in session.execute(artifacts.execution_options(yield_per=1000)):
        yield FileReference(sha256, f"job {job}", name if kind == "result" else f"{kind} {name}")
    for job, scan, request in session.execute(select(JobRow.id, JobRow.scan, JobRow.request)):
        for sha256 in sorted({scan, *find_hashes(request)}):
            yield FileReference(sha256, f"job {job}", "input")
    for sha256, name in session.execute(select(ScanRow.sha256, ScanRow.name)):
        yield FileReference(sha256, "scan", name)
    for sha256, name in session.execute(select(TemplateRow.sha256, TemplateRow.name)):
        yield FileReference(sha256, "template", name)
    for sha256, name in session.execute(select(UploadRow.sha256, UploadRow.name)):
        yield FileReference(sha256, "upload", name)
