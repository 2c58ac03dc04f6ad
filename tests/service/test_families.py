"""What passes down a family of jobs, and what never reaches the jobs that only read its results."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from garmentq.core.body.spec import BuiltinWearer
from garmentq.service.families import (
    AWAITED_FAILED_CODE,
    ChildrenBad,
    JobInUse,
    JobNotEnded,
    JobSucceeded,
    cancel,
    delete,
    make_children,
    release_waiting_jobs,
    retry,
)
from garmentq.service.jobs import (
    JobUnknown,
    claim,
    end_cancelled,
    fail,
    find_job,
    read_events,
    succeed,
)
from garmentq.service.keys import QueueFull, create_key
from garmentq.service.kinds import ChildRequest, RequestBad, find_kind, read_request
from garmentq.service.kinds.recover import RecoverRequest
from garmentq.service.models import JobRow, OwnerRow
from garmentq.service.query import JobQuery, find_jobs, parse_conditions
from garmentq.service.reaper import is_idle, reap
from garmentq.service.requeueing import release
from garmentq.service.results import export_files, report_jobs
from garmentq.service.states import ENDED, OPEN, TRANSITIONS, UNSUCCESSFUL, State
from garmentq.service.submission import InputNotEnded, LabelBad, Order, submit
from garmentq.service.terms import JobTerms
from garmentq.workers.recovery import run_job
from garmentq_family import KINDS, PIECES, Root
from garmentq_family_home import pieces, work_off
from garmentq_home import put_file
from sqlalchemy import select, update


def attempts(database, job) -> int:
    """Count how often a job was begun."""
    return [event.kind for event in read_events(database, job)].count("started")


def test_a_family_runs_to_its_end(database, store, family, tmp_path):
    """Broken where a child is missing or twice, starts before what it waits for, or cannot read what it is to read."""
    settings, queue = family
    root = queue(tags=("spring",), priority=3)
    run_job(settings, database, root, lambda: False)
    made = pieces(database, root)
    assert set(made) == set(PIECES) and {row.family for row in made.values()} == {root}
    assert {row.priority for row in made.values()} == {3}
    assert (made["front"].state, made["whole"].state) == (State.QUEUED, State.WAITING)
    assert not is_idle(database, 0.0)
    work_off(settings, database)
    assert {row.state for row in pieces(database, root).values()} == {State.SUCCEEDED}
    [path] = export_files(database, store, made["whole"].id, tmp_path / "out")
    assert path.read_text() == "whole back=(back root=(one)) front=(front root=(one)) root=(one)"
    [told] = report_jobs(database, [find_job(database, made["whole"].id)], settings)
    assert (told.parent, told.family, told.tags, told.details) == (root, root, ["spring"], {"text": "whole"})
    assert told.inputs == {"root": root, "front": made["front"].id, "back": made["back"].id}
    assert sorted(told.waits) == sorted([made["front"].id, made["back"].id])
    [above] = report_jobs(database, [find_job(database, root)], settings)
    assert {child.name: child.state for child in above.children} == dict.fromkeys(PIECES, State.SUCCEEDED)
    assert len(find_jobs(database, parse_conditions("tag = spring"))) == 4
    assert root not in [row.id for row in find_jobs(database, parse_conditions("tag != spring"))]
    with pytest.raises(JobSucceeded):
        retry(database, root)


def test_retrying_the_root_runs_only_what_did_not_succeed(database, family, tmp_path):
    """Broken where a succeeded part is computed again, a waiting one is lost, or a job that only reads is touched."""
    settings, queue = family
    refusal = tmp_path / "fail-back"
    refusal.touch()
    root = queue()
    work_off(settings, database)
    made = pieces(database, root)
    states = {name: row.state for name, row in made.items()}
    assert states == {"front": State.SUCCEEDED, "back": State.FAILED, "whole": State.FAILED}
    assert made["whole"].error_code == AWAITED_FAILED_CODE and made["back"].id in made["whole"].error_message
    reader = queue("reader", inputs={"root": root, "front": made["front"].id})
    work_off(settings, database)
    refusal.unlink()
    before = find_job(database, reader)
    retry(database, made["whole"].id)
    assert {name: row.state for name, row in pieces(database, root).items()} == {
        "front": State.SUCCEEDED,
        "back": State.QUEUED,
        "whole": State.WAITING,
    }, "what it waits for comes along"
    with pytest.raises(JobNotEnded):
        retry(database, root)
    work_off(settings, database)
    assert {row.state for row in pieces(database, root).values()} == {State.SUCCEEDED}
    counted = [attempts(database, job) for job in (root, *(made[name].id for name in PIECES))]
    assert counted == [1, 1, 2, 1], "the last one had not begun before"
    cancel(database, root)
    after = find_job(database, reader)
    assert (after.state, after.fence, after.touched) == (State.SUCCEEDED, before.fence, before.touched)


@pytest.mark.parametrize("moment", ["queued", "running", "last", "children"])
def test_cancelling_the_root_cancels_the_family(database, family, moment):
    """Broken where a child outlives the cancelled root, or is made by one that was cancelled in its last moment."""
    settings, queue = family
    root = queue()
    if moment == "children":
        run_job(settings, database, root, lambda: False)
        held = claim(database, pieces(database, root)["front"].id, "a", 30.0)
        assert cancel(database, root) == State.SUCCEEDED
        assert find_job(database, held.job).state == State.RUNNING
        end_cancelled(database, held)
    elif moment == "queued":
        assert cancel(database, root) == State.CANCELLED
    else:
        held = claim(database, root, "a", 30.0)
        assert cancel(database, root) == State.RUNNING
        if moment == "running":
            end_cancelled(database, held)
        else:
            with database.write() as session:
                succeed(session, held, {})
                make_children(session, root, [ChildRequest("front", "standin.piece", {"text": "front"})])
    release_waiting_jobs(database)
    left = pieces(database, root).values()
    assert len(left) == {"children": 3, "last": 1}.get(moment, 0)
    assert {row.state for row in left} <= {State.CANCELLED}
    assert not [row for row in find_jobs(database) if row.state in OPEN]
    retry(database, root)
    work_off(settings, database)
    assert {row.state for row in find_jobs(database, JobQuery({"family": root}).conditions)} == {State.SUCCEEDED}


def test_deleting_a_family(database, family):
    """Broken where a part of it stays behind, or a result goes that another job reads."""
    settings, queue = family
    root = queue()
    with pytest.raises(JobNotEnded):
        delete(database, [root])
    work_off(settings, database)
    front = pieces(database, root)["front"].id
    reader = queue("reader", inputs={"front": front})
    for job in (root, front):
        with pytest.raises(JobInUse):
            delete(database, [job])
    work_off(settings, database)
    assert len(delete(database, [reader])) == 4 and len(delete(database, [root])) == 4
    assert not find_jobs(database, JobQuery({"kind": Root.name}).conditions)
    with pytest.raises(JobUnknown):
        find_job(database, front)


def test_children_belong_to_their_parents_keys(database, store, family, tmp_path):
    """Broken where a key cannot see what its job made, or the family is free of charge."""
    settings, queue = family
    ours, theirs = (create_key(database, name, ("submit",), quota=2)[0].id for name in ("ours", "theirs"))
    root = queue(key=ours, quota=2)
    run_job(settings, database, root, lambda: False)
    with database.read() as session:
        owned = set(session.scalars(select(OwnerRow.job).where(OwnerRow.key == ours)))
    assert owned == {root, *(row.id for row in pieces(database, root).values())}
    with pytest.raises(QueueFull):
        queue("two", key=ours, quota=2)
    assert queue(key=theirs, quota=2) == root, "an equal order is the same job"
    assert [row.id for row in find_jobs(database, owner=theirs)] == [row.id for row in find_jobs(database, owner=ours)]
    with pytest.raises(JobUnknown):
        other = Order(put_file(tmp_path, "x.ply"), BuiltinWearer("builtin:male"))
        queue("reader", inputs={"it": submit(database, store, other).job},
              key=ours, quota=9)  # fmt: skip
    with pytest.raises(InputNotEnded):
        queue("reader", inputs={"it": pieces(database, root)["front"].id})


def test_a_family_has_a_name(database, store, tmp_path):
    """Broken where a scan's own name loses its letters, or a name makes another job of the same scan."""
    scan = put_file(tmp_path, "Kleid für Zoë 연습 <b>.ply")
    first = submit(database, store, Order(scan, BuiltinWearer("builtin:female")))
    row = find_job(database, first.job)
    assert row.name == "Kleid für Zoë 연습 b" and row.request["scan"]["name"] == "Kleid_f_r_Zo_b_.ply"
    named = Order(scan, BuiltinWearer("builtin:female"), terms=JobTerms("Anna's", ("spring", "été")))
    assert submit(database, store, named).job == first.job
    other = submit(database, store, replace(named, body=BuiltinWearer("builtin:male")))
    assert find_job(database, other.job).name == "Anna's"
    assert [row.id for row in find_jobs(database, parse_conditions("tag = 'été' and name = \"Anna's\""))] == [other.job]
    for bad in ({"name": "x" * 256}, {"name": "a\nb"}, {"tags": ("",)}, {"tags": ("x" * 65,)}, {"tags": ("\x1b",)}):
        with pytest.raises(LabelBad):
            submit(database, store, replace(named, terms=JobTerms(**bad)))


