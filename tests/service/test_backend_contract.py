"""The same questions of a home and of a service that serves it: equal records, and errors of the same codes."""

from __future__ import annotations

import ast
import inspect
import sys
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import pytest
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.cloth.fabric_file import write_fabrics
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.run.errors import BadInput, GarmentqError, NotFound
from garmentq.service import records
from garmentq.service.backend import Backend, open_backend
from garmentq.service.families import make_children
from garmentq.service.jobs import claim, fail, find_job
from garmentq.service.kinds import pack_request, read_request
from garmentq.service.kinds.kind import ChildRequest
from garmentq.service.kinds.person_request import PersonRequest
from garmentq.service.kinds.recover_request import RecoverRequest
from garmentq.service.local import LocalBackend
from garmentq.service.local_token import make_local_token
from garmentq.service.order import Order, PartOrder
from garmentq.service.progress import report
from garmentq.service.query import JobQuery
from garmentq.service.records import Job, JobReport
from garmentq.service.remote import RemoteBackend
from garmentq.service.states import State
from garmentq.service.subject_records import SubjectFields
from garmentq.service.terms import JobTerms

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "api"))

from api_client import carrying, serving  # noqa: E402
from api_work import finish, make_ply  # noqa: E402


@pytest.fixture(scope="session")
def database_kind():
    """Ask of SQLite only: what differs by database is tested below the backend."""
    return "sqlite"


@pytest.fixture
def local(settings):
    """Return the backend of a home."""
    opened = LocalBackend(settings)
    yield opened
    opened.close()


@pytest.fixture
def remote(settings):
    """Return the backend of a service that serves the same home."""
    with serving(settings) as url, RemoteBackend(url, make_local_token(settings.home)) as opened:
        yield opened


@pytest.fixture(params=["local", "remote"])
def backend(request):
    """Choose one of the two."""
    return request.getfixturevalue(request.param)


@pytest.fixture
def order(tmp_path):
    """Return an order of two files."""
    (tmp_path / "skirt.ply").write_bytes(make_ply())
    (tmp_path / "body.ply").write_bytes(make_ply(-0.5))
    return Order(tmp_path / "skirt.ply", tmp_path / "body.ply")


def code_of(ask, *given) -> tuple[str, type]:
    """Return the code and the kind of the error that a question meets."""
    with pytest.raises(GarmentqError) as caught:
        ask(*given)
    error = caught.value
    return error.code, next(kind for kind in (NotFound, BadInput, GarmentqError) if isinstance(error, kind))


def test_both_answer_every_question_of_the_protocol():
    """Breaks where a question is missing on one side, or takes other arguments there."""
    asked = [name for name, value in vars(Backend).items() if inspect.isfunction(value) and not name.startswith("_")]
    assert len(asked) > 15
    for name in asked:
        wanted = [p.replace(annotation="") for p in inspect.signature(getattr(Backend, name)).parameters.values()]
        for kind in (LocalBackend, RemoteBackend):
            given = inspect.signature(getattr(kind, name)).parameters.values()
            assert [p.replace(annotation="") for p in given] == wanted, (kind, name)


