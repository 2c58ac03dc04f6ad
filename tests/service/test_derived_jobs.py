"""Derived jobs: what is asked of a stored result, by whom, and what is kept of it; by both backends alike."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from garmentq.cli.follow import Wait, follow
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabric_file import write_fabrics
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.outcome import Outcome
from garmentq.core.cloth.statics import Drape
from garmentq.core.garment.pieces.numbers import measure_pieces
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.reuse.wear.dressing import DressedGarment, measure_worn
from garmentq.core.reuse.wear.ease import measure_ease
from garmentq.core.reuse.wear.verdicts import judge_wear
from garmentq.core.reuse.wear.worn import WornGarment, load_worn, save_worn
from garmentq.core.run.errors import GarmentqError
from garmentq.core.run.report import ResultReport
from garmentq.service.derived import DerivedOrder, submit_derived
from garmentq.service.jobs import find_job
from garmentq.service.models import PieceRow
from garmentq.service.query import JobQuery
from garmentq.service.results import export_files, list_files
from garmentq.service.services import Services
from garmentq.service.terms import JobTerms
from garmentq_family_home import REMOTE_BY_DAY, work_off
from sqlalchemy import select

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "api"))

from api_work import finish, make_key  # noqa: E402

SPEC = "builtin:male,height=1.80"


@pytest.fixture(scope="session")
def database_kind():
    """Ask of SQLite only: derived jobs are made by the same functions as all others."""
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
    finish(settings, database, store, job, tmp_path / "made")
    return job


@pytest.fixture
def quick(monkeypatch):
    """Let dressing take no time: the garment stays where it is, on the new body."""

    def dress(worn, body, fabric, clock):
        now = replace(worn, body=body, fabric=fabric or worn.fabric)
        drape = Drape(worn.garment.nodes, 0.1, 3, 1.0, Outcome.CONVERGED, worn.garment.nodes)
        from garmentq.core.recover.drape.wearer import WearerGeometry

        ease, loads = measure_ease(now.garment, body), np.zeros((2, len(worn.garment.nodes)))
        metrics = measure_worn(now, WearerGeometry(body), drape) | {"ease.hip_mm": 41.0}
        return DressedGarment(
            worn, now, drape, ease, *loads,
            ResultReport(metrics, judge_wear(metrics), ("quick",), {"drape": 0.1}, 0.1, 1.0),
            measure_pieces(worn.pattern).pieces,
        )  # fmt: skip

    def dress_over(worn, under, body, fabric, clock):
        return replace(dress(worn, body, fabric, clock), inner=replace(under, body=body))

    monkeypatch.setattr("garmentq.core.reuse.wear.dressing.dress_body", dress)
    monkeypatch.setattr("garmentq.core.reuse.wear.dress_over.dress_over", dress_over)
    monkeypatch.setattr("garmentq.core.reuse.wear.refit.make_to_measure", dress)


@REMOTE_BY_DAY
@pytest.mark.parametrize("kind", ["dress", "refit"])
def test_result_is_worn_by_another(kind, backend, result, quick, settings, database, store, tmp_path):
    """Broken where body, pose or fabric get lost on the way, the input is changed, or numbers cannot be searched."""
    before = {file.name: file.sha256 for file in list_files(database, result)}
    options = {"body": SPEC, "pose": "A", "fabric": "denim"}
    done = backend.submit_derived(DerivedOrder(kind, result, options, terms=JobTerms(tags=("try",))))
    assert done.is_new and not backend.submit_derived(DerivedOrder(kind, result, options)).is_new
    work_off(settings, database)
    report = backend.find_job(done.job)
    assert (report.state, report.error) == ("succeeded", None)
    assert (report.kind, report.body, report.fabric, report.garment) == (kind, "builtin:male", "denim", "skirt")
    assert report.inputs == {"result": result} and report.family == done.job
    with database.read() as session:
        pieces = list(session.scalars(select(PieceRow).where(PieceRow.job == done.job)))
    assert pieces and all(0.0 < piece.area < piece.perimeter and piece.cloth > 0.0 for piece in pieces)
    assert [job.id for job in backend.find_jobs(JobQuery(wheres=["ease.hip_mm > 40", f"kind = {kind}"]))] == [done.job]
    assert {file.name: file.sha256 for file in list_files(database, result)} == before
    paths = {path.name for path in export_files(database, store, done.job, tmp_path / "out")}
    assert {"dressed.ply", "body.ply", "worn.npz", "picture.png", "report.html", "pattern.json"} <= paths
    np.testing.assert_allclose(load_worn(tmp_path / "out").body.vertices, builtin_body(f"{SPEC},pose=A").vertices)


@REMOTE_BY_DAY
def test_result_is_worn_over_another(backend, result, quick, settings, database, store, tmp_path):
    """Broken where the garment below is lost on the way, or worn over nothing is the same job as worn over it."""
    alone = backend.submit_derived(DerivedOrder("dress", result, {"body": SPEC}))
    work_off(settings, database)
    order = DerivedOrder("dress", result, {"body": SPEC}, over=alone.job[:8])
    done = backend.submit_derived(order)
    assert done.is_new and not backend.submit_derived(order).is_new
    work_off(settings, database)
    report = backend.find_job(done.job)
    assert (report.state, report.inputs) == ("succeeded", {"result": result, "under": alone.job})
    paths = {path.name for path in export_files(database, store, done.job, tmp_path / "out")}
    assert {"dressed.ply", "under.ply", "under.obj", "under.glb", "worn.npz"} <= paths
    for wrong, code in (
        (replace(order, kind="refit"), "job.request_bad"),
        (replace(order, over="0" * 12), "job.unknown"),
    ):
        with pytest.raises(GarmentqError) as caught:
            backend.submit_derived(wrong)
        assert caught.value.code == code


@REMOTE_BY_DAY
def test_imported_fabric_goes_into_the_job(backend, result, quick, settings, database, tmp_path):
    """Broken where a job depends on what happens to an imported fabric after it was asked for."""
    mine = replace(get_fabric("canvas"), name="mine", k=7e-4)
    write_fabrics([mine], tmp_path / "mine.json")
    assert backend.import_materials(tmp_path / "mine.json") == [mine] == [backend.read_material("mine")]
    order = DerivedOrder("dress", result, {"body": SPEC, "fabric": "mine"})
    done = backend.submit_derived(order)
    write_fabrics([replace(mine, k=1e-4)], tmp_path / "mine.json")
    backend.import_materials(tmp_path / "mine.json")
    assert backend.submit_derived(order).is_new, "another cloth of the same name is another job"
    backend.delete_material("mine")
    assert "mine" not in [fabric.name for fabric in backend.list_materials()]
    for ask in (lambda: backend.submit_derived(order), lambda: backend.delete_material("mine")):
        with pytest.raises(GarmentqError) as caught:
            ask()
        assert caught.value.code == "fabric.unknown"
    work_off(settings, database)
    assert (backend.find_job(done.job).state, backend.find_job(done.job).fabric) == ("succeeded", "mine")
    backend.export_files(done.job, tmp_path / "out", ["worn.npz"])
    assert load_worn(tmp_path / "out").fabric == mine


def test_file_of_a_body_goes_through_the_check(backend, result, quick, settings, database, tmp_path):
    """Broken where a user's bytes are read outside the limited process, or a bad file is no bad input."""
    path = tmp_path / "bad.ply"
    path.write_bytes(b"ply\nnothing")
    done = backend.submit_derived(DerivedOrder("dress", result, {"units": "m"}, {"body": path}))
    work_off(settings, database)
    report = backend.find_job(done.job)
    assert report.state == "failed" and report.bad_input and report.stage == "check"


