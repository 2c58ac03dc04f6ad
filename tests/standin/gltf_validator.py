"""Khronos' validator of glTF files, where node and its package are found."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

_PROGRAM = """
const path = process.argv[1], file = process.argv[2];
require(path).validateBytes(new Uint8Array(require("fs").readFileSync(file)))
  .then(found => process.stdout.write(JSON.stringify(found.issues)));
"""


def find_validator() -> str | None:
    """Return the folder of the npm package `gltf-validator`: GARMENTQ_GLTF_VALIDATOR, or the global one; None: none."""
    node = shutil.which("node")
    if node is None:
        return None
    given = os.environ.get("GARMENTQ_GLTF_VALIDATOR")
    roots = [Path(given)] if given else [Path(node).resolve().parents[1] / "lib/node_modules/gltf-validator"]
    return next((str(root) for root in roots if (root / "package.json").is_file()), None)


def validate_glb(path: Path) -> dict[str, Any]:
    """Return what the validator finds in a file; the test is skipped where there is none."""
    package = find_validator()
    if package is None:
        pytest.skip("no gltf-validator: npm install gltf-validator, and set GARMENTQ_GLTF_VALIDATOR to its folder")
    done = subprocess.run(["node", "-e", _PROGRAM, package, str(path)], capture_output=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout)
    return found
