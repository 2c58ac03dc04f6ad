"""Submission: one scan with the same settings is one job."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.run.errors import BadInput
from garmentq.service.families import cancel, retry
from garmentq.service.jobs import claim, fail, find_job
from garmentq.service.keys import QueueFull, create_key
from garmentq.service.query import list_jobs
from garmentq.service.submission import BodyUnreadable, Order, clean_name, submit
from garmentq.service.terms import JobTerms
from garmentq_home import put_file


@pytest.fixture
def order(tmp_path):
    """Return an order for a shirt."""
    return Order(put_file(tmp_path, "shirt.ply"), put_file(tmp_path, "body.ply"))


def test_the_same_order_is_the_same_job(database, store, order, tmp_path):
    """Broken where the file's place or time were part of the key."""
    first = submit(database, store, order)
    again = tmp_path / "again"
    again.mkdir()
    copy = Order(again / "shirt.ply", again / "body.ply")
    copy.scan.write_bytes(order.scan.read_bytes())
    copy.body.write_bytes(order.body.read_bytes())
    second = submit(database, store, copy)
    assert first.is_new and not second.is_new
    assert first.job == second.job


@pytest.mark.parametrize("change", ["scan", "body", "builtin", "template", "settings", "force"])
def test_another_order_is_another_job(database, store, order, tmp_path, change):
    """Broken where a part of the order is missing from the key: somebody would get another order's result."""
    first = submit(database, store, order)
    other = put_file(tmp_path, "other.ply")
    changed = {
        "scan": Order(other, order.body),
        "body": Order(order.scan, other),
        "builtin": Order(order.scan, BuiltinWearer("builtin:female")),
        "template": Order(order.scan, order.body, template=other),
        "settings": Order(order.scan, order.body, settings=RecoverySettings(seed=1)),
        "force": Order(order.scan, order.body, terms=JobTerms(force=True)),
    }[change]
    assert submit(database, store, changed).job != first.job


def test_many_identical_submissions_at_once(database, store, order):
    """Broken where looking and inserting are two transactions: two equal jobs, or an integrity error."""
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: submit(database, store, order), range(16)))
    assert len({answer.job for answer in answers}) == 1
    assert sum(answer.is_new for answer in answers) == 1
    assert len(list_jobs(database)) == 1


def test_a_failed_job_is_queued_again(database, store, order):
    """Broken where a passing fault (a full disk) made an order fail for ever."""
    job = submit(database, store, order).job
    fail(database, claim(database, job, "a", 30.0), "store.full", "no room", bad_input=False)
    again = submit(database, store, order)
    row = find_job(database, job)
    assert (again.job, again.is_new, row.state, row.attempts, row.error_code) == (job, False, "queued", 0, None)


def test_no_body_is_refused(database, store, order):
    """Broken where a garment without a body went into the queue."""
    with pytest.raises(BadInput) as refused:
        submit(database, store, Order(order.scan, None, given_as="garment"))
    assert refused.value.code == "body.missing"
    assert "builtin:female" in refused.value.message
    with pytest.raises(BodyUnreadable):
        submit(database, store, Order(order.scan, order.scan.with_name("nosuch.ply")))
    assert list_jobs(database) == []


@pytest.mark.parametrize(
    ("name", "clean"),
    [
        ("../../etc/passwd", "passwd"),
        ("a b;rm -rf.ply", "a_b_rm_-rf.ply"),
        (".hidden.ply", "hidden.ply"),
        ("\x1b[31m", "_31m"),
        ("..", "file"),
    ],
)
def test_names_are_made_harmless(name, clean):
    """Broken where a file's name could leave its folder or reach a terminal raw."""
    assert clean_name(name) == clean


def test_labels_and_what_is_kept_are_part_of_the_order(database, store, tmp_path):
    """Broken where two garments of one scan are one job, or a dressed person is refused for want of a body."""
    scan, labels, others = (put_file(tmp_path, name) for name in ("person.ply", "labels.npz", "others.npz"))
    orders = [
        Order(scan, None, settings=RecoverySettings(keep="upper"), labels=labels),
        Order(scan, None, settings=RecoverySettings(keep="lower"), labels=labels),
        Order(scan, None, settings=RecoverySettings(keep="upper"), labels=others),
        Order(scan, None, settings=RecoverySettings(keep_colour="#465faa")),
    ]
    jobs = [submit(database, store, order).job for order in orders]
    assert len(set(jobs)) == 4
    assert not submit(database, store, orders[0]).is_new
    request = find_job(database, jobs[0]).request
    assert request["body"] is None and request["labels"]["name"] == "labels.npz"


def test_a_job_counts_for_the_key_that_queued_it_last(database, store, order, tmp_path):
    """Broken where sharing a job fills the quota of a key that queued nothing, or a retry is free of charge."""
    ours, theirs = (create_key(database, name, ("submit",), quota=1)[0].id for name in ("ours", "theirs"))
    first = submit(database, store, replace(order, terms=JobTerms(key=ours, quota=1))).job
    assert submit(database, store, replace(order, terms=JobTerms(key=theirs, quota=1))).job == first
    other = replace(order, scan=put_file(tmp_path, "other.ply"))
    with pytest.raises(QueueFull):
        submit(database, store, replace(other, terms=JobTerms(key=ours, quota=1)))
    cancel(database, first)
    retry(database, first, theirs, 1)
    with pytest.raises(QueueFull):
        submit(database, store, replace(other, terms=JobTerms(key=theirs, quota=1)))
    assert submit(database, store, replace(other, terms=JobTerms(key=ours, quota=1))).is_new
