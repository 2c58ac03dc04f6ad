"""Load on the service: uploads at once and the server's memory, submitting into a long table, querying many results,
and how long a small scan waits until it is checked.

python benchmarks/service_load.py                                     # all four, about a minute and a half
python benchmarks/service_load.py submit --database postgresql        # one of uploads, submit, query, checked
"""

from __future__ import annotations

import argparse
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import numpy as np
import trimesh

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "standin"))

from garmentq.core.body.spec import BuiltinWearer
from garmentq.service.database import Database, open_database
from garmentq.service.families import cancel
from garmentq.service.jobs import find_job, read_events
from garmentq.service.keys import create_key
from garmentq.service.local_token import read_local_token
from garmentq.service.models import JobRow, MaterialRow, MetricRow, OwnerRow, PatternRow, ScanRow
from garmentq.service.query import find_jobs, parse_conditions
from garmentq.service.settings import ServiceSettings
from garmentq.service.states import ENDED
from garmentq.service.store import Store
from garmentq.service.submission import Order, submit
from garmentq.service.terms import JobTerms
from garmentq.workers.embedded import ensure_services, stop_services
from garmentq_home import make_environment
from postgres_server import PostgresServer
from sqlalchemy import insert, text

METRICS = ("surface_rms_mm.t2s", "surface_rms_mm.s2t", "hausdorff_mm", "normal_cosine", "panel_area_error")


