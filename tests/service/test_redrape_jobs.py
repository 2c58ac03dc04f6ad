"""The kind `redrape`: a result is handed out before it, is doubtful until then, and is judged anew with its end."""

from __future__ import annotations

import json
from dataclasses import replace

import garmentq_redrape
import pytest
from garmentq.core.recover import pipeline
from garmentq.core.recover.settings import RecoverySettings
from garmentq.service.deletion import delete_jobs
from garmentq.service.derived import DerivedOrder, submit_derived
from garmentq.service.families import JobNotEnded, cancel, find_below, retry
from garmentq.service.jobs import FenceLost, claim, find_job, read_events
from garmentq.service.kinds import find_kind, read_request
from garmentq.service.kinds.redrape_request import RedrapeRequest
from garmentq.service.kinds.request import RequestBad
from garmentq.service.models import DeliveryRow, PatternRow
from garmentq.service.records import JobReport
from garmentq.service.results import export_files, list_files, report_jobs, store_result
from garmentq.service.services import Services
from garmentq.service.submission import Order, submit
from garmentq.service.webhooks import create_webhook
from garmentq.workers.recovery import run_job
from garmentq_home import put_file
from sqlalchemy import select


@pytest.fixture(scope="session", params=["sqlite", pytest.param("postgresql", marks=pytest.mark.nightly)])
def database_kind(request):
    """Choose SQLite by day."""
    return request.param


@pytest.fixture
def recover(settings, database, store, tmp_path, monkeypatch):
    """Return a function that recovers a scan of a name, and returns the id of its job."""
    monkeypatch.setattr(pipeline, "finish", garmentq_redrape.finish)
    standin = replace(settings, pipeline="garmentq_redrape:recover", writer="garmentq_redrape:write")

    def work(name: str = "skirt", redrape: str | None = "later") -> str:
        scan, body = put_file(tmp_path, f"{name}.ply"), put_file(tmp_path, "body.ply")
        job = submit(database, store, Order(scan, body, settings=RecoverySettings(redrape=redrape))).job
        assert run_job(standin, database, job, lambda: False) == "succeeded"
        return job

    work.settings = standin
    return work


def tell(recover, database, job: str) -> JobReport:
    """Return a job's report."""
    return report_jobs(database, [find_job(database, job)], recover.settings)[0]


def run_redrape(recover, database, job: str) -> str:
    """Run the re-drape of a job, and return how that ended."""
    (child,) = find_below(database, [job])
    return run_job(recover.settings, database, child.id, lambda: False)


def messages(database) -> list[str]:
    """Return the types of all messages that are owed, in order."""
    with database.read() as session:
        return [row.body["type"] for row in session.scalars(select(DeliveryRow).order_by(DeliveryRow.created))]


