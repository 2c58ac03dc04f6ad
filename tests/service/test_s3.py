"""One interface, two stores: what holds for the folder holds for the bucket."""

from __future__ import annotations

import hashlib
import io
import os
import time

import pytest
from garmentq.service.database import DriverMissing
from garmentq.service.settings import ServiceSettingBad
from garmentq.service.store import ArtifactMissing, Store, StoreUnreachable
from garmentq.service.stores import open_store
from garmentq_home import make_settings

AGES = time.time() + 1e6


@pytest.fixture(scope="module")
def server():
    """Start an S3 server on a free port."""
    from moto.server import ThreadedMotoServer

    started = ThreadedMotoServer("127.0.0.1", port=0, verbose=False)
    started.start()
    host, port = started.get_host_and_port()
    yield f"http://{host}:{port}"
    started.stop()


@pytest.fixture(params=["folder", "s3", "s3 with a prefix"])
def kept(request, tmp_path, monkeypatch):
    """Return each kind of store, empty."""
    if request.param == "folder":
        opened = open_store(make_settings(tmp_path))
        opened.prepare()
        return opened
    server = request.getfixturevalue("server")
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "x")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "y")
    bucket = f"gq-{os.urandom(6).hex()}"
    prefix = "/studio/a" if "prefix" in request.param else ""
    opened = open_store(make_settings(tmp_path, store=f"s3://{bucket}{prefix}", s3_endpoint=server))
    for _ in range(2):
        opened.prepare()
    return opened


def test_put_get_copy(kept, tmp_path):
    """Broken where the key is not the hash of the bytes, or equal bytes are kept twice."""
    stored = kept.put_bytes(b"cloth")
    assert (stored.sha256, stored.size) == (hashlib.sha256(b"cloth").hexdigest(), 5)
    source = tmp_path / "file"
    source.write_bytes(b"cloth")
    assert kept.put(source) == stored == kept.put_stream(io.BytesIO(b"cloth"))
    assert kept.get_bytes(stored.sha256) == b"cloth" and kept.size(stored.sha256) == 5
    assert kept.copy(stored.sha256, tmp_path / "deep" / "copy").read_bytes() == b"cloth"
    assert kept.path(stored.sha256).read_bytes() == b"cloth"
    assert [(one.sha256, one.size) for one in kept.list_files()] == [(stored.sha256, 5)]
    assert abs(next(kept.list_files()).modified - time.time()) < 60.0


def test_ranges(kept):
    """Broken where a range is off by one, or runs over the end."""
    key = kept.put_bytes(bytes(range(200))).sha256
    for start, stop in ((0, None), (0, 1), (7, 19), (199, 200), (150, 999), (200, 300), (5, 5)):
        assert b"".join(kept.read(key, start, stop)) == bytes(range(200))[start:stop]


def test_a_large_file_goes_through_in_parts(kept, tmp_path):
    """Broken where the parts of an upload come back in another order, or the file is held in memory as a whole."""
    content = os.urandom(1 << 20) * 20
    key = kept.put_bytes(content).sha256
    assert max(len(block) for block in kept.read(key)) <= 1 << 20
    assert hashlib.sha256(kept.copy(key, tmp_path / "copy").read_bytes()).hexdigest() == key


def test_what_is_missing(kept, tmp_path):
    """Broken where a missing file is an empty one, an unlisted error, or a key names a path."""
    for key in ("0" * 64, "../../etc/passwd", "", "A" * 64):
        for act in (kept.get_bytes, kept.size, kept.path, lambda k: kept.copy(k, tmp_path / "x"), kept.read):
            with pytest.raises(ArtifactMissing):
                act(key)
    assert not (tmp_path / "x").exists()


def test_remove_spares_what_is_new(kept):
    """Broken where a file that was just put again is removed because it had been old when it was listed."""
    key = kept.put_bytes(b"cloth").sha256
    assert not kept.remove(key, time.time() - 3600.0)
    assert kept.get_bytes(key) == b"cloth"
    assert kept.remove(key, AGES)
    assert list(kept.list_files()) == []


def test_an_absent_server_or_bucket_is_one_clear_error(tmp_path, monkeypatch, server):
    """Broken where boto3's traceback reaches the user, or a wrong bucket looks like a missing file."""
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "x")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "verysecret")
    monkeypatch.setattr("garmentq.service.s3.MAX_S3_ATTEMPTS", 1)
    away = open_store(make_settings(tmp_path, store="s3://bucket", s3_endpoint="http://127.0.0.1:1"))
    wrong = open_store(make_settings(tmp_path, store="s3://no-such-bucket", s3_endpoint=server))
    for one in (away, wrong):
        with pytest.raises(StoreUnreachable) as caught:
            one.put_bytes(b"cloth")
        assert "verysecret" not in caught.value.message


def test_bad_addresses(tmp_path, monkeypatch):
    """Broken where a misspelt store becomes a folder, or a missing boto3 a traceback."""
    for address in ("s3://", "s3:///x", "s3://key:secret@bucket"):
        with pytest.raises(ServiceSettingBad):
            open_store(make_settings(tmp_path, store=address))
    assert type(open_store(make_settings(tmp_path, store=str(tmp_path / "blobs")))) is Store
    monkeypatch.setitem(__import__("sys").modules, "boto3", None)
    with pytest.raises(DriverMissing, match=r"garmentq\[s3\]"):
        open_store(make_settings(tmp_path, store="s3://bucket"))
