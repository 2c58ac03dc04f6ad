"""What `gc` may remove, and what it must never."""

from __future__ import annotations

import json
import time

from garmentq.cli.gc import GARBAGE_GRACE_HOURS
from garmentq.service import garbage
from garmentq.service.garbage import collect_garbage
from garmentq.service.jobs import claim
from garmentq.service.kinds.recover import Recover
from garmentq.service.results import load_checkpoint, save_checkpoint, store_result
from garmentq.service.store import ArtifactMissing
from garmentq_home import put_file
from garmentq_standin import make_recovery

DAY = 86400.0


def collect(database, store, days_later=2.0, is_delete=True):
    """Collect as if some days had passed."""
    return collect_garbage(database, store, DAY, is_delete, now=time.time() + days_later * DAY)


def test_what_a_job_names_stays(database, store, queue_job, tmp_path):
    """Broken where scan, body, template, labels, a checkpoint or a result of a job is taken for garbage."""
    template, labels = put_file(tmp_path, "template.json"), put_file(tmp_path, "labels.npz")
    job = queue_job("shirt", template=template, labels=labels)
    held = claim(database, job, "a", 30.0)
    save_checkpoint(database, store, held, "drape", b"state")
    before = {one.sha256 for one in store.list_files()}
    assert len(before) == 5
    assert collect(database, store).files == ()
    request = type("R", (), {"scan": tmp_path / "shirt.ply", "settings": type("S", (), {"fabric": "x", "seed": 0})})
    (tmp_path / "files").mkdir()
    (tmp_path / "files" / "a.txt").write_text("result")
    store_result(database, store, held, Recover(), make_recovery(request, 1.0), tmp_path / "files")
    collect(database, store)
    assert b"result" in {store.get_bytes(one.sha256) for one in store.list_files()}
    assert before - {one.sha256 for one in store.list_files()} <= {store.put_bytes(b"state").sha256}


def test_orphans_and_old_checkpoints_go(database, store, queue_job):
    """Broken where replaced checkpoints fill the disk for ever, or the newest one goes with them."""
    job = queue_job()
    held = claim(database, job, "a", 30.0)
    for step in range(5):
        save_checkpoint(database, store, held, "drape", b"step %d" % step)
    store.put_bytes(b"orphan")
    dry = collect(database, store, is_delete=False)
    assert dry.removed == 0 and store.put_bytes(b"orphan").sha256 in {one.sha256 for one in dry.files}
    found = collect(database, store)
    assert found.removed == len(found.files) == len(dry.files) and found.size == dry.size
    assert b"orphan" not in {store.get_bytes(one.sha256) for one in store.list_files()}
    assert load_checkpoint(database, store, job, "drape") == b"step 4"


def test_what_is_young_stays(database, store):
    """Broken where a file that a running job is about to name is removed."""
    store.put_bytes(b"about to be named")
    assert collect(database, store, days_later=0.5).files == ()
    assert len(collect(database, store, days_later=1.5).files) == 1


def test_a_file_that_is_put_again_in_the_last_moment_stays(database, store, monkeypatch):
    """Broken where the age from the listing decides, though a worker put the same bytes again since."""
    key = store.put_bytes(b"checkpoint").sha256
    listed = store.list_files

    def list_then_put():
        found = [garbage.StoreEntry(one.sha256, one.size, one.modified - 2 * DAY) for one in listed()]
        store.put_bytes(b"checkpoint")
        return iter(found)

    monkeypatch.setattr(store, "list_files", list_then_put)
    found = collect_garbage(database, store, DAY, is_delete=True)
    assert (len(found.files), found.removed) == (1, 0)
    assert store.get_bytes(key) == b"checkpoint"


def test_two_collectors(database, store, monkeypatch):
    """Broken where a file that another collector was quicker to remove ends in an error."""
    store.put_bytes(b"orphan")

    def gone(key, before):
        raise ArtifactMissing()

    monkeypatch.setattr(store, "remove", gone)
    assert collect(database, store).removed == 0


def test_the_command_is_dry_unless_told(cli, database, store):
    """Broken where looking removes, or the command's grace time differs from the one that is explained."""
    assert GARBAGE_GRACE_HOURS == garbage.GARBAGE_GRACE_HOURS
    store.put_bytes(b"orphan")
    assert json.loads(cli("gc", "--json").stdout)["files"] == 0
    assert json.loads(cli("gc", "--grace-hours", 0, "--json").stdout)["files"] == 1
    assert len(list(store.list_files())) == 1
    assert "deleted 1 of 1" in cli("gc", "--grace-hours", 0, "--delete").stderr
    assert list(store.list_files()) == []
