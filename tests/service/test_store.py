"""The artifact store: the same bytes once, whole or not at all."""

from __future__ import annotations

import hashlib
import os

import pytest
from garmentq.service.store import ArtifactDamaged, ArtifactMissing, StorageFull, Store


def test_put_and_get(store, tmp_path):
    """Broken where the key is not the hash of the bytes, or equal bytes are kept twice."""
    kept = store.put_bytes(b"cloth")
    assert kept.sha256 == hashlib.sha256(b"cloth").hexdigest() and kept.size == 5
    source = tmp_path / "file"
    source.write_bytes(b"cloth")
    assert store.put(source) == kept
    assert store.get_bytes(kept.sha256) == b"cloth"
    assert store.copy(kept.sha256, tmp_path / "deep" / "copy").read_bytes() == b"cloth"
    files = [path for path in store.root.rglob("*") if path.is_file()]
    assert len(files) == 1, "no temporary file may be left"


def test_damage_is_seen(store, tmp_path):
    """Broken where a changed file were handed out as the one that was put there."""
    kept = store.put_bytes(b"cloth")
    store.path(kept.sha256).write_bytes(b"clots")
    with pytest.raises(ArtifactDamaged):
        store.get_bytes(kept.sha256)
    with pytest.raises(ArtifactDamaged):
        store.copy(kept.sha256, tmp_path / "copy")
    assert not (tmp_path / "copy").exists()
    assert store.put_bytes(b"cloth") == kept
    assert store.get_bytes(kept.sha256) == b"cloth", "putting it again must mend it"


def test_putting_again_makes_young_and_mends(store, tmp_path):
    """Broken where a kept file is written once more for every job, goes to `gc` all the same, or stays damaged."""
    source = tmp_path / "file"
    source.write_bytes(b"cloth")
    path = store.path(store.put(source).sha256)
    os.utime(path, (1.0, 1.0))
    before = path.stat()
    kept = store.put(source)
    assert path.stat().st_ino == before.st_ino and path.stat().st_mtime > 1e9
    assert store.remove(kept.sha256, before=1e9) is False, "it is young again"
    path.write_bytes(b"clots")
    assert store.put(source) == kept and store.get_bytes(kept.sha256) == b"cloth"
    assert store.remove(kept.sha256, before=1e12) and store.put(source) == kept
    assert store.get_bytes(kept.sha256) == b"cloth"


@pytest.mark.parametrize("key", ["../../../etc/passwd", "A" * 64, "0" * 63, "", "0" * 64, "../" + "0" * 61])
def test_a_key_is_a_hash_and_nothing_else(store, key):
    """Broken where a key could name a path outside the store."""
    store.put_bytes(b"cloth")
    with pytest.raises(ArtifactMissing):
        store.get_bytes(key)


def test_a_failed_write_leaves_nothing(store, monkeypatch):
    """Broken where a full disk left half a file, or surfaced as a bare OSError."""

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(StorageFull, match="No space left"):
        store.put_bytes(b"cloth")
    assert [path for path in store.root.rglob("*") if path.is_file()] == []


def test_a_place_that_cannot_be_made(tmp_path):
    """Broken where a store below a file ended in a traceback."""
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageFull):
        Store(tmp_path / "file" / "store").put_bytes(b"cloth")
