"""Files and finished jobs for the tests of the API."""

from __future__ import annotations

import json

import numpy as np
from garmentq.service.jobs import claim
from garmentq.service.keys import create_key
from garmentq.service.kinds.recover import Recover
from garmentq.service.results import store_result

HEADER = "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
FACES = "element face {}\nproperty list uchar int vertex_indices\nend_header\n"


def make_ply(mark: float = 0.0) -> bytes:
    """Return a small ASCII PLY of a tetrahedron; its bytes differ by mark."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1 + mark]])
    faces = ["3 0 2 1", "3 0 1 3", "3 0 3 2", "3 1 2 3"]
    lines = [" ".join(f"{v:.6f}" for v in p) for p in points] + faces
    return (HEADER.format(4) + FACES.format(4) + "\n".join(lines) + "\n").encode()


def upload(client, mark: float = 0.0, kind: str = "scans", name: str = "skirt.ply", **options) -> str:
    """Upload a mesh and give its hash."""
    answer = client.post(f"/v1/{kind}", params={"name": name}, content=make_ply(mark), **options)
    assert answer.status_code == 201, answer.text
    return answer.json()["sha256"]


def ask(client, mark: float = 0.0, headers=None, **wanted):
    """Upload scan and body and ask for a job."""
    headers = headers or {}
    scan = upload(client, mark, headers=headers)
    body = upload(client, -0.5, "bodies", "body.ply", headers=headers)
    return client.post("/v1/jobs", json={"scan": scan, "body": body, **wanted}, headers=headers)


def finish(settings, database, store, job: str, folder) -> None:
    """End a queued job well, with two files."""
    from garmentq.core.recover.recovery import Request
    from garmentq_standin import make_recovery

    held = claim(database, job, "test", 60.0)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "pattern.svg").write_text("<svg/>" * 100)
    (folder / "metrics.txt").write_text("1")
    store_result(database, store, held, Recover(), make_recovery(Request(folder / f"{held.name}.ply"), 3.0), folder)


def make_key(database, name: str, *scopes: str, quota: int = 100) -> dict[str, str]:
    """Make a key and give its header."""
    _, token = create_key(database, name, scopes or ("read", "submit"), quota)
    return {"authorization": f"Bearer {token}"}


def code_of(answer) -> str:
    """Return a problem's code, after a look at its form."""
    assert answer.headers["content-type"] == "application/problem+json", answer.text
    found = json.loads(answer.content)
    assert found["status"] == answer.status_code and found["type"] == f"urn:garmentq:{found['code']}"
    return found["code"]
