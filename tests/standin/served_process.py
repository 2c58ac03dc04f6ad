"""`garmentq serve` as a process of its own, with what it holds: memory, open files."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import httpx
from garmentq_home import wait_for


@dataclass(frozen=True)
class Served:
    """Describe a running server: its number, its port, and the file that its words go to."""

    process: int
    port: int
    log: Path

    @property
    def url(self) -> str:
        """Return its address."""
        return f"http://127.0.0.1:{self.port}"

    def count_open(self, beginning: object) -> int:
        """Return how many things it holds open whose name begins so: a folder, or `socket:`."""
        found = []
        for link in Path(f"/proc/{self.process}/fd").iterdir():
            with suppress(FileNotFoundError):
                found.append(os.readlink(link))
        return sum(name.startswith(str(beginning)) for name in found)

    def read_peak(self) -> int:
        """Return the most memory that it has held [bytes]."""
        lines = Path(f"/proc/{self.process}/status").read_text().splitlines()
        return next(int(line.split()[1]) << 10 for line in lines if line.startswith("VmHWM:"))


@contextmanager
def serving_alone(environment: Mapping[str, str], log: Path, umask: int = 0o022) -> Iterator[Served]:
    """Serve the home of an environment on a free port for the block."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "garmentq.cli.main", "serve", "--port", str(port)]
    with log.open("wb") as out:
        process = subprocess.Popen(command, env=environment, stdout=out, stderr=out, umask=umask)
    served = Served(process.pid, port, log)

    def answers() -> bool:
        assert process.poll() is None, log.read_text()
        try:
            return httpx.get(f"{served.url}/healthz").status_code == 200
        except httpx.TransportError:
            return False

    try:
        wait_for(answers)
        yield served
    finally:
        process.terminate()
        process.wait(30)
