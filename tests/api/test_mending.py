"""A person's labels mended over HTTP: a new job for the same scan, and nothing for who may not."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from api_client import serving
from api_work import code_of, make_key
from garmentq.core.people.mend import LabelsOld, apply_corrected_labels
from garmentq.core.people.part import Part
from garmentq.service.client import Client
from garmentq.service.jobs import find_job, read_events
from garmentq.service.keys import create_key
from garmentq.service.kinds import read_request
from garmentq.service.kinds.person_request import PersonRequest
from garmentq.service.results import list_files
from garmentq.service.services import Services
from garmentq.service.settings import PERSON_CHECKER, SEPARATOR
from garmentq.service.states import State
from garmentq_family_home import pieces, work_off
from person_jobs import EXTRA, keep_person
from shells import dress_in_shells


@pytest.fixture(scope="module")
def shells():
    """Return a dressed person of 7000 points."""
    return dress_in_shells(0)


def make_npy(values: np.ndarray) -> bytes:
    """Return an array as the bytes of an .npy file."""
    out = io.BytesIO()
    np.save(out, values)
    return out.getvalue()


def test_who_may_not_mends_nothing(client, settings, database, store, shells, tmp_path):
    """Broken where a key sees or mends another's labels, a reader mends, or labels that do not fit make a job."""
    row, _ = create_key(database, "studio", ("read", "submit"), 100)
    ours, theirs, reader = (make_key(database, name, *s) for name, s in (("o", ()), ("t", ()), ("r", ("read",))))
    job = keep_person(Services(settings, database, store), tmp_path / "anna", shells, key=row.id)
    admin = make_key(database, "admin", "admin", "read", "submit")

    def mend(values: np.ndarray | bytes, headers: dict[str, str], of: str = job):
        content = values if isinstance(values, bytes) else make_npy(values)
        kept = client.post("/v1/labels", params={"name": "points.npy"}, content=content, headers=headers)
        points = kept.json().get("sha256", "0" * 64)
        return client.post(f"/v1/jobs/{of}/labels", json={"points": points}, headers=headers)

    good = shells.label
    for headers in (ours, theirs):
        assert (mend(good, headers).status_code, code_of(mend(good, headers))) == (404, "job.unknown")
    assert code_of(mend(good, reader)) == "key.scope_missing"
    assert code_of(mend(good[:-1], admin)) == "scan.labels_mismatch"
    for bad in (good.astype(np.float64), np.stack([good, good]), np.where(good == 0, 77, good), b"\x93NUMPY junk"):
        assert code_of(mend(bad, admin)) == "scan.labels_unreadable"
    assert len(client.get("/v1/jobs", headers=admin).json()["jobs"]) == 1
    made = mend(good, admin)
    assert made.status_code == 202 and made.headers["location"] == f"/v1/jobs/{made.json()['job']}"
    assert mend(good, admin).status_code == 200


def test_a_person_is_taken_for_another_outfit(client, settings, database, store, shells, tmp_path):
    """Broken where another key or a reader chooses an outfit, a word that is none makes a job, or options are lost."""
    key, _ = create_key(database, "studio", ("read", "submit"), 100)
    job = keep_person(Services(settings, database, store), tmp_path / "berta", shells, key=key.id)
    other, reader = (make_key(database, name, *s) for name, s in (("o2", ()), ("r2", ("read",))))
    admin = make_key(database, "admin2", "admin", "read", "submit")

    def wear(wearing: str, headers: dict[str, str]):
        return client.post(f"/v1/jobs/{job}/wearing", json={"wearing": wearing}, headers=headers)

    assert code_of(wear("one-piece", other)) == "job.unknown"
    assert code_of(wear("one-piece", reader)) == "key.scope_missing"
    assert code_of(wear("socks", admin)) == "segment.hint_bad"
    made = wear("one-piece", admin)
    assert made.status_code == 202 and wear("one-piece", admin).status_code == 200
    again = read_request(PersonRequest, find_job(database, made.json()["job"]).request)
    assert (again.wearing, again.labels, again.given_as) == ("one-piece", None, "person")
    assert again.scan == read_request(PersonRequest, find_job(database, job).request).scan


def test_labels_go_where_the_files_points_are(tmp_path):
    """Broken where points that were merged, dropped or split get another's label, or old files are believed to fit."""
    stored = tmp_path / "labels.npz"
    label = np.array([20, 0, 10, 10, 0], np.uint8)
    np.savez(stored, label=label, confidence=np.ones(5), names=np.array([""]), place=np.array([-1, 2, 0, 0, 1]))
    mended = np.array([11, 0, 1], np.uint8)
    with np.load(apply_corrected_labels(stored, mended, tmp_path / "new.npz")) as found:
        assert found["label"].tolist() == [20, 1, 11, 11, 0]
        assert found["place"].tolist() == [-1, 2, 0, 0, 1]
    np.savez(stored, label=label, confidence=np.ones(5), names=np.array([""]))
    with pytest.raises(LabelsOld):
        apply_corrected_labels(stored, mended, tmp_path / "new.npz")


@pytest.mark.nightly
def test_a_mended_person_is_taken_apart_by_the_labels(settings, database, store, tmp_path):
    """Broken where the new job does not read what was mended: a shirt that became a one-piece stays a shirt."""
    shells = dress_in_shells(1)
    job = keep_person(Services(settings, database, store), tmp_path / "anna", shells)
    mended = np.where(shells.label == Part.UPPER, Part.ONE_PIECE, shells.label).astype(np.uint8)
    mended[shells.label == Part.LOWER] = Part.ONE_PIECE
    (tmp_path / "points.npy").write_bytes(make_npy(mended))
    from garmentq.service.local_token import make_local_token

    with serving(settings) as url, Client(url, make_local_token(settings.home)) as service:
        made = service.mend_labels(job, tmp_path / "points.npy")
    assert made.is_new and made.state == State.QUEUED
    assert read_request(PersonRequest, find_job(database, made.job).request).labels.name == "labels.npz"
    real = replace(settings, separator=SEPARATOR, person_checker=PERSON_CHECKER)
    work_off(real, database)
    row = find_job(database, made.job)
    told = [event.data for event in read_events(database, made.job)][-1]
    assert row.state == "succeeded", told
    assert list(pieces(database, made.job)) == ["one-piece"]
    kept = {file.name: file.sha256 for file in list_files(database, made.job)}
    with np.load(io.BytesIO(store.get_bytes(kept["labels.npz"]))) as arrays:
        assert np.array_equal(arrays["label"][EXTRA:], mended)
        assert int(arrays["place"].max()) + 1 <= len(mended) + 10
