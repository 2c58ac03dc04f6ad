"""Hostile files and connections against a running service with the shipped limits: memory, /healthz of others, answers.

python benchmarks/hostile_load.py bombs      # files that are small to send and large to read; about 4 minutes
python benchmarks/hostile_load.py mutated --count 2000 --seed 7 --minutes 20
python benchmarks/hostile_load.py silent     # 5000 silent connections and 200 that drip, from 127.0.0.2
python benchmarks/hostile_load.py checks     # 45 checks at once of a pattern of 2000 edges, by one key that may read

API, broker and worker are those of `garmentq up --serve`. Files are checked as in production; a job whose files pass is
ended by the stand-in for the recovery. `mutated` hands in every file and lets the worker read them for some minutes.
"""

from __future__ import annotations

import argparse
import http.client
import io
import json
import resource
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import httpx
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "standin"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "scan"))

from garmentq.service.database import open_database
from garmentq.service.keys import create_key
from garmentq.service.local_token import read_local_token
from garmentq.service.settings import ServiceSettings
from garmentq.workers.broker import run_folder
from garmentq_home import make_environment
from test_mutated_files import make_files, mutate

BODY = "builtin:female,height=1.70"
ENDED = ("succeeded", "failed", "dead", "cancelled")
PERIOD_SECONDS = 0.2
KEYS = {"greedy": ("read",), "other": ("read", "submit")}
"""Scopes of the keys of `measure_checks`."""


class Watcher:
    """Ask /healthz again and again, and note the largest memory of the API and of what its worker starts."""

    def __init__(self, url: str, api: int, worker: int) -> None:
        self.host, self.port = httpx.URL(url).host, httpx.URL(url).port
        self.api, self.worker = api, worker
        self.slowest, self.failed, self.asked, self.children_mb = 0.0, 0, 0, 0.0
        self._ended = threading.Event()
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._ask, self._measure)]

    def __enter__(self) -> Watcher:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        for thread in self._threads:
            thread.join()

    def _ask(self) -> None:
        while not self._ended.wait(PERIOD_SECONDS):
            begun = time.monotonic()
            connection = http.client.HTTPConnection(self.host, self.port, timeout=60)
            try:
                connection.request("GET", "/healthz")
                self.failed += connection.getresponse().status != 200
            except OSError:
                self.failed += 1
            finally:
                connection.close()
            self.asked += 1
            self.slowest = max(self.slowest, time.monotonic() - begun)

    def _measure(self) -> None:
        while not self._ended.wait(PERIOD_SECONDS):
            self.children_mb = max([self.children_mb, *(read_mb(pid) for pid in list_below(self.worker))])

    def tell(self) -> str:
        """Return the figures since the last time."""
        told = (
            f"/healthz asked {self.asked} times, failed {self.failed}, slowest {self.slowest:.2f} s; "
            f"API {read_mb(self.api):.0f} MB, largest process of the worker {self.children_mb:.0f} MB"
        )
        self.slowest, self.failed, self.asked, self.children_mb = 0.0, 0, 0, 0.0
        return told


def read_mb(pid: int) -> float:
    """Return the largest resident memory that a process had [MB]; 0 where it is gone."""
    with suppress(OSError, StopIteration):
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
        return int(next(line for line in lines if line.startswith("VmHWM")).split()[1]) / 1024
    return 0.0


def list_below(pid: int) -> list[int]:
    """List a process and all that it and its children started."""
    found, level = [], [pid]
    while level:
        found += level
        below: list[int] = []
        for one in level:
            with suppress(OSError):
                for task in Path(f"/proc/{one}/task").iterdir():
                    below += [int(child) for child in (task / "children").read_text().split()]
        level = below
    return found


