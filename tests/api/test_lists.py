"""Lists in pages: short rows, their number, and where the next page begins."""

from __future__ import annotations

import pytest
from api_work import ask, code_of, finish, make_key
from garmentq.service.api.answers import Whole
from garmentq.service.jobs import read_events
from garmentq.service.remote import RemoteBackend


def walk(client, path: str, name: str, cursor: str = "cursor", **params):
    """Return all rows of a list, page after page, and the totals that the pages say."""
    rows, totals, following = [], [], None
    while True:
        more = {} if following is None else {cursor: following}
        found = client.get(path, params=params | more).json()
        rows, totals, following = rows + found[name], [*totals, found["total"]], found["next"]
        if following is None:
            return rows, totals


def test_jobs_in_pages(client):
    """Broken where a page repeats a job, leaves one out, or a job that is added meanwhile shifts the next page."""
    jobs = [ask(client, 0.1 * n).json()["job"] for n in range(5)]
    for path in ("/v1/jobs", "/v1/query"):
        rows, totals = walk(client, path, "jobs", limit=2)
        assert [row["job"] for row in rows] == jobs[::-1] and totals == [5, 5, 5]
    first = client.get("/v1/jobs", params={"limit": 2}).json()
    added = ask(client, 0.9).json()["job"]
    second = client.get("/v1/jobs", params={"limit": 2, "cursor": first["next"]}).json()
    assert [row["job"] for row in second["jobs"]] == jobs[2:0:-1] and second["total"] == 6
    assert client.get("/v1/jobs").json()["jobs"][0]["job"] == added
    assert client.get("/v1/jobs", params={"state": "failed"}).json() == {"jobs": [], "total": 0, "next": None}


def test_a_row_is_short_and_a_report_is_full(client, settings, database, store, tmp_path):
    """Broken where a list sends each job's settings and metrics, or a row says otherwise than the job itself."""
    job = ask(client).json()["job"]
    finish(settings, database, store, job, tmp_path / "files")
    shown = client.get(f"/v1/jobs/{job}").json()
    for path in ("/v1/jobs", "/v1/query"):
        (short,) = client.get(path).json()["jobs"]
        assert not {"settings", "metrics", "gates", "details", "stage_seconds"} & set(short)
        assert short == {name: shown[name] for name in short} and short["garment"]
        assert client.get(path, params={"detail": "full"}).json()["jobs"] == [shown]
    assert code_of(client.get("/v1/jobs", params={"detail": "most"})) == "request.bad"


def test_a_cursor_shows_no_other_keys_jobs(client, database):
    """Broken where a cursor over another key's job opens its list, or two keys' totals are one."""
    ours, theirs = make_key(database, "ours"), make_key(database, "theirs")
    for n in range(3):
        ask(client, 0.1 * n, headers=theirs)
    own = ask(client, 0.9, headers=ours).json()["job"]
    theirs_next = client.get("/v1/jobs", params={"limit": 1}, headers=theirs).json()["next"]
    seen = client.get("/v1/jobs", params={"limit": 1}, headers=ours).json()
    assert [row["job"] for row in seen["jobs"]] == [own] and (seen["total"], seen["next"]) == (1, None)
    assert client.get("/v1/jobs", params={"cursor": theirs_next}, headers=ours).json()["jobs"] == []


@pytest.mark.parametrize("params", [{"cursor": "x"}, {"cursor": ""}, {"sort": "name"}, {"offset": 1}])
def test_a_wrong_cursor_is_refused(client, params):
    """Broken where a cursor of another sort, or beside an offset, quietly begins somewhere."""
    for n in range(2):
        ask(client, 0.1 * n)
    following = client.get("/v1/query", params={"limit": 1}).json()["next"]
    answer = client.get("/v1/query", params={"cursor": following} | params)
    assert answer.status_code == 422 and code_of(answer) in ("query.cursor_bad", "query.bad")


def test_events_in_pages(client, settings, database, store, tmp_path):
    """Broken where the events of a long job come at once, or the end of a list hides that there are more."""
    job = ask(client).json()["job"]
    finish(settings, database, store, job, tmp_path / "files")
    path, ids = f"/v1/jobs/{job}/events", [event.id for event in read_events(database, job)]
    rows, totals = walk(client, path, "events", "after", limit=1)
    assert [row["id"] for row in rows] == ids and totals == [3, 3, 3]
    assert client.get(path, params={"after": ids[-1]}).json() == {
        "state": "succeeded", "events": [], "total": 3, "next": None
    }  # fmt: skip


def test_a_client_asks_for_all_events(client, address, settings, database, store, tmp_path, monkeypatch):
    """Broken where a program sees an ended job without the events of its end."""
    job = ask(client).json()["job"]
    finish(settings, database, store, job, tmp_path / "files")
    with RemoteBackend(address, client.headers["authorization"].removeprefix("Bearer ")) as service:
        request = service._ask
        paged = lambda method, url, **options: request(  # noqa: E731
            method, url, **options | {"params": options.get("params", {}) | {"limit": 1}}
        )
        monkeypatch.setattr(service, "_ask", paged)
        assert len(service.poll_events(job).events) == 3


def test_whole_lists_say_so(client):
    """Broken where a list that has no pages lacks the words of one that has."""
    page = client.get("/openapi.json").json()
    whole = {one.__name__ for one in Whole.__subclasses__()}
    for path, methods in page["paths"].items():
        schema = methods.get("get", {}).get("responses", {}).get("200", {}).get("content", {})
        name = schema.get("application/json", {}).get("schema", {}).get("$ref", "").rpartition("/")[2]
        if name in whole and "{" not in path:
            found = client.get(path).json()
            assert found["total"] == len(next(iter(found.values()))) and found["next"] is None
