"""The questions that commands and programs ask: of a home on this machine, or by HTTP of a service elsewhere.

Both implementations return the same records and raise errors of the same codes; one test asks them the same.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from ..core.run.errors import BadInput
from .settings import ServiceSettings
from .states import State

if TYPE_CHECKING:
    from ..core.cloth.fabric import Fabric
    from .catalogue import ImportedTemplate, Template
    from .derived import DerivedOrder
    from .order import Order
    from .query import JobQuery
    from .queue_records import Queue
    from .records import Artifact, Job, JobReport, Key, News
    from .submission import SubmissionResult
    from .versions import Version
    from .webhook_records import Receipt, Webhook


class LocalOnly(BadInput):
    """This command works on a home of this machine; unset GARMENTQ_URL, or run it where the service runs."""

    code = "command.local_only"


class Backend(Protocol):
    """Answer what a user may ask of a service.

    Attributes:
        is_remote: True where another machine may be asked: nothing is started here for its jobs.
        poll_seconds: How often it is asked for news [s].
    """

    is_remote: bool
    poll_seconds: float

    def find_job(self, job: str) -> JobReport:
        """Return a job by its id, or by a beginning of it that fits no other.

        Raises:
            JobUnknown: where there is none, or more than one.
        """

    def find_jobs_by_id(self, ids: Sequence[str], below: bool = False) -> list[Job]:
        """Return how far the jobs of some ids are, in the order of the ids; with `below` then all jobs below them.

        Raises:
            JobUnknown: where one is not known.
        """

    def list_jobs(self, limit: int = 50) -> list[JobReport]:
        """Return the jobs that run, then the newest others, each newest first."""

    def find_jobs(self, wanted: JobQuery) -> list[JobReport]:
        """Return the jobs that meet every condition of a query.

        Raises:
            QueryBad: where a condition cannot be read, or names what there is not.
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

    def submit(self, order: Order) -> SubmissionResult:
        """Keep or send an order's files, and queue the job."""

    def submit_derived(self, order: DerivedOrder) -> SubmissionResult:
        """Keep or send an order's files, and queue the job that works on a stored result.

        Raises:
            GarmentqError: with the code of what cannot be used.
        """

    def list_versions(self, job: str) -> list[Version]:
        """Return all versions of the result that a job is one of: the first, and every edit, oldest first."""

    def cancel(self, job: str) -> State:
        """Ask a job to stop, and return its state after that."""

    def retry(self, job: str) -> State:
        """Queue a job that ended without success once more, and return its state after that.

        Raises:
            JobNotEnded, JobSucceeded: where there is nothing to try again.
        """

    def list_artifacts(self, job: str) -> list[Artifact]:
        """Return a job's result files by name."""

    def export_files(self, job: str, folder: Path, names: Sequence[str] = ()) -> list[Path]:
        """Copy a job's result files (all, or those named) into a folder, each checked against its hash.

        Raises:
            ResultMissing: where the job has no result, or no file of a name.
        """

    def list_templates(self) -> list[Template]:
        """Return shipped and imported templates."""

    def read_template(self, name: str) -> bytes:
        """Return a template's pattern file.

        Raises:
            TemplateUnknown: where there is none of that name.
        """

    def import_template(self, name: str, path: Path) -> ImportedTemplate:
        """Check a pattern file and keep it as a template.

        Raises:
            TemplateNameBad: where the name is none, or a shipped template's.
        """

    def delete_template(self, name: str) -> None:
        """Delete an imported template; jobs that were asked for with it keep its file.

        Raises:
            TemplateUnknown, TemplateShipped: where there is none of that name, or it is a shipped one.
        """

    def list_materials(self) -> list[Fabric]:
        """Return every fabric of the library."""

    def read_material(self, name: str) -> Fabric:
        """Return one fabric.

        Raises:
            FabricUnknown: where there is none of that name.
        """

    def import_materials(self, path: Path) -> list[Fabric]:
        """Check a file of fabrics and keep them; one imported before under a name is replaced.

        Raises:
            FabricFileBad, FabricUnitBad: where the file cannot be read.
            FabricShipped: where one has a shipped fabric's name.
            BadInput: as `check_fabric` says.
        """

    def delete_material(self, name: str) -> None:
        """Delete an imported fabric; jobs that were asked for with it keep its numbers.

        Raises:
            FabricUnknown, FabricShipped: where there is none of that name, or it is a shipped one.
        """

    def create_key(
        self, name: str, scopes: Sequence[str], quota: int, priority: int = 0, days: float | None = None
    ) -> tuple[Key, str]:
        """Make an API key; its token is returned here and never again.

        Its jobs may have a `priority` up to that, and it expires after some `days`.
        """

    def list_keys(self) -> list[Key]:
        """Return every API key, oldest first."""

    def revoke_key(self, key: str) -> Key:
        """Revoke an API key; its jobs stay.

        Raises:
            KeyUnknown: where there is none of that id.
        """

    def create_webhook(self, url: str, states: Sequence[State] = ()) -> tuple[Webhook, str]:
        """Keep an address that is told when jobs end, all or those of some states; its secret is returned only here.

        Raises:
            WebhookBad, AddressForbidden: where the address cannot be used.
            WebhooksFull: where there are as many as there may be.
        """

    def list_webhooks(self) -> list[Webhook]:
        """Return the webhooks, oldest first."""

    def delete_webhook(self, webhook: str) -> None:
        """Delete a webhook with all that is owed to it.

        Raises:
            WebhookUnknown: where there is none of that id.
        """

    def test_webhook(self, webhook: str) -> Receipt:
        """Let a message of the type `test` be sent as all others are, and return what came of it.

        Raises:
            WebhookUnknown: where there is none of that id.
        """

    def close(self) -> None:
        """Close every connection."""


def open_backend(settings: ServiceSettings) -> Backend:
    """Return the backend of a home, or of the service that GARMENTQ_URL names (with the key of GARMENTQ_API_KEY).

    Nothing is opened before the first question: that raises `DatabaseUnreachable` or `ServiceUnreachable` if it must.
    """
    url = os.environ.get("GARMENTQ_URL", "")
    if url:
        from .local_token import find_local_token
        from .remote import RemoteBackend

        return RemoteBackend(url, os.environ.get("GARMENTQ_API_KEY", "") or find_local_token(url, settings.home))
    from .local import LocalBackend

    return LocalBackend(settings)
