"""`/v1/jobs`: create, show, list, cancel, retry and delete jobs."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, Header, Query, Request, Response
from starlette.concurrency import run_in_threadpool

from ... import __version__
from ...core.body.spec import read_wearer
from ...core.recover.settings import LATER, RecoverySettings
from ...core.run.sandbox import IsStopped, never_stopped
from ..checking import check_request
from ..cursors import MAX_CURSOR_LENGTH
from ..deletion import Deleted, delete_jobs
from ..derived import DerivedOrder, submit_derived
from ..families import cancel, retry
from ..job_pages import find_page
from ..jobs import find_job
from ..keys import Caller
from ..kinds import FileRef, find_kind
from ..models import JobRow
from ..order import Order, PartOrder
from ..ordering import check_order
from ..query import MAX_QUERY_OFFSET, JobQuery
from ..records import ListedJob, get_json_name
from ..refining import submit_refinement
from ..results import report_jobs
from ..submission import SubmissionResult, clean_name, own_name, submit
from ..terms import JobTerms
from ..uploads import begin_idempotent, end_idempotent, find_upload
from ..versions import list_versions
from .access import AppState, AppStateDependency, Reader, Submitter, find_own
from .answers import Asked, Changed, Job, Jobs, Versions
from .problems import RequestBad, show_answer, show_list
from .schemas import AnyJobIn, DerivedIn, JobIn, PartIn, Text
from .waiting import MAX_WAIT_SECONDS, wait_for_end

router = APIRouter(prefix="/jobs", tags=["jobs"])

EXAMPLE = {
    "job": "3685ecfd4f81", "name": "skirt", "state": "succeeded", "stage": "measure", "progress": 1.0, "attempts": 1,
    "overall": 1.0, "expected_end": None,
    "created": 1795250000.1, "started": 1795250000.4, "finished": 1795250071.9,
    "created_at": "2026-11-21T08:33:20.100Z", "started_at": "2026-11-21T08:33:20.400Z",
    "finished_at": "2026-11-21T08:34:31.900Z", "error": None, "garment": "skirt",
    "template": "skirt", "fabric": "cotton_poplin", "body": "builtin:female,height=1.70", "bad_input": False,
    "queue": "cpu", "priority": 0, "verdict": "pass",
    "settings": {"method": "deform", "fabric": "cotton_poplin"}, "version": __version__,
    "metrics": {"surface_rms_mm.t2s": 0.41, "redrape.at_rest": 1.0}, "gates": [], "warnings": [],
    "stage_seconds": {"drape": 12.3}, "cpu_seconds": 71.2, "peak_mb": 900.0, "kind": "recover",
    "family": "3685ecfd4f81", "parent": None, "children": [],
    "inputs": {}, "waits": [], "tags": ["spring"], "details": {}, "delay": None,
    "redrape": {"state": "done", "job": None, "code": None}, "subject": "Anna Müller",
    "place": None, "expected_start": None,
}  # fmt: skip
LISTED = {name: EXAMPLE[name] for name in map(get_json_name, fields(ListedJob))}
PAGE = {"jobs": [LISTED], "total": 1, "next": None}
UPLOADED_AS = {"body": "bodies", "motion": "motions", "pattern": "patterns"}
"""Kind of upload of each file field of a derived job; other fields accept any upload."""

VERSION = {
    "job": "5f1d0c9b7a3e", "predecessor": "3685ecfd4f81", "name": "skirt", "kind": "edit", "state": "succeeded",
    "verdict": "pass", "created": 1795250100.0,
}  # fmt: skip
DELETED = {"jobs": ["3685ecfd4f81"], "uploads": 0, "files": 7, "size": 2048000, "young": 0}
LATER_REQUEST_FIELDS = ("given_as", "wearing", "marks", "parts", "over", "subject")
"""Fields of a request that later versions added: while empty, they are left out of its fingerprint."""

Words = Annotated[Text | None, Query(max_length=255)]
ASKED = {"job": "3685ecfd4f81", "state": "queued", "is_new": True}

Token = Annotated[str | None, Header(max_length=128, pattern=r"^[!-~]+$", description="Makes a repeated request safe.")]


def show_created() -> dict[int | str, dict[str, Any]]:
    """Describe the two successful responses of `create_job`."""
    known = show_answer(ASKED | {"is_new": False}, 200, Asked)[200] | {"description": "An equal job existed."}
    return {**show_answer(ASKED, 202, Asked, (408, 507)), 200: known}


@router.post("", status_code=202, summary="Create a recovery or a derived job.", responses=show_created())
async def create_job(
    payload: AnyJobIn,
    request: Request,
    response: Response,
    rooms: AppStateDependency,
    caller: Submitter,
    idempotency_key: Token = None,
) -> Any:
    """Queue the job. The same files with the same settings are the same job: 200, not 202.

    Names and settings are checked at once. The files are read by the job's first stage, `check`: an unusable file ends
    the job as `failed` with `bad_input` and a code for the reason. With `"check": true` they are read before, and an
    unusable one is refused with 422 and that code. With a `kind` the job works on the result of another job that has
    succeeded.
    """
    caller.check_priority(payload.priority)
    create = partial(create_one, rooms, caller, payload, idempotency_key)
    if calls_limited(rooms, payload):
        done = await rooms.limited.run(request, caller.key, create)
    else:
        done = await run_in_threadpool(create)
    return answer_submission(response, done)


@dataclass(frozen=True)
class JobFilter:
    """Describe a filter of jobs by their fields; each job of a family has the family's tags."""

    state: Words = None
    name: Words = None
    kind: Words = None
    family: Words = None
    parent: Words = None
    tag: Words = None
    subject: Words = None

    @property
    def chosen(self) -> dict[str, str]:
        """Return the fields that are set."""
        return {name: value for name, value in asdict(self).items() if value is not None}