def test_equal_records(local, remote, order, settings, database, store, tmp_path):
    """Breaks where a field is lost, rounded or of another type on the way through JSON."""
    done = local.submit(local.check_order(order)).job
    finish(settings, database, store, done, tmp_path / "made")
    forced = Order(order.scan, order.body, settings=RecoverySettings(seed=2))
    failed = remote.submit(remote.check_order(forced)).job
    held = claim(database, failed, "test", 60.0)
    report(database, held, records.Progress("drape", 0.123456789, "half \u00fcber", 0.256789, 61.23))
    fail(database, held, "scan.x", "bad", bad_input=True)
    built_in = Order(order.scan, BuiltinWearer("builtin:female,height=1.70"))
    queued = local.submit(replace(built_in, terms=JobTerms(tags=("spring/1",), subject="\u00c4nne"))).job
    local.create_subject(SubjectFields("Bo", "note", 1.5, "form", 2.5, 90.0, 3.5))
    with database.write() as session:
        asked = [ChildRequest("\u00c4rmel", "recover", find_job(database, done).request)]
        (child,) = make_children(session, done, asked).values()
    local.import_template("mine", _write_template(tmp_path))

    ids = [queued, done, failed]
    assert [job.id for job in remote.find_jobs_by_id(ids, below=True)] == [*ids, child]
    for ask in (
        *(lambda backend, job=job: backend.find_job(job) for job in (*ids, done[:6])),
        lambda backend: backend.find_jobs_by_id(ids),
        lambda backend: backend.find_jobs_by_id([failed, done], below=True),
        lambda backend: backend.find_jobs(JobQuery({"family": done})),
        lambda backend: backend.list_jobs(),
        lambda backend: backend.list_jobs(2),
        lambda backend: backend.find_jobs(JobQuery({"state": "failed"})),
        lambda backend: backend.find_jobs(JobQuery(wheres=["surface_rms_mm.t2s < 9", "attempts = 1"])),
        lambda backend: backend.find_jobs(JobQuery(sort="attempts", limit=2)),
        lambda backend: backend.find_page(JobQuery()),
        lambda backend: backend.find_page(JobQuery(limit=1, cursor=backend.find_page(JobQuery(limit=2)).next)),
        *(lambda backend, job=job: backend.poll_events(job) for job in ids),
        lambda backend: backend.poll_events(failed, backend.poll_events(failed).events[1].id),
        lambda backend: backend.read_queue(),
        lambda backend: backend.list_subjects(),
        lambda backend: backend.list_subjects("Bo", 1),
        lambda backend: backend.find_subject("\u00c4nne"),
        lambda backend: backend.delete_subject("\u00c4nne", dry_run=True),
        lambda backend: backend.find_jobs(JobQuery({"subject": "\u00c4nne"})),
        lambda backend: backend.list_batches(),
        lambda backend: backend.find_batch("spring/1"),
        lambda backend: backend.list_artifacts(done),
        lambda backend: backend.list_artifacts(queued),
        lambda backend: backend.list_templates(),
        lambda backend: backend.read_template("skirt"),
        lambda backend: backend.read_template("mine"),
        lambda backend: backend.list_materials(),
        lambda backend: backend.read_material("denim"),
    ):
        here, there = ask(local), ask(remote)
        assert here == there
        assert _kinds(here) == _kinds(there)
    found = remote.find_job(failed)
    assert isinstance(found, JobReport) and found.state is State.FAILED and found.progress == 0.1235
    assert found.error == records.Failure("scan.x", "bad") and found.bad_input
    assert found.settings["seed"] == 2
    told = remote.poll_events(failed).events[2].progress
    assert told == records.Progress("drape", 0.1235, "half \u00fcber", 0.2568, 61.2)
    assert type(remote.find_jobs_by_id([done])[0]) is Job


def test_imported_fabrics(backend, order, database, tmp_path):
    """Breaks where a job has not the numbers of the fabric that it names, or a shipped fabric can be changed."""
    mine = replace(get_fabric("canvas"), name="mine", k=7e-4)
    write_fabrics([mine], tmp_path / "mine.csv")
    backend.import_materials(tmp_path / "mine.csv")
    settings = RecoverySettings(fabric="mine")
    alone = Order(order.scan, order.body, settings=settings)
    person = Order(order.scan, None, given_as="person", choices={"upper": PartOrder(fabric="mine")})
    jobs = [backend.submit(backend.check_order(asked)).job for asked in (alone, person)]
    unknown = Order(order.scan, order.body, settings=RecoverySettings(fabric="granite"))
    assert code_of(backend.check_order, unknown) == ("fabric.unknown", NotFound)
    backend.delete_material("mine")
    recover, apart = (find_job(database, job).request for job in jobs)
    assert read_request(RecoverRequest, recover).settings.fabric == mine
    asked = read_request(PersonRequest, apart)
    child = asked.make_recovery("upper", asked.choose(["upper"])["upper"])
    assert get_fabric(read_request(RecoverRequest, pack_request(child)).settings.fabric) == mine
    assert backend.find_job(jobs[0]).settings["fabric"]["name"] == "mine"
    assert code_of(backend.delete_material, "denim") == ("fabric.shipped", BadInput)
    write_fabrics([replace(mine, name="other"), get_fabric("denim")], tmp_path / "denim.json")
    assert code_of(backend.import_materials, tmp_path / "denim.json") == ("fabric.shipped", BadInput)
    assert backend.read_material("denim") == get_fabric("denim")
    assert code_of(backend.read_material, "other") == ("fabric.unknown", NotFound), "all of a file, or nothing"


def test_the_same_job_by_both_ways(local, remote, order, settings, database, store, tmp_path):
    """Breaks where the same order is two jobs, or a file that was brought out has other bytes."""
    first = local.submit(local.check_order(order))
    second = remote.submit(remote.check_order(order))
    assert first.is_new and not second.is_new and (first.job, first.state) == (second.job, second.state)
    finish(settings, database, store, first.job, tmp_path / "made")
    for name, backend in (("a", local), ("b", remote)):
        paths = backend.export_files(first.job, tmp_path / name)
        assert sorted(path.name for path in paths) == ["metrics.txt", "pattern.svg"]
        (one,) = backend.export_files(first.job, tmp_path / f"{name}1", ["pattern.svg"])
        assert one.read_bytes() == (tmp_path / "made" / "pattern.svg").read_bytes()


