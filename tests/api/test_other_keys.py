"""What is another key's is as unknown as what nobody has: the same status, body and headers on every route."""

from __future__ import annotations

from dataclasses import replace

import httpx
import pytest
from api_client import LIMITS, serving
from api_routes import list_pages, list_routes
from api_work import ask, finish, make_key, make_ply, upload
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.templates import load_template
from garmentq.service.jobs import find_job
from garmentq.service.kinds import KINDS, FileRef, pack_request
from garmentq.service.kinds.person_request import PersonRequest
from garmentq.service.models import ApiKeyRow, ArtifactRow, JobRow
from garmentq.service.results import RESULT, list_files
from garmentq.service.states import State
from garmentq.service.submission import JobRequest, add_job
from garmentq.service.terms import JobTerms
from sqlalchemy import select

NOBODY = {
    "job": "0123456789ab",
    "sha256": "ab" * 32,
    "webhook": "0123456789ab",
    "share": "0123456789ab",
    "name": "Nemo",
    "key": "0123456789ab",
    "subject": "0123456789ab",
    "tag": "nobody",
}
"""An id of each kind that nothing has, and as long as those that something has."""

PASSING = ("date", "x-request-id", "set-cookie")
"""Headers that differ from one answer to the next."""

FREE = replace(LIMITS, requests_per_second=1e6, burst=10**6)
BODIES = {
    "POST /v1/jobs/{job}/labels": {"points": "cd" * 32},
    "PUT /v1/subjects/{subject}": {"name": "Berta"},
    "POST /v1/subjects/{subject}/jobs": {"jobs": ["JOB"]},
    "POST /v1/jobs/states": {"jobs": ["JOB"], "below": True},
}


def find_owner(session, name: str) -> str:
    """Return the id of a key by its name."""
    return session.scalars(select(ApiKeyRow.id).where(ApiKeyRow.name == name)).one()


@pytest.fixture
def theirs(client, settings, database, store, tmp_path):
    """Return the ids of what another key has: jobs of several kinds and states, an upload and a webhook."""
    header = make_key(database, "theirs")
    done, waits = ask(client, 0.1, headers=header).json()["job"], ask(client, 0.2, headers=header).json()["job"]
    finish(settings, database, store, done, tmp_path / "made")
    row = find_job(database, done)
    request = pack_request(PersonRequest(FileRef(row.scan, "skirt.ply")))
    with database.write() as session:
        terms = JobTerms("Anna", ("theirs",), key=find_owner(session, "theirs"), quota=9)
        wanted = JobRequest("person", request, row.scan, terms=terms)
        person = add_job(session, wanted).job
    hook = client.post("/v1/webhooks", json={"url": "https://studio.example/"}, headers=header).json()["webhook"]
    share = client.post(f"/v1/jobs/{done}/shares", json={}, headers=header).json()["share"]
    return {
        "share": share,
        "jobs": [done, waits, person],
        "sha256": upload(client, 0.7, headers=header),
        "webhook": hook,
        "name": "Anna",
        "subject": client.post("/v1/subjects", json={"name": "Anna"}, headers=header).json()["subject"],
        "tag": "theirs",
    }


@pytest.fixture
def ours(settings, database, client):
    """Return a client of another key, and one that is signed in with it; its jobs are newer."""
    header = make_key(database, "ours")
    for mark in (0.3, 0.4):
        ask(client, mark, headers=header)
    with serving(settings, FREE, is_open=False) as url:
        with httpx.Client(base_url=url, headers=header, timeout=60.0) as program:
            with httpx.Client(base_url=url, timeout=60.0) as browser:
                token = header["authorization"].removeprefix("Bearer ")
                assert browser.post("/signin", data={"token": token}).status_code == 303
                yield program, browser


def tell(answer: httpx.Response, named: str, nobody: str) -> tuple[int, str, list[tuple[str, str]]]:
    """Return status, body and headers of an answer, whichever id was asked for."""
    headers = [(name, value) for name, value in answer.headers.multi_items() if name not in PASSING]
    return answer.status_code, answer.text.replace(named, nobody).replace(named[:12], nobody[:12]), sorted(headers)


