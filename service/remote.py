"""The backend of a remote service: a typed client of the HTTP API.

with RemoteBackend("http://127.0.0.1:8080", key="gq_...") as service:
    job = service.submit(Order(Path("skirt.ply"), "builtin:female,height=1.70")).job
    for event in service.follow(job):
        print(event.kind, event.data)
    service.export_files(job, Path("result"))
"""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import time
import uuid
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Self
from urllib.parse import quote

import httpx

from ..core.body.spec import BuiltinWearer
from ..core.recover.settings import WAIT
from ..core.run.errors import GarmentqError, NotFound
from .connection import MAX_REQUEST_TRIES, Connection, ServiceUnreachable, make_refusal
from .derived import DerivedOrder
from .jobs import order_by_ids
from .kinds import FileRef, RequestBad
from .materials import is_shipped
from .order import Order
from .ordering import check_order_locally
from .query import JobQuery
from .queue_records import Queue
from .records import Artifact, Event, Job, JobPage, JobReport, Json, ListedJob, News, check_id
from .remote_libraries import read, read_all
from .remote_subjects import RemoteSubjects
from .results import choose_files
from .states import State
from .store import ArtifactDamaged
from .submission import BodyUnreadable, SubmissionResult
from .terms import JobTerms
from .versions import Version

__all__ = ["RemoteBackend"]

MAX_JOBS_PER_REQUEST = 1000
"""Largest number of jobs in one request for states, the service's limit."""

REMOTE_POLL_INTERVAL = 0.5
"""Interval at which a service is polled for new events [s]; progress is written twice a second."""

UPLOADS = {"body": "bodies", "motion": "motions", "pattern": "patterns"}
"""Kind of upload of each file of a derived job, by its field."""

MAX_ORDERS_PER_REQUEST = 100
"""Largest number of orders in one request, the service's limit."""

MAX_WAIT_SECONDS = 60.0
"""Longest time for which one request waits for a job's end [s], the service's limit."""

ID_LENGTH = 12
"""Number of letters of a job's complete id."""