WRONG = [
    ("body.spec_bad", {"options": {"pose": "lotus"}}),
    ("body.spec_bad", {"options": {"body": "builtin:giant"}}),
    ("fabric.unknown", {"options": {"fabric": "granite"}}),
    ("job.request_bad", {"options": {"fabric": {"name": "mine", "k": -1.0}}}),
    ("job.request_bad", {"options": {"colour": "red"}}),
    ("job.request_bad", {"kind": "recover"}),
    ("job.request_bad", {"options": {"units": "cm"}}),
    ("job.request_bad", {"files": {"scan": Path(__file__)}}),
    ("job.kind_unknown", {"kind": "knit"}),
    ("job.request_bad", {"options": {"body": {"sha256": 64 * "a", "name": "b.ply"}}}),
    ("job.request_bad", {"kind": "animate", "options": {"motion": {"sha256": 64 * "a", "name": "m.bvh"}}}),
    ("job.request_bad", {"kind": "animate", "options": {"motion": {"sha256": 1, "name": "m.bvh"}}}),
    ("job.request_bad", {"kind": "animate", "options": {"motion": "walk", "fps": 10**400}}),
]


def test_what_cannot_be_is_refused_at_once(backend, result):
    """Broken where a slip in the order is a queued job, a traceback or a fault of the service."""
    for code, change in WRONG:
        with pytest.raises(GarmentqError) as caught:
            backend.submit_derived(DerivedOrder(**{"kind": "dress", "result": result, **change}))
        assert caught.value.code == code, change


