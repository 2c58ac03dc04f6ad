"""A stand-in for the limited process that looks at a scan: it finds a person, and imports nothing."""

from __future__ import annotations

from typing import Any


def inspect_order(source: str, is_quick: bool, **said: Any) -> dict[str, Any]:
    """Return what is said of a person whose wearer is found on a second look."""
    scan = {
        "name": "anna", "units": "m", "up": "y", "is_cloud": False, "vertex_count": 30587, "face_count": 59882,
        "file_count": 30594, "extent_m": [1.201, 1.668, 0.315], "has_colours": True, "has_labels": False,
        "notes": ["Dropped 7 points as flyers."],
    }  # fmt: skip
    body = None if is_quick else {"source": "scan:anna", "height_m": 1.663, "skin_rms_mm": 2.95}
    return {
        "as": "person", "is_sure": not is_quick, "scan": scan, "body": body, "category": None, "contours_m": None,
        "needs": None, "remarks": ["The hem lies inside the body."],
    }  # fmt: skip
