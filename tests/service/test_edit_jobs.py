"""Versions of a result: an edited pattern is draped anew, nothing is overwritten, and nobody sees another's."""

from __future__ import annotations

import json
import sys
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from pathlib import Path

import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.result import write_json
from garmentq.core.garment.garmentcode import load_pattern, read_pattern
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.reuse.wear.worn import WornGarment, load_worn, save_worn
from garmentq.core.run.errors import GarmentqError
from garmentq.service.derived import DerivedOrder
from garmentq.service.keys import create_key
from garmentq.service.local import LocalBackend
from garmentq.service.local_token import make_local_token
from garmentq.service.models import OwnerRow
from garmentq.service.remote import RemoteBackend
from garmentq.service.results import list_files
from garmentq_family_home import REMOTE_BY_DAY, work_off

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "api"))

from api_client import serving  # noqa: E402
from api_work import finish  # noqa: E402
from quick_edit import drape_at_once  # noqa: E402


@pytest.fixture(scope="session")
def database_kind():
    """Ask of SQLite only: versions are found by one plain question."""
    return "sqlite"


@pytest.fixture(scope="module")
def worn() -> WornGarment:
    """Return a skirt as it hangs on the body that it was drafted for."""
    garment = load_draped_template("skirt")
    body = builtin_body("builtin:female,height=1.70")
    waist = garment.nodes[garment.contour("waist").vertices]
    return WornGarment(garment, get_fabric("cotton_poplin"), body, waist, None, "skirt", "skirt")


@pytest.fixture
def result(queue_job, settings, database, store, tmp_path, worn) -> str:
    """Return a recovery that has succeeded and kept a skirt."""
    job = queue_job("skirt")
    (tmp_path / "made").mkdir()
    save_worn(worn, tmp_path / "made")
    write_json(write_pattern(worn.pattern), tmp_path / "made" / "pattern.json")
    finish(settings, database, store, job, tmp_path / "made")
    return job


@pytest.fixture
def quick(monkeypatch):
    """Let draping take no time."""
    drape_at_once(monkeypatch)


def lengthen(document: dict, panels: tuple[str, ...], by: float) -> dict:
    """Return a skirt's document with the lowest points of some panels lower by so much [its unit]."""
    changed = deepcopy(document)
    for name in panels:
        vertices = changed["pattern"]["panels"][name]["vertices"]
        lowest = min(y for _, y in vertices)
        for vertex in vertices:
            vertex[1] -= by * (vertex[1] < lowest + 3.0)
    return changed


def write(document: dict, path: Path) -> Path:
    """Write a document as a browser does."""
    path.write_text(json.dumps(document))
    return path


@REMOTE_BY_DAY
def test_an_edit_is_a_version(backend, result, quick, settings, database, store, worn, tmp_path):
    """Broken where an edit changes its input, loses its predecessor, is not compared with the recovered pattern, or an
    undo to the start gives another file."""
    before = {file.name: file.sha256 for file in list_files(database, result)}
    start = write_pattern(worn.pattern)
    longer = write(lengthen(start, ("front", "back"), 2.0), tmp_path / "longer.json")
    first = backend.submit_derived(DerivedOrder("edit", result, files={"pattern": longer}))
    assert first.is_new and not backend.submit_derived(DerivedOrder("edit", result, files={"pattern": longer})).is_new
    work_off(settings, database)
    undone = backend.submit_derived(
        DerivedOrder("edit", first.job, files={"pattern": write(start, tmp_path / "u.json")})
    )
    work_off(settings, database)
    report = backend.find_job(first.job)
    assert (report.state, report.error, report.kind, report.garment) == ("succeeded", None, "edit", "skirt")
    assert report.inputs == {"result": result} and report.details["predecessor"] == result
    assert report.metrics["seam_mismatch_mm"] < 1e-3 and report.metrics["area_change_cm2"] > 100.0
    assert {"at_rest", "depth", "crossings", "seams"} <= {gate.name for gate in report.gates}
    assert {file.name: file.sha256 for file in list_files(database, result)} == before
    found = [(one.job, one.predecessor, one.kind) for one in backend.list_versions(undone.job)]
    assert found == [(result, None, "recover"), (first.job, result, "edit"), (undone.job, first.job, "edit")]
    backend.export_files(undone.job, tmp_path / "undone")
    assert (tmp_path / "undone" / "pattern.json").read_bytes() == (tmp_path / "made" / "pattern.json").read_bytes()
    difference = json.loads((tmp_path / "undone" / "difference.json").read_text())
    assert all(pair["outline_mm"] < 1e-6 for pair in difference["panels"]["pairs"])
    backend.export_files(first.job, tmp_path / "first")
    told = json.loads((tmp_path / "first" / "difference.json").read_text())
    assert {pair["first"]: pair["paired_by"] for pair in told["panels"]["pairs"]} == {"front": "name", "back": "name"}
    assert all(pair["area_percent"] > 0.5 for pair in told["panels"]["pairs"])
    changes = [change for seam in told["seams"] for change in seam["change_mm"]]
    assert max(changes) == pytest.approx(20.0, rel=0.1) and told["seams_added"] == told["seams_removed"] == []
    assert "Difference to the recovered pattern" in (tmp_path / "first" / "report.html").read_text()


