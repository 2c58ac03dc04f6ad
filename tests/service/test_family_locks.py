"""Two transactions on one family at the same moment: no deadlock, nothing seen half-way, nobody let in by the way."""

from __future__ import annotations

import threading
import time

import pytest
from garmentq.service import families
from garmentq.service.families import make_children, release_waiting_jobs, retry
from garmentq.service.jobs import JobUnknown, find_job
from garmentq.service.keys import create_key
from garmentq.service.kinds import ChildRequest, pack_request
from garmentq.service.models import JobRow, OwnerRow
from garmentq.service.states import State
from garmentq.workers.recovery import run_job
from garmentq_family import Piece, PieceRequest
from garmentq_family_home import pieces, work_off
from sqlalchemy import event, select, text

WAITERS = "select count(*) from pg_stat_activity where datname = current_database() and wait_event_type = 'Lock'"


def start(database, call) -> threading.Thread:
    """Start a call in a thread, and return once it has ended or waits for a lock; SQLite has one writer at a time."""
    thread = threading.Thread(target=call, daemon=True)
    thread.start()
    while thread.is_alive() and not database.is_sqlite:
        with database.read() as session:
            if session.scalar(text(WAITERS)):
                break
        time.sleep(0.02)
    return thread


def test_who_locks_siblings_locks_their_parent_first(database, family, tmp_path):
    """Broken where retrying the root and retrying a child that takes a sibling along can wait for each other."""
    settings, queue = family
    (tmp_path / "fail-back").touch()
    root = queue()
    work_off(settings, database)
    made = pieces(database, root)
    with database.write() as session:
        session.get(JobRow, root, with_for_update=True)
        thread = start(database, lambda: retry(database, made["whole"].id))
        assert thread.is_alive()
    thread.join()
    assert find_job(database, made["back"].id).state == State.QUEUED


def test_a_job_whose_sibling_is_tried_again_goes_on_waiting(database, family, monkeypatch, tmp_path):
    """Broken where a sibling that is tried again between two looks at it counts as one that succeeded."""
    settings, queue = family
    root = queue()
    run_job(settings, database, root, lambda: False)
    monkeypatch.setattr(families, "_is_ready", lambda: JobRow.state == State.WAITING)
    release_waiting_jobs(database)
    assert pieces(database, root)["whole"].state == State.WAITING


def test_a_new_owner_sees_what_is_made_meanwhile(database, family):
    """Broken where a child that is made while its family gets another owner is not that one's."""
    settings, queue = family
    root, key = queue(), create_key(database, "theirs", ("submit",))[0].id
    run_job(settings, database, root, lambda: False)
    front = pieces(database, root)["front"].id
    with database.write() as session:
        session.get(JobRow, front, with_for_update=True)  # as who stores its result does
        request = pack_request(PieceRequest("below"))
        made = make_children(session, front, [ChildRequest("below", Piece.name, request)])
        thread = start(database, lambda: queue(key=key, quota=9))
    thread.join()
    with database.read() as session:
        owned = set(session.scalars(select(OwnerRow.job).where(OwnerRow.key == key)))
    assert made["below"] in owned and len(owned) == 5


def test_the_quota_is_judged_before_a_key_gets_a_job(database, family):
    """Broken where two requests of a key each hold its row, and each waits to lock it."""
    _, queue = family
    root, key = queue(), create_key(database, "theirs", ("submit",))[0].id
    families.cancel(database, root)
    said: list[str] = []
    event.listen(database.engine, "before_cursor_execute", lambda *given: said.append(given[2]))
    assert queue(key=key, quota=9) == root
    locks = next(number for number, one in enumerate(said) if "FROM api_keys" in one)
    assert locks < next(number for number, one in enumerate(said) if one.startswith("INSERT INTO owners"))


def test_an_equal_job_is_no_way_to_a_foreign_result(database, family):
    """Broken where naming another key's job as an input shows the job that its owner made of it."""
    settings, queue = family
    ours, theirs = (create_key(database, name, ("submit",))[0].id for name in ("ours", "theirs"))
    root = queue(key=ours, quota=9)
    run_job(settings, database, root, lambda: False)
    reader = {"text": "reader", "inputs": {"it": root}, "quota": 9}
    queue(key=ours, **reader)
    with pytest.raises(JobUnknown):
        queue(key=theirs, **reader)
