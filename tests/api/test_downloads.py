"""Downloads of a real server process: what they leave on its disk, in its memory, and with a client."""

from __future__ import annotations

import hashlib
import os
import socket
import time
import zipfile
from contextlib import ExitStack, contextmanager
from email import message_from_bytes
from io import BytesIO
from itertools import count

import httpx
import pytest
from api_client import local_user
from api_work import ask, code_of, finish, make_key
from garmentq.service.api.media_types import find_media_type
from garmentq.service.models import ArtifactRow
from garmentq.service.results import RESULT
from garmentq_home import STANDIN, make_environment, make_home, wait_for
from served_process import serving_alone

SIZE = 24 << 20
STALLED = 2.0
MARKS = count()
"""Marks that tell the scans of one job from those of another."""


@pytest.fixture(scope="module")
def settings(tmp_path_factory, blank_database):
    """Return one home for the whole module: each test that harms a file has a job of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(STANDIN))
        yield make_home(tmp_path_factory.mktemp("downloads") / "home", blank_database)


@pytest.fixture(scope="module")
def server(settings):
    """Serve the home in a process of its own, which gives up on what lies unread after two seconds."""
    temporary = settings.home.parent / "temporary"
    temporary.mkdir()
    chosen = {"GARMENTQ_API_STALLED_SECONDS": str(STALLED), "TMPDIR": str(temporary)}
    with serving_alone(make_environment(settings) | chosen, settings.home.parent / "serve.log") as found:
        yield found


@pytest.fixture
def served(server, settings):
    """Return the server; what it wrote for the test before is gone from its log."""
    os.truncate(server.log, 0)
    return server


@pytest.fixture
def large(served, settings, database, store, tmp_path):
    """Return a finished job with a large file beside its own ones: its id, and the file's hash."""
    with httpx.Client(base_url=served.url, headers=local_user(settings), timeout=60.0) as client:
        job = ask(client, float(next(MARKS))).json()["job"]
    finish(settings, database, store, job, tmp_path / "out")
    return job, add_large(database, store, job)


def add_large(database, store, job: str) -> str:
    """Put a large file among a job's, and return its hash."""
    kept = store.put_bytes(os.urandom(SIZE))
    with database.write() as session:
        session.add(ArtifactRow(job=job, kind=RESULT, name="large.bin", sha256=kept.sha256, size=SIZE, created=0.0))
    return kept.sha256


@contextmanager
def unread(served, path: str, header: dict[str, str], room: int = 1 << 14):
    """Ask for something and read none of it."""
    with socket.socket() as asking:
        asking.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, room)
        asking.settimeout(60)
        asking.connect(("127.0.0.1", served.port))
        lines = [f"GET {path} HTTP/1.1", "Host: 127.0.0.1", *(f"{name}: {value}" for name, value in header.items())]
        asking.sendall("\r\n".join([*lines, "", ""]).encode())
        yield asking


def drain(asking: socket.socket) -> bytes:
    """Return all that still comes, until the server closes."""
    found = []
    while True:
        try:
            block = asking.recv(1 << 16)
        except ConnectionResetError:
            break
        if not block:
            break
        found.append(block)
    return b"".join(found)