@contextmanager
def serving() -> Iterator[tuple[httpx.Client, Watcher, Path]]:
    """Run a service with one worker; give a client of it, what watches it, and its home."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        quick = {"pipeline": "garmentq_standin:recover", "writer": "garmentq_standin:write"}
        settings = ServiceSettings(home=Path(folder), **quick)
        environment = make_environment(settings) | {"GARMENTQ_API_REQUESTS_PER_SECOND": "100000"}
        command = [sys.executable, "-m", "garmentq.cli.main", "up", "--serve", "--workers", "2", "--port", str(port)]
        with (settings.home / "api.log").open("wb") as log:
            process = subprocess.Popen(command, env=environment, stderr=log)
        url = f"http://127.0.0.1:{port}"
        try:
            wait_for(lambda: answers(url))
            worker = int((run_folder(settings) / "worker.pid").read_text())
            token = {"authorization": f"Bearer {read_local_token(settings.home)}"}
            with (
                httpx.Client(base_url=url, headers=token, timeout=300) as client,
                Watcher(url, process.pid, worker) as watcher,
            ):
                yield client, watcher, settings.home
        finally:
            process.send_signal(signal.SIGINT)
            process.wait()


def wait_for(check: Callable[[], object]) -> None:
    """Wait until something is true."""
    while not check():
        time.sleep(0.2)


def answers(url: str) -> bool:
    """Return whether a service answers."""
    try:
        return httpx.get(f"{url}/healthz").status_code == 200
    except httpx.TransportError:
        return False


def zip_of(write: Callable[[zipfile.ZipFile], None]) -> bytes:
    """Return a .zip that a function fills."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        write(archive)
    return out.getvalue()


def write_zeros(archive: zipfile.ZipFile, name: str, dtype: str, shape: tuple[int, ...]) -> None:
    """Add an array of zeros."""
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": dtype, "fortran_order": False, "shape": shape})
    size, block = int(np.prod(shape)) * np.dtype(dtype).itemsize, b"\0" * (1 << 24)
    with archive.open(f"{name}.npy", "w", force_zip64=True) as out:
        out.write(head.getvalue())
        for at in range(0, size, len(block)):
            out.write(block[: size - at])


def many_entries(archive: zipfile.ZipFile) -> None:
    """Add a million empty entries."""
    for number in range(1_000_000):
        archive.writestr(f"{number}", b"")


def tube(columns: int, rows: int) -> bytes:
    """Return a binary PLY of an open tube."""
    angle, y = np.meshgrid(np.linspace(0, 2 * np.pi, columns, endpoint=False), np.linspace(0.8, 1.1, rows))
    points = np.stack([0.2 * np.sin(angle), y, 0.2 * np.cos(angle)], axis=2).reshape(-1, 3).astype("<f4")
    here = np.arange(columns * rows).reshape(rows, columns)
    a, b, c, d = here[:-1], np.roll(here, -1, 1)[:-1], here[1:], np.roll(here, -1, 1)[1:]
    faces = np.concatenate([np.stack(one, axis=2).reshape(-1, 3) for one in ((a, b, c), (b, d, c))])
    table = np.zeros(len(faces), [("n", "u1"), ("v", "<i4", 3)])
    table["n"], table["v"] = 3, faces
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
    head += f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    return head.encode() + points.tobytes() + table.tobytes()


def many_nodes(nodes: int, faces: int) -> bytes:
    """Return a GLB in which many nodes show the same mesh."""
    points = np.random.default_rng(0).random((3 * faces, 3), dtype=np.float32).tobytes()
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(nodes))}],
        "nodes": [{"mesh": 0}] * nodes, "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3 * faces, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(points)}], "buffers": [{"byteLength": len(points)}],
    }  # fmt: skip
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    parts = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(points), 0x004E4942) + points
    return struct.pack("<III", 0x46546C67, 2, 12 + len(parts)) + parts


def make_bombs() -> Iterator[tuple[str, str, str, bytes]]:
    """Yield what each file is, what it is handed in as, its name and its bytes."""
    for rows in (4, 8):
        content = zip_of(lambda archive, rows=rows: write_zeros(archive, "labels", "<U64", (rows * 10**6,)))
        yield f"labels.npz, <U64, {rows} M rows", "labels", "labels.npz", content
    for count in (20, 60):

        def arrays(archive: zipfile.ZipFile, count: int = count) -> None:
            for number in range(10):
                write_zeros(archive, f"a{number}", "<f8", (count * 10**6,))

        content = zip_of(arrays)
        yield f"npz, 10 arrays of {count} M doubles, as labels", "labels", "labels.npz", content
        yield f"npz, 10 arrays of {count} M doubles, as body", "body", "body.npz", content
    yield "labels.json, 10 M empty lists", "labels", "labels.json", b"[" + b",".join([b"[]"] * 10**7) + b"]"
    yield "labels.npz, 1 M directory entries", "labels", "labels.npz", zip_of(many_entries)
    yield "labels.txt, 10 M words", "labels", "labels.txt", b"ab " * 10**7
    yield "PLY tube of 2 M faces", "scan", "tube.ply", tube(2000, 501)
    yield "GLB, 300 triangles in 20 000 nodes", "scan", "nodes.glb", many_nodes(20_000, 300)