@dataclass(frozen=True)
class Paging:
    """Describe where a page of jobs begins, and what it says of each."""

    offset: Annotated[int, Query(ge=0, le=MAX_QUERY_OFFSET, description="Jobs before the page; not with `cursor`.")] = 0
    cursor: Annotated[str | None, Query(max_length=MAX_CURSOR_LENGTH, description="`next` of the page before.")] = None
    detail: Annotated[Literal["short", "full"], Query(description="full: the reports, as of one job.")] = "short"


@router.get("", summary="List the newest jobs.", responses=show_answer(PAGE, model=Jobs))
def list_jobs(
    rooms: AppStateDependency,
    caller: Reader,
    job_filter: Annotated[JobFilter, Depends()],
    paging: Annotated[Paging, Depends()],
    limit: Annotated[int, Query(ge=1, le=1000)] = 50,
) -> Any:
    """Return a page of the caller's jobs that match the filter, newest first; jobs that are added shift no page."""
    query = JobQuery(job_filter.chosen, limit=limit, offset=paging.offset, cursor=paging.cursor)
    return answer_query(rooms, caller, query, paging.detail == "full")


@router.get(
    "/{job}", name="show_job", summary="Show a job and its report.", responses=show_answer(EXAMPLE, model=Job),
)  # fmt: skip
async def show_one(
    job: str,
    request: Request,
    rooms: AppStateDependency,
    caller: Reader,
    wait: Annotated[float, Query(ge=0, le=MAX_WAIT_SECONDS, description="Longest wait for the job's end [s].")] = 0.0,
) -> Any:
    """Return one job; with `wait` as soon as it has ended, or as it is after that time.

    A local user may name it by its first letters.
    """
    row = await run_in_threadpool(find_own, rooms, caller, job)
    if wait:
        await wait_for_end(rooms, request, caller.key, row.id, wait)
        row = await run_in_threadpool(find_own, rooms, caller, row.id)
    return await run_in_threadpool(show_job, rooms, row)


@router.get(
    "/{job}/versions", name="list_versions", summary="List the versions of a result.",
    responses=show_answer(show_list("versions", [VERSION]), model=Versions),
)  # fmt: skip
def show_versions(job: str, rooms: AppStateDependency, caller: Reader) -> Any:
    """Return the original result and every edited version of it that is the caller's, oldest first."""
    row = find_own(rooms, caller, job)
    return show_list("versions", list_versions(rooms.database, row.id, "" if caller.sees_all else caller.key))


