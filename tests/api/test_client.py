"""The Python client against the documented API: every route has a method, and a result is opened by its address."""

from __future__ import annotations

import asyncio
import json
import re
from dataclasses import replace
from pathlib import Path

import garmentq
import numpy as np
import pytest
from api_client import carrying, serving
from api_work import make_ply
from garmentq.core.cloth.fabric_file import write_fabrics
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.run.errors import GarmentqError
from garmentq.service.client import Client
from garmentq.service.derived import DerivedOrder, InputWrong
from garmentq.service.families import make_children
from garmentq.service.jobs import claim, find_job
from garmentq.service.kinds.kind import ChildRequest
from garmentq.service.kinds.recover import Recover
from garmentq.service.local_token import make_local_token
from garmentq.service.models import ArtifactRow
from garmentq.service.order import Order
from garmentq.service.query import JobQuery
from garmentq.service.results import ResultMissing, store_result
from garmentq.service.subject_records import SubjectFields
from sqlalchemy import delete

NO_METHOD = {
    ("GET", "/v1/jobs/{job}/result"): "`find_job` and `list_artifacts` give the same in two answers.",
}
"""Routes without a method of the client, each with the reason."""


@pytest.fixture
def service(settings):
    """Return a client of the served home that notes what it asks, as (method, path) in `asked`."""
    with serving(settings) as url, Client(url, make_local_token(settings.home)) as opened:
        opened.asked, opened.url = [], url
        opened._connection._http.event_hooks["request"].append(
            lambda request: opened.asked.append((request.method, request.url.path))
        )
        yield opened


@pytest.fixture(scope="module")
def made(tube_recovery, tmp_path_factory) -> Path:
    """Return a folder with the files of a recovery that are read, and a picture of its pattern."""
    from garmentq.core.deliver.export.meshes import write_ply
    from garmentq.core.deliver.export.pattern_svg import write_svg
    from garmentq.core.deliver.export.result import to_plain_json
    from garmentq.core.reuse.wear.worn import save_worn, worn_from_recovery

    folder, recovery = tmp_path_factory.mktemp("made"), tube_recovery()
    for name, nodes in recovery.meshes:
        write_ply(nodes, recovery.garment.faces, folder / f"{name}.ply")
    for name in ("metrics", "manifest"):
        (folder / f"{name}.json").write_text(json.dumps(to_plain_json(getattr(recovery.report, name))))
    write_svg(recovery.pattern, folder / "pattern.svg")
    save_pattern(recovery.pattern, folder / "pattern.json")
    save_worn(worn_from_recovery(recovery), folder)
    return folder


@pytest.fixture
def finished(database, store, queue_job, tube_recovery, made) -> str:
    """Return a job with a result."""
    job = queue_job("skirt")
    held = claim(database, job, "test", 60.0)
    store_result(database, store, held, Recover(), tube_recovery(), made)
    return job


def find_routes(document: dict) -> set[tuple[str, str]]:
    """Return method and path of every documented route."""
    return {(method.upper(), path) for path, methods in document["paths"].items() for method in methods}


def names_of(route: tuple[str, str], asked: list[tuple[str, str]]) -> bool:
    """Return whether a route was asked; a name in braces stands for one part of a path, or of a file's name for all."""
    pattern = re.escape(route[1]).replace(r"/\{name\}", "/.+")
    return any(m == route[0] and re.fullmatch(re.sub(r"\\{.*?\\}", "[^/]+", pattern), path) for m, path in asked)


