"""The backend of commands and programs: a home on this machine, or a service by HTTP.

Both implementations return the same records and raise errors of the same codes; one test checks both alike.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from ..core.run.errors import BadInput
from .settings import ServiceSettings
from .share_records import DEFAULT_SHARE_DAYS
from .states import State

if TYPE_CHECKING:
    from ..core.cloth.fabric import Fabric
    from .batch_records import Batch, BatchReport
    from .catalogue import ImportedTemplate, Template
    from .derived import DerivedOrder
    from .order import Order
    from .persons import PersonDeleted
    from .query import JobQuery
    from .queue_records import Queue
    from .records import Artifact, Job, JobPage, JobReport, Key, News
    from .share_records import Share
    from .subject_records import Subject, SubjectFields, SubjectReport
    from .submission import SubmissionResult
    from .versions import Version
    from .webhook_records import Receipt, Webhook

__all__ = ["Backend", "LocalOnly", "open_backend"]


class LocalOnly(BadInput):
    """This command works only on a home of this machine; unset GARMENTQ_URL, or run it where the service runs."""

    code = "command.local_only"


class Backend(Protocol):
    """Declare the operations that a user may request of a service.

    Attributes:
        is_remote: True if the service may be on another machine: then no worker is started here for its jobs.
        poll_seconds: Interval at which news are polled [s].
    """

    is_remote: bool
    poll_seconds: float

    def find_job(self, job: str) -> JobReport:
        """Return a job by its id, or by a beginning of the id that no other job has.

        Raises:
            JobUnknown: if no job, or more than one, matches.
        """

    def wait_job(self, job: str, seconds: float) -> JobReport:
        """Return a job as soon as it has ended, or as it is after some seconds; a service waits for at most 60 s.

        Raises:
            JobUnknown: as `find_job` raises it.
        """

    def find_jobs_by_id(self, ids: Sequence[str], below: bool = False) -> list[Job]:
        """Return the progress of some jobs, in the order of the ids; with `below`, then of all jobs below them.

        Raises:
            JobUnknown: if one is not known.
        """

    def list_jobs(self, limit: int = 50) -> list[JobReport]:
        """Return the running jobs, then the newest others, each newest first."""

    def find_jobs(self, terms: JobQuery) -> list[JobReport]:
        """Return the jobs that meet every condition of a query.

        Raises:
            QueryBad: if a condition cannot be parsed, or names an unknown field.
        """

    def find_page(self, terms: JobQuery) -> JobPage:
        """Return a page of the jobs that meet a query, with their number and the next page's cursor.

        Pages do not shift while jobs are added: the next one is the query with `cursor` set to this one's `next`.

        Raises:
            QueryBad: as `find_jobs` raises it.
            CursorBad: if the cursor is none of this list.
        """

    def poll_events(self, job: str, after: int = 0) -> News:
        """Return a job's state and its events with an id above `after`, in order."""

    def read_queue(self) -> Queue:
        """Count the jobs by state, and list the living workers."""

    def check_order(self, order: Order, template: str | None = None) -> Order:
        """Check an order's files and names before anything is queued; `template` is a template's name, never a path.

        Raises:
            GarmentqError: with the code of what cannot be used.
        """

    def submit(self, order: Order, is_checked: bool = False) -> SubmissionResult:
        """Store or send an order's files, and queue the job.

        Args:
            order: What is to be recovered.
            is_checked: Read the files before the job is queued, and refuse unusable ones; otherwise the job does.

        Raises:
            BadInput: as the check refuses a file.
        """

    def submit_derived(self, order: DerivedOrder) -> SubmissionResult:
        """Store or send an order's files, and queue the job that works on a stored result.

        Raises:
            GarmentqError: with the code of what cannot be used.
        """

    def refine(self, job: str) -> SubmissionResult:
        """Queue the recovery at standard quality of a preview's files.

        Raises:
            NotPreview: if the job is not a preview.
        """

    def list_versions(self, job: str) -> list[Version]:
        """Return all versions of the result that a job belongs to: the first and every edit, oldest first."""

    def cancel(self, job: str) -> State:
        """Request that a job stops, and return its state after that."""

    def retry(self, job: str) -> State:
        """Queue a job again that ended without success, and return its state after that.

        Raises:
            JobNotEnded, JobSucceeded: if it cannot be retried.
        """

    def change_priority(self, job: str, priority: int) -> int:
        """Change the priority of a job's whole family, and return the job's own after that.

        Raises:
            JobUnknown: if there is none of that id.
        """

    def rename(self, job: str, name: str | None = None, tags: Sequence[str] | None = None) -> JobReport:
        """Write another name or other tags of a job's family, and return the job; None: as it is.

        Raises:
            LabelBad: if they cannot be used.
        """

    def list_artifacts(self, job: str) -> list[Artifact]:
        """Return a job's result files by name."""

    def export_files(self, job: str, folder: Path, names: Sequence[str] = ()) -> list[Path]:
        """Copy a job's result files (all, or those named) into a folder, each checked against its hash.

        Raises:
            ResultMissing: if the job has no result, or no file of a name.
        """

    def list_templates(self) -> list[Template]:
        """Return shipped and imported templates."""

    def read_template(self, name: str) -> bytes:
        """Return a template's pattern file.

        Raises:
            TemplateUnknown: if there is none of that name.
        """

    def import_template(self, name: str, path: Path) -> ImportedTemplate:
        """Check a pattern file and store it as a template.

        Raises:
            TemplateNameBad: if the name is invalid, or a shipped template's.
        """

    def delete_template(self, name: str) -> None:
        """Delete an imported template; jobs that use it keep its file.

        Raises:
            TemplateUnknown, TemplateShipped: if there is none of that name, or it is a shipped one.
        """

    def list_materials(self) -> list[Fabric]:
        """Return every fabric of the library."""

    def read_material(self, name: str) -> Fabric:
        """Return one fabric.

        Raises:
            FabricUnknown: if there is none of that name.
        """

    def import_materials(self, path: Path) -> list[Fabric]:
        """Check a file of fabrics and store them; imported fabrics of the same names are replaced.

        Raises:
            FabricFileBad, FabricUnitBad: if the file cannot be read.
            FabricShipped: if one has a shipped fabric's name.
            BadInput: as `check_fabric` says.
        """

    def delete_material(self, name: str) -> None:
        """Delete an imported fabric; jobs that use it keep its numbers.

        Raises:
            FabricUnknown, FabricShipped: if there is none of that name, or it is a shipped one.
        """

    def create_subject(self, fields: SubjectFields) -> Subject:
        """Create the record of a person who was scanned.

        Raises:
            SubjectBad, SubjectTaken: if a field cannot be used, or there is one of this name.
        """

    def update_subject(self, subject: str, fields: SubjectFields) -> Subject:
        """Replace what is said of a subject, by its id or name.

        Raises:
            SubjectUnknown, SubjectBad, SubjectTaken: if there is none, or a field cannot be used.
        """

    def list_subjects(self, name: str = "", limit: int = 50, before: str = "") -> list[Subject]:
        """Return the newest subjects; with `name` the one of exactly this name, with `before` those after an id."""

    def find_subject(self, subject: str) -> SubjectReport:
        """Return a subject by its id or name, with its scans, families and bodies.

        Raises:
            SubjectUnknown: if there is none.
        """

    def assign_jobs(self, subject: str, jobs: Sequence[str]) -> Subject:
        """Make jobs, with all of their families, a subject's.

        Raises:
            SubjectUnknown, JobUnknown: if there is none of an id or name.
        """

    def delete_subject(self, subject: str, dry_run: bool = False) -> PersonDeleted:
        """Delete a subject with its scans, jobs and all that was made of them; a dry run only lists them.

        Raises:
            SubjectUnknown: if there is none.
            JobNotEnded: if one of its jobs has not ended; nothing is deleted then.
        """

    def list_batches(self, limit: int = 20, before: str = "") -> list[Batch]:
        """Return the tags whose jobs were ordered last, with their progress; with `before` those after a tag."""

    def find_batch(self, tag: str) -> BatchReport:
        """Return the progress of the jobs with a tag, with its failures.

        Raises:
            BatchUnknown: if no job has the tag.
        """

    def create_key(
        self, name: str, scopes: Sequence[str], quota: int, priority: int = 0, days: float | None = None
    ) -> tuple[Key, str]:
        """Create an API key and return it with its token, which is returned only here.

        Its jobs may have a priority up to `priority`, and it expires after `days`.
        """

    def list_keys(self) -> list[Key]:
        """Return every API key, oldest first."""

    def revoke_key(self, key: str) -> Key:
        """Revoke an API key; its jobs stay.

        Raises:
            KeyUnknown: if there is none of that id.
        """

    def create_share(self, job: str, days: int = DEFAULT_SHARE_DAYS) -> tuple[Share, str]:
        """Make a link to a job's result, and return it with its path, which holds the token and is returned only here.

        Raises:
            ShareDaysBad, ResultUnshared, SharesFull: if it cannot be made.
        """

    def list_shares(self, job: str) -> list[Share]:
        """Return the valid links to a job's result, oldest first."""

    def revoke_share(self, job: str, share: str) -> None:
        """Revoke a link to a job's result.

        Raises:
            ShareUnknown: if there is none of that id.
        """

    def rotate_key(self, key: str, hours: float = 24.0) -> tuple[Key, str]:
        """Give an API key a new token, and return both; the token before stays valid for some hours.

        Raises:
            KeyUnknown: if there is none of that id.
            KeyRevoked: if it was revoked.
            GraceBad: if `hours` is out of range.
        """

    def create_webhook(self, url: str, states: Sequence[State] = ()) -> tuple[Webhook, str]:
        """Create a webhook for all end states, or some; return it with its secret, which is returned only here.

        Raises:
            WebhookBad, AddressForbidden: if the address cannot be used.
            WebhooksFull: if the largest number of webhooks is reached.
        """

    def rotate_secret(self, webhook: str, hours: float = 24.0) -> tuple[Webhook, str]:
        """Give a webhook a new secret, and return both; the one before signs its messages too, for some hours.

        Raises:
            WebhookUnknown: if there is none of that id.
            GraceBad: if `hours` is out of range.
        """

    def list_webhooks(self) -> list[Webhook]:
        """Return the webhooks, oldest first."""

    def delete_webhook(self, webhook: str) -> None:
        """Delete a webhook and its unsent messages.

        Raises:
            WebhookUnknown: if there is none of that id.
        """

    def test_webhook(self, webhook: str) -> Receipt:
        """Send a message of the type `test` as all others are sent, and return the outcome.

        Raises:
            WebhookUnknown: if there is none of that id.
        """

    def close(self) -> None:
        """Close every connection."""


def open_backend(settings: ServiceSettings) -> Backend:
    """Return the backend of a home, or of the service at GARMENTQ_URL (with the key of GARMENTQ_API_KEY).

    No connection is opened before the first call, which may raise `DatabaseUnreachable` or `ServiceUnreachable`.
    """
    url = os.environ.get("GARMENTQ_URL", "")
    if url:
        from .local_token import find_local_token
        from .remote import RemoteBackend

        return RemoteBackend(url, os.environ.get("GARMENTQ_API_KEY", "") or find_local_token(url, settings.home))
    from .local import LocalBackend

    return LocalBackend(settings)