def test_only_ended_garments_of_ones_own_are_worn(settings, database, store, result, queue_job):
    """Broken where a job without a result is read, or another's result by whoever knows its id."""
    services = Services(settings, database, store)
    waiting = queue_job("other")
    with pytest.raises(GarmentqError) as caught:
        submit_derived(services, DerivedOrder("dress", waiting))
    assert caught.value.code == "job.input_not_ended"
    make_key(database, "stranger")
    with pytest.raises(GarmentqError) as caught:
        submit_derived(services, DerivedOrder("dress", result, terms=JobTerms(key="stranger")))
    assert caught.value.code == "job.unknown"
    assert find_job(database, result).state == "succeeded"


def test_result_of_an_older_version_is_refused_at_once(backend, queue_job, settings, database, store, tmp_path):
    """Broken where a job is queued that can only fail, or its refusal does not say what to do."""
    job = queue_job("older")
    (tmp_path / "older").mkdir()
    (tmp_path / "older" / "detail.ply").write_bytes(b"ply of an older version")
    finish(settings, database, store, job, tmp_path / "older")
    for order in (DerivedOrder("dress", job), DerivedOrder("animate", job, {"motion": "walk"})):
        with pytest.raises(GarmentqError) as caught:
            backend.submit_derived(order)
        assert caught.value.code == "result.old"


@REMOTE_BY_DAY
def test_only_the_garment_is_read(backend, result, quick, settings, database, monkeypatch):
    """Broken where every mesh and picture of a result is copied for a job that reads one file of it."""
    from garmentq.core.reuse.wear import worn as wear

    seen, load = [], wear.load_worn
    monkeypatch.setattr(wear, "load_worn", lambda folder: seen.append(sorted(folder.iterdir())) or load(folder))
    done = backend.submit_derived(DerivedOrder("dress", result, {"body": SPEC}))
    work_off(settings, database)
    again = backend.submit_derived(DerivedOrder("dress", done.job, {"body": SPEC}))
    work_off(settings, database)
    assert backend.find_job(again.job).state == "succeeded"
    assert [[path.name for path in paths] for paths in seen] == [["worn.npz"]] * 2


def test_a_file_is_worn_only_by_who_handed_it_in(settings, database, store, result, tmp_path):
    """Broken where whoever knows a file's hash reads it by naming it among the options, past the check of uploads."""
    services = Services(settings, database, store)
    (tmp_path / "secret.ply").write_bytes(b"ply of another")
    kept = store.put(tmp_path / "secret.ply").sha256
    with pytest.raises(GarmentqError) as caught:
        submit_derived(services, DerivedOrder("dress", result, {"body": {"sha256": kept, "name": "body.ply"}}))
    assert caught.value.code == "job.request_bad"


def test_thirty_is_thirty(backend, result):
    """Broken where a rate written without a point is another job than the same rate with one."""
    first = backend.submit_derived(DerivedOrder("animate", result, {"motion": "walk", "fps": 30}))
    assert backend.submit_derived(DerivedOrder("animate", result, {"motion": "walk", "fps": 30.0})).job == first.job


@pytest.fixture
def still(monkeypatch):
    """Let moving take no time: every frame is the garment at rest, but each frame's body is the motion's."""
    from garmentq.core.reuse.animate.animation import Animation, FrameVerdict

    def frames(worn, motion, settings, hooks):
        from garmentq.core.body.motion.moving_body import MovingBody
        from garmentq.core.reuse.animate.animation import list_times

        times = list_times(motion, settings)
        transforms = np.stack([MovingBody(worn.body).transforms(motion.at(float(t))) for t in times])
        nodes = np.tile(worn.garment.nodes, (len(times), 1, 1))
        return Animation(
            worn, settings.fps, times, nodes, transforms, (FrameVerdict(True, 0.0, 0, 1, 1, 0.1),) * len(times)
        )

    monkeypatch.setattr("garmentq.core.reuse.animate.animate_garment.animate", frames)