@pytest.mark.parametrize("names", [("a", "a"), ("b<a", "a")])
def test_children_that_cannot_be_are_refused(database, family, names):
    """Broken where two children of a name are one job, or a child could wait for what comes after it."""
    _, queue = family
    held = claim(database, queue(), "a", 30.0)
    parts = [name.partition("<") for name in names]
    children = [ChildRequest(name, "standin.piece", {}, tuple(filter(None, (on,)))) for name, _, on in parts]
    with pytest.raises(ChildrenBad), database.write() as session:
        succeed(session, held, {})
        make_children(session, held.job, children)
    assert find_job(database, held.job).state == State.RUNNING, "nothing of it is kept"


@pytest.mark.parametrize(
    "change",
    [{"scan": None}, {"gone": 1}, {"body": 3}, {"scan": {"sha256": "0" * 64, "name": "../x"}},
     {"settings": {"seed": "1"}}],
)  # fmt: skip
def test_a_request_that_does_not_fit_is_refused(database, queue_job, change):
    """Broken where an odd request reaches a stage and ends as a crash."""
    request = find_job(database, queue_job()).request
    assert read_request(RecoverRequest, request).scan.name == "shirt.ply"
    with pytest.raises(RequestBad):
        read_request(RecoverRequest, request | change)


def test_an_unknown_kind_is_one_clear_error(settings, database, family):
    """Broken where a worker without GARMENTQ_KINDS ends a job in a traceback, or such a job cannot be shown."""
    _, queue = family
    root = queue()
    assert run_job(settings, database, root, lambda: False) == "failed"
    row = find_job(database, root)
    assert row.error_code == "job.kind_unknown"
    assert report_jobs(database, [row], settings)[0].details == {}
    assert find_kind(replace(settings, kinds=KINDS), Root.name).stages[0] == "check"