def measure(folder) -> int:
    """Return the bytes of all files below a folder."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) if folder.exists() else 0


@pytest.mark.parametrize("form", ["file", pytest.param("range", marks=pytest.mark.nightly), "archive"])
def test_what_is_not_read_takes_no_room_and_ends(served, large, settings, form):
    """Broken where an unread download holds a copy on the disk, its memory, or its connection for ever."""
    job, _ = large
    header = local_user(settings) | ({"Range": "bytes=1-"} if form == "range" else {})
    path = f"/v1/jobs/{job}/result.zip" if form == "archive" else f"/v1/jobs/{job}/artifacts/large.bin"
    sockets, memory = served.count_open("socket:"), served.read_peak()
    with ExitStack() as held:
        asking = [held.enter_context(unread(served, path, header)) for _ in range(25)]
        assert all(one.recv(15).endswith(b" 200 OK" if form != "range" else b" 206 Pa") for one in asking)
        assert served.count_open(settings.store_path) <= 25
        assert measure(settings.home / "incoming") == measure(settings.home.parent / "temporary") == 0
        assert served.read_peak() - memory < 4 * SIZE  # copies of 25 files would take 25 times the size
        wait_for(lambda: served.count_open("socket:") <= sockets)
        wait_for(lambda: served.count_open(settings.store_path) == 0)
        assert all(len(drain(one)) < SIZE for one in asking)
    assert measure(settings.home / "incoming") == measure(settings.home.parent / "temporary") == 0
    with httpx.Client(base_url=served.url, headers=local_user(settings), timeout=60.0) as client:
        assert client.get("/v1/jobs").status_code == 200
    assert "Traceback" not in served.log.read_text()


def test_a_slow_reader_goes_on(served, large, settings):
    """Broken where a client that reads little by little, for longer than an unread answer may lie, is cut off."""
    job, sha256 = large
    header = local_user(settings) | {"Connection": "close"}
    with unread(served, f"/v1/jobs/{job}/artifacts/large.bin", header) as asking:
        begun, found = time.monotonic(), b""
        while time.monotonic() < begun + 3 * STALLED:
            found += asking.recv(1 << 15)
            time.sleep(0.1)
        found += drain(asking)
    head, _, content = found.partition(b"\r\n\r\n")
    assert b" 200 " in head and hashlib.sha256(content).hexdigest() == sha256


@pytest.mark.parametrize("where", [SIZE - 1, *(pytest.param(n, marks=pytest.mark.nightly) for n in (0, SIZE // 2))])
def test_a_damaged_file_never_comes_whole(served, large, settings, store, where):
    """Broken where a client can take a damaged file for the one that was kept, alone or in an archive."""
    job, sha256 = large
    with store.path(sha256).open("r+b") as stream:
        stream.seek(where)
        before = stream.read(1)
        stream.seek(where)
        stream.write(bytes([before[0] ^ 1]))
    with httpx.Client(base_url=served.url, headers=local_user(settings), timeout=60.0) as client:
        for path in (f"/v1/jobs/{job}/artifacts/large.bin", f"/v1/jobs/{job}/result.zip"):
            with pytest.raises(httpx.RemoteProtocolError), client.stream("GET", path) as answer:
                got = b"".join(answer.iter_raw())
                assert not got
        assert client.get(f"/v1/jobs/{job}/artifacts/pattern.svg").status_code == 200
    assert "store.damaged" in served.log.read_text() and "Traceback" not in served.log.read_text()


def test_a_damaged_small_file_and_one_of_another_size_are_refused(served, large, settings, store):
    """Broken where what can be told before a byte is sent is not an answer with a code."""
    job, sha256 = large
    with httpx.Client(base_url=served.url, headers=local_user(settings), timeout=60.0) as client:
        files = {one["name"]: one["sha256"] for one in client.get(f"/v1/jobs/{job}/artifacts").json()["files"]}
        small = store.path(files["pattern.svg"])
        whole = small.read_bytes()
        small.write_bytes(whole[::-1])
        assert code_of(client.get(f"/v1/jobs/{job}/artifacts/pattern.svg")) == "store.damaged"
        small.write_bytes(whole)  # other jobs have the same file
        for size in (SIZE - 1, SIZE + 1):
            os.truncate(store.path(sha256), size)
            for header in ({}, {"range": "bytes=0-9"}):
                answer = client.get(f"/v1/jobs/{job}/artifacts/large.bin", headers=header)
                assert (answer.status_code, code_of(answer)) == (503, "store.damaged")
            assert client.head(f"/v1/jobs/{job}/artifacts/large.bin").status_code == 503
        store.path(sha256).unlink()
        assert code_of(client.get(f"/v1/jobs/{job}/artifacts/large.bin")) == "store.missing"


@pytest.mark.parametrize("harm", ["cut", "removed"])
def test_a_file_that_changes_while_it_is_sent(served, large, settings, store, harm):
    """Broken where less than the file comes and is called whole, or one that is unlinked is not sent to its end."""
    job, sha256 = large
    header = local_user(settings) | {"Connection": "close"}
    with unread(served, f"/v1/jobs/{job}/artifacts/large.bin", header) as asking:
        found = asking.recv(1 << 16)
        if harm == "cut":
            os.truncate(store.path(sha256), SIZE // 2)
        else:
            store.path(sha256).unlink()
        content = (found + drain(asking)).partition(b"\r\n\r\n")[2]
    assert (hashlib.sha256(content).hexdigest() == sha256) == (harm == "removed")
    assert harm == "removed" or len(content) < SIZE
    assert "Traceback" not in served.log.read_text()


def test_ranges_read_only_what_they_send(served, large, settings, store):
    """Broken where a part, or a HEAD, has other bytes or sizes than the file, or reads all of it."""
    job, sha256 = large
    content = store.path(sha256).read_bytes()
    url = f"/v1/jobs/{job}/artifacts/large.bin"
    with httpx.Client(base_url=served.url, headers=local_user(settings), timeout=60.0) as client:
        assert client.get(url).content == content
        head = client.head(url)
        assert (head.status_code, head.headers["content-length"], head.content) == (200, str(SIZE), b"")
        assert head.headers["etag"] == f'"{sha256}"' and head.headers["accept-ranges"] == "bytes"
        before = read_bytes_of(served.process)
        assert client.head(url).status_code == 200
        for asked, start, stop in (("5-5", 5, 6), ("-7", SIZE - 7, SIZE), (f"{SIZE - 3}-{SIZE + 9}", SIZE - 3, SIZE)):
            some = client.get(url, headers={"range": f"bytes={asked}"})
            assert (some.status_code, some.content) == (206, content[start:stop]), asked
            assert some.headers["content-range"] == f"bytes {start}-{stop - 1}/{SIZE}"
        assert client.head(url, headers={"range": "bytes=0-9"}).headers["content-length"] == "10"
        assert read_bytes_of(served.process) - before < 1 << 20  # one look at the whole file is 24 times that
        several = client.get(url, headers={"range": "bytes=9-19, 0-4, 3-6, -2"})
        kind = several.headers["content-type"]
        assert several.status_code == 206 and kind.startswith("multipart/byteranges; boundary=")
        assert len(several.content) == int(several.headers["content-length"])
        parts = message_from_bytes(f"Content-Type: {kind}\r\n\r\n".encode() + several.content).get_payload()
        assert [one["content-range"] for one in parts] == [
            f"bytes {start}-{stop}/{SIZE}" for start, stop in ((0, 6), (9, 19), (SIZE - 2, SIZE - 1))
        ]
        assert [one.get_payload(decode=True) for one in parts] == [content[:7], content[9:20], content[-2:]]
        whole = client.get(url, headers={"range": "bytes=" + ",".join(f"{2 * at}-{2 * at}" for at in range(200))})
        assert (whole.status_code, whole.content) == (200, content)
        assert client.get(url, headers={"range": "bytes=0-1", "if-range": '"other"'}).content == content
        behind = client.get(url, headers={"range": f"bytes={SIZE}-"})
        assert (behind.status_code, code_of(behind)) == (416, "request.range")
        assert behind.headers["content-range"] == f"bytes */{SIZE}"
        for bad in ("bytes=", "bytes=9-5", "lines=1-2", "bytes=a-b", "bytes=-", "bytes=" + "9" * 5000 + "-"):
            refused = client.get(url, headers={"range": bad})
            assert refused.status_code in (400, 416) and code_of(refused) == "request.range", bad
        assert client.get(url, headers={"if-none-match": f'"x", "{sha256}"'}).status_code == 304


def read_bytes_of(process: int) -> int:
    """Return how many bytes a process has read so far, from whatever."""
    with open(f"/proc/{process}/io") as stream:
        return int(stream.readline().split()[1])


def test_an_archive_holds_every_file(served, large, settings):
    """Broken where the archive lacks a file or has other bytes."""
    job, sha256 = large
    with httpx.Client(base_url=served.url, headers=local_user(settings), timeout=60.0) as client:
        files = {one["name"]: one["sha256"] for one in client.get(f"/v1/jobs/{job}/artifacts").json()["files"]}
        with zipfile.ZipFile(BytesIO(client.get(f"/v1/jobs/{job}/result.zip").content)) as archive:
            found = {name: hashlib.sha256(archive.read(name)).hexdigest() for name in archive.namelist()}
    assert found == files and found["large.bin"] == sha256


def test_downloads_at_a_time(tmp_path, settings, database, store):
    """Broken where one key can hold any number of downloads, or one that it left counts for ever."""
    environment = make_environment(settings) | {"GARMENTQ_API_DOWNLOADS": "2"}
    with serving_alone(environment, tmp_path / "serve.log") as served:
        ours, theirs = make_key(database, "ours", "read", "submit"), make_key(database, "admin", "admin")
        with httpx.Client(base_url=served.url, headers=ours, timeout=60.0) as client:
            job = ask(client, float(next(MARKS))).json()["job"]
            finish(settings, database, store, job, tmp_path / "out")
            add_large(database, store, job)
            url = f"/v1/jobs/{job}/artifacts/large.bin"
            with unread(served, url, ours) as one, unread(served, f"/v1/jobs/{job}/result.zip", ours) as two:
                assert one.recv(15).endswith(b" 200 OK") is two.recv(15).endswith(b" 200 OK") is True
                refused = client.get(url)
                assert (refused.status_code, code_of(refused)) == (429, "key.downloads_open")
                assert client.head(url).status_code == 200 and client.get(f"/v1/jobs/{job}").status_code == 200
                assert client.get(url, headers=theirs).status_code == 200
            wait_for(lambda: client.get(url).status_code == 200)


@pytest.mark.parametrize(
    ("name", "media"),
    [
        ("mesh.glb", "model/gltf-binary"), ("pattern.pdf", "application/pdf"), ("pattern.SVG", "image/svg+xml"),
        ("metrics.json", "application/json"), ("report.html", "text/html; charset=utf-8"),
        ("scan.ply", "application/octet-stream"), ("noend", "application/octet-stream"),
    ],
)  # fmt: skip
def test_a_file_has_its_media_type(name, media):
    """Broken where a program has to guess what it gets."""
    assert find_media_type(name) == media
