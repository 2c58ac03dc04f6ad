"""A typed client of the HTTP API.

with Client("http://127.0.0.1:8080", key="gq_...") as client:
    job = client.submit(Order(Path("skirt.ply"), "builtin:female,height=1.70")).job
    for event in client.follow(job):
        print(event.kind, event.data)
    client.export_files(job, Path("result"))
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
import time
import uuid
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import httpx

from ..core.body import is_builtin
from ..core.errors import NotFound
from .connection import TRIES, Connection, ServiceUnreachable
from .jobs import JobUnknown
from .store import ArtifactDamaged
from .submission import BodyUnreadable, Order, Submitted

__all__ = ["Client", "Event", "File", "Job", "Key", "ServiceUnreachable", "Worker"]

MOST_JOBS = 1000
"""Jobs of one question about states, as the service bounds it."""


@dataclass(frozen=True)
class Job:
    """Show a job as the service knows it; `described` holds everything that it said."""

    id: str
    name: str
    state: str
    stage: str
    progress: float
    attempts: int
    created: float
    started: float | None
    finished: float | None
    error_code: str | None
    error_message: str | None
    bad_input: bool
    queue: str
    priority: int
    described: dict[str, Any]


@dataclass(frozen=True)
class Event:
    """Tell one thing that happened to a job."""

    id: int
    job: str
    at: float
    kind: str
    data: dict[str, Any]


@dataclass(frozen=True)
class File:
    """Name one file of a job: its name, sha256 (hex) and size [bytes]."""

    name: str
    sha256: str
    size: int


@dataclass(frozen=True)
class Worker:
    """Tell of a living worker; its name is hidden from all but the scope `admin`."""

    name: str
    queues: str
    concurrency: int
    started: float
    seen: float


@dataclass(frozen=True)
class Key:
    """Show an API key, without its token."""

    id: str
    name: str
    scopes: list[str]
    quota: int
    created: float
    revoked: float | None


class Client:
    """Ask a service by HTTP. Every refusal is a `GarmentqError` with the service's code."""

    def __init__(self, url: str, key: str = "") -> None:
        """Prepare a client; nothing is sent before the first question.

        Args:
            url: Address of the service, `http://host:port`.
            key: Token of an API key, or empty.

        Raises:
            ServiceUnreachable: where the address is none.
        """
        self._connection = Connection(url, key)
        self._ask, self._send = self._connection.ask, self._connection.send

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()

    def submit(self, order: Order) -> Submitted:
        """Upload an order's files and ask for the job; a template that is no file goes by its name in the settings."""
        settings = order.settings.as_dict()
        template = settings.pop("template")
        wanted: dict[str, Any] = {
            "scan": self.upload("scans", order.scan),
            "settings": settings,
            "priority": order.priority,
            "queue": order.queue,
            "force": order.force,
        }
        if is_builtin(order.body):
            wanted["body"] = order.body
        elif order.body is not None:
            wanted["body"] = self.upload("bodies", Path(order.body))
        if order.labels is not None:
            wanted["labels"] = self.upload("labels", order.labels)
        if order.template is not None:
            wanted["pattern"] = self.upload("patterns", order.template)
        elif template is not None:
            wanted["template"] = template
        token = order.nonce or uuid.uuid4().hex
        found = self._ask("POST", "/v1/jobs", json=wanted, headers={"idempotency-key": token} if order.force else {})
        return Submitted(_checked(found["job"]), found["is_new"], found["state"])

    def upload(self, kind: str, path: Path) -> str:
        """Send a file as one of `scans`, `bodies`, `labels`, `patterns`, unless the service has it; give its sha256."""
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

    def find_job(self, job: str) -> Job:
        """Give a job by its id."""
        return _make_job(self._ask("GET", f"/v1/jobs/{quote(job, safe='')}"))

    def find_jobs_by_id(self, jobs: Sequence[str]) -> list[Job]:
        """Give the jobs of some ids in their order, told by one request for each thousand; what they found is left out.

        Raises:
            JobUnknown: where one is not known.
        """
        found: dict[str, Job] = {}
        for start in range(0, len(jobs), MOST_JOBS):
            answer = self._ask("POST", "/v1/jobs/states", json={"jobs": list(jobs[start : start + MOST_JOBS])})
            found |= {row["job"]: _make_job(row) for row in answer["jobs"]}
        missing = [job for job in jobs if job not in found]
        if missing:
            raise JobUnknown(f"there is no job '{missing[0]}'; `garmentq status` lists them all.")
        return [found[job] for job in jobs]

    def look(self, job: str, after: int = 0) -> tuple[str, list[Event]]:
        """Give a job's state, and its events with an id above `after`, in one request."""
        found = self._ask("GET", f"/v1/jobs/{quote(job, safe='')}/events", params={"after": after})
        return found["state"], [Event(e["id"], job, e["at"], e["kind"], e["data"]) for e in found["events"]]

    def read_queue(self) -> tuple[dict[str, int], list[Worker]]:
        """Count the jobs by state, and give the living workers."""
        found = self._ask("GET", "/v1/queue")
        return found["states"], [Worker(**row) for row in found["workers"]]

    def list_jobs(self, limit: int = 50) -> list[Job]:
        """Give the newest jobs, newest first."""
        return [_make_job(row) for row in self._ask("GET", "/v1/jobs", params={"limit": min(limit, 1000)})["jobs"]]

    def read_events(self, job: str, after: int = 0) -> list[Event]:
        """Give a job's events with an id above `after`, in order."""
        return self.look(job, after)[1]

    def follow(self, job: str, after: int = 0) -> Iterator[Event]:
        """Give a job's events as they happen until it has ended; a broken connection is taken up where it broke."""
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
                            found = json.loads(line[6:])
                            after, failures = found["id"], 0
                            yield Event(found["id"], job, found["at"], found["kind"], found["data"])
            except httpx.TransportError as error:
                failures += 1
                if failures >= TRIES:
                    raise ServiceUnreachable(f"the service at {self._connection.address} does not answer.") from error
            time.sleep(0.5)

    def list_files(self, job: str) -> list[File]:
        """Give a job's result files by name."""
        found = self._ask("GET", f"/v1/jobs/{quote(job, safe='')}/artifacts")
        return [File(row["name"], row["sha256"], row["size"]) for row in found["files"]]

    def export_files(self, job: str, folder: Path, names: Sequence[str] = ()) -> list[Path]:
        """Download a job's files (all, or those named) into a folder, each checked against its hash."""
        from .results import ResultMissing

        files = self.list_files(job)
        if not files:
            raise ResultMissing(f"job {job} has no result files; `garmentq status {job}` tells why.")
        unknown = set(names) - {file.name for file in files}
        if unknown:
            known = ", ".join(file.name for file in files)
            raise ResultMissing(f"job {job} has no file {', '.join(sorted(unknown))}; it has {known}.")
        return [self._download(job, file, folder) for file in files if not names or file.name in names]

    def find_jobs(
        self, wheres: Sequence[str] = (), sort: str = "-created", limit: int = 50, **given: str | None
    ) -> list[Job]:
        """Give the jobs that meet every condition; `given` are garment, state and fabric."""
        params: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        params |= {"where": list(wheres), "sort": sort, "limit": limit}
        return [_make_job(row) for row in self._ask("GET", "/v1/query", params=params)["jobs"]]

    def cancel(self, job: str) -> str:
        """Stop a job; give its state after that."""
        return str(self._ask("POST", f"/v1/jobs/{quote(job, safe='')}/cancel")["state"])

    def retry(self, job: str) -> None:
        """Queue an ended job again."""
        self._ask("POST", f"/v1/jobs/{quote(job, safe='')}/retry", tries=1)

    def list_templates(self) -> list[dict[str, Any]]:
        """Give the templates: name, category, source, title."""
        return list(self._ask("GET", "/v1/templates")["templates"])

    def read_template(self, name: str) -> bytes:
        """Give a template's pattern file."""
        return self._send("GET", f"/v1/templates/{quote(name, safe='')}").content

    def import_template(self, name: str, path: Path) -> dict[str, Any]:
        """Send a pattern file as a template; give its name, panels, seams and category."""
        return dict(self._ask("PUT", f"/v1/templates/{quote(name, safe='')}", content=path.read_bytes()))

    def list_materials(self) -> list[dict[str, Any]]:
        """Give the fabrics, each with every parameter in SI units and its sources."""
        return list(self._ask("GET", "/v1/materials")["materials"])

    def read_material(self, name: str) -> dict[str, Any]:
        """Give one fabric."""
        return dict(self._ask("GET", f"/v1/materials/{quote(name, safe='')}"))

    def create_key(self, name: str, scopes: Sequence[str], quota: int) -> tuple[Key, str]:
        """Make an API key; its token is given here and never again."""
        found = self._ask("POST", "/v1/keys", tries=1, json={"name": name, "scopes": list(scopes), "quota": quota})
        return _make_key(found), str(found["token"])

    def list_keys(self) -> list[Key]:
        """Give every API key, oldest first."""
        return [_make_key(row) for row in self._ask("GET", "/v1/keys")["keys"]]

    def revoke_key(self, key: str) -> Key:
        """Take an API key back."""
        return _make_key(self._ask("DELETE", f"/v1/keys/{quote(key, safe='')}"))

    def read_health(self) -> dict[str, str]:
        """Give the service's version, and `ok` or what is wrong of its database and store."""
        version = str(self._ask("GET", "/healthz")["version"])
        return {"version": version, **self._ask("GET", "/readyz")}

    def _download(self, job: str, file: File, folder: Path) -> Path:
        """Write below the folder only: a service's answer is as little to be trusted as a user's file."""
        parts = file.name.split("/")
        if any(part in ("", ".", "..") or "\\" in part or not part.isprintable() for part in parts):
            raise ArtifactDamaged(f"the service names a file '{file.name[:80]}', which is no name; tell its operator.")
        path = folder.joinpath(*parts)
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor, temporary = tempfile.mkstemp(dir=path.parent)
        try:
            digest = hashlib.sha256()
            url = f"/v1/jobs/{quote(job, safe='')}/artifacts/{quote(file.name)}"
            with os.fdopen(descriptor, "wb") as out, self._connection.reach(), self._connection.stream(url) as answer:
                for block in answer.iter_bytes():
                    digest.update(block)
                    out.write(block)
            if digest.hexdigest() != file.sha256:
                raise ArtifactDamaged()
            os.chmod(temporary, 0o644)
            os.replace(temporary, path)
        finally:
            Path(temporary).unlink(missing_ok=True)
        return path


def _checked(job: str) -> str:
    """Give an id that may be printed and put into a path.

    Raises:
        ServiceUnreachable: where what answers is no service of ours.
    """
    if not (job.isascii() and job.isalnum() and len(job) <= 16):
        raise ServiceUnreachable("what answers is no garmentq service: it gives a job an id that is none.")
    return job


def _make_job(found: dict[str, Any]) -> Job:
    error = found["error"] or {}
    described = {name: value for name, value in found.items() if name not in ("bad_input", "queue", "priority")}
    names = ("name", "state", "stage", "progress", "attempts", "created", "started", "finished")
    return Job(
        id=_checked(found["job"]),
        **{name: found[name] for name in names},
        error_code=error.get("code"),
        error_message=error.get("message"),
        bad_input=found["bad_input"],
        queue=found["queue"],
        priority=found["priority"],
        described=described,
    )


def _make_key(found: dict[str, Any]) -> Key:
    return Key(found["key"], *(found[name] for name in ("name", "scopes", "quota", "created", "revoked")))