def ask_everything(service: Client, finished: str, folder: Path, settings) -> None:
    """Ask every question of the client once."""

    def refused(ask, *given) -> None:
        with pytest.raises(GarmentqError):
            ask(*given)

    for name, content in (("a.ply", make_ply()), ("b.ply", make_ply(0.5)), ("labels.json", b"[1]"), ("m.bvh", b"x")):
        (folder / name).write_bytes(content)
    save_pattern(load_template("skirt"), folder / "mine.json")
    write_fabrics([get_fabric("denim")], folder / "shipped.json")
    text = (folder / "shipped.json").read_text().replace('"denim"', '"mine"')
    (folder / "fabric.json").write_text(text)
    kinds = {"scans": "a.ply", "bodies": "b.ply", "labels": "labels.json", "patterns": "mine.json", "motions": "m.bvh"}
    for kind, name in kinds.items():
        service.forget_upload(kind, service.upload(kind, folder / name))
    scan = service.upload("scans", folder / "a.ply")
    assert service.inspect_scan(scan, quick=True, as_="garment", up="y")["needs"]["code"] == "body.missing"
    order = Order(folder / "a.ply", folder / "b.ply")
    job = service.submit(order).job
    assert [one.job for one in service.submit_many([order])] == [job]
    (folder / "points.npy").write_bytes(b"x")
    refused(service.mend_labels, finished, folder / "points.npy")
    refused(service.set_wearing, finished, "upper")
    refused(service.refine, finished)
    refused(service.submit_derived, DerivedOrder("dress", job, {"body": "builtin:female"}))
    service.find_job(job), service.find_jobs_by_id([job]), service.list_jobs(), service.find_jobs(JobQuery({}))
    found = list(service.iterate_jobs(JobQuery(limit=1)))
    assert [one.id for one in found] == [one.id for one in service.find_page(JobQuery()).jobs] and len(found) > 1
    service.poll_events(job), service.read_queue(), service.cancel(job), service.retry(job), service.cancel(job)
    service.delete_job(job)
    assert [one.job for one in service.list_versions(finished)] == [finished]
    service.rename(finished, "anna", ["march"])
    share, _ = service.create_share(finished)
    assert [one.id for one in service.list_shares(finished)] == [share.id]
    service.revoke_share(finished, share.id)
    service.list_artifacts(finished), service.export_files(finished, folder / "out", ["pattern.svg"])
    assert service.read_archive(finished).startswith(b"PK")
    refused(service.read_export, finished, "nosuch.pdf")
    assert service.read_wearer(finished)["job"] == finished
    assert service.match(finished, service.upload("patterns", folder / "mine.json"))["pairs"]
    document = json.loads(service.read_template("skirt"))
    assert service.check_pattern(document)["is_sound"]
    assert service.edit_pattern(document, [{"op": "equalise"}])["is_sound"]
    service.list_templates(), service.read_template("skirt"), service.import_template("mine", folder / "mine.json")
    service.delete_template("mine")
    hook, _ = service.create_webhook("https://127.0.0.1.invalid/")
    with carrying(settings):
        error = service.test_webhook(hook.id).error
    assert error and [(one.id, one.error) for one in service.list_webhooks()] == [(hook.id, error)]
    rotated, secret = service.rotate_secret(hook.id, 2.0)
    assert rotated.id == hook.id and secret.startswith("whsec_")
    service.delete_webhook(hook.id)
    anna = service.create_subject(SubjectFields("Anna"))
    service.update_subject(anna.id, replace(anna.said, note="x")), service.assign_jobs(anna.id, [finished])
    assert [one.id for one in service.list_subjects()] == [service.find_subject("Anna").id] == [anna.id]
    service.delete_subject(anna.id, dry_run=True)
    assert [one.tag for one in service.list_batches()] == ["march"]
    refused(service.find_batch, "nosuch")
    refused(service.find_person, "nobody"), refused(service.delete_person, "nobody", True)
    service.list_materials(), service.read_material("denim"), service.import_materials(folder / "fabric.json")
    service.delete_material("mine")
    assert "garmentq" in service.read_metrics() and service.read_health()["version"] == garmentq.__version__
    key, token = service.create_key("mine", ["admin"], 10)
    with Client(service.url, token) as admin:
        admin._connection._http.event_hooks = service._connection._http.event_hooks
        admin.list_keys()
        assert admin.rotate_key(key.id, 2.0)[0].id == admin.revoke_key(key.id).id


def test_every_route_has_a_method(service, finished, settings, tmp_path):
    """Broken where a route is added that the client does not know, and a program has to build its requests itself."""
    routes = find_routes(service.read_api())
    ask_everything(service, finished, tmp_path, settings)
    missing = {route for route in routes if not names_of(route, service.asked)}
    assert missing - NO_METHOD.keys() == set()
    assert NO_METHOD.keys() <= missing, "a reason for a route that has a method, or is gone"


def test_every_body_has_an_example(service):
    """Broken where a route takes a body and shows none."""
    document = service.read_api()
    schemas = document["components"]["schemas"]
    for path, methods in document["paths"].items():
        for method, route in methods.items():
            for kind, content in route.get("requestBody", {}).get("content", {}).items():
                named = [item.get("$ref", "").split("/")[-1] for item in walk(content["schema"])]
                shown = "example" in content or any("example" in schemas.get(name, {}) for name in named)
                assert shown or kind == "application/octet-stream", (method, path)