def measure_bombs(_: argparse.Namespace) -> None:
    """Hand in one file after the other and wait for the job's end."""
    bombs = list(make_bombs())  # before anything is timed: this process would not ask in time while it makes them
    with serving() as (client, watcher, home):
        sound = client.post("/v1/scans?name=sound.ply", content=tube(40, 20)).json()["sha256"]
        print(f"begin: {watcher.tell()}", flush=True)
        for what, used, name, content in bombs:
            wanted = {"scan": sound, "body": BODY, "as": "garment", "force": True}
            route = "scans" if used == "scan" else "labels"
            answer = client.post(f"/v1/{route}", params={"name": name}, content=content)
            end = f"upload {answer.status_code} {answer.json().get('code', '')}"
            if answer.status_code == 201:
                answer = client.post("/v1/jobs", json=wanted | {used: answer.json()["sha256"]})
                end = f"job {answer.status_code} {answer.json().get('code', '')}"
            if answer.status_code == 202:
                job, begun = answer.json()["job"], time.monotonic()
                wait_for(lambda job=job: client.get(f"/v1/jobs/{job}").json()["state"] in ENDED)
                found = client.get(f"/v1/jobs/{job}").json()
                end = f"{found['state']} {(found['error'] or {}).get('code', '')} {time.monotonic() - begun:.0f} s"
            print(f"{what} ({len(content) / 1e6:.1f} MB): {end}; {watcher.tell()}", flush=True)
        print_logs(home)


def measure_mutated(given: argparse.Namespace) -> None:
    """Hand in mutated files of every kind, and ask for a job with each."""
    files = sorted(make_files().items())
    routes = {"labels": "labels", "pattern": "patterns", "body": "bodies", "keys": "motions", "walk": "motions"}
    fields = {"labels": "labels", "patterns": "pattern", "bodies": "body", "scans": "scan"}
    answered: Counter[str] = Counter()
    jobs: list[str] = []
    with serving() as (client, watcher, home):
        sound = client.post("/v1/scans?name=sound.ply", content=tube(40, 20)).json()["sha256"]
        for seed in range(given.seed, given.seed + given.count):
            name, content = files[seed % len(files)]
            route = routes.get(name.split(".")[0], "scans")
            content = mutate(content, np.random.default_rng(seed))
            answer = client.post(f"/v1/{route}", params={"name": name}, content=content)
            answered[f"upload {answer.status_code}"] += 1
            if answer.status_code != 201 or route not in fields:
                continue
            wanted = {"scan": sound, "body": BODY, "as": "garment", "force": True}
            answer = client.post("/v1/jobs", json=wanted | {fields[route]: answer.json()["sha256"]})
            answered[f"job {answer.status_code}"] += 1
            jobs += [answer.json()["job"]] if answer.status_code == 202 else []
        print(f"{given.count} files, seed {given.seed}: {dict(sorted(answered.items()))}", flush=True)
        until = time.monotonic() + 60 * given.minutes
        counts: dict[str, int] = {}
        while time.monotonic() < until:
            counts = client.get("/v1/queue").json()["states"]
            if not counts.get("queued") and not counts.get("running"):
                break
            time.sleep(5)
        codes: Counter[str] = Counter()
        for start in range(0, len(jobs), 1000):
            for job in client.post("/v1/jobs/states", json={"jobs": jobs[start : start + 1000]}).json()["jobs"]:
                codes[job["error"]["code"] if job["error"] else job["state"]] += 1
        print(f"jobs: {counts}; {dict(codes.most_common())}\n{watcher.tell()}", flush=True)
        print_logs(home)


