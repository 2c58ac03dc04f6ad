"""Media types of downloaded files by the end of their names; every file is an attachment, so a browser runs none."""

from __future__ import annotations

BYTES = "application/octet-stream"
"""Media type of all other files."""

MEDIA_TYPES = {
    ".csv": "text/csv; charset=utf-8", ".dxf": "image/vnd.dxf", ".gif": "image/gif",
    ".glb": "model/gltf-binary", ".html": "text/html; charset=utf-8", ".jpg": "image/jpeg",
    ".json": "application/json", ".mtl": "model/mtl", ".obj": "model/obj", ".pdf": "application/pdf",
    ".png": "image/png", ".stl": "model/stl", ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8", ".usda": "model/vnd.usda", ".usdz": "model/vnd.usdz+zip",
    ".webp": "image/webp", ".zip": "application/zip",
}  # fmt: skip
"""Types of the IANA registry; formats without one, such as PLY, are bytes."""


def find_media_type(name: str) -> str:
    """Return the media type of a file."""
    return MEDIA_TYPES.get(f".{name.rpartition('.')[2].lower()}", BYTES)