def walk(schema: dict) -> list[dict]:
    """Return a schema and its choices."""
    return [schema, *schema.get("anyOf", []), *schema.get("oneOf", [])]


def test_a_result_is_opened_by_its_address(service, finished, settings, tube_recovery, monkeypatch):
    """Broken where an address is not understood, a mesh is another one, or a token goes to a service not its own."""
    monkeypatch.delenv("GARMENTQ_URL", raising=False)
    monkeypatch.setenv("GARMENTQ_API_KEY", make_local_token(settings.home))
    wanted = tube_recovery().meshes.detail
    for source in (f"{service.url}/results/{finished}", f"{service.url}/v1/jobs/{finished}/result", finished[:6]):
        found = garmentq.open_result(source, home=settings.home)
        assert np.array_equal(found.mesh("detail").vertices, wanted)
    monkeypatch.setenv("GARMENTQ_URL", "http://127.0.0.1:9")
    monkeypatch.setenv("GARMENTQ_API_KEY", "gq_secret")
    found = garmentq.open_result(f"{service.url}/results/{finished}", home=settings.home)  # by the home's own token
    assert found.pattern.name == "tube"
    with pytest.raises(GarmentqError, match="key"):
        garmentq.open_result(f"{service.url}/results/{finished}", key="gq_wrong")


def test_a_persons_job_names_its_garments(service, finished, settings, monkeypatch, database):
    """Broken where a job without a garment ends in a missing file instead of the next step."""
    monkeypatch.delenv("GARMENTQ_URL", raising=False)
    root = find_job(database, finished)
    with database.write() as session:
        made = make_children(session, finished, [ChildRequest("upper", "recover", root.request)])
        session.execute(delete(ArtifactRow).where(ArtifactRow.job == finished, ArtifactRow.name == "worn.npz"))
    with pytest.raises(InputWrong, match=f"upper {made['upper']}"):
        garmentq.open_result(finished, home=settings.home)
    with pytest.raises(ResultMissing):
        garmentq.open_result(made["upper"], home=settings.home)


def test_ten_lines_lead_from_a_scan_to_a_pattern(service, finished, settings, tmp_path, monkeypatch):
    """Broken where a job's handle shows another result, waits for ever, or a person's garments are not named."""
    with garmentq.Client(service.url, make_local_token(settings.home)) as client:
        job = client.job(finished[:6]).wait(5.0)
        assert job.pattern.name == "tube" and job.mesh("detail").vertices.shape[1] == 3
        assert job.metrics == job.report.metrics and list(job.garments) == [job.name]
        assert job.read_file("pattern.svg").startswith(b"<")
        assert repr(job) == f"<JobHandle {finished} 'skirt' succeeded>" and repr(client) == f"<Client {service.url}>"
        scan = tmp_path / "a.ply"
        scan.write_bytes(make_ply())
        new = client.recover(
            scan, "builtin:female,height=1.70", name="mine", tags=["t"], quality="preview", method="deform"
        )
        assert (new.name, new.state, new.report.tags) == ("mine", "queued", ["t"])
        assert (new.report.settings["method"], new.report.settings["vertex_count"]) == ("deform", 2000)
        with pytest.raises(GarmentqError, match="has not ended"):
            new.wait(0.0)
        with pytest.raises(GarmentqError, match=r"is queued; `wait\(\)`"):
            _ = new.pattern
        assert new.cancel().state == "cancelled"
        with pytest.raises(GarmentqError, match="no result"):
            new.wait()
        with pytest.raises(GarmentqError, match="Did you mean 'method'"):
            client.recover(scan, methd="deform")


def test_many_scans_are_waited_for_at_once(service, finished, settings):
    """Broken where the asynchronous client blocks the loop, or gives another result than the other."""

    async def ask() -> tuple[str, int]:
        async with garmentq.AsyncClient(service.url, make_local_token(settings.home)) as client:
            jobs = await asyncio.gather(*(client.job(finished) for _ in range(3)))
            done = await asyncio.gather(*(job.wait(5.0) for job in jobs))
            queue = await client.call(client.client.read_queue)
            return (await done[0].result()).pattern.name, queue.states["succeeded"]

    assert asyncio.run(ask()) == ("tube", 1)