def print_logs(home: Path) -> None:
    """Print how many tracebacks API and worker wrote, and the last lines of the first."""
    for name in ("api.log", "worker.log"):
        text = (home / name).read_text(errors="replace")
        print(f"{name}: {text.count('Traceback')} tracebacks, {text.count('CRITICAL')} critical")
        if "Traceback" in text:
            print(text[text.index("Traceback") :][:1500])


def measure_silent(_: argparse.Namespace) -> None:
    """Open connections that say nothing, or a byte every 5 s, from 127.0.0.2, and ask from 127.0.0.1."""
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    with serving() as (client, watcher, _):
        port = client.base_url.port
        held: list[socket.socket] = []
        begun, opened = time.monotonic(), 0
        for _ in range(5200):
            one = socket.socket()
            one.bind(("127.0.0.2", 0))
            one.setblocking(False)
            with suppress(BlockingIOError):
                one.connect(("127.0.0.1", port))
            held.append(one)
            opened += 1
            time.sleep(0.002)
        print(f"{opened} connections in {time.monotonic() - begun:.0f} s; {watcher.tell()}", flush=True)
        for letter in b"GET / HTTP/1.1":
            for one in held[:200]:
                with suppress(OSError):
                    one.send(bytes([letter]))
            time.sleep(5)
        print(f"200 of them dripped for 70 s; {watcher.tell()}")
        for one in held:
            one.close()


def draw_circle(count: int) -> dict[str, object]:
    """Return a document of one round panel."""
    angle = 2 * np.pi * np.arange(count) / count
    vertices = (30 * np.stack([np.cos(angle), np.sin(angle)], axis=1)).tolist()
    panel = {"vertices": vertices, "edges": [{"endpoints": [i, (i + 1) % count]} for i in range(count)]}
    return {"pattern": {"panels": {"front": panel}, "stitches": []}, "properties": {"units_in_meter": 100}}


def measure_checks(_: argparse.Namespace) -> None:
    """Ask for 45 checks at once by one key, and meanwhile for other pages by another."""
    with serving() as (client, watcher, home):
        database = open_database(ServiceSettings(home=home))
        made = [create_key(database, name, scopes, 100)[1] for name, scopes in KEYS.items()]
        keys = [{"authorization": f"Bearer {token}"} for token in made]
        url, document, answered = str(client.base_url), draw_circle(1990), Counter[str]()
        most = [0, 0.0]

        def check() -> None:
            try:
                answer = httpx.post(f"{url}/v1/patterns/check", json=document, headers=keys[0], timeout=120)
                answered[f"{answer.status_code} {answer.json().get('code', '')}"] += 1
            except httpx.HTTPError as error:
                answered[type(error).__name__] += 1

        askers = [threading.Thread(target=check) for _ in range(45)]
        for asker in askers:
            asker.start()
        slowest = dict.fromkeys(("/healthz", "/readyz", "/v1/jobs", "/signin"), 0.0)
        while any(asker.is_alive() for asker in askers):
            for path in slowest:
                begun = time.monotonic()
                with suppress(httpx.TimeoutException):
                    httpx.get(url + path, headers=keys[1], timeout=10)
                slowest[path] = max(slowest[path], time.monotonic() - begun)
            below = set(list_below(watcher.api)) - set(list_below(watcher.worker))
            children = [pid for pid in below if b"core.run.sandbox" in read_command(pid)]
            most = [max(most[0], len(children)), max(most[1], sum(read_mb(pid) for pid in children))]
            time.sleep(PERIOD_SECONDS)
        print(f"answers {dict(answered)}; at most {most[0]} processes at a time with {most[1]:.0f} MB")
        print(f"slowest [s]: { {path: round(seconds, 2) for path, seconds in slowest.items()} }; {watcher.tell()}")
        print_logs(home)


def read_command(pid: int) -> bytes:
    """Return the command line of a process; empty where it is gone."""
    with suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    return b""


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parts = {"bombs": measure_bombs, "mutated": measure_mutated, "silent": measure_silent, "checks": measure_checks}
    parser.add_argument("part", choices=[*parts])
    parser.add_argument("--count", type=int, default=2000, help="mutated files")
    parser.add_argument("--seed", type=int, default=7, help="of the first mutated file")
    parser.add_argument("--minutes", type=float, default=20.0, help="how long the worker reads mutated files")
    given = parser.parse_args()
    parts[given.part](given)
