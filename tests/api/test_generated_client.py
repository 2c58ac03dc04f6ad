"""A client that a stock generator makes of /openapi.json, used against a real server."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest
from api_work import make_ply
from garmentq.service.local_token import make_local_token

GENERATOR = "openapi-python-client==0.29.1"
CONFIG = "content_type_overrides:\n  application/zip: application/octet-stream\n"
"""What the generator does not know: a .zip is a file."""

SCRIPT = """
import io, json, sys
from garmentq_client import AuthenticatedClient
from garmentq_client.api.files import upload_scan
from garmentq_client.api.jobs import create_job, list_jobs, show_job
from garmentq_client.api.results import download_artifact
from garmentq_client.models import JobIn, Problem
from garmentq_client.types import File

address, token, scan = sys.argv[1:]
client = AuthenticatedClient(address, token)
kept = upload_scan.sync(client=client, body=File(io.BytesIO(open(scan, "rb").read())), name="skirt.ply")
asked = create_job.sync(client=client, body=JobIn(scan=kept.sha256, body="builtin:female,height=1.70"))
shown = show_job.sync(asked.job, client=client)
missing = show_job.sync_detailed("deadbeef0000", client=client)
refused = create_job.sync_detailed(client=client, body=JobIn(scan=kept.sha256, body="builtin:nosuch"))
wrong = list_jobs.sync_detailed(client=client, limit=0)
nothing = download_artifact.sync_detailed(asked.job, "pattern.svg", client=client)
problems = [missing, refused, wrong, nothing]
assert all(isinstance(one.parsed, Problem) for one in problems), [one.content for one in problems]
print(json.dumps({
    "job": asked.job, "state": shown.state, "is_new": asked.is_new, "name": shown.name,
    "problems": [[one.status_code, one.parsed.code, one.parsed.detail] for one in problems],
}))
"""


@pytest.mark.nightly
def test_a_generated_client_reads_refusals(client, address, settings, tmp_path):
    """Broken where a generator drops a schema with a warning, or a refusal comes without its code and words."""
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "venv"], check=True)
    programs = tmp_path / "venv" / "bin"
    plain = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    options = {"env": plain, "cwd": tmp_path, "capture_output": True, "text": True, "check": False}
    done = subprocess.run([programs / "pip", "install", "-q", GENERATOR], **options)
    if done.returncode != 0:
        pytest.skip(f"pip has no {GENERATOR}: {done.stderr.strip().splitlines()[-1]}")
    (tmp_path / "openapi.json").write_text(json.dumps(client.get("/openapi.json").json()))
    (tmp_path / "config.yml").write_text(CONFIG + "post_hooks: []\n")
    made = [programs / "openapi-python-client", "generate", "--path", "openapi.json", "--config", "config.yml"]
    done = subprocess.run([*made, "--meta", "none", "--output-path", "garmentq_client", "--fail-on-warning"], **options)
    assert done.returncode == 0 and "WARNING" not in done.stdout + done.stderr, done.stdout + done.stderr
    (tmp_path / "use.py").write_text(SCRIPT)
    (tmp_path / "skirt.ply").write_bytes(make_ply())
    token = make_local_token(settings.home)
    done = subprocess.run([programs / "python", "use.py", address, token, "skirt.ply"], **options)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert client.get(f"/v1/jobs/{told['job']}").json()["state"] == told["state"] == "queued" and told["is_new"]
    assert told["name"] == "skirt"
    codes = [(status, code) for status, code, _ in told["problems"]]
    assert codes == [(404, "job.unknown"), (422, "body.spec_bad"), (422, "request.bad"), (404, "result.missing")]
    assert all(detail for *_, detail in told["problems"])