def test_what_cannot_be_sewn_is_refused_with_its_place(result, settings, worn, tmp_path):
    """Broken where a pattern that cannot be draped is queued, or its refusal does not say where."""
    start = write_pattern(worn.pattern)
    broken = write(lengthen(start, ("front",), 5.0), tmp_path / "broken.json")
    with serving(settings) as url, RemoteBackend(url, make_local_token(settings.home)) as there:
        with pytest.raises(GarmentqError) as caught:
            there.submit_derived(DerivedOrder("edit", result, files={"pattern": broken}))
        assert caught.value.code == "pattern.unsound" and "seam" in caught.value.message
        digest = there.upload("patterns", broken)
        wanted = {"kind": "edit", "result": result, "files": {"pattern": digest}}
        answer = there._connection._http.post("/v1/jobs", json=wanted)
    assert answer.status_code == 422 and answer.headers["content-type"] == "application/problem+json"
    finding = answer.json()["findings"][0]
    assert (finding["code"], finding["severity"]) == ("pattern.seam_unequal", "error") and finding["seam"] is not None
    assert {place["panel"] for place in finding["places"]} == {"front", "back"}
    assert all(place["edge"] is not None for place in finding["places"])


def test_edit_by_command(cli, result, worn, tmp_path):
    """Broken where the command queues nothing, or ends well or without a place where the pattern cannot be sewn."""
    start = write_pattern(worn.pattern)
    longer = write(lengthen(start, ("front", "back"), 2.0), tmp_path / "longer.json")
    done = cli("edit", result, "--pattern", str(longer), "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["is_new"]
    broken = write(lengthen(start, ("front",), 5.0), tmp_path / "broken.json")
    refused = cli("edit", result, "--pattern", str(broken))
    assert refused.returncode == 4 and "pattern.unsound" in refused.stderr and "seam 0" in refused.stderr


def test_what_is_no_pattern_is_refused(backend, result, tmp_path):
    """Broken where bytes that are no pattern are queued, or the recovered pattern can be given by whoever asks."""
    (tmp_path / "bad.json").write_text("{")
    with pytest.raises(GarmentqError) as caught:
        backend.submit_derived(DerivedOrder("edit", result, files={"pattern": tmp_path / "bad.json"}))
    assert caught.value.code == "pattern.unreadable"
    with pytest.raises(GarmentqError) as caught:
        backend.submit_derived(DerivedOrder("edit", result))
    assert caught.value.code == "job.request_bad"


@pytest.mark.nightly
def test_two_edit_one_result_at_once(result, quick, settings, database, store, worn, tmp_path):
    """Broken where one of two edits of a result is lost or changes the other, or a key sees or edits another's."""
    keys = [create_key(database, name, ("read", "submit"), 10) for name in ("anna", "bert", "eve")]
    with database.write() as session:
        for row, _ in keys[:2]:
            session.add(OwnerRow(key=row.id, job=result))
    start = write_pattern(worn.pattern)
    files = [write(lengthen(start, ("front", "back"), by), tmp_path / f"{by}.json") for by in (1.0, 3.0)]
    with serving(settings) as url:
        people = [RemoteBackend(url, token) for _, token in keys]

        def ask(at: int) -> str:
            return people[at].submit_derived(DerivedOrder("edit", result, files={"pattern": files[at]})).job

        with ThreadPoolExecutor(2) as pool:
            jobs = list(pool.map(ask, (0, 1)))
        work_off(settings, database)
        for at in (0, 1):
            assert [(one.job, one.predecessor) for one in people[at].list_versions(result)] == [
                (result, None), (jobs[at], result)
            ]  # fmt: skip
            people[at].export_files(jobs[at], tmp_path / str(at), ["pattern.json"])
            wanted = write_json(write_pattern(read_pattern(files[at].read_text())), tmp_path / "wanted.json")
            assert (tmp_path / str(at) / "pattern.json").read_bytes() == wanted.read_bytes()
            with pytest.raises(GarmentqError) as caught:
                people[at].find_job(jobs[1 - at])
            assert caught.value.code == "job.unknown"
        asks = [
            lambda: people[2].list_versions(result),
            lambda: people[2].submit_derived(DerivedOrder("edit", result, files={"pattern": files[0]})),
            lambda: people[0].submit_derived(DerivedOrder("edit", jobs[1], files={"pattern": files[0]})),
        ]
        for question in asks:
            with pytest.raises(GarmentqError) as caught:
                question()
            assert caught.value.code == "job.unknown"
        for one in people:
            one.close()
    owners = LocalBackend(settings)
    assert owners.list_versions(jobs[0])[0].job == result
    assert {one.job for one in owners.list_versions(jobs[0])} == {result, *jobs}
    owners.close()


@REMOTE_BY_DAY
def test_a_version_becomes_a_template(backend, result, quick, settings, database, worn, tmp_path):
    """Broken where the pattern of a version cannot be imported as a template as it is."""
    longer = write(lengthen(write_pattern(worn.pattern), ("front", "back"), 2.0), tmp_path / "longer.json")
    job = backend.submit_derived(DerivedOrder("edit", result, files={"pattern": longer})).job
    work_off(settings, database)
    [file] = backend.export_files(job, tmp_path / "out", ["pattern.json"])
    assert backend.import_template("my_skirt", file).panels == 2
    assert backend.read_template("my_skirt") == file.read_bytes()
    assert load_worn_pattern(backend, job, tmp_path) == load_pattern(file).points.tolist()


def load_worn_pattern(backend, job: str, folder: Path) -> list:
    """Return the control points of the garment that a job keeps to be worn again."""
    backend.export_files(job, folder / "worn", ["worn.npz"])
    return load_worn(folder / "worn").pattern.points.tolist()
