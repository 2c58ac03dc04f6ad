"""A subject's jobs are found together, are nobody else's, and go with it."""

from __future__ import annotations

from dataclasses import replace

import pytest
from garmentq.service.deletion import YOUNG_SECONDS
from garmentq.service.families import JobNotEnded, cancel, make_children
from garmentq.service.jobs import claim, find_job, find_jobs_by_id
from garmentq.service.keys import create_key
from garmentq.service.kinds.kind import ChildRequest
from garmentq.service.kinds.recover import Recover
from garmentq.service.models import BatchRow, BodyRow, JobRow, JobTagRow, MetricRow, ScanRow, SubjectRow, UploadRow
from garmentq.service.persons import delete_person, delete_subject, find_person
from garmentq.service.query import QueryBad, find_jobs, parse_conditions
from garmentq.service.results import report_jobs, store_result
from garmentq.service.states import State
from garmentq.service.subject_records import SubjectFields
from garmentq.service.subjects import (
    SubjectBad,
    SubjectJobShared,
    SubjectTaken,
    SubjectUnknown,
    assign_jobs,
    create_subject,
    find_subject,
    list_subjects,
    update_subject,
)
from garmentq.service.submission import JobRequest, add_job
from garmentq.service.uploads import keep_upload
from garmentq_standin import make_recovery
from sqlalchemy import select

ANNA = "Anna M\u00fcller"


@pytest.fixture
def done(database, store, queue_job, tmp_path):
    """Return a function that makes a job with a result."""

    def make(name: str, **terms) -> str:
        job = queue_job(name, **terms)
        request = type(
            "R", (), {"scan": tmp_path / f"{name}.ply", "settings": type("S", (), {"fabric": "x", "seed": 0})}
        )
        files = tmp_path / f"files-{job}"
        files.mkdir(exist_ok=True)
        (files / "pattern.svg").write_text(f"<svg>{name}{job}</svg>")
        store_result(database, store, claim(database, job, "a", 30.0), Recover(), make_recovery(request, 1.0), files)
        return job

    return make


@pytest.fixture
def keys(database):
    """Return the ids of two keys."""
    return [create_key(database, name, ("read", "submit"))[0].id for name in ("a", "b")]


def subject_of(database, settings, job: str) -> str | None:
    """Return the name of a job's subject, as its report says it."""
    return report_jobs(database, [find_job(database, job)], settings)[0].subject


def test_a_name_is_one_subject_of_a_key(database, keys):
    """Broken where a key has two subjects of a name, sees another's, or loses a field by changing one."""
    fields = SubjectFields(ANNA, "note", 1.0, "form 7", 2.0, 90.0, 5e9)
    first = create_subject(database, fields, keys[0])
    assert first.said == fields and first.jobs == 0 and first.key == keys[0]
    assert first.expires == pytest.approx(first.created + 90 * 86400.0)
    with pytest.raises(SubjectTaken):
        create_subject(database, SubjectFields(ANNA), keys[0])
    second = create_subject(database, SubjectFields(ANNA), keys[1])
    assert second.expires is None
    assert [one.id for one in list_subjects(database, key=keys[0])] == [first.id]
    assert {one.id for one in list_subjects(database, ANNA)} == {first.id, second.id}
    for ask in (find_subject, lambda *given: update_subject(given[0], given[1], fields, given[2])):
        with pytest.raises(SubjectUnknown):
            ask(database, first.id, keys[1])
    assert find_subject(database, ANNA, keys[1]).id == second.id
    with pytest.raises(SubjectUnknown, match="several"):
        find_subject(database, ANNA)
    changed = update_subject(database, first.id, replace(fields, name="Anne", keep_days=None), keys[0])
    assert changed.said == replace(fields, name="Anne", keep_days=None) and changed.expires == 5e9
    create_subject(database, SubjectFields("Bo"), keys[0])
    with pytest.raises(SubjectTaken):
        update_subject(database, first.id, SubjectFields("Bo"), keys[0])


@pytest.mark.parametrize(
    "fields",
    [
        SubjectFields(""), SubjectFields(" a"), SubjectFields("x" * 256), SubjectFields("a\n"), SubjectFields("0" * 12),
        SubjectFields("a", keep_days=0.0), SubjectFields("a", keep_days=4e4),
        SubjectFields("a", consented=float("nan")),
        SubjectFields("a", keep_until=-1.0), SubjectFields("a", note="x" * 10_001),
    ],
)  # fmt: skip
def test_what_cannot_be_a_subject(database, fields):
    """Broken where a record can be stored that no list shows, or that is taken for an id."""
    with pytest.raises(SubjectBad):
        create_subject(database, fields)


def test_subjects_are_paged(database):
    """Broken where a page repeats or leaves out subjects of the same time."""
    made = [create_subject(database, SubjectFields(f"s{n}")).id for n in range(7)]
    with database.write() as session:
        for row in session.scalars(select(SubjectRow)):
            row.created = 5.0 if row.name in ("s2", "s3", "s4") else row.created
    found: list[str] = []
    while page := list_subjects(database, limit=2, before=found[-1] if found else ""):
        found += [one.id for one in page]
    assert sorted(found) == sorted(made) and len(found) == 7


