"""Families of jobs in any state, without the work that made them."""

from __future__ import annotations

import io
import uuid

import numpy as np
from garmentq.service.jobs import create
from garmentq.service.keys import grant_job
from garmentq.service.models import ArtifactRow, ScanRow
from garmentq.service.new_job import NewJob
from garmentq.service.results import RESULT
from garmentq.service.services import Services
from garmentq.service.states import State
from PIL import Image

SKIN, SCAN = (250, 180, 60), (20, 90, 200)


def add_job(services: Services, name: str, kind: str = "person", *, parent="", reads="", tags=(), owner="", **values):
    """Add a job with some columns, below another one or reading its result; gives its id."""
    with services.database.write() as session:
        if session.get(ScanRow, "0" * 64) is None:
            session.add(ScanRow(sha256="0" * 64, name="scan.ply", size=1, created=0.0))
            session.flush()
        inputs = {"result": reads} if reads else {}
        new = NewJob(uuid.uuid4().hex, kind, {}, "0" * 64, name, tags=tuple(tags), inputs=inputs,
                     parent=(parent, parent) if parent else None)  # fmt: skip
        row = create(session, new)
        for column, value in values.items():
            setattr(row, column, value)
        session.flush()
        if owner:
            grant_job(session, owner, row.id)
        return row.id


def add_person(services: Services, name: str, **values) -> tuple[str, str, str]:
    """Add a person with a passed top and failed trousers."""
    done = {"finished": 1.0, "overall": 1.0, "progress": 1.0}
    person = add_job(services, name, state=State.SUCCEEDED, **done, **values)
    tags = values.get("tags", ())
    upper = add_job(services, "upper", "recover", parent=person, tags=tags, state=State.SUCCEEDED, garment="tshirt",
                    verdict="pass", **done)  # fmt: skip
    error = {"error_code": "body.missing", "error_message": "Say the wearer with --body."}
    lower = add_job(services, "lower", "recover", parent=person, tags=tags, state=State.FAILED, **(error | done))
    return person, upper, lower


def keep_sheet(services: Services, job: str) -> None:
    """Store a contact sheet of 4 by 3 pictures of 300 x 480: in the first a blue block, in all others one like skin."""
    sheet = np.full((3 * 480, 4 * 300, 3), 255, np.uint8)
    for row in range(3):
        for column in range(4):
            sheet[row * 480 + 40 : row * 480 + 440, column * 300 + 100 : column * 300 + 200] = (
                SKIN if row or column else SCAN
            )
    content = io.BytesIO()
    Image.fromarray(sheet).save(content, "PNG")
    kept = services.store.put_bytes(content.getvalue())
    with services.database.write() as session:
        session.add(
            ArtifactRow(job=job, kind=RESULT, name="picture.png", sha256=kept.sha256, size=kept.size, created=0.0)
        )