KEYS = b'{"keys": [{"t": 0, "pose": "A"}, {"t": 1, "pose": {"left_knee": [40, 0, 0]}}]}'


@REMOTE_BY_DAY
def test_result_moves(backend, result, still, settings, database, store, tmp_path):
    """Broken where the motion's file, its range or its rate get lost on the way, or numbers cannot be searched."""
    path = tmp_path / "bend.json"
    path.write_bytes(KEYS)
    options = {"fps": 10.0, "begin": 0.5}
    done = backend.submit_derived(DerivedOrder("animate", result, options, {"motion": path}))
    work_off(settings, database)
    report = backend.find_job(done.job)
    assert (report.state, report.error) == ("succeeded", None)
    assert (report.kind, report.garment, report.metrics["frames"]) == ("animate", "skirt", 6.0)
    verdicts = {gate.name: gate.verdict for gate in report.gates}
    assert verdicts == dict.fromkeys(["motion", "converged", "depth", "pinched", "crossings"], "pass")
    found = backend.find_jobs(JobQuery(wheres=["max_depth_mm < 2", "crossings < 1", "kind = animate"]))
    assert [job.id for job in found] == [done.job]
    paths = {path.name for path in export_files(database, store, done.job, tmp_path / "out")}
    assert {"garment.pc2", "garment.mdd", "garment.glb", "body.pc2", "sheet.png", "preview.gif", "report.html"} <= paths


LEG = (
    "JOINT {0}UpLeg {{\nOFFSET {1} -4 0\nJOINT {0}Leg {{\nOFFSET 0 -42 0\n"
    "JOINT {0}Foot {{\nOFFSET 0 -41 0\n}}\n}}\n}}\n"
)

LEGS = (
    "HIERARCHY\nROOT Hips {\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    f"{LEG.format('Left', 9)}{LEG.format('Right', -9)}}}\n"
    "MOTION\nFrames: 2\nFrame Time: 0.1\n0 0 0\n0 10 0\n"
)


def test_a_motion_without_arms_is_told_when_it_is_read(backend, result, still, settings, database, tmp_path, capsys):
    """Broken where a motion whose arms and trunk are not understood passes, or is only told of at the end."""
    path = tmp_path / "legs.bvh"
    path.write_text(LEGS)
    done = backend.submit_derived(DerivedOrder("animate", result, {}, {"motion": path}))
    work_off(settings, database)
    report = backend.find_job(done.job)
    assert (report.state, report.verdict) == ("succeeded", "fail")
    gate = next(gate for gate in report.gates if gate.name == "motion")
    assert gate.verdict == "fail" and "left_shoulder" in gate.message
    follow(backend, done.job, Wait())
    lines = capsys.readouterr().err.splitlines()
    told = next(n for n, line in enumerate(lines) if "doubted" in line and "left_shoulder" in line)
    assert told < next(n for n, line in enumerate(lines) if "animate ..." in line)


def test_a_motions_file_goes_through_the_check(backend, result, still, settings, database, tmp_path):
    """Broken where a user's motion is read outside the limited process, or a bad one is no bad input."""
    path = tmp_path / "bad.bvh"
    path.write_bytes(b"HIERARCHY\n}\nMOTION\n")
    done = backend.submit_derived(DerivedOrder("animate", result, {}, {"motion": path}))
    work_off(settings, database)
    report = backend.find_job(done.job)
    assert report.state == "failed" and report.bad_input and report.stage == "check"
    assert report.error["code"] == "motion.bad" if isinstance(report.error, dict) else "motion.bad" in str(report.error)


NO_ANIMATION = [
    ("job.request_bad", {"motion": "moonwalk"}),
    ("job.request_bad", {}),
    ("animate.settings_bad", {"motion": "walk", "fps": 0.0}),
    ("animate.settings_bad", {"motion": "walk", "begin": 2.0, "end": 1.0}),
    ("animate.settings_bad", {"motion": "walk", "damping": -1.0}),
]


def test_what_makes_no_animation_is_refused_at_once(backend, result):
    """Broken where such an order is a queued job, a traceback or a fault of the service."""
    for code, options in NO_ANIMATION:
        with pytest.raises(GarmentqError) as caught:
            backend.submit_derived(DerivedOrder("animate", result, options))
        assert caught.value.code == code, options
