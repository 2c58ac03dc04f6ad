"""Which job is next, and which running job gives way to it."""

from __future__ import annotations

from dataclasses import replace
from threading import Thread

import pytest
from garmentq.core.recover.settings import LATER, RecoverySettings, complete_by_quality
from garmentq.service.families import make_children
from garmentq.service.jobs import JobUnknown, claim, claim_next, find_job, read_events
from garmentq.service.keys import create_key, grant_job
from garmentq.service.kinds import KINDS, find_kind
from garmentq.service.kinds.kind import ChildRequest
from garmentq.service.lanes import Lane
from garmentq.service.models import JobRow
from garmentq.service.places import find_places
from garmentq.service.preemption import MAX_PREEMPTIONS, NEAR_END_SECONDS, preempt
from garmentq.service.priority import change_priority
from garmentq.service.reaper import record_heartbeat
from garmentq.service.requeueing import give_way
from garmentq.service.settings import ServiceSettings
from garmentq.service.states import State
from garmentq.workers import watch
from garmentq.workers.recovery import run_job
from garmentq_home import wait_for
from sqlalchemy import select, text


@pytest.fixture
def change(database):
    """Return a function that writes columns of a job."""

    def write(job: str, **values) -> str:
        with database.write() as session:
            for name, value in values.items():
                setattr(session.get_one(JobRow, job), name, value)
        return job

    return write


def take_all(database, wakeup: str) -> list[str]:
    """Claim every queued job, and return them in their order."""
    taken = []
    while (found := claim_next(database, wakeup, "w", 30.0)) is not None:
        taken.append(found.job)
    return taken


def test_what_somebody_waits_for_goes_before_any_priority(database, queue_job, change):
    """Broken where an edit waits behind a batch, whatever the batch's priority, or previews hold an edit up."""
    batch, urgent = queue_job("batch"), queue_job("urgent", priority=100)
    preview = queue_job("preview", settings=RecoverySettings(**complete_by_quality("preview", {})))
    edits = [change(queue_job(name, priority=p), lane=Lane.INTERACTIVE) for name, p in (("low", -5), ("edit", 0))]
    assert find_job(database, preview).lane == Lane.PREVIEW and find_job(database, batch).lane == Lane.BATCH
    assert take_all(database, batch) == [edits[1], edits[0], preview, urgent, batch]


def test_kinds_somebody_waits_for():
    """Broken where a new derived kind is forgotten, or an animation of minutes holds edits up."""
    lanes = {name: find_kind(ServiceSettings(), name).lane for name in KINDS}
    slow = {"recover", "person", "animate", "redrape"}
    assert lanes == {name: Lane.BATCH if name in slow else Lane.INTERACTIVE for name in KINDS}


def test_a_person_begun_is_finished_before_the_next(database, queue_job, change):
    """Broken where every scan is taken apart before anybody sees a pattern, or a re-drape goes before a result."""
    persons = [queue_job(f"person{i}") for i in range(3)]
    request = find_job(database, persons[0]).request
    first, second = (claim_next(database, persons[0], "w", 30.0) for _ in range(2))
    pieces = [ChildRequest("upper", "recover", request), ChildRequest("lower", "recover", request)]
    pieces.append(ChildRequest("later", "recover", request, priority=-100, lane=Lane.BATCH))
    with database.write() as session:
        late = make_children(session, second.job, pieces)
        early = make_children(session, first.job, pieces)
    order = [early["upper"], early["lower"], late["upper"], late["lower"], persons[2], early["later"], late["later"]]
    assert take_all(database, persons[0]) == order


def test_children_are_of_their_parents_lane(database, queue_job):
    """Broken where the garments of a previewed person wait behind a batch, or their re-drapes go before it."""
    settings = RecoverySettings(**complete_by_quality("preview", {"redrape": LATER}))
    parent = queue_job("anna", settings=settings)
    request = find_job(database, parent).request
    with database.write() as session:
        made = make_children(
            session,
            parent,
            [ChildRequest("a", "recover", request), ChildRequest("b", "recover", request, lane=Lane.BATCH)],
        )
    assert [find_job(database, made[name]).lane for name in "ab"] == [Lane.PREVIEW, Lane.BATCH]


def test_keys_take_turns_with_their_edits(database, queue_job, change):
    """Broken where one key's many edits go before another's one."""
    many = [change(queue_job(f"many{i}"), lane=Lane.INTERACTIVE, payer="a") for i in range(3)]
    one = change(queue_job("one"), lane=Lane.INTERACTIVE, payer="b")
    assert take_all(database, one) == [many[0], one, *many[1:]]


def test_a_priority_is_that_of_the_family(database, queue_job):
    """Broken where a garment keeps its old priority, a re-drape goes before results, or no event tells."""
    batch, anna = queue_job("batch", priority=1), queue_job("anna")
    request = find_job(database, anna).request
    pieces = [ChildRequest("upper", "recover", request), ChildRequest("late", "redrape", request, priority=-100)]
    with database.write() as session:
        made = make_children(session, anna, pieces)
    assert change_priority(database, made["upper"], 5) == 5
    assert [find_job(database, job).priority for job in (batch, anna, *made.values())] == [1, 5, 5, -100]
    assert read_events(database, anna)[-1].data == {"priority": 5}
    assert take_all(database, batch) == [anna, made["upper"], batch, made["late"]]
    with pytest.raises(JobUnknown):
        change_priority(database, "nosuch", 1)


