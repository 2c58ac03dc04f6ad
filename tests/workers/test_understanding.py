"""What a scan is that came with a body: the whole person, or a garment alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.spec import BuiltinWearer
from garmentq.service.jobs import find_job
from garmentq.service.kinds import FileRef
from garmentq.service.kinds.recover import Recover
from garmentq.service.kinds.recover_request import RecoverRequest
from garmentq.service.settings import CHECKER
from garmentq.service.submission import Order, submit
from garmentq.workers.recovery import run_job

WEARER = "builtin:female,height=1.70"
PERSONS = {"separator": "garmentq_person:take_apart", "person_checker": "garmentq_checker:check"}


@pytest.mark.slow
def test_who_shows_his_face_is_a_person(settings, database, store, tmp_path):
    """Breaks where a whole person is cut up as one garment, or a suit from neck to ankles is taken for a person."""
    body = builtin_body(WEARER)
    corners = body.vertices[body.faces]
    is_suit = (corners[..., 1].max(axis=1) < body.joint("neck")[1]) & (np.abs(corners[..., 0]).max(axis=1) < 0.6)
    is_suit &= corners[..., 1].min(axis=1) > body.joint("left_ankle")[1]
    for name, faces, kind in (("whole", body.faces, "person"), ("suit", body.faces[is_suit], "recover")):
        mesh = trimesh.Trimesh(body.vertices, faces, process=False)
        mesh.remove_unreferenced_vertices()
        mesh.export(tmp_path / f"{name}.ply")
        job = submit(database, store, Order(tmp_path / f"{name}.ply", BuiltinWearer(WEARER))).job
        run_job(replace(settings, **PERSONS, checker=CHECKER), database, job, lambda: False)
        assert find_job(database, job).kind == kind, name


def test_who_says_garment_is_not_asked_again():
    """Breaks where what the user said of the scan is looked into all the same."""
    file = FileRef("a" * 64, "scan.ply")
    said = RecoverRequest(file, WEARER, None, given_as="garment")
    assert not said.is_open and RecoverRequest(file, WEARER, None).is_open
    assert Recover().turn(said, None, None) is None