def test_result_is_there_before_its_redrape(recover, database, store, tmp_path):
    """Breaks where a result waits for its re-drape, passes without it, or never gets its numbers, files and verdict."""
    create_webhook(database, "https://studio.example/hook", (), "")
    job = recover()
    before = tell(recover, database, job)
    (child,) = find_below(database, [job])
    assert (before.state, before.verdict, before.redrape.state) == ("succeeded", "doubtful", "pending")
    assert before.redrape.job == child.id and (child.kind, child.parent, child.priority) == ("redrape", job, -100)
    assert [gate.name for gate in before.gates if gate.verdict != "pass"] == ["redrape"]
    assert "unfinished.npz" in {file.name for file in list_files(database, job)}

    assert run_redrape(recover, database, job) == "succeeded"
    after = tell(recover, database, job)
    assert (after.verdict, after.redrape.state, after.redrape.job) == ("pass", "done", child.id)
    assert after.metrics["redrape.surface_rms_mm.s2t"] == 5.0 and "redrape_missing" not in after.metrics
    assert {name: after.metrics.get(name) for name in before.metrics} == before.metrics | {"redrape_missing": None}
    assert [gate.name for gate in after.gates if "redrape" in gate.name] == ["redrape_fit"]
    assert (after.cpu_seconds, after.stage_seconds) == (before.cpu_seconds, before.stage_seconds)
    names = {file.name for file in list_files(database, job)}
    assert names == {"metrics.json", "report.html", "detail.ply", "manifest.json", "redrape.ply"}
    assert not list_files(database, child.id)
    export_files(database, store, job, tmp_path / "out")
    assert json.loads((tmp_path / "out" / "metrics.json").read_text()) == after.metrics
    assert (tmp_path / "out" / "report.html").read_text() == "0.20"
    with database.read() as session:
        assert session.get(PatternRow, job) is not None

    told = [event.data for event in read_events(database, job) if event.kind == "verdict_changed"]
    assert told == [{"job": job, "verdict": "pass", "before": "doubtful"}]
    assert [event.data for event in read_events(database, child.id) if event.kind == "verdict_changed"] == told
    assert messages(database).count("job.verdict_changed") == 1
    with database.read() as session:
        (sent,) = [row.body for row in session.scalars(select(DeliveryRow)) if "verdict" in row.body["type"]]
    assert (sent["job"]["job"], sent["job"]["verdict"], sent["job"]["state"]) == (job, "pass", "succeeded")


@pytest.mark.parametrize(("name", "verdict", "count"), [("torn", "fail", 1), ("same", "doubtful", 0)])
def test_verdict_is_reported_where_it_changes(recover, database, name, verdict, count):
    """Breaks where a pattern that hangs badly stays doubtful, or a verdict that stays is reported as new."""
    create_webhook(database, "https://studio.example/hook", (), "")
    job = recover(name)
    assert run_redrape(recover, database, job) == "succeeded"
    assert tell(recover, database, job).verdict == verdict
    assert sum(event.kind == "verdict_changed" for event in read_events(database, job)) == count
    assert messages(database).count("job.verdict_changed") == count


def test_redrape_that_failed_is_told_and_retried_with_its_recovery(recover, database, monkeypatch):
    """Breaks where a result whose re-drape failed counts as pending or passes, or a retry does not reach it."""
    job = recover("lost")
    assert run_redrape(recover, database, job) == "failed"
    found = tell(recover, database, job)
    assert (found.verdict, found.redrape.state, found.redrape.code) == ("doubtful", "failed", "drape.crumpled")
    assert (found.state, found.error) == ("succeeded", None)
    monkeypatch.setenv("MENDED", "1")
    assert retry(database, job) == "succeeded"
    assert tell(recover, database, job).redrape.state == "pending"
    assert run_redrape(recover, database, job) == "succeeded"
    assert (tell(recover, database, job).redrape.state, tell(recover, database, job).verdict) == ("done", "pass")


def test_redrape_is_cancelled_and_deleted_with_its_recovery(recover, database, store):
    """Breaks where a re-drape outlives the result that it belongs to, or is not told as cancelled."""
    job = recover()
    with pytest.raises(JobNotEnded):
        delete_jobs(database, store, [job])
    assert cancel(database, job) == "succeeded"
    found = tell(recover, database, job)
    assert (found.redrape.state, found.redrape.code, found.verdict) == ("failed", "job.cancelled", "doubtful")
    (child,) = find_below(database, [job])
    assert set(delete_jobs(database, store, [job]).jobs) == {job, child.id}


def test_redrape_that_lost_its_claim_changes_nothing(recover, database, store, tmp_path):
    """Breaks where the result of a recovery is written by a worker that does not own its re-drape any more."""
    job = recover()
    (child,) = find_below(database, [job])
    held = replace(claim(database, child.id, "me", 60.0), fence=0)
    kind = find_kind(recover.settings, "redrape")
    case = garmentq_redrape.recover(
        pipeline.Request(tmp_path / "skirt.ply", settings=RecoverySettings(redrape="later")), None
    ).case
    result = garmentq_redrape.finish(case, None, {}, garmentq_redrape.Hooks())
    with pytest.raises(FenceLost):
        store_result(database, store, held, kind, result, tmp_path / "nothing")
    assert tell(recover, database, job).verdict == "doubtful"


