"""The pictures of a report: scan, result and distance between them, front and back, from one camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry import TriangleSurface
from ...recover.recovery import Recovery
from .picture import ColouredMesh, aim, draw, png_base64

WIDTH = 480
"""Width of a picture [pixel]: three fit side by side on a page and stay sharp in print."""

SLIMMEST, WIDEST = 1.5, 0.85
"""Height of a picture over its width follows the garment between these: a page shows both rows whole."""

SKIN = np.array([0.90, 0.85, 0.80])
SCANNED = np.array([0.62, 0.66, 0.70])
CLOTH = np.array([0.40, 0.58, 0.74])
DRAPED = np.array([0.48, 0.66, 0.58])
REDRAPED = np.array([0.72, 0.62, 0.46])
"""Colours: skin pale, so that the cloth leads; the scan grey as clay; the result blue; the simulation mesh green, and
sand the pattern that was dressed anew."""

STOPS = (
    (0.00, (0.90, 0.92, 0.90)),
    (0.25, (0.98, 0.86, 0.55)),
    (0.50, (0.95, 0.60, 0.26)),
    (0.75, (0.80, 0.25, 0.20)),
    (1.00, (0.42, 0.05, 0.24)),
)
"""The error map's colours, light to dark: readable in print and without red-green vision."""

LEAST_RANGE_MM = 5.0
"""Least end of the colour bar [mm]: below that a scanner's noise would look like an error."""


@dataclass(frozen=True)
class View:
    """Describe one row of pictures: each a PNG as base64 text, by what it shows."""

    title: str
    pictures: dict[str, str]


def colour_of(fraction: np.ndarray) -> np.ndarray:
    """Return the error map's RGB for fractions of its range, shape [n, 3]."""
    at = [stop for stop, _ in STOPS]
    return np.stack([np.interp(fraction, at, [rgb[k] for _, rgb in STOPS]) for k in range(3)], axis=-1)


def render_views(recovery: Recovery) -> tuple[tuple[View, ...], float]:
    """Draw front and back.

    Returns:
        The rows, and the end of the error map's colour bar [mm].
    """
    scan, body, faces = recovery.scan, recovery.body, recovery.garment.faces
    distance = TriangleSurface(scan.vertices, scan.faces).distance(recovery.meshes.detail)
    millimetres = 1e3 * distance
    end = float(np.ceil(max(LEAST_RANGE_MM, float(np.quantile(millimetres, 0.99)))))
    person = ColouredMesh(body.vertices, body.faces, SKIN)
    scanned = ColouredMesh(scan.vertices, scan.faces, SCANNED if scan.colours is None else scan.colours)
    result = ColouredMesh(recovery.meshes.detail, faces, CLOTH)
    error = ColouredMesh(recovery.meshes.detail, faces, colour_of(np.minimum(millimetres / end, 1.0)))
    shown = {"Scan": scanned, "Detail mesh": result, "Distance, detail to scan": error}
    if recovery.meshes.simulation is not None:
        shown["Simulation mesh"] = ColouredMesh(recovery.meshes.simulation, faces, DRAPED)
    if recovery.meshes.redraped is not None:
        shown["Dressed anew from the pattern"] = ColouredMesh(recovery.meshes.redraped, faces, REDRAPED)
    both = np.concatenate([recovery.target.vertices, recovery.meshes.detail])
    low, high = both.min(axis=0), both.max(axis=0)
    aspect = (high[1] - low[1]) / max(float(np.hypot(high[0] - low[0], high[2] - low[2])), 1e-6)
    height = int(WIDTH * np.clip(aspect, WIDEST, SLIMMEST))
    views = []
    for title, turn in (("Front", np.eye(3)), ("Back", np.diag([-1.0, 1.0, -1.0]))):
        camera = aim(both, turn @ body.heading, WIDTH, height)
        pictures = {name: png_base64(draw([person, surface], camera)) for name, surface in shown.items()}
        views.append(View(title, pictures))
    return tuple(views), end
