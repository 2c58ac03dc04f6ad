"""The ten lines of Python in the reference, run against a real service."""

from __future__ import annotations

import os
import re
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import httpx
import pytest
from garmentq_home import wait_for
from patience import WAIT_SECONDS

ROOT = Path(__file__).parents[2]


def is_served(url: str) -> bool:
    """Return whether a service answers."""
    try:
        return httpx.get(f"{url}/healthz").is_success
    except httpx.HTTPError:
        return False


@pytest.mark.nightly  # a preview of a T-shirt: 20 s of CPU
def test_the_ten_lines_do_what_they_say(tmp_path):
    """Broken where a name in the reference is not the client's, or a preview has no pattern, mesh or metric."""
    page = (ROOT / "docs" / "reference" / "python.md").read_text()
    (block,) = re.findall(r"## In ten lines.*?```python\n(.*?)```", page, re.DOTALL)
    assert len([line for line in block.splitlines() if line.strip()]) <= 10
    for name, own in (("garment.ply", "scan.ply"), ("body.ply", "body.ply")):
        shutil.copy(ROOT / "examples" / "data" / name, tmp_path / own)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    environment = os.environ | {"GARMENTQ_HOME": str(tmp_path / "home")}
    command = [sys.executable, "-m", "garmentq.cli.main", "up", "--serve", "--workers", "1", "--port", str(port)]
    with (tmp_path / "up.log").open("w") as log:
        service = subprocess.Popen(command, env=environment, stdout=log, stderr=log)
    try:
        wait_for(lambda: is_served(f"http://127.0.0.1:{port}"))
        lines = block.replace(":8080", f":{port}")
        done = subprocess.run(
            [sys.executable, "-c", lines], env=environment, cwd=tmp_path, capture_output=True, text=True,
            timeout=WAIT_SECONDS, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
    finally:
        service.terminate()
        service.wait(timeout=WAIT_SECONDS)
    names = [line.split()[0] for line in done.stdout.splitlines()[:-2]]
    assert {"front", "back"} <= set(names), done.stdout
    assert (tmp_path / "result" / "pattern.json").is_file() and (tmp_path / "result" / "detail.ply").is_file()
