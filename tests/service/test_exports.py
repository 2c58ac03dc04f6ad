"""Jobs that write a stored result for production."""

from __future__ import annotations

import sys
from pathlib import Path

import httpx
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.reuse.wear.worn import WornGarment, save_worn
from garmentq.core.run.errors import GarmentqError
from garmentq.service.derived import DerivedOrder
from garmentq.service.local import LocalBackend
from garmentq.service.models import PieceRow
from garmentq.service.query import JobQuery
from garmentq_family_home import work_off
from sqlalchemy import select

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "api"))

from api_client import local_user, serving  # noqa: E402
from api_work import finish  # noqa: E402


@pytest.fixture(scope="session")
def database_kind():
    """Ask of SQLite only: exports are made by the same functions as all jobs."""
    return "sqlite"


@pytest.fixture
def result(queue_job, settings, database, store, tmp_path) -> str:
    """Return a recovery that has succeeded and kept a T-shirt."""
    job = queue_job("tshirt")
    garment, body = load_draped_template("tshirt"), builtin_body("builtin:female,height=1.70")
    (tmp_path / "made").mkdir()
    save_worn(
        WornGarment(garment, get_fabric("single_jersey"), body, None, None, "tshirt", "tshirt"), tmp_path / "made"
    )
    finish(settings, database, store, job, tmp_path / "made")
    return job


def test_an_export_is_made_once_kept_and_served(result, settings, database, tmp_path):
    """Broken where options get lost on the way, pieces cannot be searched, or a file is served that nobody made."""
    backend = LocalBackend(settings)
    order = DerivedOrder("export", result, {"format": "pdf", "allowance": "hem=30", "paper": "letter"})
    done = backend.submit_derived(order)
    assert done.is_new and not backend.submit_derived(order).is_new
    key = local_user(settings)
    with serving(settings) as url, httpx.Client(base_url=f"{url}/v1/jobs/{result}/exports", headers=key) as client:
        missing = client.get("/pieces.pdf")
        assert (missing.status_code, missing.json()["code"]) == (404, "result.missing")
        work_off(settings, database)
        report = backend.find_job(done.job)
        assert (report.state, report.error, report.kind) == ("succeeded", None, "export")
        (path,) = backend.export_files(done.job, tmp_path / "out")
        served = client.get("/pieces.pdf")
        assert served.status_code == 200 and served.content == path.read_bytes() and served.content.startswith(b"%PDF")
        assert client.get("/worn.npz").status_code == client.get("/..%2Fpieces.pdf").status_code == 404
    with database.read() as session:
        rows = {row.name: row for row in session.scalars(select(PieceRow).where(PieceRow.job == done.job))}
    assert set(rows) == {"FRONT", "BACK", "SLEEVE"}
    assert rows["SLEEVE"].is_pair and rows["SLEEVE"].cloth == 2 * rows["SLEEVE"].area
    found = backend.find_jobs(JobQuery(wheres=["pieces.cloth_length_m < 1.2", "kind = export"]))
    assert [job.id for job in found] == [done.job]
    backend.close()


WRONG = (
    ({}, "job.request_bad"), ({"format": "doc"}, "export.unknown"), ({"format": ["pdf"]}, "job.request_bad"),
    ({"format": "pdf", "allowance": "hem=x"}, "pieces.allowance"),
    ({"format": "pdf", "size": 1}, "job.request_bad"),
    ({"format": "dxf", "dialect": "../x"}, "export.unknown"),
    ({"format": "pdf", "paper": "roll:9"}, "export.paper"),
    ({"format": "texture", "texel": 0.3}, "texture.texel"),
    ({"format": "sizes", "drape": 1}, "job.request_bad"),
    ({"format": "sizes", "chart": "moon"}, "export.sizes"),
    ({"format": "sizes", "sizes": [{"name": "S", "bust": 34, "waist": 27}]}, "export.sizes_unclear"),
)  # fmt: skip
"""Options, and the code that they are refused with."""


def test_wrong_requests_are_refused_at_once(result, settings):
    """Broken where a job is queued that can only fail."""
    backend = LocalBackend(settings)
    for options, code in WRONG:
        with pytest.raises(GarmentqError) as caught:
            backend.submit_derived(DerivedOrder("export", result, options))
        assert (options, caught.value.code) == (options, code)
    backend.close()
