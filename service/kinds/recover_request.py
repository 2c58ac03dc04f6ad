"""The request of a recovery; the module is light, because the limited process that reads its files imports it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from ...core.people.part import GARMENTS
from ...core.recover.recovery import Request
from ...core.recover.settings import RecoverySettings
from .request import BuiltinText, FileRef, RequestBad

READING = "reading.npz"
"""File with the arrays of the files that were read, beside their folders."""

PERSON_REPORT_FILE = "person.json"
"""File of a person's result with its garments and their confidence."""

AS_PERSON = "as-person"
"""File that replaces the reading if the files turned out to be a whole person's."""

PERSON = "person"
"""Name of the input with the person that a garment belongs to."""


@dataclass(frozen=True)
class RecoverRequest:
    """Describe one recovery.

    Attributes:
        scan: The garment's or the dressed person's file.
        body: The wearer's file, a built-in body, or None: then it is in the scan.
        template: A pattern file, or None.
        settings: All other settings.
        labels: One label per vertex of a dressed person's scan, or None.
        part: The garment of a segmented person, `upper`: its reading is in the folder of that name of the input
            `PERSON`, and there are no files. None: the files are those above.
        given_as: `garment` if the user says that the scan is one, so that it is not checked for a person.
    """

    scan: FileRef | None
    body: FileRef | BuiltinText | None
    template: FileRef | None
    settings: RecoverySettings = field(default_factory=RecoverySettings)
    labels: FileRef | None = None
    part: str | None = None
    given_as: str | None = None

    def __post_init__(self) -> None:
        """Refuse a request without a scan or a garment.

        Raises:
            RequestBad: if neither or both are given, or the part is unknown.
        """
        words = {part.word for part in GARMENTS}
        if (self.scan is None) == (self.part is None) or self.part not in {None, *words}:
            raise RequestBad(f"a recovery is of a scan or of a part; {RequestBad().message}")

    @property
    def is_open(self) -> bool:
        """Return whether the scan may be a whole person's: the user has not said which of it is the garment."""
        chosen = self.settings
        return self.given_as is None and chosen.keep is None and chosen.keep_colour is None

    def unpack(self, files: Path, person: Path | None = None) -> Request:
        """Return the pipeline's request: the files in a folder as FIELD/NAME, and their reading if it exists.

        Args:
            files: Folder of the files and of their reading.
            person: Folder of the result of the person's job, if the garment is a part of a person.
        """
        if self.part is not None and person is not None:
            return self._take(person / self.part)
        if self.scan is None:
            raise RequestBad(f"the garment's person is missing; {RequestBad().message}")

        def find(part: str, file: FileRef | None) -> Path | None:
            return files / part / file.name if file is not None else None

        reading = None
        if (files / READING).is_file():
            from ...core.garment.reading import load_reading

            reading = load_reading(files / READING)
        return Request(
            scan=files / "scan" / self.scan.name,
            body=find("body", self.body) if isinstance(self.body, FileRef) else self.body,
            template=find("template", self.template),
            settings=self.settings,
            labels=find("labels", self.labels),
            reading=reading,
        )

    def _take(self, folder: Path) -> Request:
        """Return the pipeline's request of a garment whose reading was stored in a folder."""
        from ...core.garment.reading import load_reading

        reading, base = load_reading(folder / READING), self.settings.template
        template = None if reading.pattern is None else Path(f"{base or reading.pattern.name}.json")
        return Request(scan=folder, template=template, settings=self.settings, reading=reading)
