"""What bad files and requests cost: CPU and wall time of the service (a job that its worker refuses is a 202 here), and
of `garmentq run` on the same file, whose worker refuses it.

python benchmarks/hostile_input.py           # a table in Markdown, about a minute on an idle machine
"""

from __future__ import annotations

import http.client
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import httpx
from garmentq.service.database import open_database
from garmentq.service.keys import create_key
from garmentq.service.settings import ServiceSettings

TESTS = Path(__file__).parents[1] / "tests"
sys.path[:0] = [str(TESTS / "standin"), str(TESTS / "api")]

from api_work import make_ply  # noqa: E402
from bad_files import FILES, PICKLES  # noqa: E402

LIMITS = {"GARMENTQ_API_UPLOAD_BYTES": "1048576", "GARMENTQ_API_CHUNK_SECONDS": "1"}
"""Small, so that going beyond them does not take the time of sending 512 MiB, or of falling silent for 30 s."""

TICK = os.sysconf("SC_CLK_TCK")


class Service:
    """Run `garmentq serve` and ask it."""

    def __init__(self, home: Path) -> None:
        """Start it with two keys."""
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        database = open_database(ServiceSettings(home=home))
        self.keys = [create_key(database, name, ("read", "submit"))[1] for name in ("ours", "theirs")]
        database.dispose()
        command = [sys.executable, "-m", "garmentq.cli.main", "serve", "--home", str(home), "--port", str(self.port)]
        self.process = subprocess.Popen(command, env={**os.environ, **LIMITS})
        headers = {"authorization": f"Bearer {self.keys[0]}"}
        self.client = httpx.Client(base_url=f"http://127.0.0.1:{self.port}", headers=headers, timeout=60.0)
        while not self.is_alive():
            time.sleep(0.1)

    def is_alive(self) -> bool:
        """Return whether it answers."""
        try:
            return self.client.get("/healthz").status_code == 200
        except httpx.TransportError:
            return False

    def cpu_seconds(self) -> float:
        """Return the CPU time of the process and of the parsers that have ended [s]."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return sum(map(int, fields[11:15])) / TICK

    def peak_mb(self) -> float:
        """Return the largest resident memory [MB]."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(next(line for line in status.splitlines() if line.startswith("VmHWM")).split()[1]) / 1024

    def upload(self, name: str, content: bytes, kind: str = "scans") -> httpx.Response:
        """Send a file."""
        return self.client.post(f"/v1/{kind}", params={"name": name}, content=content)

    def ask(self, name: str, content: bytes, **more: object) -> httpx.Response:
        """Send a scan and ask for a job with it."""
        answer = self.upload(name, content)
        return (
            self.client.post("/v1/jobs", json={"scan": answer.json()["sha256"], **more})
            if answer.is_success
            else answer
        )

    def raw(self, path: str) -> httpx.Response:
        """Ask for a path as it is written."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        connection.request("GET", path, headers={"authorization": f"Bearer {self.keys[0]}"})
        answer = connection.getresponse()
        found = httpx.Response(answer.status, content=answer.read())
        connection.close()
        return found

    def fall_silent(self) -> httpx.Response:
        """Begin an upload and send no more."""
        head = f"POST /v1/scans?name=a.ply HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {self.keys[0]}\r\n"
        with socket.create_connection(("127.0.0.1", self.port), timeout=60) as slow:
            slow.sendall(f"{head}Content-Length: 1000\r\nConnection: close\r\n\r\nply\n".encode())
            text = b"".join(iter(lambda: slow.recv(65536), b""))
        return httpx.Response(int(text.split()[1]), content=text.split(b"\r\n\r\n", 1)[1])


def list_requests(service: Service) -> dict[str, Callable[[], httpx.Response]]:
    """Name the bad files and requests."""
    body = service.upload("body.ply", make_ply(-0.5), "bodies").json()["sha256"]
    job = service.ask("good.ply", make_ply(), body=body).json()["job"]
    big = b"x" * (1 << 20) + b"x"
    pieces = [big[at : at + 65536] for at in range(0, len(big), 65536)]
    theirs = {"authorization": f"Bearer {service.keys[1]}"}

    def ask_labels(name: str, content: bytes) -> httpx.Response:
        labels = service.upload(name, content, "labels").json()["sha256"]
        return service.ask("good.ply", make_ply(), labels=labels, settings={"keep": "1"})

    found: dict[str, Callable[[], httpx.Response]] = {
        name: lambda name=name, content=content: service.ask(name, content, body=body)
        for name, content in FILES.items()
    }
    found |= {
        f"labels: {name}": lambda name=name, content=content: ask_labels(name, content)
        for name, content in PICKLES.items()
    }
    return found | {
        "artifact ../../secret": lambda: service.raw(f"/v1/jobs/{job}/artifacts/../../secret"),
        "template ..%2f..%2fsecret": lambda: service.raw("/v1/templates/..%2f..%2fsecret"),
        "body ../../secret": lambda: service.ask("good.ply", make_ply(), body="../../secret"),
        "1 MiB + 1, length told": lambda: service.upload("a.ply", big),
        "1 MiB + 1, length untold": lambda: service.client.post("/v1/scans?name=a.ply", content=iter(pieces)),
        "silent after 4 bytes (limit 1 s)": service.fall_silent,
        "another key's job": lambda: service.client.get(f"/v1/jobs/{job}", headers=theirs),
        "60 000 brackets": lambda: service.client.post(
            "/v1/jobs", content=b"[" * 60_000, headers={"content-type": "application/json"}
        ),
        "id of terminal escapes": lambda: service.raw("/v1/jobs/%1b[31m<script>"),
    }


def run_command(name: str, content: bytes, folder: Path) -> tuple[float, float, int, str]:
    """Return CPU and wall time [s], exit status and code of `garmentq run` on a file."""
    path, body = folder / name, folder / "body.ply"
    path.write_bytes(content)
    body.write_bytes(make_ply(-0.5))
    command = [sys.executable, "-m", "garmentq.cli.main", "run", str(path), "--body", str(body)]
    begun = time.monotonic()
    process = subprocess.Popen([*command, "--home", str(folder / "home")], stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    told = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    seconds = time.monotonic() - begun
    code = told.strip().splitlines()[-1].split(":")[0].removeprefix("error ")
    return usage.ru_utime + usage.ru_stime, seconds, process.returncode, code


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        service = Service(Path(folder) / "served")
        print("| file or request | status | code | service CPU s | wall s | `garmentq run` | CPU s | wall s |")
        print("|---|---|---|---|---|---|---|---|")
        for name, ask in list_requests(service).items():
            cpu, begun = service.cpu_seconds(), time.monotonic()
            answer = ask()
            seconds, cpu = time.monotonic() - begun, service.cpu_seconds() - cpu
            try:
                code = answer.json().get("code", "-")
            except ValueError:
                code = "-"
            row = f"| {name} | {answer.status_code} | {code} | {cpu:.2f} | {seconds:.2f} |"
            if name in FILES:
                cpu, seconds, status, code = run_command(name, FILES[name], Path(folder))
                row += f" {status} {code} | {cpu:.2f} | {seconds:.2f} |"
            else:
                row += " | | |"
            print(row, flush=True)
        assert service.is_alive() and service.process.poll() is None
        print(f"\nThe service lives; its largest resident memory was {service.peak_mb():.0f} MB.")
        service.process.terminate()
        service.process.wait()
        down = [sys.executable, "-m", "garmentq.cli.main", "down", "--home", str(Path(folder) / "home")]
        subprocess.run(down, check=True)


if __name__ == "__main__":
    main()
