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
import weakref
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import httpx

from ..core.errors import BadInput, GarmentqError, NotFound
from .store import BLOCK, ArtifactDamaged
from .submission import BUILTIN, BodyUnreadable, Order, Submitted

SECONDS = httpx.Timeout(150.0, connect=5.0)
"""The service answers within 120 s or says that it cannot; a connection takes milliseconds."""

PATIENT = ("key.too_many_requests", "key.uploads_open")
"""Refusals that pass by themselves within seconds: the client waits as long as it is told, and asks again."""

PATIENCE_SECONDS = 60.0
"""How long it waits in all for one request [s]."""

TRIES = 3
"""Times that a question is asked again where the connection breaks; every one of them is safe to repeat."""


class ServiceUnreachable(GarmentqError):
    """The service does not answer; check GARMENTQ_URL, or start it by `garmentq serve`."""

    code = "service.unreachable"


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
        headers = {"authorization": f"Bearer {key}"} if key else {}
        try:
            self._http = httpx.Client(base_url=url.rstrip("/"), headers=headers, timeout=SECONDS)
        except (httpx.InvalidURL, ValueError) as error:
            raise ServiceUnreachable(f"GARMENTQ_URL is no address: {error}.") from error
        weakref.finalize(self, self._http.close)  # a command that ends by an error leaves no socket open

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection."""
        self._http.close()

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
        if isinstance(order.body, str) and order.body.startswith(BUILTIN):
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
        return Submitted(found["job"], found["is_new"], found["state"])

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

    def list_jobs(self, limit: int = 50) -> list[Job]:
        """Give the newest jobs, newest first."""
        return [_make_job(row) for row in self._ask("GET", "/v1/jobs", params={"limit": min(limit, 1000)})["jobs"]]

    def read_events(self, job: str, after: int = 0) -> list[Event]:
        """Give a job's events with an id above `after`, in order."""
        found = self._ask("GET", f"/v1/jobs/{quote(job, safe='')}/events", params={"after": after})
        return [Event(e["id"], job, e["at"], e["kind"], e["data"]) for e in found["events"]]

    def follow(self, job: str, after: int = 0) -> Iterator[Event]:
        """Give a job's events as they happen until it has ended; a broken connection is taken up where it broke."""
        url, failures = f"/v1/jobs/{quote(job, safe='')}/events", 0
        while True:
            headers = {"accept": "text/event-stream", "last-event-id": str(after)}
            try:
                with self._http.stream("GET", url, headers=headers) as answer:
                    if answer.status_code >= 400:
                        answer.read()
                        raise _make_error(answer)
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
                    raise ServiceUnreachable(f"the service at {self._http.base_url} does not answer.") from error
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

    def _download(self, job: str, file: File, folder: Path) -> Path:
        """Write below the folder only: a service's answer is as little to be trusted as a user's file."""
        parts = file.name.split("/")
        if any(part in ("", ".", "..") or "\\" in part or "\x00" in part for part in parts):
            raise ArtifactDamaged(f"the service names a file '{file.name[:80]}', which is no name; tell its operator.")
        path = folder.joinpath(*parts)
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor, temporary = tempfile.mkstemp(dir=path.parent)
        try:
            digest = hashlib.sha256()
            url = f"/v1/jobs/{quote(job, safe='')}/artifacts/{quote(file.name)}"
            with os.fdopen(descriptor, "wb") as out, self._reach(), self._http.stream("GET", url) as answer:
                if answer.status_code >= 400:
                    answer.read()
                    raise _make_error(answer)
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

    def _ask(self, method: str, url: str, **options: Any) -> Any:
        answer = self._send(method, url, **options)
        try:
            return answer.json()
        except ValueError:
            raise ServiceUnreachable(f"what answers at {self._http.base_url} is no garmentq service.") from None

    def _send(self, method: str, url: str, tries: int = TRIES, **options: Any) -> httpx.Response:
        """Ask, and wait where the service says that the key asks too often."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while True:
            answer = self._send_now(method, url, tries, **options)
            if answer.status_code < 400:
                return answer
            error, pause = _make_error(answer), _pause_of(answer)
            if error.code not in PATIENT or time.monotonic() + pause > deadline:
                raise error
            time.sleep(pause)

    def _send_now(
        self, method: str, url: str, tries: int, content: bytes | Path | None = None, **options: Any
    ) -> httpx.Response:
        """Ask at once; a file is streamed, and a broken connection is tried again `tries` times in all."""
        with self._reach():
            while True:
                try:
                    if not isinstance(content, Path):
                        return self._http.request(method, url, content=content, **options)
                    with content.open("rb") as stream:
                        blocks = iter(lambda: stream.read(BLOCK), b"")
                        return self._http.request(method, url, content=blocks, **options)
                except httpx.ConnectError:
                    raise
                except httpx.TransportError:
                    tries -= 1
                    if tries <= 0:
                        raise
                    time.sleep(0.2)

    @contextmanager
    def _reach(self) -> Iterator[None]:
        try:
            yield
        except (httpx.TransportError, httpx.InvalidURL) as error:
            raise ServiceUnreachable(
                f"the service at {self._http.base_url} does not answer ({type(error).__name__}); "
                "check GARMENTQ_URL, or start it by `garmentq serve`."
            ) from error


def _pause_of(answer: httpx.Response) -> float:
    """Read how long to wait [s]; a second where the service does not tell."""
    text = answer.headers.get("retry-after", "")
    return float(text) if text.isascii() and text.isdigit() else 1.0


def _make_error(answer: httpx.Response) -> GarmentqError:
    """Give the error that the service met, of the class that its status tells, under the service's own code."""
    try:
        found = answer.json()
        code, message = str(found["code"]), str(found["detail"])
    except (ValueError, KeyError, TypeError):
        return ServiceUnreachable(f"what answers at {answer.url.host} is no garmentq service ({answer.status_code}).")
    kinds: dict[int, type[GarmentqError]] = {404: NotFound, 400: BadInput, 408: BadInput, 409: BadInput}
    kinds |= {413: BadInput, 422: BadInput}
    error = kinds.get(answer.status_code, GarmentqError)(message)
    error.code = code
    return error


def _make_job(found: dict[str, Any]) -> Job:
    error = found["error"] or {}
    described = {name: value for name, value in found.items() if name not in ("bad_input", "queue", "priority")}
    names = ("name", "state", "stage", "progress", "attempts", "created", "started", "finished")
    return Job(
        id=found["job"],
        **{name: found[name] for name in names},
        error_code=error.get("code"),
        error_message=error.get("message"),
        bad_input=found["bad_input"],
        queue=found["queue"],
        priority=found["priority"],
        described=described,
    )
