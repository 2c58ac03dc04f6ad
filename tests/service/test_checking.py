"""The first stage of a job: what a limited process read is what would have been read here, and so are its refusals."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.reading import load_reading, save_reading
from garmentq.core.garment.templates import load_template
from garmentq.core.recover.inputs import read_request
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.run.checkpoints import pack
from garmentq.core.run.errors import BadInput
from garmentq.core.run.sandbox import ReaderCrashed
from garmentq.service.checking import check_files
from garmentq.service.families import cancel
from garmentq.service.jobs import find_job
from garmentq.service.kinds import pack_request
from garmentq.service.kinds import read_request as parse_request
from garmentq.service.kinds.recover_request import READING, FileRef, RecoverRequest
from garmentq.service.results import report_jobs
from garmentq.service.settings import CHECKER
from garmentq.workers.recovery import run_job
from garmentq_home import SQLITE_BY_DAY, wait_for

sys.path.insert(0, str(Path(__file__).parents[1] / "api"))
from bad_files import FILES

MESHES = ".ply", ".obj", ".stl", ".off", ".glb"


def write_mesh(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Write an OBJ."""
    path.parent.mkdir(parents=True)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path.write_text("\n".join(lines) + "\n")


@pytest.fixture
def request_of(tmp_path):
    """Write a skirt on a body with a pattern file; give a function that makes a request of a scan's name."""
    body = builtin_body("builtin:female,height=1.70,pose=A")
    hips = (np.abs(body.vertices[:, 1] - 0.85) < 0.18) & (np.abs(body.vertices[:, 0]) < 0.25)
    faces = body.faces[hips[body.faces].all(axis=1)]
    write_mesh(tmp_path / "scan" / "skirt.obj", body.vertices, faces)
    write_mesh(tmp_path / "body" / "body.obj", body.vertices, body.faces)
    (tmp_path / "template").mkdir()
    save_pattern(load_template("skirt"), tmp_path / "template" / "mine.json")

    def make(name: str = "skirt.obj", template: str | None = "mine.json") -> dict:
        ref = FileRef("0" * 64, name)
        base = FileRef("0" * 64, template) if template else None
        return pack_request(RecoverRequest(ref, FileRef("0" * 64, "body.obj"), base, RecoverySettings()))

    return make


def never() -> bool:
    """Stop nothing."""
    return False


def test_what_is_read_is_the_same(tmp_path, request_of):
    """Broken where the arrays that a limited process hands over differ by a bit from those read in this process."""
    found = check_files(CHECKER, request_of(), tmp_path, never)
    files = (tmp_path / "scan" / "skirt.obj", tmp_path / "body" / "body.obj", tmp_path / "template" / "mine.json")
    plain = read_request(Request(*files))
    read = load_reading(tmp_path / READING)
    assert read.pattern is not None and plain.pattern is not None and read.pattern.extra == plain.pattern.extra
    ours, theirs = (pack(replace(one, pattern=replace(one.pattern, extra={}))) for one in (plain, read))
    assert ours.keys() == theirs.keys()
    assert all(ours[name].dtype == theirs[name].dtype and np.array_equal(ours[name], theirs[name]) for name in ours)
    assert found["scan"]["units"] == "m" and found["scan"]["face_count"] == len(plain.pieces.garment.faces)
    assert found["body"]["vertex_count"] == len(plain.pieces.wearer.vertices)
    assert found["pattern"]["panels"] == len(plain.pattern.panels) and found["cpu_seconds"] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in FILES if name.endswith(MESHES)])
def test_refusals_are_the_same(tmp_path, request_of, name):
    """Broken where a bomb or a file that lies about its size has another code, or message, in a limited process."""
    path = tmp_path / "scan" / name
    path.write_bytes(FILES[name])
    wanted = request_of(name, None)
    with pytest.raises(BadInput) as here:
        read_request(parse_request(RecoverRequest, wanted).unpack(tmp_path))
    with pytest.raises(BadInput) as there:
        check_files(CHECKER, wanted, tmp_path, never)
    assert (there.value.code, there.value.message) == (here.value.code, here.value.message)


def test_what_was_handed_over_is_not_believed(tmp_path, request_of):
    """Broken where a reader that a file took over hands over a pickle, a bomb or something else."""
    check_files(CHECKER, request_of(), tmp_path, never)
    path, whole = tmp_path / READING, load_reading(tmp_path / READING)
    np.savez_compressed(path, a=np.zeros(10))
    with pytest.raises(ReaderCrashed):
        load_reading(path)
    np.savez(path, a=np.array([{}], dtype=object))
    with pytest.raises(ReaderCrashed):
        load_reading(path)
    save_reading(whole, path)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(ReaderCrashed):
        load_reading(path)


@SQLITE_BY_DAY
def test_the_job_shows_what_was_read_or_why_not(settings, database, queue_job):
    """Broken where the first stage's findings or its refusal do not reach the job's row."""
    good, greedy, odd = queue_job("good"), queue_job("greedy"), queue_job("odd")
    assert run_job(settings, database, good, never) == "succeeded"
    assert run_job(settings, database, greedy, never) == "failed"
    assert run_job(settings, database, odd, never) == "failed"
    report = report_jobs(database, [find_job(database, good)], settings)[0]
    assert report.details["checked"]["scan"] == {"name": "good", "units": "m"}
    row = find_job(database, greedy)
    assert (row.error_code, row.bad_input, row.stage) == ("input.too_large", True, "check")
    assert find_job(database, odd).error_message == "the panel 'a??' is cut off; export it again."


def test_a_cancelled_job_does_not_wait_for_its_reader(settings, database, queue_job):
    """Broken where an endless reader keeps a cancelled job, and its worker, until the deadline."""
    job = queue_job("endless")
    work = Thread(target=run_job, args=(settings, database, job, never))
    work.start()
    wait_for(lambda: find_job(database, job).stage == "check")
    cancel(database, job)
    work.join()
    assert find_job(database, job).state == "cancelled"
