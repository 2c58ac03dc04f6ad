"""The kind `outfit`: all garments of a person on one body, asked for as `dress` of the person's job."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.outcome import Outcome
from garmentq.core.cloth.statics import Drape
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.reuse.wear.worn import WornGarment, load_worn, save_worn
from garmentq.core.run.errors import GarmentqError
from garmentq.service.derived import DerivedOrder, submit_derived
from garmentq.service.jobs import find_job
from garmentq.service.query import JobQuery
from garmentq.service.results import export_files
from garmentq.service.services import Services
from garmentq.service.terms import JobTerms
from garmentq.workers.recovery import run_job
from garmentq_family_home import REMOTE_BY_DAY, pieces, work_off

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "api"))

from api_work import finish, make_key  # noqa: E402

SPEC = "builtin:male,height=1.80"


@pytest.fixture(scope="session")
def database_kind():
    """Ask of SQLite only: outfits are made by the same functions as all derived jobs."""
    return "sqlite"


@pytest.fixture
def person(queue_person, persons, settings, database, store, tmp_path) -> str:
    """Return a person that was taken apart, both garments recovered; each is a skirt."""
    root = queue_person()
    run_job(persons, database, root, lambda: False)
    garment, body = load_draped_template("skirt"), builtin_body("builtin:female,height=1.70")
    (tmp_path / "made").mkdir()
    save_worn(WornGarment(garment, get_fabric("cotton_poplin"), body, None, None, "skirt", "skirt"), tmp_path / "made")
    for row in pieces(database, root).values():
        finish(settings, database, store, row.id, tmp_path / "made")
    return root


@pytest.fixture
def quick(monkeypatch):
    """Let dressing take no time: each garment stays where it is."""

    def stay(garments, wearer, hooks):
        nodes = np.concatenate([one.garment.nodes for one in garments])
        return tuple(garments), Drape(nodes, 0.1, 3, 1.0, Outcome.CONVERGED, nodes)

    monkeypatch.setattr(
        "garmentq.core.reuse.wear.outfit.drape_in_order", lambda garments, wearer, hooks: tuple(garments)
    )
    monkeypatch.setattr("garmentq.core.reuse.wear.outfit.drape_together", stay)


@REMOTE_BY_DAY
def test_a_person_is_dressed_in_all_garments(backend, person, quick, settings, database, store, tmp_path):
    """Broken where a garment is lost, body or order get lost on the way, or numbers cannot be searched."""
    below = {word: row.id for word, row in pieces(database, person).items()}
    order = DerivedOrder("dress", person, {"body": SPEC, "pose": "A"})
    done = backend.submit_derived(order)
    assert done.is_new and not backend.submit_derived(order).is_new
    work_off(settings, database)
    report = backend.find_job(done.job)
    assert (report.state, report.error, report.kind) == ("succeeded", None, "outfit")
    assert report.inputs == {"person": person} | below
    assert report.details["garments"] == ["lower", "upper"] and report.details["body"] == "builtin:male"
    names = [gate.name for gate in report.gates]
    assert names[0] == "at_rest" and {"lower.depth", "upper.crossings", "upper.layers"} <= set(names)
    assert "lower.layers" not in names
    found = backend.find_jobs(JobQuery(wheres=["kind = outfit", "garments = 2", "upper.vertices > 100"]))
    assert [job.id for job in found] == [done.job]
    export_files(database, store, done.job, tmp_path / "out")
    for word in ("lower", "upper"):
        assert {"dressed.ply", "dressed.glb", "pattern.json", "worn.npz"} <= {
            path.name for path in (tmp_path / "out" / word).iterdir()
        }
        kept = load_worn(tmp_path / "out" / word)
        np.testing.assert_allclose(kept.body.vertices, builtin_body(f"{SPEC},pose=A").vertices)
    assert (tmp_path / "out" / "picture.png").is_file() and "upper" in (tmp_path / "out" / "report.html").read_text()
    other = backend.submit_derived(replace(order, options={**order.options, "order": "upper,lower"}))
    assert other.is_new and find_job(database, other.job).request["order"] == "upper,lower"


WRONG = [
    ("job.request_bad", {"options": {"fabric": "denim"}}),
    ("job.request_bad", {"options": {"order": "upper"}}),
    ("job.request_bad", {"options": {"order": "upper,upper"}}),
    ("job.request_bad", {"options": {"order": "hat,lower"}}),
    ("job.request_bad", {"over": "PERSON"}),
    ("job.input_kind", {"kind": "refit"}),
]


def test_what_cannot_be_is_refused_at_once(backend, person):
    """Broken where a slip in the order of a whole person is a queued job."""
    for code, change in WRONG:
        given = {name: person if value == "PERSON" else value for name, value in change.items()}
        with pytest.raises(GarmentqError) as caught:
            backend.submit_derived(DerivedOrder(**{"kind": "dress", "result": person, **given}))
        assert caught.value.code == code, change


def test_only_ones_own_recovered_persons_are_worn(queue_person, person, settings, database, store):
    """Broken where a person is worn whose garments are still to be recovered, or whoever knows an id wears it."""
    services = Services(settings, database, store)
    make_key(database, "stranger")
    with pytest.raises(GarmentqError) as caught:
        submit_derived(services, DerivedOrder("dress", person, terms=JobTerms(key="stranger")))
    assert caught.value.code == "job.unknown"
    waiting = queue_person("bert.ply")
    with pytest.raises(GarmentqError) as caught:
        submit_derived(services, DerivedOrder("dress", waiting))
    assert caught.value.code == "job.input_not_ended"
