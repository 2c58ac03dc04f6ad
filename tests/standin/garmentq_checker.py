"""A quick stand-in for the checker; it needs neither numpy nor meshes. What it does is in the scan's name.

`endless...` computes for ever, `greedy...` takes more memory than there is, `odd...` is refused with letters that no
database keeps; all else is a mesh if it begins with `ply`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from garmentq.core.run.errors import BadInput


class Refused(BadInput):
    """The file is cut off; export it again."""

    code = "scan.truncated"


def check(request: dict[str, Any], files: str) -> dict[str, Any]:
    """Refuse a file that is not a PLY."""
    name = request["scan"]["name"]
    while name.startswith("endless"):
        pass
    if name.startswith("greedy"):
        return {"size": len(bytearray(1 << 50))}
    if name.startswith("odd"):
        raise Refused("the panel 'a\x00\ud800' is cut off; export it again.")
    if not (Path(files) / "scan" / name).read_bytes().startswith(b"ply"):
        raise Refused()
    return {"scan": {"name": Path(name).stem, "units": "m"}}