class RemoteBackend(RemoteSubjects):
    """Implement `backend.Backend` by HTTP. Every refusal is a `GarmentqError` with the service's code."""

    is_remote = True
    poll_seconds = REMOTE_POLL_INTERVAL

    def __init__(self, url: str, key: str = "") -> None:
        """Prepare a client; nothing is sent before the first request.

        Args:
            url: Address of the service, `http://host:port`.
            key: Token of an API key, or empty.

        Raises:
            ServiceUnreachable: if the address is invalid.
        """
        super().__init__(Connection(url, key))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()

    def check_order(self, order: Order, template: str | None = None) -> Order:
        """Check an order's files and names before they are sent; templates and fabrics are checked by the service."""
        checked = check_order_locally(order)
        for fabric in {order.settings.fabric, *(one.fabric for one in order.choices.values())}:
            if isinstance(fabric, str) and not is_shipped(fabric):
                self.read_material(fabric)
        return replace(checked, settings=replace(checked.settings, template=template))

    def submit(self, order: Order, is_checked: bool = False) -> SubmissionResult:
        """Upload an order's files and create the job; a template that is not a file is sent by its name."""
        payload = self._describe(order)
        if is_checked:  # a service of an earlier version refuses the field
            payload["check"] = True
        return self._submit(payload, order.terms)

    def submit_many(self, orders: Sequence[Order]) -> list[SubmissionResult | GarmentqError]:
        """Upload the files of orders and create their jobs, a hundred a request; return each one's job or refusal."""
        results: list[SubmissionResult | GarmentqError] = []
        for start in range(0, len(orders), MAX_ORDERS_PER_REQUEST):
            payload = {"orders": [self._describe(order) for order in orders[start : start + MAX_ORDERS_PER_REQUEST]]}
            headers = {"idempotency-key": uuid.uuid4().hex}
            found = self._ask("POST", "/v1/jobs/batch", json=payload, headers=headers)
            results += read_all(_read_result, found, "results")
        return results

    def _describe(self, order: Order) -> dict[str, Any]:
        """Upload an order's files, and return the request for its job."""
        settings = order.settings.as_dict()
        template, settings["redrape"] = settings.pop("template"), settings["redrape"] or WAIT
        payload: dict[str, Any] = {
            "scan": self.upload("scans", order.scan),
            "settings": settings,
        }
        payload |= _describe_terms(order.terms) | self._describe_person(order)
        if isinstance(order.body, BuiltinWearer):
            payload["body"] = order.body.spec
        elif order.body is not None:
            payload["body"] = self.upload("bodies", order.body)
        if order.labels is not None:
            payload["labels"] = self.upload("labels", order.labels)
        if order.template is not None:
            payload["pattern"] = self.upload("patterns", order.template)
        elif template is not None:
            payload["template"] = template
        return payload

    def submit_derived(self, order: DerivedOrder) -> SubmissionResult:
        """Upload an order's files and create the job that works on a stored result."""
        payload: dict[str, Any] = {
            "kind": order.kind,
            "result": self._complete(order.result),
            "options": dict(order.options),
            "files": {name: self._send_file(name, file) for name, file in order.files.items()},
            **_describe_terms(order.terms),
        }
        if order.over:  # a service of an earlier version refuses the field
            payload["over"] = self._complete(order.over)
        return self._submit(payload, order.terms)

    def _submit(self, payload: dict[str, Any], terms: JobTerms) -> SubmissionResult:
        """Create a job; a forced one has an idempotency key, so that a repeated request creates no second job."""
        headers = {"idempotency-key": terms.nonce or uuid.uuid4().hex} if terms.force else {}
        return read_submitted(self._ask("POST", "/v1/jobs", json=payload, headers=headers))

    def _complete(self, job: str) -> str:
        """Return the complete id of a job from a beginning of it."""
        return self.find_job(job).id if len(job) < ID_LENGTH else job

    def _send_file(self, field: str, file: Path | FileRef) -> str:
        """Send a file of a derived job's request, and return its key.

        Raises:
            RequestBad: if no kind has a file of that field.
        """
        if field not in UPLOADS:
            raise RequestBad(f"no request has a file '{field[:40]}'; there are {', '.join(UPLOADS)}.")
        return self.upload(UPLOADS[field], file) if isinstance(file, Path) else file.sha256

    def _describe_person(self, order: Order) -> dict[str, Any]:
        """Return an order's options for a person, without empty fields, which an earlier version would refuse."""
        parts = {}
        for word, one in order.choices.items():
            pattern = self.upload("patterns", one.template) if one.template is not None else None
            template = None if pattern else one.name
            choices = {"garment": one.garment, "fabric": one.fabric, "lock": one.lock, "cut": one.parts}
            values = {"pattern": pattern, "template": template, **choices}
            parts[word] = {name: value for name, value in values.items() if value is not None}
        said = {"as": order.given_as, "wearing": order.wearing, "marks": list(order.marks), "parts": parts}
        return {name: value for name, value in said.items() if value}

    def upload(self, kind: str, path: Path) -> str:
        """Send a file as `scans`, `bodies`, `labels` or `patterns`, unless the service has it; return its sha256."""
        try:
            with path.open("rb") as stream:
                digest = hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError as error:
            raise BodyUnreadable(f"'{path}' cannot be read: {error.strerror}.") from error
        with suppress(NotFound):
            if self._ask("GET", f"/v1/{kind}/{digest}")["name"].endswith(path.suffix):
                return digest
        headers = {"x-content-sha256": digest, "content-length": str(path.stat().st_size)}
        found = self._ask("POST", f"/v1/{kind}", tries=1, params={"name": path.name}, content=path, headers=headers)
        return str(found["sha256"])

    def find_job(self, job: str) -> JobReport:
        """Return a job by its id, or by a beginning of the id that no other job has."""
        found = self._ask("GET", f"/v1/jobs/{quote(job, safe='')}")
        return read(lambda: JobReport.from_json(found))

    def wait_job(self, job: str, seconds: float) -> JobReport:
        """Return a job as soon as it has ended, or as it is after some seconds, at most 60.

        Of a key that has all its streams open the job is returned after a moment.
        """
        params = {"wait": round(min(max(seconds, 0.0), MAX_WAIT_SECONDS), 3)}
        try:
            found = self._ask("GET", f"/v1/jobs/{quote(job, safe='')}", params=params)
        except GarmentqError as error:
            if error.code != "request.streams_full":
                raise
            time.sleep(min(self.poll_seconds, max(seconds, 0.0)))
            return self.find_job(job)
        return read(lambda: JobReport.from_json(found))

    def find_jobs_by_id(self, ids: Sequence[str], below: bool = False) -> list[Job]:
        """Return the progress of some jobs, a thousand a request; with `below`, then of all jobs below them."""
        found: dict[str, Job] = {}
        for start in range(0, len(ids), MAX_JOBS_PER_REQUEST):
            payload = {"jobs": list(ids[start : start + MAX_JOBS_PER_REQUEST])} | ({"below": True} if below else {})
            answer = self._ask("POST", "/v1/jobs/states", json=payload)
            found |= {job.id: job for job in read_all(Job.from_json, answer, "jobs")}
        known, requested = order_by_ids(ids, found), set(ids)
        return known + [job for job in found.values() if job.id not in requested]

    def list_jobs(self, limit: int = 50) -> list[JobReport]:
        """Return the running jobs, then the newest others, each newest first; at most a thousand.

        The running jobs are read last: a job that starts between both requests is at least among these.
        """
        conditions: list[dict[str, Any]] = [{}, {"state": State.RUNNING.value}]
        pages = [
            self._ask("GET", "/v1/jobs", params=one | {"limit": min(limit, MAX_JOBS_PER_REQUEST), "detail": "full"})
            for one in conditions
        ]
        found = {job.id: job for one in pages for job in read_all(JobReport.from_json, one, "jobs")}
        newest = sorted(found.values(), key=lambda job: (-job.created, job.id))
        return sorted(newest, key=lambda job: job.state != State.RUNNING)[:limit]

    def find_jobs(self, terms: JobQuery) -> list[JobReport]:
        """Return the jobs that meet every condition of a query, which is parsed here before it is sent."""
        return read_all(JobReport.from_json, self._query(terms, detail="full"), "jobs")

    def find_page(self, terms: JobQuery) -> JobPage:
        """Return a page of the jobs that meet a query, with their number and the next page's cursor."""
        found = self._query(terms)
        return read(lambda: JobPage(read_all(ListedJob.from_json, found, "jobs"), found["total"], found["next"]))

    def _query(self, terms: JobQuery, **more: str) -> Json:
        _ = terms.conditions
        params = {**terms.fields, "where": list(terms.wheres), "sort": terms.sort, "limit": terms.limit, **more}
        params |= {"offset": terms.offset} if terms.offset else {}
        params |= {} if terms.cursor is None else {"cursor": terms.cursor}
        found: Json = self._ask("GET", "/v1/query", params=params)
        return found

    def poll_events(self, job: str, after: int = 0) -> News:
        """Return a job's state and its events with an id above `after`."""
        events: list[Event] = []
        following: int | None = after
        while following is not None:
            found = self._ask("GET", f"/v1/jobs/{quote(job, safe='')}/events", params={"after": following})
            events += read_all(Event.from_json, found, "events")
            following = found.get("next")
        return read(lambda: News(State(found["state"]), events))

    def read_queue(self) -> Queue:
        """Count the jobs by state, and list the living workers."""
        found = self._ask("GET", "/v1/queue")
        return read(lambda: Queue.from_json(found))

    def follow(self, job: str, after: int = 0) -> Iterator[Event]:
        """Yield a job's events as they happen until it has ended; a broken connection is resumed at the next event."""
        url, failures = f"/v1/jobs/{quote(job, safe='')}/events", 0
        while True:
            headers = {"accept": "text/event-stream", "last-event-id": str(after)}
            try:
                with self._connection.stream(url, headers) as answer:
                    kind = ""
                    for line in answer.iter_lines():
                        if line.startswith("event: "):
                            kind = line[7:]
                        elif line.startswith("data: ") and kind == "end":
                            return
                        elif line.startswith("data: "):
                            event = read(partial(_read_event, line[6:]))
                            after, failures = event.id, 0
                            yield event
            except httpx.TransportError as error:
                failures += 1
                if failures >= MAX_REQUEST_TRIES:
                    raise ServiceUnreachable(f"the service at {self._connection.address} does not respond.") from error
            time.sleep(0.5)

    def list_artifacts(self, job: str) -> list[Artifact]:
        """Return a job's result files by name."""
        found = self._ask("GET", f"/v1/jobs/{quote(job, safe='')}/artifacts")
        return read_all(Artifact.from_json, found, "files")

    def export_files(self, job: str, folder: Path, names: Sequence[str] = ()) -> list[Path]:
        """Download a job's result files (all, or those named) into a folder, each checked against its hash."""
        files = choose_files(job, self.list_artifacts(job), names)
        return [self._download(job, file, folder) for file in files]

    def list_versions(self, job: str) -> list[Version]:
        """Return all versions of the result that a job belongs to, oldest first."""
        return read_all(Version.from_json, self._ask("GET", f"/v1/jobs/{quote(job, safe='')}/versions"), "versions")

    def cancel(self, job: str) -> State:
        """Request that a job stops, and return its state after that."""
        found = self._ask("POST", f"/v1/jobs/{quote(job, safe='')}/cancel")
        return read(lambda: State(found["state"]))

    def retry(self, job: str) -> State:
        """Queue a job again that ended without success."""
        found = self._ask("POST", f"/v1/jobs/{quote(job, safe='')}/retry", tries=1)
        return read(lambda: State(found["state"]))

    def rename(self, job: str, name: str | None = None, tags: Sequence[str] | None = None) -> JobReport:
        """Write another name or other tags of a job's family, and return the job; None: as it is."""
        changes = {"name": name, "tags": None if tags is None else list(tags)}
        found = self._ask("PATCH", f"/v1/jobs/{quote(job, safe='')}", json=changes)
        return read(lambda: JobReport.from_json(found))

    def change_priority(self, job: str, priority: int) -> int:
        """Change the priority of a job's whole family, and return the job's own after that."""
        found = self._ask("PATCH", f"/v1/jobs/{quote(job, safe='')}", json={"priority": priority})
        return read(lambda: int(found["priority"]))

    def refine(self, job: str) -> SubmissionResult:
        """Queue the recovery at standard quality of a preview's files."""
        return read_submitted(self._ask("POST", f"/v1/jobs/{quote(job, safe='')}/refine"))

    def read_health(self) -> dict[str, Any]:
        """Return the service's version, and `ok` or the fault of its database and store."""
        version = str(self._ask("GET", "/healthz")["version"])
        return {"version": version, **self._ask("GET", "/readyz")}

    def _download(self, job: str, file: Artifact, folder: Path) -> Path:
        """Write a file below the folder only: a service's response is as untrusted as a user's file."""
        parts = file.name.split("/")
        if any(part in ("", ".", "..") or "\\" in part or not part.isprintable() for part in parts):
            raise ArtifactDamaged(f"the service names a file '{file.name[:80]}', an invalid name; inform its operator.")
        path = folder.joinpath(*parts)
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.parent / f".garmentq-{secrets.token_hex(8)}"
        try:
            digest = hashlib.sha256()
            url = f"/v1/jobs/{quote(job, safe='')}/artifacts/{quote(file.name)}"
            with temporary.open("xb") as out, self._connection.reach(), self._connection.stream(url) as answer:
                for block in answer.iter_bytes():
                    digest.update(block)
                    out.write(block)
            if digest.hexdigest() != file.sha256:
                raise ArtifactDamaged()
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)
        return path


def _describe_terms(terms: JobTerms) -> dict[str, Any]:
    """Return the terms of a job as fields of a request; the service knows the key."""
    names = ("priority", "queue", "force", "name")
    subject = {"subject": terms.subject} if terms.subject else {}  # a service of an earlier version refuses the field
    return {name: getattr(terms, name) for name in names} | {"tags": list(terms.tags)} | subject


def _read_result(found: Json) -> SubmissionResult | GarmentqError:
    """Return what became of one of several orders."""
    if found["error"] is None:
        return read_submitted(found["job"])
    return make_refusal(int(found["error"]["status"]), str(found["error"]["code"]), str(found["error"]["detail"]))


def read_submitted(found: Json) -> SubmissionResult:
    """Return what the service answers to a submission."""
    return read(
        lambda: SubmissionResult(
            check_id(found["job"]), bool(found["is_new"]), State(found["state"]), found.get("understood")
        )
    )


def _read_event(text: str) -> Event:
    return Event.from_json(json.loads(text))