def test_a_family_has_its_subject(database, store, settings, done, queue_job):
    """Broken where what was made of a subject's job is not the subject's, or is listed without scan or body."""
    job = done("anna", subject=ANNA)
    (subject,) = list_subjects(database)
    assert (subject.name, subject.jobs) == (ANNA, 1)
    row = find_job(database, job)
    with database.write() as session:
        (child,) = make_children(session, job, [ChildRequest("upper", "recover", row.request)]).values()
        derived = add_job(session, JobRequest("export", {"format": "pdf"}, row.scan, {"result": job})).job
        refined = add_job(session, JobRequest("recover", {"settings": {}}, row.scan, before=job)).job
        session.merge(BodyRow(job=job, source="builtin:female", fit_rms=0.01, joints={}, parameters={}))
        session.add(MetricRow(job=job, name="wearer.bust_girth_mm", value=921.5))
    other = queue_job("other")
    assert {one: subject_of(database, settings, one) for one in (job, child, derived, refined, other)} == {
        job: ANNA, child: ANNA, derived: ANNA, refined: ANNA, other: None
    }  # fmt: skip
    found = find_subject(database, ANNA)
    assert {one.job for one in found.families} == {job, derived, refined} and found.jobs == 4
    assert [(one.name, one.state) for one in found.families[-1].children] == [("upper", State.QUEUED)]
    assert [one.sha256 for one in found.scans] == [row.scan]
    assert [(one.job, one.measures) for one in found.wearers] == [(job, {"bust_girth": 921.5})]
    for where, jobs in ((f"subject = '{ANNA}'", {job, child, derived, refined}), (f"subject != {subject.id}", {other})):
        assert {one.id for one in find_jobs(database, parse_conditions(where))} == jobs
    with pytest.raises(QueryBad):
        parse_conditions("subject < a")


def test_a_job_of_a_subject_is_nobody_elses(database, settings, queue_job, keys):
    """Broken where keys that share jobs learn whom another key scanned, or two subjects have one job."""
    mine, other = keys
    shared = queue_job("s", key=mine, quota=9)
    assert queue_job("s", key=other, quota=9) == shared
    own = queue_job("s", key=mine, quota=9, subject="A")
    assert own != shared and subject_of(database, settings, shared) is None
    assert queue_job("s", key=mine, quota=9, subject="A") == own
    again = queue_job("s", key=other, quota=9, subject="A")
    assert again not in (own, shared) and queue_job("s", key=other, quota=9) == shared
    with pytest.raises(SubjectJobShared):
        assign_jobs(database, "A", [shared], mine)
    alone = queue_job("t", key=mine, quota=9)
    assert queue_job("t", key=mine, quota=9, subject="A", tags=("x",)) == alone, "named later"
    assert subject_of(database, settings, alone) == "A"
    assert queue_job("t", key=mine, quota=9, subject="B") != alone
    joined = queue_job("t", key=other, quota=9)
    assert joined != alone and subject_of(database, settings, joined) is None
    assert {one.name: one.jobs for one in list_subjects(database, key=mine)} == {"A": 2, "B": 1}
    with pytest.raises(SubjectUnknown):
        queue_job("u", key=other, quota=9, subject=find_subject(database, "A", mine).id)


def test_a_subject_goes_with_all_its_data(database, store, done, queue_job, tmp_path, monkeypatch):
    """Broken where a scan, body, label file, upload or job of a person stays, or one of another person goes."""
    monkeypatch.setattr("garmentq.service.deletion.YOUNG_SECONDS", -YOUNG_SECONDS)
    first, second = done("a", subject=ANNA, tags=("march",)), done("b", subject=ANNA, tags=("march", "april"))
    kept, open_ = done("c", subject="Bo", tags=("april",)), queue_job("d", subject=ANNA)
    scan = find_job(database, first).scan
    keep_upload(database, store, "", tmp_path / "a.ply", ("whoever.ply", "scans"))
    unnamed = queue_job("a", force=True)
    cancel(database, unnamed)
    with pytest.raises(JobNotEnded, match=open_):
        delete_subject(database, store, ANNA)
    cancel(database, open_)
    found = delete_subject(database, store, ANNA, is_dry_run=True).found
    assert {one.job for one in found.jobs} == {first, second, open_, unnamed} and len(found.files) == 3
    gone = delete_subject(database, store, ANNA)
    assert set(gone.jobs) == {first, second, open_, unnamed} and gone.uploads == 1
    assert not find_jobs_by_id(database, [first, second, open_, unnamed]) and find_job(database, kept)
    assert [one.name for one in list_subjects(database)] == ["Bo"]
    with database.read() as session:
        assert session.query(UploadRow).count() == 0
        assert session.scalars(select(ScanRow.sha256)).all() == [find_job(database, kept).scan]
        assert session.scalars(select(BatchRow.tag)).all() == ["april"]
    assert scan not in {one.sha256 for one in store.list_files()}
    with pytest.raises(SubjectUnknown):
        delete_subject(database, store, ANNA)


def test_the_erasure_by_name_finds_the_subject(database, store, done, keys):
    """Broken where a person's name finds the file of that name alone, or what another key has."""
    job = done("scan_7", subject=ANNA)
    theirs = done("scan_8", subject=ANNA, key=keys[0], quota=9)
    found = find_person(database, ANNA)
    assert {one.job for one in found.jobs} == {job, theirs} and len(found.subjects) == 2
    assert {one.job for one in find_person(database, ANNA, keys[0]).jobs} == {theirs}
    create_subject(database, SubjectFields("Empty"))
    assert delete_person(database, store, "Empty").jobs == ()
    delete_person(database, store, ANNA, keys[0])
    assert [one.key for one in list_subjects(database, ANNA)] == [""] and find_job(database, job)


def test_an_equal_job_gets_new_tags(database, queue_job):
    """Broken where a scan of a batch that was computed before is not in the batch."""
    job = queue_job("a", tags=("march",))
    assert queue_job("a", tags=("april", "march")) == job
    with database.read() as session:
        assert set(session.scalars(select(JobTagRow.tag).where(JobTagRow.job == job))) == {"march", "april"}
        assert session.query(JobRow).count() == 1
