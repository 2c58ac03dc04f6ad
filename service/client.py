"""A program's client of the HTTP API: the operations of `RemoteBackend`, and all other routes.

import garmentq
with garmentq.Client("http://127.0.0.1:8080", key="gq_...") as service:
    job = service.recover("scan.ply", name="anna", tags=["march"]).wait()
    print(job.pattern.panels, job.mesh("detail").vertices.shape)
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any
from urllib.parse import quote

from ..core.body.spec import read_wearer
from ..core.recover.settings import RecoverySettings, SettingsBad, complete_by_quality
from ..core.run.errors import BadInput, GarmentqError, NotFound
from .connection import ServiceUnreachable
from .deletion import Deleted
from .job_handle import JobHandle
from .opening import find_key
from .order import Order
from .persons import Person, PersonDeleted
from .query import JobQuery
from .records import ListedJob
from .remote import RemoteBackend, read_submitted
from .remote_libraries import read
from .settings import read_settings
from .submission import SubmissionResult
from .terms import JobTerms

__all__ = ["Client"]


class Client(RemoteBackend):
    """Call every route of a service. Every refusal is a `GarmentqError` with the service's code."""

    def __init__(self, url: str = "", key: str | None = None) -> None:
        """Prepare a client; nothing is sent before the first request.

        Args:
            url: Address of the service, `http://host:port`; empty: that of GARMENTQ_URL.
            key: Token of an API key. None: that of GARMENTQ_API_KEY, or of the home for a service on this machine.

        Raises:
            ServiceUnreachable: if the address is invalid.
        """
        settings = read_settings()
        address = url or os.environ.get("GARMENTQ_URL", "")
        super().__init__(address, find_key(address, settings) if key is None else key)

    def __repr__(self) -> str:
        """Return a short description, without the key."""
        return f"<Client {self._connection.address}>"

    def recover(
        self,
        scan: str | Path,
        body: str | Path | None = None,
        *,
        name: str = "",
        tags: Sequence[str] = (),
        given_as: str | None = None,
        quality: str | None = None,
        subject: str = "",
        **settings: Any,
    ) -> JobHandle:
        """Upload a scan, queue its recovery, and return the job.

        Args:
            scan: File of a dressed person or of a garment.
            body: The wearer of a garment: a file, or `builtin:female,height=1.70`.
            name: Name of the job; empty: that of the file.
            tags: Words by which it can be found.
            given_as: `person` or `garment`; None: found out.
            quality: `preview`, `standard` or `fine`; None: `standard`.
            subject: Id or name of the person who was scanned; a new name creates a subject.
            settings: Fields of `RecoverySettings`, as `method="deform"`.

        Raises:
            SettingsBad: if a setting is unknown or cannot be used; the message has the nearest name.
            GarmentqError: with the code of what else cannot be used.
        """
        order = _make_order(scan, body, (name, tags), given_as, _make_settings(quality, settings))
        return JobHandle(self, self.submit(self.check_order(order, order.settings.template)).job)

    def recover_many(
        self,
        scans: Sequence[str | Path],
        body: str | Path | None = None,
        *,
        tags: Sequence[str] = (),
        given_as: str | None = None,
        quality: str | None = None,
        **settings: Any,
    ) -> list[JobHandle | GarmentqError]:
        """Upload scans, queue their recoveries in one request for each hundred, and return a job or refusal for each.

        The arguments are those of `recover`. A scan that is refused does not keep the others from being queued.

        Raises:
            SettingsBad: if a setting is unknown or cannot be used.
        """
        chosen = _make_settings(quality, settings)
        results: dict[int, JobHandle | GarmentqError] = {}
        orders: dict[int, Order] = {}
        for number, scan in enumerate(scans):
            order = _make_order(scan, body, ("", tags), given_as, chosen)
            try:
                orders[number] = self.check_order(order, chosen.template)
            except (BadInput, NotFound) as error:
                results[number] = error
        for number, done in zip(orders, self.submit_many(list(orders.values())), strict=True):
            results[number] = done if isinstance(done, GarmentqError) else JobHandle(self, done.job)
        return [results[number] for number in range(len(scans))]

    def job(self, job: str) -> JobHandle:
        """Return a job by its id or a beginning of it.

        Raises:
            JobUnknown: if there is none.
        """
        return JobHandle(self, job)

    def iterate_jobs(self, terms: JobQuery) -> Iterator[ListedJob]:
        """Yield all jobs that meet a query, page after page of its `limit`.

        Raises:
            QueryBad: if a condition cannot be parsed, or names an unknown field.
        """
        following: JobQuery | None = terms
        while following is not None:
            page = self.find_page(following)
            yield from page.jobs
            following = replace(following, cursor=page.next, offset=0) if page.next else None

    def match(
        self,
        first: str,
        second: str,
        pairs: Mapping[str, str] | None = None,
        only_given: bool = False,
        outlines: bool = False,
    ) -> dict[str, Any]:
        """Compare two patterns panel by panel, as JSON values.

        Args:
            first, second: Jobs, templates, or uploaded patterns by their hash.
            pairs: Names of the second's panels by the first's, where they are known.
            only_given: Compare only these pairs.
            outlines: Also return every panel's outline [m].
        """
        params: dict[str, Any] = {"first": first, "second": second}
        params["pair"] = [f"{one}:{other}" for one, other in (pairs or {}).items()]
        params |= {"only_given": only_given, "outlines": outlines}
        return self._request_object("GET", "/v1/match", params=params)

    def inspect_scan(self, sha256: str, quick: bool = False, **options: str) -> dict[str, Any]:
        """Return what is detected in an uploaded scan, before a job is created.

        Args:
            sha256: Its hash, as `upload("scans", path)` returns it.
            quick: Read only the file, and do not fit the wearer.
            options: Options of an order: `as_` (person or garment), `body` (builtin:...), `units`, `up`, `height`.
        """
        params = {name.rstrip("_"): value for name, value in options.items()} | {"quick": quick}
        return self._request_object("GET", f"/v1/scans/{quote(sha256, safe='')}/inspection", params=params)

    def check_pattern(self, document: Mapping[str, Any]) -> dict[str, Any]:
        """Return findings, lengths, seams and symmetry of a pattern's document (docs/reference/http.md)."""
        return self._request_object("POST", "/v1/patterns/check", json=dict(document))

    def edit_pattern(self, document: Mapping[str, Any], operations: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """Return a document after operations, as `pattern`, beside the result of `check_pattern`."""
        payload = {"pattern": dict(document), "operations": [dict(one) for one in operations]}
        return self._request_object("POST", "/v1/patterns/edit", json=payload)

    def read_wearer(self, job: str) -> dict[str, Any]:
        """Return the wearer that a job estimated: source, joints [m] by name, parameters."""
        return self._request_object("GET", f"/v1/bodies/of/{quote(job, safe='')}")

    def read_export(self, job: str, name: str) -> bytes:
        """Return a file by name from the newest export of a job's result."""
        return self._send("GET", f"/v1/jobs/{quote(job, safe='')}/exports/{quote(name, safe='')}").content

    def read_archive(self, job: str) -> bytes:
        """Return all files of a job as one .zip; `export_files` checks each against its hash."""
        return self._send("GET", f"/v1/jobs/{quote(job, safe='')}/result.zip").content

    def mend_labels(self, job: str, points: Path) -> SubmissionResult:
        """Label a person's scan again with corrected labels; the job stays, and a new one is queued.

        Args:
            job: A job of kind `person` with files.
            points: An .npy file, uint8: the number of a `Part` for each point of the job's segmented.ply.
        """
        payload = {"points": self.upload("labels", points)}
        return read_submitted(self._request_object("POST", f"/v1/jobs/{quote(job, safe='')}/labels", json=payload))

    def set_wearing(self, job: str, wearing: str) -> SubmissionResult:
        """Label a person's scan again in another outfit; the job stays, and a new one is queued.

        Args:
            job: A job of kind `person`; its `details["outfits"]` has the readings, the likeliest first.
            wearing: Exactly these garments, `upper,lower`, or `nothing`.
        """
        path = f"/v1/jobs/{quote(job, safe='')}/wearing"
        return read_submitted(self._request_object("POST", path, json={"wearing": wearing}))

    def delete_job(self, job: str) -> Deleted:
        """Delete an ended job, all jobs below it and all jobs that read its results."""
        found = self._request_object("DELETE", f"/v1/jobs/{quote(job, safe='')}", tries=1)
        return read(lambda: Deleted.from_json(found))

    def find_person(self, name: str) -> Person:
        """Return the data of a person, whose jobs, scans or uploads have exactly this name."""
        found = self._request_object("GET", f"/v1/persons/{quote(name, safe='')}")
        return read(lambda: Person.from_json(found))

    def delete_person(self, name: str, dry_run: bool = False) -> PersonDeleted:
        """Delete the scans and uploads of exactly this name, and all made of them; a dry run only lists them."""
        params = {"dry_run": True} if dry_run else {}
        found = self._request_object("DELETE", f"/v1/persons/{quote(name, safe='')}", tries=1, params=params)
        return read(lambda: PersonDeleted.from_json(found))

    def forget_upload(self, kind: str, sha256: str) -> Deleted:
        """Delete an upload, one of `scans`, `bodies`, `labels`, `patterns`, `motions`; jobs keep their files."""
        found = self._request_object("DELETE", f"/v1/{kind}/{quote(sha256, safe='')}", tries=1)
        return read(lambda: Deleted.from_json(found))

    def read_metrics(self) -> str:
        """Return the service's metrics in the text format of Prometheus."""
        return self._send("GET", "/metrics").text

    def read_api(self) -> dict[str, Any]:
        """Return the OpenAPI document."""
        return self._request_object("GET", "/openapi.json")

    def _request_object(self, method: str, url: str, **options: Any) -> dict[str, Any]:
        """Return a JSON object.

        Raises:
            ServiceUnreachable: if the response is something else.
        """
        found = self._ask(method, url, **options)
        if not isinstance(found, dict):
            raise ServiceUnreachable("the server is not a garmentq service: its response cannot be read.")
        return found


def _make_order(
    scan: str | Path,
    body: str | Path | None,
    labels: tuple[str, Sequence[str]],
    given_as: str | None,
    settings: RecoverySettings,
) -> Order:
    """Return the order of a recovery; `labels` are its name and tags."""
    wearer = read_wearer(str(body)) if body is not None else None
    terms = JobTerms(labels[0], tuple(labels[1]))
    return Order(Path(scan), wearer, settings=settings, given_as=given_as, terms=terms)


def _make_settings(quality: str | None, values: Mapping[str, Any]) -> RecoverySettings:
    """Return settings by their fields' names."""
    known = [one.name for one in fields(RecoverySettings)]
    for name in values:
        if name not in known:
            near = get_close_matches(name, known, 1)
            meant = f" Did you mean '{near[0]}'?" if near else f" There are {', '.join(known)}."
            raise SettingsBad(f"there is no setting '{name}'.{meant}")
    return RecoverySettings(**complete_by_quality(quality, values))
