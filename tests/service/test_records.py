"""Records from a service's response: what a client believes, and what it refuses."""

from __future__ import annotations

from datetime import datetime

import pytest
from garmentq.service.queue_records import Queue
from garmentq.service.records import Failure, JobReport, Key
from garmentq.service.states import State

REPORT = {
    "job": "3685ecfd4f81", "name": "anna", "state": "failed", "stage": "measure", "progress": 1, "attempts": 1,
    "created": 1, "started": 2.0, "finished": None, "error": {"code": "scan.bad", "message": "b"}, "bad_input": True,
    "queue": "cpu", "priority": 0, "kind": "person", "family": "3685ecfd4f81", "parent": None, "verdict": None,
    "garment": None, "template": None, "fabric": None, "body": None, "settings": {}, "version": "0.1.0",
    "metrics": {"area_m2": 1, "none": None}, "inputs": {"result": "ab12"}, "waits": [], "tags": [], "details": {},
    "children": [{"job": "cd34", "name": "upper", "kind": "recover", "state": "queued"}],
}  # fmt: skip
"""A response without the fields that an older service does not send."""


def test_a_response_of_another_version_is_read():
    """Broken where a field that an older service lacks or a newer one adds makes its response unreadable."""
    report = JobReport.from_json({**REPORT, "news": 1})
    assert (report.id, report.state, report.error) == ("3685ecfd4f81", State.FAILED, Failure("scan.bad", "b"))
    assert (report.children[0].state, report.gates, report.delay, report.overall) == (State.QUEUED, [], None, 0.0)
    shown = report.as_json()
    assert {name: shown[name] for name in REPORT} == REPORT
    assert JobReport.from_json(shown) == report
    assert Queue.from_json({"states": {"queued": 3}, "workers": []}) == Queue({State.QUEUED: 3}, [], [], 0.0)
    key = Key.from_json({"key": "k", "name": "n", "scopes": [], "quota": 3, "created": 1, "revoked": None})
    assert (key.id, key.priority, key.as_json()["key"]) == ("k", 0, "k")


def test_times_are_texts_too():
    """Broken where a time's text is of another time or zone, or a server can give one that differs from its number."""
    report = JobReport.from_json({**REPORT, "created": 1_764_500_000.25, "created_at": "1999-01-01T00:00:00Z"})
    assert (report.created_at, report.finished_at) == ("2025-11-30T10:53:20.250Z", None)
    assert datetime.fromisoformat(report.created_at).timestamp() == 1_764_500_000.25
    assert JobReport.from_json({**REPORT, "created": 1e30}).created_at is None


@pytest.mark.parametrize(
    "change",
    [{"job": "../x"}, {"family": "a\x1b[0m"}, {"parent": "../x"}, {"inputs": {"result": "../x"}}, {"waits": ["../x"]},
     {"children": [{**REPORT["children"][0], "job": "../x"}]}, {"job": 17 * "a"}, {"state": "gone"}, {"progress": "x"},
     {"metrics": None}],
)  # fmt: skip
def test_a_response_that_no_service_sends_is_refused(change):
    """Broken where an id of a response reaches a path or the terminal unchecked, or a wrong type a caller."""
    with pytest.raises(ValueError):
        JobReport.from_json(REPORT | change)


@pytest.mark.parametrize("name", sorted(REPORT))
def test_a_field_of_every_version_is_required(name):
    """Broken where the response of another server counts as a job without a value."""
    with pytest.raises(ValueError):
        JobReport.from_json({key: value for key, value in REPORT.items() if key != name})
