"""The part of `remote.RemoteBackend` for subjects and batches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from urllib.parse import quote

from .batch_records import Batch, BatchReport
from .persons import PersonDeleted
from .remote_libraries import RemoteLibraries, read, read_all
from .subject_records import Subject, SubjectFields, SubjectReport
from .subjects import SUBJECT_ID, SubjectUnknown


class RemoteSubjects(RemoteLibraries):
    """Implement the operations of `backend.Backend` on subjects and batches by HTTP."""

    def create_subject(self, fields: SubjectFields) -> Subject:
        """Create the record of a person who was scanned."""
        found = self._ask("POST", "/v1/subjects", tries=1, json=asdict(fields))
        return read(lambda: Subject.from_json(found))

    def update_subject(self, subject: str, fields: SubjectFields) -> Subject:
        """Replace what is said of a subject, by its id or name."""
        found = self._ask("PUT", f"/v1/subjects/{self._find_id(subject)}", json=asdict(fields))
        return read(lambda: Subject.from_json(found))

    def list_subjects(self, name: str = "", limit: int = 50, before: str = "") -> list[Subject]:
        """Return the newest subjects."""
        params = {"name": name, "limit": limit, "before": before}
        answer = self._ask("GET", "/v1/subjects", params={key: value for key, value in params.items() if value != ""})
        return read_all(Subject.from_json, answer, "subjects")

    def find_subject(self, subject: str) -> SubjectReport:
        """Return a subject by its id or name, with its scans, families and bodies."""
        found = self._ask("GET", f"/v1/subjects/{self._find_id(subject)}")
        return read(lambda: SubjectReport.from_json(found))

    def assign_jobs(self, subject: str, jobs: Sequence[str]) -> Subject:
        """Make jobs, with all of their families, a subject's."""
        found = self._ask("POST", f"/v1/subjects/{self._find_id(subject)}/jobs", json={"jobs": list(jobs)})
        return read(lambda: Subject.from_json(found))

    def delete_subject(self, subject: str, dry_run: bool = False) -> PersonDeleted:
        """Delete a subject with its scans, jobs and all that was made of them; a dry run only lists them."""
        params = {"dry_run": True} if dry_run else {}
        found = self._ask("DELETE", f"/v1/subjects/{self._find_id(subject)}", tries=1, params=params)
        return read(lambda: PersonDeleted.from_json(found))

    def list_batches(self, limit: int = 20, before: str = "") -> list[Batch]:
        """Return the tags whose jobs were ordered last, with their progress."""
        params = {"limit": limit} | ({"before": before} if before else {})
        return read_all(Batch.from_json, self._ask("GET", "/v1/batches", params=params), "batches")

    def find_batch(self, tag: str) -> BatchReport:
        """Return the progress of the jobs with a tag, with its failures."""
        found = self._ask("GET", f"/v1/batches/{quote(tag, safe='')}")
        return read(lambda: BatchReport.from_json(found))

    def _find_id(self, subject: str) -> str:
        """Return the id of a subject by its id or exact name.

        Raises:
            SubjectUnknown: if there is none of this name, or several keys have one.
        """
        if SUBJECT_ID.fullmatch(subject):
            return subject
        found = self.list_subjects(subject, 2) if subject else []
        if len(found) == 2:
            own = [one for one in found if not one.key]
            if not own:
                raise SubjectUnknown(f"several API keys have a subject '{subject[:80]}'; name it by its id.")
            found = own
        if not found:
            raise SubjectUnknown()
        return found[0].id