@contextmanager
def serving(settings: ServiceSettings) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """Run `garmentq serve` with the quick stand-in for the checker of meshes, and no rate limit for the one client."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    unlimited = dict.fromkeys(("GARMENTQ_API_REQUESTS_PER_SECOND", "GARMENTQ_API_BURST"), "100000")
    environment = make_environment(settings) | unlimited | {"GARMENTQ_CHECKER": "garmentq_checker:check"}
    command = [sys.executable, "-m", "garmentq.cli.main", "serve", "--port", str(port)]
    process = subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL)
    url = f"http://127.0.0.1:{port}"
    try:
        for _ in range(200):
            try:
                httpx.get(f"{url}/healthz")
                break
            except httpx.TransportError:
                time.sleep(0.1)
        else:
            raise SystemExit("the service did not start")
        yield process, url
    finally:
        process.terminate()
        process.wait()


@contextmanager
def fresh_settings(kind: str) -> Iterator[ServiceSettings]:
    """Return settings of an empty service, on a database of its own with tables."""
    postgres = PostgresServer() if kind == "postgresql" else None
    try:
        with tempfile.TemporaryDirectory() as folder:
            settings = ServiceSettings(home=Path(folder), database_url=postgres.url if postgres else "")
            open_database(settings, is_upgraded=True).dispose()
            yield settings
    finally:
        if postgres is not None:
            postgres.end()


def peak_mb(pid: int) -> float:
    """Return the largest resident memory of a process [MB]."""
    status = Path(f"/proc/{pid}/status").read_text()
    return int(next(line for line in status.splitlines() if line.startswith("VmHWM")).split()[1]) / 1024


def mesh(seed: int, size: int) -> bytes:
    """Return a binary PLY of about a size [bytes]."""
    count = size // 12
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    points = np.random.default_rng(seed).random((count, 3), dtype=np.float32)
    return head.encode() + points.tobytes() + b"\x03" + np.array([0, 1, 2], np.int32).tobytes()


def measure_uploads(settings: ServiceSettings, count: int = 50, size: int = 20 * 10**6) -> None:
    """Send many files at once."""
    with serving(settings) as (process, url):
        idle = peak_mb(process.pid)
        answers: list[int] = []
        base = mesh(0, size)

        headers = {"authorization": f"Bearer {read_local_token(settings.home)}"}

        def send(index: int) -> None:
            content = base[:-20] + index.to_bytes(7, "little") + base[-13:]
            answer = httpx.post(f"{url}/v1/scans?name={index}.ply", content=content, headers=headers, timeout=300)
            answers.append(answer.status_code)

        threads = [threading.Thread(target=send, args=(index,)) for index in range(count)]
        begun = time.monotonic()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        seconds = time.monotonic() - begun
        print(f"{count} uploads of {size / 1e6:.0f} MB at once: {answers.count(201)} kept in {seconds:.1f} s, "
              f"peak {peak_mb(process.pid):.0f} MB (idle {idle:.0f} MB)")  # fmt: skip


def fill(database: Database, count: int, state: str) -> None:
    """Add jobs, ended ones with metrics."""
    rng = np.random.default_rng(0)
    with database.write() as session:
        session.execute(
            insert(ScanRow), [{"sha256": "0" * 64, "name": "s.ply", "size": 1, "created": 0.0, "details": {}}]
        )
        fabric = dict.fromkeys(("H00", "H01", "H11", "H22", "k", "density", "thickness", "friction"), 1.0)
        session.execute(insert(MaterialRow), [{"id": "m", "name": "denim", "title": "", "sources": [], **fabric}])
        request = {"settings": {"method": "deform", "preset": "default"}}
        for begin in range(0, count, 5000):
            ids = [f"{index:012x}" for index in range(begin, min(begin + 5000, count))]
            session.execute(insert(JobRow), [
                {"id": i, "dedup": i, "scan": "0" * 64, "name": "s", "request": request, "version": "0", "priority": 0,
                 "state": state, "cancel": False, "attempts": 1, "fence": 1, "touched": 0.0,
                 "created": float(int(i, 16)),
                 "stage": "", "progress": 1.0, "bad_input": False,
                 "finished": float(int(i, 16)) if state == "succeeded" else None} for i in ids
            ])  # fmt: skip
            if state == "succeeded":
                names = ("skirt", "tshirt", "trousers", "dress")
                session.execute(insert(PatternRow), [
                    {"job": i, "name": "p", "category": names[int(i, 16) % 4], "template": "t",
                     "material": "m", "seams": 1}
                    for i in ids
                ])  # fmt: skip
                values = rng.random((len(ids), len(METRICS))) * 10
                session.execute(insert(MetricRow), [
                    {"job": i, "name": name, "value": float(values[row, column])}
                    for row, i in enumerate(ids) for column, name in enumerate(METRICS)
                ])  # fmt: skip


def measure_submit(settings: ServiceSettings, table: int = 10_000, count: int = 300) -> None:
    """Ask for new jobs while the table is long, in this process and over HTTP, by a key that owns all that are there.

    In this process: `submit()`, from the call to the end of its transaction. Over HTTP: POST /v1/jobs, from the first
    byte sent to the last received: key, quota, copy of the scan, names and body, and the same `submit()`. The mesh is
    10 kB and was uploaded before; parsing it in a process of its own is the checker's, and is not in here.
    """
    body = "builtin:female,height=1.70"
    database, store = open_database(settings), Store(settings.store_path)
    fill(database, table, "queued")
    key, token = create_key(database, "load", ("read", "submit"), quota=1_000_000)
    with database.write() as session:
        session.execute(insert(OwnerRow), [{"key": key.id, "job": f"{index:012x}"} for index in range(table)])
    content, path = mesh(1, 10_000), settings.home / "a.ply"
    path.write_bytes(content)
    order = Order(path, body, terms=JobTerms(force=True, key=key.id, quota=1_000_000))
    show(f"submit(), {table} jobs in the table", lambda: submit(database, store, order), count)
    with (
        serving(settings) as (_, url),
        httpx.Client(base_url=url, timeout=60, headers={"authorization": f"Bearer {token}"}) as client,
    ):
        scan = client.post("/v1/scans", params={"name": "a.ply"}, content=content).json()["sha256"]

        def ask() -> None:
            answer = client.post("/v1/jobs", json={"scan": scan, "body": body, "force": True})
            if answer.status_code != 202:
                raise SystemExit(f"not taken: {answer.status_code} {answer.text}")

        show(f"POST /v1/jobs, {table} jobs in the table", ask, count)
    database.dispose()


def show(what: str, ask: Callable[[], object], count: int) -> None:
    """Time one thing many times; the first few, which import and compile, do not count."""
    times = []
    for _ in range(count + 5):
        begun = time.monotonic()
        ask()
        times.append(time.monotonic() - begun)
    low, high = np.percentile(np.array(times[5:]) * 1000, [50, 95])
    print(f"{what}: median {low:.0f} ms, 95th percentile {high:.0f} ms")


def measure_query(settings: ServiceSettings, count: int = 100_000) -> None:
    """Find jobs among many by the conditions of docs/reference/cli.md, and print how long each search takes."""
    database = open_database(settings)
    fill(database, count, "succeeded")
    if settings.database_url:  # PostgreSQL does so by itself within a minute, and results do not come all at once
        with database.write() as session:
            session.execute(text("analyze"))
    for where, sort in (
        ("", "-created"), ("garment = skirt", "-created"), ("surface_rms_mm.t2s < 4", "-created"),
        ("surface_rms_mm.t2s < 0.01", "surface_rms_mm.t2s"), ("surface_rms_mm.t2s < 4", "surface_rms_mm.t2s"),
        ("garment = skirt and surface_rms_mm.t2s < 4 and hausdorff_mm < 5", "-created"), ("", "hausdorff_mm"),
    ):  # fmt: skip
        times = []
        for _ in range(5):
            begun = time.monotonic()
            found = find_jobs(database, parse_conditions(where) if where else [], sort)
            times.append(1000 * (time.monotonic() - begun))
        print(f"query over {count}: {where or 'all'!r} by {sort}: {len(found)} jobs in {np.median(times):.0f} ms")
    database.dispose()


def measure_checked(settings: ServiceSettings, count: int = 12) -> None:
    """Submit a scan of 1600 triangles to an idle worker, one at a time, and wait until the first stage has ended.

    Counted from the job's `queued` and from its `started`; the files are read by the shipped checker in a process
    of its own. The recovery that would follow is cancelled.
    """
    shape = trimesh.creation.cylinder(0.3, 0.6, sections=200).subdivide()
    tube = shape.submesh([np.abs(shape.face_normals[:, 2]) < 0.5], append=True)
    database, store = open_database(settings), Store(settings.store_path)
    os.environ.update(make_environment(settings))
    ensure_services(settings, workers=1)
    seconds: dict[str, list[float]] = {"queued": [], "started": []}
    try:
        for index in range(count + 2):
            path = settings.home / f"{index}.ply"
            trimesh.Trimesh(tube.vertices + 1e-3 * index, tube.faces).export(path)
            job = submit(database, store, Order(path, BuiltinWearer("builtin:female,height=1.70"))).job
            while find_job(database, job).checked is None:
                time.sleep(0.005)
            end = time.time()
            cancel(database, job)
            while find_job(database, job).state not in ENDED:
                time.sleep(0.05)
            for event in read_events(database, job):
                if event.kind in seconds and index >= 2:  # the first ones import and compile
                    seconds[event.kind].append(end - event.at)
    finally:
        stop_services(settings)
        database.dispose()
    for kind, values in seconds.items():
        print(f"{len(tube.faces)} triangles, {kind} to checked: median {np.median(values):.2f} s, "
              f"at most {max(values):.2f} s of {len(values)}")  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parts = {"uploads": measure_uploads, "submit": measure_submit, "query": measure_query, "checked": measure_checked}
    parser.add_argument("parts", nargs="*", metavar="PART", default=[*parts], help=f"some of {', '.join(parts)}")
    parser.add_argument("--database", choices=["sqlite", "postgresql"], default="sqlite")
    given = parser.parse_args()
    for part in given.parts:
        with fresh_settings(given.database) as chosen:
            print(f"{given.database}:", flush=True)
            parts[part](chosen)
