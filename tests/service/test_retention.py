"""What is kept for a time goes when it is over, by the subject's, the tag's or the home's rule, and nothing earlier."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from garmentq.service.families import cancel, make_children
from garmentq.service.jobs import find_job, find_jobs_by_id
from garmentq.service.kinds.kind import ChildRequest
from garmentq.service.models import JobInputRow, JobRow
from garmentq.service.retention import Expired, delete_expired, enforce_retention, find_expired
from garmentq.service.settings import ServiceSettingBad, read_settings
from garmentq.service.subject_records import SubjectFields
from garmentq.service.subjects import create_subject, find_subject, list_subjects
from sqlalchemy import select, update

DAY = 86400.0
NOW = 2e9
"""The database's time in these tests [s since 1970]."""


@pytest.fixture
def old(database, queue_job, monkeypatch):
    """Return a function that makes an ended job of a name that ended some days ago; the database's clock is set."""
    monkeypatch.setattr("garmentq.service.retention.clock", lambda: NOW)

    def make(name: str, days: float, **terms) -> str:
        job = queue_job(name, **terms)
        cancel(database, job)
        age(database, [job], days)
        return job

    return make


def age(database, jobs, days: float) -> None:
    """Let jobs have ended some days ago."""
    at = NOW - days * DAY
    with database.write() as session:
        session.execute(update(JobRow).where(JobRow.id.in_(jobs)).values(created=at, finished=at))


def test_a_home_keeps_families_for_a_time(database, store, settings, old, queue_job):
    """Broken where a family goes before its last job's time, with an open job, or under what was made of it since."""
    gone, young, open_ = old("gone", 31.0), old("young", 29.0), queue_job("open")
    parent, read = old("parent", 40.0), old("read", 40.0)
    with database.write() as session:
        (child,) = make_children(session, parent, [ChildRequest("upper", "recover", {})]).values()
        session.add(JobInputRow(job=young, name="result", input=read))
    cancel(database, child)
    age(database, [child], 10.0)
    assert find_expired(database, settings) == Expired(), "without a setting nothing is over"
    kept = replace(settings, keep_days=30.0)
    assert find_expired(database, kept).families == (gone,)
    assert delete_expired(database, store, find_expired(database, kept)) == 1
    assert len(find_jobs_by_id(database, [young, open_, parent, child, read])) == 5
    age(database, [child, young], 50.0)
    assert set(find_expired(database, kept).families) == {young, read, parent}
    assert len(find_expired(database, kept, 2).families) == 2
    assert not enforce_retention(database, store, kept)
    with database.read() as session:
        assert session.scalars(select(JobRow.id)).all() == [open_]


def test_a_tag_has_a_time_of_its_own(database, settings, old):
    """Broken where the home's time overrules a tag's, or the shorter of two tags' counts."""
    trial, both = old("trial", 8.0, tags=("trial",)), old("both", 8.0, tags=("trial", "client"))
    forever, plain = old("forever", 999.0, tags=("show",)), old("plain", 31.0)
    chosen = replace(settings, keep_tag_days="trial=7, client=365,show=0")
    assert find_expired(database, chosen).families == (trial,)
    assert set(find_expired(database, replace(chosen, keep_days=30.0)).families) == {trial, plain}
    age(database, [both], 366.0)
    assert set(find_expired(database, chosen).families) == {trial, both}
    assert find_job(database, forever)


@pytest.mark.parametrize("text", ["trial", "trial=", "=7", "trial=-1", "trial=week", "trial=1e9", "a=1,b"])
def test_a_wrong_time_of_a_tag_is_refused_at_once(text):
    """Broken where a worker finds an hour after its start that a setting cannot be read, or keeps for ever."""
    with pytest.raises(ServiceSettingBad, match="TAG=DAYS"):
        read_settings({"GARMENTQ_KEEP_TAG_DAYS": text})


def test_a_subject_goes_when_its_time_is_over(database, store, settings, old, queue_job):
    """Broken where a person's data stay beyond the time that was promised, or go by the rule of a tag before it."""
    for name, fields in {
        "over": {"keep_days": 30.0}, "young": {"keep_days": 90.0}, "until": {"keep_until": NOW - 1.0},
        "later": {"keep_until": NOW + 1.0}, "open": {"keep_until": NOW - 1.0}, "none": {},
    }.items():  # fmt: skip
        create_subject(database, SubjectFields(name, **fields))
        queue_job("open", subject="open") if name == "open" else old(name, 40.0, subject=name, tags=("trial",))
    with database.write() as session:
        from garmentq.service.models import SubjectRow

        session.execute(update(SubjectRow).values(created=NOW - 50 * DAY))
    chosen = replace(settings, keep_days=20.0, keep_tag_days="trial=7")
    expired = find_expired(database, chosen)
    ids = {one.id: one.name for one in list_subjects(database)}
    assert {ids[one] for one in expired.subjects} == {"over", "until"}
    assert [find_job(database, job).name for job in expired.families] == ["none"]
    assert delete_expired(database, store, expired) == 3
    assert {one.name for one in list_subjects(database)} == {"young", "later", "open", "none"}
    assert find_subject(database, "young").jobs == 1 and find_subject(database, "none").jobs == 0


def test_gc_deletes_what_is_over(database, cli, old):
    """Broken where a home without a worker keeps everything, or what is counted is deleted without being asked."""
    job, kept = old("gone", 31.0), {"GARMENTQ_KEEP_DAYS": "30"}
    told = json.loads(cli("gc", "--json", **kept).stdout)
    assert (told["expired"], told["expired_removed"]) == (1, 0) and find_job(database, job)
    assert "1 families and 0 subjects" in cli("gc", **kept).stderr
    assert json.loads(cli("gc", "--delete", "--json", **kept).stdout)["expired_removed"] == 1
    assert find_jobs_by_id(database, [job]) == []
