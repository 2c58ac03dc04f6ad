"""The backend of a home on this machine, which uses its database and its files directly."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

from . import (
    batches,
    checking,
    derived,
    families,
    health,
    job_pages,
    jobs,
    keys,
    materials,
    ordering,
    persons,
    query,
    refining,
    results,
    shares,
    subjects,
    submission,
    templates,
    webhooks,
)
from .batch_records import Batch, BatchReport
from .catalogue import ImportedTemplate, Template
from .database import Database
from .jobs import find_job
from .order import Order
from .persons import PersonDeleted
from .priority import change_priority
from .queue_records import Queue
from .records import Artifact, Event, Job, JobPage, JobReport, Key, ListedJob, News
from .renaming import rename_family
from .services import Services, open_services
from .settings import ServiceSettings
from .share_records import DEFAULT_SHARE_DAYS, SHARE_PATH, Share
from .states import ENDED, State
from .subject_records import Subject, SubjectFields, SubjectReport
from .versions import Version, list_versions
from .webhook_records import Receipt, Webhook
from .webhook_trial import try_webhook

if TYPE_CHECKING:
    from ..core.cloth.fabric import Fabric

DATABASE_POLL_INTERVAL = 0.2
"""Interval at which the database is read for new events [s]; a shorter one makes no visible difference."""


class LocalBackend:
    """Implement `backend.Backend` on a home."""

    is_remote = False
    poll_seconds = DATABASE_POLL_INTERVAL

    def __init__(self, settings: ServiceSettings) -> None:
        """Prepare the backend; the home is opened by the first call that needs its database."""
        self.settings = settings

    @cached_property
    def services(self) -> Services:
        """Return the open home.

        Raises:
            DatabaseUnreachable, DatabaseTooNew: if it cannot be opened.
        """
        return open_services(self.settings)

    @property
    def _database(self) -> Database:
        return self.services.database

    def find_job(self, job: str) -> JobReport:
        """Return a job by its id, or by a beginning of the id that no other job has."""
        return results.report_jobs(self._database, [jobs.find_job(self._database, job)], self.settings)[0]

    def wait_job(self, job: str, seconds: float) -> JobReport:
        """Return a job as soon as it has ended, or as it is after some seconds."""
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0.0 and jobs.find_job(self._database, job).state not in ENDED:
            time.sleep(min(self.poll_seconds, left))
        return self.find_job(job)

    def find_jobs_by_id(self, ids: Sequence[str], below: bool = False) -> list[Job]:
        """Return the progress of some jobs, in the order of the ids; with `below`, then of all jobs below them."""
        found = {row.id: Job.from_row(row) for row in jobs.find_jobs_by_id(self._database, ids)}
        known = jobs.order_by_ids(ids, found)
        more = families.find_below(self._database, ids) if below else []  # read last: has ended jobs' children
        return known + [Job.from_row(row) for row in more]

    def list_jobs(self, limit: int = 50) -> list[JobReport]:
        """Return the running jobs, then the newest others, each newest first."""
        return results.report_jobs(self._database, query.list_jobs(self._database, limit), self.settings)

    def find_jobs(self, terms: query.JobQuery) -> list[JobReport]:
        """Return the jobs that meet every condition of a query."""
        found = job_pages.find_page(self._database, terms)
        return results.report_jobs(self._database, found.rows, self.settings)

    def find_page(self, terms: query.JobQuery) -> JobPage:
        """Return a page of the jobs that meet a query, with their number and the next page's cursor."""
        found = job_pages.find_page(self._database, terms)
        return JobPage([ListedJob.from_row(row) for row in found.rows], found.total, found.next)

    def poll_events(self, job: str, after: int = 0) -> News:
        """Return a job's state and its events after one; the state is read first, so that no event is missed."""
        row = jobs.find_job(self._database, job)
        return News(row.state, [Event.from_row(event) for event in jobs.read_events(self._database, row.id, after)])

    def read_queue(self) -> Queue:
        """Count the jobs by state, and list the living workers."""
        return health.read_queue(self._database)

    def check_order(self, order: Order, template: str | None = None) -> Order:
        """Check an order's files and names before anything is queued."""
        return ordering.check_order(self.services, order, template)

    def submit(self, order: Order, is_checked: bool = False) -> submission.SubmissionResult:
        """Store an order's files, check them, and queue the job."""
        check = partial(checking.check_request, self.services) if is_checked else None
        return submission.submit(self._database, self.services.store, order, check)

    def submit_derived(self, order: derived.DerivedOrder) -> submission.SubmissionResult:
        """Store an order's files, and queue the job that works on a stored result."""
        return derived.submit_derived(self.services, order)

    def refine(self, job: str) -> submission.SubmissionResult:
        """Queue the recovery at standard quality of a preview's files."""
        return refining.submit_refinement(self.services, jobs.find_job(self._database, job))

    def list_versions(self, job: str) -> list[Version]:
        """Return all versions of the result that a job belongs to, oldest first."""
        return list_versions(self._database, jobs.find_job(self._database, job).id)

    def cancel(self, job: str) -> State:
        """Request that a job stops, and return its state after that."""
        return families.cancel(self._database, jobs.find_job(self._database, job).id)

    def retry(self, job: str) -> State:
        """Queue a job again that ended without success."""
        return families.retry(self._database, jobs.find_job(self._database, job).id)

    def rename(self, job: str, name: str | None = None, tags: Sequence[str] | None = None) -> JobReport:
        """Write another name or other tags of a job's family, and return the job; None: as it is."""
        row = jobs.find_job(self._database, job)
        rename_family(self._database, row.id, name, tags)
        return self.find_job(row.id)

    def change_priority(self, job: str, priority: int) -> int:
        """Change the priority of a job's whole family, and return the job's own after that."""
        return change_priority(self._database, jobs.find_job(self._database, job).id, priority)

    def list_artifacts(self, job: str) -> list[Artifact]:
        """Return a job's result files by name."""
        row = jobs.find_job(self._database, job)
        return [Artifact.from_row(file) for file in results.list_files(self._database, row.id)]

    def export_files(self, job: str, folder: Path, names: Sequence[str] = ()) -> list[Path]:
        """Copy a job's result files (all, or those named) into a folder."""
        row = jobs.find_job(self._database, job)
        return results.export_files(self._database, self.services.store, row.id, folder, names)

    def list_templates(self) -> list[Template]:
        """Return shipped and imported templates."""
        return templates.list_templates(self._database)

    def read_template(self, name: str) -> bytes:
        """Return a template's pattern file."""
        return templates.read_template(self.services, name)

    def import_template(self, name: str, path: Path) -> ImportedTemplate:
        """Check a pattern file and store it as a template."""
        return templates.import_template(self.services, name, path)

    def delete_template(self, name: str) -> None:
        """Delete an imported template; jobs that use it keep its file."""
        templates.delete_template(self._database, name)

    def list_materials(self) -> list[Fabric]:
        """Return every fabric of the library."""
        return materials.list_materials(self._database)

    def read_material(self, name: str) -> Fabric:
        """Return one fabric."""
        return materials.read_material(self._database, name)

    def import_materials(self, path: Path) -> list[Fabric]:
        """Check a file of fabrics and store them."""
        return materials.import_materials(self._database, path)

    def delete_material(self, name: str) -> None:
        """Delete an imported fabric; jobs that use it keep its numbers."""
        materials.delete_material(self._database, name)

    def create_subject(self, fields: SubjectFields) -> Subject:
        """Create the record of a person who was scanned."""
        return subjects.create_subject(self._database, fields)

    def update_subject(self, subject: str, fields: SubjectFields) -> Subject:
        """Replace what is said of a subject, by its id or name."""
        return subjects.update_subject(self._database, subject, fields)

    def list_subjects(self, name: str = "", limit: int = 50, before: str = "") -> list[Subject]:
        """Return the newest subjects."""
        return subjects.list_subjects(self._database, name, limit, before)

    def find_subject(self, subject: str) -> SubjectReport:
        """Return a subject by its id or name, with its scans, families and bodies."""
        return subjects.find_subject(self._database, subject)

    def assign_jobs(self, subject: str, jobs: Sequence[str]) -> Subject:
        """Make jobs, with all of their families, a subject's."""
        ids = [find_job(self._database, job).id for job in jobs]
        return subjects.assign_jobs(self._database, subject, ids)

    def delete_subject(self, subject: str, dry_run: bool = False) -> PersonDeleted:
        """Delete a subject with its scans, jobs and all that was made of them; a dry run only lists them."""
        return persons.delete_subject(self._database, self.services.store, subject, None, dry_run)

    def list_batches(self, limit: int = 20, before: str = "") -> list[Batch]:
        """Return the tags whose jobs were ordered last, with their progress."""
        return batches.list_batches(self._database, limit, before)

    def find_batch(self, tag: str) -> BatchReport:
        """Return the progress of the jobs with a tag, with its failures."""
        return batches.find_batch(self._database, tag)

    def create_key(
        self, name: str, scopes: Sequence[str], quota: int, priority: int = 0, days: float | None = None
    ) -> tuple[Key, str]:
        """Create an API key and return it with its token, which is returned only here."""
        row, token = keys.create_key(self._database, name, tuple(scopes), quota, priority, days)
        return Key.from_row(row), token

    def list_keys(self) -> list[Key]:
        """Return every API key, oldest first."""
        return [Key.from_row(row) for row in keys.list_keys(self._database)]

    def revoke_key(self, key: str) -> Key:
        """Revoke an API key; its jobs stay."""
        return Key.from_row(keys.revoke_key(self._database, key))

    def create_share(self, job: str, days: int = DEFAULT_SHARE_DAYS) -> tuple[Share, str]:
        """Make a link to a job's result, and return it with its path."""
        share, token = shares.create_share(self._database, jobs.find_job(self._database, job).id, days)
        return share, f"{SHARE_PATH}{token}"

    def list_shares(self, job: str) -> list[Share]:
        """Return the valid links to a job's result, oldest first."""
        return shares.list_shares(self._database, jobs.find_job(self._database, job).id)

    def revoke_share(self, job: str, share: str) -> None:
        """Revoke a link to a job's result."""
        shares.revoke_share(self._database, jobs.find_job(self._database, job).id, share)

    def rotate_key(self, key: str, hours: float = keys.DEFAULT_GRACE_HOURS) -> tuple[Key, str]:
        """Give an API key a new token, and return both; the token before stays valid for some hours."""
        row, token = keys.rotate_key(self._database, key, hours)
        return Key.from_row(row), token

    def create_webhook(self, url: str, states: Sequence[State] = ()) -> tuple[Webhook, str]:
        """Create a webhook and return it with its secret, which is returned only here."""
        return webhooks.create_webhook(self._database, url, states, self.settings.webhook_networks)

    def rotate_secret(self, webhook: str, hours: float = keys.DEFAULT_GRACE_HOURS) -> tuple[Webhook, str]:
        """Give a webhook a new secret, and return both; the one before signs its messages too, for some hours."""
        return webhooks.rotate_secret(self._database, webhook, hours)

    def list_webhooks(self) -> list[Webhook]:
        """Return the webhooks, oldest first."""
        return webhooks.list_webhooks(self._database)

    def delete_webhook(self, webhook: str) -> None:
        """Delete a webhook and its unsent messages."""
        webhooks.delete_webhook(self._database, webhook)

    def test_webhook(self, webhook: str) -> Receipt:
        """Send a message of the type `test`, and return the outcome."""
        return asyncio.run(try_webhook(self._database, webhook))

    def close(self) -> None:
        """Close every connection to the database, if there is one."""
        if "services" in self.__dict__:
            self._database.dispose()