@pytest.mark.parametrize("seed", [0, 1, 2, *(pytest.param(seed, marks=pytest.mark.nightly) for seed in range(3, 12))])
def test_random_sequences_keep_to_the_table(database, family, seed):
    """Broken where any sequence of calls moves a job past the table, makes a child twice, or leaves one for ever."""
    settings, queue = family
    generator = random.Random(seed)
    root = queue()
    held: dict[str, object] = {}

    def expire() -> None:
        with database.write() as session:
            session.execute(update(JobRow).where(JobRow.state == State.RUNNING).values(lease_until=0.0))
        reap(database, 2)
        held.clear()

    def finish(job: str, how: str) -> None:
        claimed = held.pop(job)
        if how == "succeed":
            with database.write() as session:
                succeed(session, claimed, {})
                outcome = find_kind(settings, claimed.kind).store(session, claimed, claimed.name)
                make_children(session, job, outcome.children)
        elif how == "fail":
            fail(database, claimed, "x", "x", bad_input=False)
        else:
            {"cancel": end_cancelled, "release": release}[how](database, claimed)

    def step() -> None:
        rows = find_jobs(database, JobQuery({"family": root}).conditions)
        row, what = generator.choice(rows), generator.randrange(8)
        if what < 3 and (taken := claim(database, row.id, "a", 600.0)):
            held[row.id] = taken
        elif what < 5 and held:
            job = generator.choice(sorted(held))
            finish(job, generator.choice(["succeed", "succeed", "fail", "cancel", "release"]))
        elif what == 5:
            release_waiting_jobs(database)
        elif what == 6:
            generator.choice([lambda: cancel(database, row.id), expire])()
        elif what == 7:
            tree = [one.state for one in rows if one.id == row.id or row.id == root]
            is_free = row.state not in OPEN and set(tree) & UNSUCCESSFUL
            if is_free:
                retry(database, row.id)
            else:
                with pytest.raises((JobNotEnded, JobSucceeded)):
                    retry(database, row.id)

    for _ in range(60):
        before = {row.id: row.state for row in find_jobs(database)}
        step()
        after = find_jobs(database)
        for row in after:
            old = before.get(row.id, row.state)
            assert row.state == old or row.state in TRANSITIONS[old], (old, row.state)
        assert len(pieces(database, root)) == (3 if find_job(database, root).state == State.SUCCEEDED else 0)
    expire()

    def end_all() -> None:
        while (release_waiting_jobs(database), queued := find_jobs(database, JobQuery({"state": "queued"}).conditions))[
            1
        ]:
            for row in queued:
                held[row.id] = claim(database, row.id, "a", 600.0)
                finish(row.id, "succeed")

    end_all()
    if any(row.state in UNSUCCESSFUL for row in find_jobs(database, JobQuery({"family": root}).conditions)):
        retry(database, root)
        end_all()
    for row in find_jobs(database, JobQuery({"family": root}).conditions):
        kinds = [event.kind for event in read_events(database, row.id)]
        assert row.state in ENDED and kinds.count("succeeded") == 1 and attempts(database, row.id) == row.fence
