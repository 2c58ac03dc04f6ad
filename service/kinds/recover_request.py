"""What a recovery is asked for; light, since the limited process that reads its files imports it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from ...core.recovery import Request
from ...core.settings import RecoverySettings
from .request import FileRef

READING = "reading.npz"
"""Holds what was read of the files, beside their folders."""


@dataclass(frozen=True)
class RecoverRequest:
    """Ask for one recovery.

    Attributes:
        scan: The garment's or the dressed person's file.
        body: The wearer's file, the description of a built-in body, or None: then it is in the scan.
        template: A pattern file, or None.
        settings: Everything else.
        labels: One label per vertex of a dressed person's scan, or None.
    """

    scan: FileRef
    body: FileRef | str | None
    template: FileRef | None
    settings: RecoverySettings = field(default_factory=RecoverySettings)
    labels: FileRef | None = None

    def unpack(self, files: Path) -> Request:
        """Return the pipeline's request: the files in a folder as FIELD/NAME, and what was read of them if it was."""

        def find(part: str, file: FileRef | None) -> Path | None:
            return files / part / file.name if file is not None else None

        reading = None
        if (files / READING).is_file():
            from ...core.reading import load_reading

            reading = load_reading(files / READING)
        return Request(
            scan=files / "scan" / self.scan.name,
            body=find("body", self.body) if isinstance(self.body, FileRef) else self.body,
            template=find("template", self.template),
            settings=self.settings,
            labels=find("labels", self.labels),
            reading=reading,
        )
