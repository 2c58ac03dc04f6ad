"""A quality stands for method and vertices, and a preview is refined from what the home has."""

from __future__ import annotations

from dataclasses import replace

import pytest
from garmentq.core.recover.settings import QUALITIES, RecoverySettings, SettingsBad, complete_by_quality
from garmentq.core.run.errors import BadInput
from garmentq.service.jobs import claim, fail, find_job
from garmentq.service.order import Order
from garmentq.service.records import JobReport
from garmentq.service.refining import submit_refinement
from garmentq.service.results import report_jobs
from garmentq.service.services import Services
from garmentq.service.submission import submit
from garmentq.service.terms import JobTerms
from garmentq.workers.recovery import run_job
from garmentq_family_home import pieces, work_off
from garmentq_home import put_file

PREVIEW = RecoverySettings(**QUALITIES["preview"])


@pytest.fixture(scope="session")
def database_kind():
    """Ask of SQLite only: no statement is new."""
    return "sqlite"


def order(folder, settings: RecoverySettings, **terms) -> Order:
    """Return an order of the same two files at each call."""
    files = put_file(folder, "skirt.ply"), put_file(folder, "body.ply")
    return Order(*files, settings=settings, terms=JobTerms(**terms))


def refused(backend, job: str) -> str:
    """Return the code by which a refinement is refused, in the home or by HTTP."""
    with pytest.raises(BadInput) as error:
        backend.refine(job)
    return error.value.code


def test_quality_stands_for_what_is_not_given() -> None:
    """Breaks where the default is no standard recovery, an option loses to the quality, or any word is taken."""
    standard = RecoverySettings()
    assert RecoverySettings(**complete_by_quality(None, {})) == standard
    assert RecoverySettings(**complete_by_quality("standard", {})) == standard
    assert (PREVIEW.method, PREVIEW.vertex_count) == ("deform", 2000)
    assert complete_by_quality("preview", {"method": "inverse", "seed": 7}) == {
        "method": "inverse", "vertex_count": 2000, "seed": 7
    }  # fmt: skip
    with pytest.raises(SettingsBad, match="'perfect' is not one of preview, standard, fine"):
        complete_by_quality("perfect", {})


def test_commands_name_a_quality_and_what_overrides_it(cli, database, tmp_path) -> None:
    """Breaks where a quality and what it stands for are two jobs, a table lacks it, or an override is not told."""
    scan, body, table = put_file(tmp_path, "one.ply"), put_file(tmp_path, "body.ply"), tmp_path / "batch.csv"

    def submitted(*words: object) -> tuple[list[str], str]:
        done = cli("submit", *words, "--body", body)
        assert done.returncode == 0, done.stderr
        return [line.split()[0] for line in done.stdout.splitlines()], done.stdout

    assert submitted(scan)[0] == submitted(scan, "--quality", "standard")[0]
    preview, told = submitted(scan, "--quality", "preview")
    assert "overrides --quality" not in told
    assert preview == submitted(scan, "--method", "deform", "--vertices", 2000)[0]
    assert preview == submitted(scan, "--quality", "preview", "--vertices", 2000)[0]
    (other,), told = submitted(scan, "--quality", "preview", "--vertices", 900)
    assert "; --vertices 900 overrides --quality preview" in told and "--method" not in told
    settings = find_job(database, other).request["settings"]
    assert (settings["method"], settings["vertex_count"]) == ("deform", 900) and "quality" not in settings
    table.write_text("scan,quality\none.ply,preview\none.ply,\n")
    assert submitted(table)[0] == [*preview, *submitted(scan)[0]]
    assert cli("submit", scan, "--body", body, "--quality", "perfect").returncode == 2


def test_preview_is_refined_to_the_standard_order(backend, settings, database, store, tmp_path) -> None:
    """Breaks where a refinement is another job than the order at standard quality, or loses a setting, name or tag."""
    chosen = replace(PREVIEW, seed=7, fabric="denim")
    preview = submit(database, store, order(tmp_path, chosen, name="Anna", tags=("spring",))).job
    assert refused(backend, preview) == "job.input_not_ended"
    assert run_job(settings, database, preview, lambda: False) == "succeeded"
    (tmp_path / "skirt.ply").unlink()  # nothing is uploaded again
    done = backend.refine(preview)
    refined: JobReport = backend.find_job(done.job)
    assert done.is_new and (refined.name, refined.tags) == ("Anna", ["spring"])
    assert refined.settings == backend.find_job(preview).settings | dict(QUALITIES["standard"])
    assert backend.refine(preview) == replace(done, is_new=False)
    assert not submit(database, store, order(tmp_path, replace(chosen, **QUALITIES["standard"]))).is_new
    assert refused(backend, done.job) == "job.not_preview"
    assert run_job(settings, database, done.job, lambda: False) == "succeeded"


def test_failed_preview_is_not_refined(backend, database, store, tmp_path) -> None:
    """Breaks where files that no recovery could read are queued a second time."""
    job = submit(database, store, order(tmp_path, PREVIEW)).job
    fail(database, claim(database, job, "test", 60.0), "scan.unreadable", "It cannot be read.", bad_input=True)
    assert refused(backend, job) == "job.input_not_ended"


def test_garment_of_a_person_keeps_its_labels(queue_person, persons, settings, database, store) -> None:
    """Breaks where a person is separated again for one garment, or its refinement reads another's part."""
    root = queue_person(settings=PREVIEW)
    work_off(persons, database)
    services, upper = Services(settings, database, store), pieces(database, root)["upper"]
    done = submit_refinement(services, find_job(database, upper.id))
    (report,) = report_jobs(database, [find_job(database, done.job)], settings)
    assert report.inputs == {"person": root} and report.settings["method"] == "hybrid"
    assert report.parent is None and find_job(database, done.job).request["part"] == "upper"
    assert run_job(persons, database, done.job, lambda: False) == "succeeded"
    again = submit_refinement(services, find_job(database, root))
    assert find_job(database, again.job).kind == "person"


@pytest.mark.parametrize(
    "values", [{"height": 0.2}, {"height": float("nan")}, {"height": 1.7, "units": "cm"}, {"height": 3.0}]
)
def test_a_height_is_a_persons_and_stands_for_the_unit(values):
    """Broken where a height of no person, or one beside a unit that says otherwise, is taken."""
    with pytest.raises(SettingsBad):
        RecoverySettings(**values)
    assert RecoverySettings(height=1.7).as_dict()["height"] == 1.7