@router.post(
    "/{job}/cancel", summary="Stop a job.",
    responses=show_answer({"job": "3685ecfd4f81", "state": "running"}, model=Changed),
)  # fmt: skip
def cancel_job(job: str, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Stop a queued job at once, a running one within a second or two; an ended job does not change.

    If keys share jobs, a job that another key has also requested continues for that key.
    """
    row = find_own(rooms, caller, job)
    return {"job": row.id, "state": cancel(rooms.database, row.id, "" if caller.sees_all else caller.key)}


@router.delete(
    "/{job}", summary="Delete an ended job.", responses=show_answer(DELETED, model=Deleted, refusals=(409,))
)  # fmt: skip
def delete_job(job: str, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Delete an ended job, all jobs below it, all jobs that read its results, and the files that no other job names."""
    row = find_own(rooms, caller, job)
    return delete_jobs(rooms.database, rooms.store, [row.id], "" if caller.sees_all else caller.key)


@router.post(
    "/{job}/retry", status_code=202, summary="Queue an ended job again.",
    responses=show_answer({"job": "3685ecfd4f81", "state": "queued"}, 202, Changed, (409,)),
)  # fmt: skip
def retry_job(job: str, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Queue an ended job again, with all its attempts."""
    row = find_own(rooms, caller, job)
    return {"job": row.id, "state": retry(rooms.database, row.id, caller.key, caller.quota)}


@router.post(
    "/{job}/refine", status_code=202, summary="Recover a preview's garment at standard quality.",
    responses=show_created(),
)  # fmt: skip
def refine_job(job: str, response: Response, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Queue the recovery at standard quality of the same files, with all other settings; the preview stays.

    If an equal job exists, that is returned: 200, not 202.
    """
    row = find_own(rooms, caller, job)
    return answer_submission(response, submit_refinement(rooms, row, make_owner_terms(rooms, caller)))


def answer_submission(response: Response, done: SubmissionResult) -> dict[str, Any]:
    """Return the response of a submission."""
    response.headers["location"] = f"/v1/jobs/{done.job}"
    response.status_code = 202 if done.is_new else 200
    return asdict(done)


def show_job(rooms: AppState, row: JobRow) -> dict[str, Any]:
    """Return a job as JSON values."""
    return report_jobs(rooms.database, [row], rooms.settings)[0].as_json()


def answer_query(rooms: AppState, caller: Caller, query: JobQuery, is_full: bool) -> dict[str, Any]:
    """Return the response with a page of the caller's jobs that match a query, as reports if it is full."""
    page = find_page(rooms.database, query, None if caller.sees_all else caller.key)
    jobs = report_jobs(rooms.database, page.rows, rooms.settings) if is_full else map(ListedJob.from_row, page.rows)
    return {"jobs": [job.as_json() for job in jobs], "total": page.total, "next": page.next}


def calls_limited(rooms: AppState, payload: JobIn | DerivedIn) -> bool:
    """Return whether files are read before the job is queued, in a limited process."""
    if isinstance(payload, JobIn):
        return payload.check
    return find_kind(rooms.settings, payload.kind).is_refused_early


def create_one(
    rooms: AppState,
    caller: Caller,
    payload: JobIn | DerivedIn,
    token: str | None,
    is_stopped: IsStopped = never_stopped,
) -> SubmissionResult:
    known = None
    if token is not None:
        known = begin_idempotent(rooms.database, caller.key, token, json.dumps(fingerprint(payload), sort_keys=True))
    if known is not None:
        return SubmissionResult(known, False, find_job(rooms.database, known).state)
    nonce = "" if token is None else hashlib.sha256(f"{caller.key} {token}".encode()).hexdigest()
    if isinstance(payload, DerivedIn):
        done = submit_derived(rooms, _derive(rooms, caller, payload, nonce), is_stopped)
    else:
        with rooms.copying() as folder:
            order = check_order(rooms, _unpack(rooms, caller, payload, folder), payload.template)
            order = replace(order, terms=replace(order.terms, nonce=nonce))
            check = partial(check_request, rooms, is_stopped=is_stopped) if payload.check else None
            done = submit(rooms.database, rooms.store, order, check)
    if token is not None:
        end_idempotent(rooms.database, caller.key, token, done.job)
    return done


def fingerprint(payload: JobIn | DerivedIn) -> dict[str, Any]:
    """Return what identifies a repeated request; without later versions' fields it equals that of earlier versions."""
    left_out = {name for name in LATER_REQUEST_FIELDS if not getattr(payload, name, None)}
    found = payload.model_dump(exclude=left_out | {"check"})
    if isinstance(payload, JobIn):
        found["settings"] = payload.settings.complete()
        if found["settings"]["redrape"] == LATER:
            del found["settings"]["redrape"]
    return found


def _derive(rooms: AppState, caller: Caller, payload: DerivedIn, nonce: str) -> DerivedOrder:
    """Return the order of a derived job; its files are the caller's uploads."""
    names = {
        field: find_upload(rooms.database, caller.key, sha256, UPLOADED_AS.get(field)).name
        for field, sha256 in payload.files.items()
    }
    files = {field: FileRef(payload.files[field], clean_name(name)) for field, name in names.items()}
    terms = replace(_read_terms(rooms, caller, payload), nonce=nonce)
    return DerivedOrder(payload.kind, payload.result, payload.options, files, payload.over or "", terms)


def _read_terms(rooms: AppState, caller: Caller, payload: JobIn | DerivedIn) -> JobTerms:
    """Return the terms under which the job is queued."""
    return replace(
        make_owner_terms(rooms, caller),
        name=payload.name,
        tags=tuple(payload.tags),
        priority=payload.priority,
        queue=payload.queue,
        force=payload.force,
        subject=payload.subject or "",
    )


def make_owner_terms(rooms: AppState, caller: Caller) -> JobTerms:
    """Return the terms of a job that a caller owns: its key, quota and realm."""
    return JobTerms(key=caller.key, quota=caller.quota, realm=find_realm(rooms, caller))


def find_realm(rooms: AppState, caller: Caller) -> str:
    """Return whose equal orders are one job: the caller's own, unless the operator lets keys share jobs."""
    return "" if rooms.settings.share_jobs else caller.key


def _unpack(rooms: AppState, caller: Caller, payload: JobIn, folder: Path) -> Order:
    """Copy the uploads into a folder, each into a folder of its own and under its cleaned name."""
    choices: list[JobIn | PartIn] = [payload, *payload.parts.values()]
    if any(one.pattern is not None and one.template is not None for one in choices):
        raise RequestBad("give a pattern or a template's name, not both.")

    def unpack(part: str, sha256: str, kind: str) -> Path:
        row = find_upload(rooms.database, caller.key, sha256, kind)
        return rooms.store.copy(sha256, folder / part / clean_name(row.name))

    def choose(word: str, one: PartIn) -> PartOrder:
        file = unpack(f"pattern-{word}", one.pattern, "patterns") if one.pattern else None
        return PartOrder(file, one.template, one.garment, one.fabric, one.lock, one.cut)

    terms, body = _read_terms(rooms, caller, payload), read_wearer(payload.body)
    if isinstance(body, Path) and payload.body is not None:
        body = unpack("body", payload.body, "bodies")
    return Order(
        scan=unpack("scan", payload.scan, "scans"),
        body=body,
        template=unpack("pattern", payload.pattern, "patterns") if payload.pattern else None,
        settings=RecoverySettings(**payload.settings.complete()),
        labels=unpack("labels", payload.labels, "labels") if payload.labels else None,
        given_as=payload.given_as,
        wearing=payload.wearing,
        marks=tuple(payload.marks),
        choices={word: choose(word, one) for word, one in payload.parts.items()},
        terms=replace(terms, name=terms.name or own_name(find_upload(rooms.database, caller.key, payload.scan).name)),
    )