def test_a_shared_job_is_only_raised(database, queue_job):
    """Broken where one key puts off what another key has ordered too."""
    job = queue_job("shared", priority=2)
    ours, theirs = (create_key(database, name, ("submit",))[0].id for name in ("ours", "theirs"))
    with database.write() as session:
        grant_job(session, ours, job)
        grant_job(session, theirs, job)
    assert [change_priority(database, job, priority, ours) for priority in (-5, 4, 3)] == [2, 4, 4]
    assert change_priority(database, job, -5) == -5, "the operator decides"


def marked(database) -> set[str]:
    """Return the jobs that are to give way."""
    with database.read() as session:
        return set(session.scalars(select(JobRow.id).where(JobRow.preempt)))


def test_as_many_give_way_as_wait(database, queue_job, change):
    """Broken where a waiting edit stops every job, one that is nearly done, or any while a worker is free."""
    jobs = [queue_job(f"batch{i}") for i in range(3)]
    for index, job in enumerate(jobs[:2]):
        claim(database, job, f"w{index}", 30.0)
        change(job, started=100.0 + index)
    record_heartbeat(database, "worker", "cpu,gpu", 2, 30.0)
    assert preempt(database) == 0 and not marked(database), "a batch gives way to no batch"
    edit = change(queue_job("edit"), lane=Lane.INTERACTIVE)
    assert preempt(database) == 1 and marked(database) == {jobs[1]}, "the one begun last"
    assert preempt(database) == 0
    record_heartbeat(database, "second", "cpu", 1, 30.0)
    assert preempt(database) == 1 and not marked(database), "a free worker takes the edit"
    with database.write() as session:
        session.execute(text("delete from workers where name = 'second'"))
    now = find_job(database, edit).created
    change(jobs[1], expected_end=now + 0.5 * NEAR_END_SECONDS)
    assert preempt(database) == 1 and marked(database) == {jobs[0]}
    change(jobs[0], preempt=False, preemptions=MAX_PREEMPTIONS)
    assert preempt(database) == 0 and not marked(database)


def test_whoever_gives_way_loses_no_attempt_and_is_next(database, queue_job, change):
    """Broken where giving way counts as a failed attempt, or the job goes to the end of its queue."""
    job, later = queue_job("batch"), queue_job("later")
    held = claim_next(database, job, "w", 30.0)
    change(job, preempt=True)
    give_way(database, held)
    row = find_job(database, job)
    assert (row.state, row.attempts, row.preemptions) == ("queued", 0, 1)
    assert read_events(database, job)[-1].kind == "preempted"
    assert take_all(database, job) == [job, later] and not find_job(database, job).preempt


def test_a_job_gives_way_at_its_checkpoint_and_goes_on_from_there(settings, database, queue_job, change, tmp_path):
    """Broken where a worker does not see the mark, forgets the checkpoint, or ends the job."""
    job, outcomes = queue_job("slow"), []
    quick = replace(settings, poll_seconds=0.05)

    def work() -> None:
        outcomes.append(run_job(quick, database, job, lambda: False))

    thread = Thread(target=work)
    thread.start()
    wait_for(lambda: find_job(database, job).progress > 0.1)
    change(job, preempt=True)
    thread.join()
    assert outcomes == ["preempted"] and find_job(database, job).state == "queued"
    work()
    row = find_job(database, job)
    assert outcomes[1] == "succeeded" and (row.attempts, row.preemptions) == (1, 1)


def test_places_are_the_order_of_the_claims(database, queue_job, change):
    """Broken where the place is by age alone, a paused job has one, or other keys are not counted in turn."""
    jobs = [queue_job(f"batch{i}") for i in range(4)]
    for job in jobs[:3]:
        change(job, payer="a")
    change(jobs[3], payer="b")
    urgent, paused = queue_job("urgent", priority=3), queue_job("paused")
    edit = change(queue_job("edit"), lane=Lane.INTERACTIVE)
    change(paused, not_before=find_job(database, edit).created + 60.0)
    found = find_places(database, [*jobs, urgent, paused, edit])
    order = take_all(database, edit)
    assert [job for job, _ in sorted(found.items(), key=lambda one: one[1].place)] == order
    assert [found[job].place for job in order] == [1, 2, 3, 4, 5, 6] and paused not in found
    assert {one.expected_start for one in found.values()} == {None}, "no worker, no earlier job"


def test_jobs_start_when_slots_come_free(database, queue_job, change):
    """Broken where the time to wait is that of one worker, or a running job's end is not counted."""
    done, running, *jobs = [queue_job(name) for name in ("done", "running", "a", "b", "c")]
    claim(database, running, "w", 30.0)
    record_heartbeat(database, "worker", "cpu,gpu", 2, 30.0)
    now = find_job(database, running).started
    change(done, state=State.SUCCEEDED, started=now - 100.0, finished=now)
    change(running, expected_end=now + 30.0)
    found = find_places(database, jobs)
    waits = [found[job].expected_start - now for job in jobs]
    assert waits == pytest.approx([0.0, 30.0, 100.0], abs=5.0)


def test_an_iteration_that_takes_long_is_interrupted(settings, database, queue_job, change, monkeypatch):
    """Broken where an edit waits until a long iteration of a batch ends, or the interruption ends the job."""
    monkeypatch.setattr(watch, "CHECKPOINT_WAIT_SECONDS", 0.2)
    monkeypatch.setattr(watch, "ITERATION_WAIT_SECONDS", 0.2)
    job = queue_job("stuck")

    def mark() -> None:
        wait_for(lambda: find_job(database, job).stage == "scan")
        change(job, preempt=True)

    marker = Thread(target=mark)
    marker.start()
    outcome = run_job(replace(settings, poll_seconds=0.05), database, job, lambda: False)
    marker.join()
    row = find_job(database, job)
    assert (outcome, row.state, row.attempts, row.preemptions) == ("preempted", "queued", 0, 1)