def test_the_same_person_by_both_ways(local, remote, order, database, tmp_path):
    """Breaks where what is said of a person, or of one of the garments, is lost on the way over HTTP."""
    choices = {
        "upper": PartOrder(_write_template(tmp_path), fabric="denim", lock="panel:front"),
        "lower": PartOrder(name="skirt", garment="skirt"),
    }
    said = {"wearing": "upper,lower", "marks": ("upper=0,1,0", "lower=0,0.5,0"), "choices": choices}
    for asked in (Order(order.scan, None), Order(order.scan, order.body, given_as="person", **said)):
        first, second = (backend.submit(backend.check_order(asked)) for backend in (local, remote))
        assert first.is_new and not second.is_new and first.job == second.job
        assert local.find_job(first.job).kind == "person"
    request = find_job(database, first.job).request
    assert request["choices"]["upper"]["template"]["name"] == "template.json" and request["given_as"] == "person"
    garment = Order(order.scan, order.body, given_as="garment")
    assert local.submit(local.check_order(garment)).job == remote.submit(remote.check_order(garment)).job
    plain = Order(order.scan, order.body)
    assert local.submit(local.check_order(plain)).job not in (first.job, local.submit(garment).job)


def test_a_job_is_stopped_and_tried_again(backend, order, database):
    """Breaks where a state after a change is not the one that the job then has."""
    job = backend.submit(backend.check_order(order)).job
    assert code_of(backend.retry, job) == ("job.not_ended", BadInput)
    assert backend.cancel(job[:8]) is State.CANCELLED and backend.find_job(job).state is State.CANCELLED
    assert backend.retry(job) is State.QUEUED and backend.find_job(job).state is State.QUEUED
    assert backend.change_priority(job[:8], -7) == -7 == backend.find_job(job).priority
    assert claim(database, job, "test", 60.0)
    assert backend.cancel(job) is State.RUNNING and backend.find_job(job).state is State.RUNNING


def test_a_family_is_renamed(backend, order, database):
    """Breaks where a name or tags are changed in one job only, are lost, or bad ones are stored."""
    job = backend.submit(backend.check_order(order)).job
    with database.write() as session:
        make_children(session, job, [ChildRequest("upper", "recover", {})])
    assert backend.rename(job[:8], "Anna Bluse", ["spring", "fitting"]).name == "Anna Bluse"
    child = backend.find_job(job).children[0].job
    assert backend.find_job(child).tags == ["fitting", "spring"] and backend.find_job(child).name == "upper"
    assert backend.rename(child, "Anna").id == child
    found = backend.find_job(job)
    assert (found.name, found.tags) == ("Anna", ["fitting", "spring"])
    assert sorted(one.tag for one in backend.list_batches()) == ["fitting", "spring"]
    assert (
        backend.rename(job, tags=[]).tags == []
        and backend.list_batches() == []
        and backend.find_job(job).name == "Anna"
    )
    for bad in ({"name": "a\x00b"}, {"tags": ["x" * 65]}, {"tags": [str(n) for n in range(21)]}):
        with pytest.raises(BadInput):
            backend.rename(job, **bad)
    assert backend.find_job(job).name == "Anna"
    assert code_of(backend.rename, "abcdefabcdef") == ("job.unknown", NotFound)


def test_a_template_and_a_key_come_and_go(local, remote, tmp_path):
    """Breaks where what one side made is another on the other side."""
    pattern = _write_template(tmp_path)
    assert local.import_template("here", pattern).panels == remote.import_template("there", pattern).panels > 0
    assert local.read_template("there") == remote.read_template("here") == pattern.read_bytes()
    key, token = remote.create_key("atelier", ("submit", "read"), 7)
    assert local.list_keys() == [key] and token.startswith("gq_") and key.scopes == ["read", "submit"]
    with_key = RemoteBackend(str(remote._connection._http.base_url), token)
    assert with_key.list_jobs() == []
    with_key.close()


def test_a_webhook_and_a_template_go(backend, settings, tmp_path):
    """Breaks where what was deleted is still there, or a secret is shown a second time."""
    webhook, secret = backend.create_webhook("https://studio.example/in", [State.FAILED, State.DEAD])
    assert secret.startswith("whsec_") and backend.list_webhooks() == [webhook]
    assert (webhook.states, webhook.key, webhook.owed) == ([State.DEAD, State.FAILED], "", 0)
    backend.delete_webhook(webhook.id)
    assert backend.list_webhooks() == []
    near, _ = backend.create_webhook("https://studio.invalid/", ())
    with carrying(settings):
        receipt = backend.test_webhook(near.id)
    assert receipt.status is None and receipt.error
    assert [(one.error, one.owed) for one in backend.list_webhooks()] == [(receipt.error, 0)]
    backend.import_template("mine", _write_template(tmp_path))
    backend.delete_template("mine")
    assert "mine" not in [one.name for one in backend.list_templates()]