@pytest.mark.parametrize(("redrape", "state", "verdict"), [("never", "never", "doubtful"), ("wait", "done", "pass")])
def test_no_job_is_made_where_none_is_asked_for(recover, database, redrape, state, verdict):
    """Breaks where a re-drape that is not wanted is made, or one that was waited for is made again."""
    job = recover(redrape=redrape)
    found = tell(recover, database, job)
    assert (found.children, found.redrape.state, found.redrape.job) == ([], state, None)
    assert found.verdict == verdict
    assert ("redrape" in find_job(database, job).request["settings"]) == (redrape == "never")


def test_request_of_a_redrape_is_the_recoverys(recover, database, store):
    """Breaks where a re-drape is made with other settings, or a user orders one of any result."""
    job = recover()
    (child,) = find_below(database, [job])
    asked = read_request(RedrapeRequest, child.request)
    assert asked == RedrapeRequest(RecoverySettings(redrape="later"), has_pattern_file=False)
    with pytest.raises(RequestBad):
        submit_derived(Services(recover.settings, database, store), DerivedOrder("redrape", job))


def test_later_and_at_once_are_one_order(recover, database, store, tmp_path):
    """Breaks where `run` computes again what `submit` has queued, or who asked for no re-drape decides for others."""
    files = put_file(tmp_path, "skirt.ply"), put_file(tmp_path, "body.ply")

    def order(redrape: str) -> str:
        return submit(database, store, Order(*files, settings=RecoverySettings(redrape=redrape))).job

    assert order("later") == order("wait") != order("never")


@pytest.mark.parametrize(("redrape", "stored"), [(None, None), ("wait", None), ("later", "later"), ("never", "never")])
def test_order_reaches_the_home_and_the_service_alike(backend, database, tmp_path, redrape, stored):
    """Breaks where a program that waits for re-drapes at home does not by HTTP, whose own default is another."""
    files = put_file(tmp_path, "skirt.ply"), put_file(tmp_path, "body.ply")
    job = backend.submit(Order(*files, settings=RecoverySettings(redrape=redrape))).job
    assert find_job(database, job).request["settings"].get("redrape") == stored


def test_commands_ask_for_it_later_or_wait(cli, database, tmp_path):
    """Breaks where `submit` waits for re-drapes, its tables do not name the option, or another word is taken."""
    body, table = put_file(tmp_path, "body.ply"), tmp_path / "batch.csv"
    for name in ("one", "two", "three"):
        put_file(tmp_path, f"{name}.ply")
    table.write_text("scan,redrape\ntwo.ply,never\nthree.ply,\n")
    jobs = cli("submit", tmp_path / "one.ply", table, "--body", body).stdout.splitlines()
    jobs = [line.split()[0] for line in jobs]
    assert [find_job(database, job).request["settings"].get("redrape") for job in jobs] == ["later", "never", "later"]
    waited = cli("submit", tmp_path / "one.ply", "--body", body, "--redrape", "wait", "--force").stdout.split()[0]
    assert "redrape" not in find_job(database, waited).request["settings"]
    assert cli("submit", tmp_path / "one.ply", "--body", body, "--redrape", "soon").returncode == 2


def test_result_is_shown_before_its_redrape(recover, cli, database):
    """Breaks where `garmentq result` waits for a re-drape, ends with a status for it, or hides that it is pending."""
    job = recover()
    (child,) = find_below(database, [job])
    shown = cli("result", job)
    assert shown.returncode == 0 and f"pending, job {child.id}" in shown.stdout
    assert cli("result", child.id).returncode == 3
    assert cli("result", job, "--json").stdout.count("\n") == 1
    assert run_redrape(recover, database, job) == "succeeded"
    assert "pending" not in cli("result", job).stdout