def test_no_route_tells_another_keys_id_from_nobodys(client, settings, theirs, ours):
    """Broken where a route looks at something before it looks at whose it is."""
    program, browser = ours
    asked = 0
    for method, path, parameters in list_routes(settings):
        for parameter in parameters:
            field = "job" if parameter["name"] in ("first", "second", "family", "parent") else parameter["name"]
            if field not in theirs and field != "job":
                continue
            for known in theirs["jobs"] if field == "job" else [theirs[field]]:
                told = []
                for one in (known, NOBODY[field]):
                    values = {name: NOBODY[name] for name in NOBODY}
                    query = {"first": "skirt", "second": "skirt"} if path == "/v1/match" else {}
                    (values if parameter["in"] == "path" else query)[parameter["name"]] = one
                    body = BODIES.get(f"{method} {path}")
                    answer = program.request(method, path.format(**values), params=query, json=body)
                    told.append(tell(answer, one, NOBODY[field]))
                assert told[0] == told[1], (method, path, parameter["name"], told)
                asked += 1
    assert asked > 60
    for path, queries in list_pages():
        for name in [*(["job"] if "{job}" in path else []), *({"before", "a", "b"} & set(queries))]:
            for known in theirs["jobs"]:
                told = []
                for one in (known, NOBODY["job"]):
                    query = {} if name == "job" else {name: one}
                    answer = browser.get(path.format(job=one, number=0, column=0), params=query)
                    told.append(tell(answer, one, NOBODY["job"]))
                assert told[0] == told[1], (path, name)
                asked += 1
    assert asked > 90


def test_no_order_tells_another_keys_id_from_nobodys(settings, theirs, ours):
    """Broken where an order's files are judged before whose job they are for, in any kind, or the job worn over."""
    program, _ = ours
    mine = program.get("/v1/jobs").json()["jobs"][0]["job"]
    document = write_pattern(load_template("skirt"))
    unsound = document | {"pattern": document["pattern"] | {"stitches": []}}
    pattern = program.post("/v1/patterns", params={"name": "p.json"}, json=unsound).json()["sha256"]
    motion = program.post("/v1/motions", params={"name": "m.json"}, json={"keys": 1}).json()["sha256"]
    scan = program.post("/v1/scans", params={"name": "b.ply"}, content=make_ply()).json()["sha256"]
    given = {
        "edit": {"files": {"pattern": pattern}},
        "animate": {"files": {"motion": motion}},
        "dress": {"options": {"body": "builtin:male,height=1.85", "pose": "A"}},
        "refit": {"options": {"body": "builtin:male,height=1.85"}},
        "outfit": {"options": {"body": "builtin:male,height=1.85"}},
        "export": {"options": {"format": "svg"}},
    }
    said = set()
    for kind in KINDS:
        orders = [{}, given.get(kind, {}), {"options": {"nosuch": 1}}, {"files": {"scan": scan}}, {"name": "x" * 300}]
        for order in orders:
            for known in theirs["jobs"]:
                places = [{"result": "JOB"}, {"result": mine, "over": "JOB"}]
                for place in places:
                    told = []
                    for one in (known, NOBODY["job"]):
                        named = {field: value.replace("JOB", one) for field, value in place.items()}
                        answer = program.post("/v1/jobs", json={"kind": kind, **order, **named})
                        told.append(tell(answer, one, NOBODY["job"]))
                    assert told[0] == told[1], (kind, order, place, told)
                    said.add(answer.json()["code"])
    assert {"job.unknown", "job.request_bad", "request.bad"} <= said
    for known in theirs["jobs"]:
        assert program.post("/v1/jobs/states", json={"jobs": [known], "below": True}).json() == {"jobs": []}


def test_an_export_of_another_key_is_not_handed_out(settings, database, store, tmp_path):
    """Broken where keys that share jobs are handed what another key had made of them."""
    shared = replace(settings, share_jobs=1)
    with serving(shared, LIMITS, is_open=False) as url, httpx.Client(base_url=url, timeout=60.0) as client:
        ours, theirs = make_key(database, "ours"), make_key(database, "theirs")
        job = ask(client, headers=ours).json()["job"]
        assert ask(client, headers=theirs).json()["job"] == job
        finish(settings, database, store, job, tmp_path / "made")
        with database.write() as session:
            wanted = JobRequest("export", {"format": "pdf"}, find_job(database, job).scan, inputs={"result": job})
            terms = JobTerms(key=find_owner(session, "theirs"), quota=9)
            made = add_job(session, replace(wanted, terms=terms)).job
            row, (file,) = session.get(JobRow, made), list_files(database, job)[:1]
            row.state, row.finished = State.SUCCEEDED, row.created
            same = {"sha256": file.sha256, "size": file.size}
            session.add(ArtifactRow(job=made, kind=RESULT, name="pieces.pdf", created=1.0, **same))
        path = f"/v1/jobs/{job}/exports/pieces.pdf"
        assert client.get(path, headers=theirs).status_code == 200
        assert client.get(path, headers=ours).status_code == 404