def test_the_same_refusals(backend, order, tmp_path):
    """Breaks where a mistake has another code, or another exit status, by way of asking."""
    job = backend.submit(backend.check_order(order)).job
    for code, kind, ask, *given in (
        ("job.unknown", NotFound, backend.find_job, "abcdefabcdef"),
        ("job.unknown", NotFound, backend.find_job, job[:3]),
        ("job.unknown", NotFound, backend.find_jobs_by_id, [job, "abcdefabcdef"]),
        ("job.unknown", NotFound, backend.poll_events, "abcdefabcdef"),
        ("job.unknown", NotFound, backend.cancel, "abcdefabcdef"),
        ("job.unknown", NotFound, backend.retry, "abcdefabcdef"),
        ("job.unknown", NotFound, backend.list_artifacts, "abcdefabcdef"),
        ("job.unknown", NotFound, backend.export_files, "abcdefabcdef", tmp_path),
        ("result.missing", NotFound, backend.export_files, job, tmp_path),
        ("query.bad", BadInput, backend.find_jobs, JobQuery(wheres=["drop table jobs"])),
        ("query.cursor_bad", BadInput, backend.find_page, JobQuery(cursor="x")),
        ("query.bad", BadInput, backend.find_jobs, JobQuery(wheres=["garment < 3"])),
        ("query.bad", BadInput, backend.find_jobs, JobQuery(sort="no such")),
        ("template.unknown", NotFound, backend.read_template, "nosuch"),
        ("template.name_bad", BadInput, backend.import_template, "skirt", _write_template(tmp_path)),
        ("template.unknown", NotFound, backend.delete_template, "nosuch"),
        ("template.shipped", BadInput, backend.delete_template, "skirt"),
        ("webhook.bad", BadInput, backend.create_webhook, "ftp://studio.example/"),
        ("webhook.address_forbidden", BadInput, backend.create_webhook, "https://127.0.0.1/"),
        ("webhook.unknown", NotFound, backend.delete_webhook, "nosuch"),
        ("webhook.unknown", NotFound, backend.test_webhook, "nosuch"),
        ("fabric.unknown", NotFound, backend.read_material, "nosuch"),
        ("key.unknown", NotFound, backend.revoke_key, "nosuch"),
        ("body.missing", BadInput, backend.check_order, Order(order.scan, None, given_as="garment")),
        ("scan.missing", BadInput, backend.check_order, Order(tmp_path / "none.ply", order.body)),
    ):
        assert code_of(ask, *given) == (code, kind), (ask, given)


def test_one_place_chooses(settings, monkeypatch):
    """Breaks where GARMENTQ_URL does not decide who is asked, or something is opened before the first question."""
    monkeypatch.delenv("GARMENTQ_URL", raising=False)
    here = open_backend(settings)
    assert isinstance(here, LocalBackend) and "services" not in vars(here)
    monkeypatch.setenv("GARMENTQ_URL", "http://127.0.0.1:1")
    assert isinstance(open_backend(settings), RemoteBackend)


def test_what_answers_may_be_no_service_of_ours(monkeypatch):
    """Breaks where an answer of another form is a traceback."""
    with RemoteBackend("http://127.0.0.1:1") as backend:
        for answer in ({}, [], None, {"jobs": 3}, {"jobs": [{}]}, {"job": 5, "error": None}, {"state": 3}):
            monkeypatch.setattr(backend, "_ask", lambda *given, answer=answer, **more: answer)
            for ask, *given in ((backend.find_job, "abcd"), (backend.list_jobs,), (backend.poll_events, "abcd")):
                assert code_of(ask, *given)[0] == "service.unreachable", (answer, ask)


@pytest.mark.parametrize("layer", ["cli", "workers"])
def test_no_row_leaves_the_service(layer):
    """Breaks where a module above the service reads its tables, or a backend returns a row."""
    for path in (ROOT / layer).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                names = [node.module or "", *(f"{node.module}.{alias.name}" for alias in node.names)]
                assert not any("service.models" in name for name in names), path
    hints = {name: str(inspect.signature(value).return_annotation) for name, value in vars(Backend).items()
             if inspect.isfunction(value) and not name.startswith("_")}  # fmt: skip
    assert not [name for name, hint in hints.items() if "Row" in hint or "Any" in hint]


def _write_template(folder: Path) -> Path:
    return save_pattern(load_template("skirt"), folder / "template.json")


def _kinds(value: object) -> object:
    """Return the types of all that a record holds: 1 and 1.0 are equal, but not the same answer."""
    if is_dataclass(value):
        return type(value), [_kinds(getattr(value, item.name)) for item in fields(value)]
    if isinstance(value, list | tuple):
        return type(value), [_kinds(item) for item in value]
    if isinstance(value, dict):
        return {name: _kinds(item) for name, item in value.items()}
    return type(value)
