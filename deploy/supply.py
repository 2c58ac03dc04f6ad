"""What production is made of: a lock file with hashes from pip's report, and a list of its packages (CycloneDX).

The list is of an environment as the Dockerfile makes it: what `prune.py` takes out of a package is a property of it.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from prune import REMOVED

HEAD = """# Made by `make lock` for Linux x86_64 and Python 3.11. torch comes apart: which of its builds is right
# depends on the machine, and each has another hash. It is taken from the index of that build alone:
#   pip install --no-deps --index-url https://download.pytorch.org/whl/cpu TORCH
#   pip install --require-hashes --no-deps -r requirements.lock && pip install --no-deps .
# What prints its hash:
#   pip download --no-deps --index-url https://download.pytorch.org/whl/cpu TORCH && pip hash torch-*.whl
"""
APART = "torch"
PACKAGES = {"libigl": "igl"}
"""Folders of packages that are called otherwise than their wheels, of those that parts are removed of."""
LINE = re.compile(r"(?P<name>[A-Za-z0-9._-]+)==(?P<version>[^ ]+) --hash=sha256:(?P<hash>[0-9a-f]{64})")


def write_lock(report: dict[str, Any]) -> str:
    """Return a lock file: each package of pip's report by name, version and hash, but the project itself and torch."""
    lines, head = [], HEAD
    for one in report["install"]:
        name = re.sub(r"[-_.]+", "-", one["metadata"]["name"]).lower()
        if name == "garmentq":
            continue
        if name == APART:
            head = HEAD.replace("TORCH", f"{name}=={one['metadata']['version'].split('+')[0]}")
            continue
        digest = one["download_info"]["archive_info"]["hashes"]["sha256"]
        lines.append(f"{name}=={one['metadata']['version']} --hash=sha256:{digest}")
    return head + "\n".join(sorted(lines)) + "\n"


def write_list(lock: str) -> str:
    """Return the packages of a lock file as CycloneDX 1.5 JSON; the same lock gives the same list."""
    components = [
        {
            "type": "library",
            "name": found["name"],
            "version": found["version"],
            "purl": f"pkg:pypi/{found['name']}@{found['version']}",
            "hashes": [{"alg": "SHA-256", "content": found["hash"]}],
        }
        | _describe_removed(found["name"])
        for found in LINE.finditer(lock)
    ]
    if apart := re.search(rf"{APART}==([0-9.]+)", lock):
        purl = f"pkg:pypi/{APART}@{apart[1]}"
        components.append({"type": "library", "name": APART, "version": apart[1], "purl": purl})
    listed = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1, "components": components}
    return json.dumps(listed, indent=1)


def _describe_removed(name: str) -> dict[str, Any]:
    folders = REMOVED.get(PACKAGES.get(name, name), ())
    properties = [{"name": "garmentq:removed", "value": f"{PACKAGES.get(name, name)}/{folder}"} for folder in folders]
    return {"properties": properties} if properties else {}


if __name__ == "__main__":
    what, source = sys.argv[1], Path(sys.argv[2]).read_text(encoding="utf-8")
    sys.stdout.write(write_lock(json.loads(source)) if what == "lock" else write_list(source))
