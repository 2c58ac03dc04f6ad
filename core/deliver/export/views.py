"""The pictures of a report: scan, result and distance between them, front and back, from one camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...recover.recovery import Recovery
from .picture import Canvas, ColouredMesh, aim_camera, png_base64

REPORT_VIEW_WIDTH_PX = 480
"""Width of a picture [pixel]: three fit side by side on a page and are sharp in print."""

MAX_VIEW_ASPECT_RATIO, MIN_VIEW_ASPECT_RATIO = 1.5, 0.85
"""Largest and smallest ratio of a picture's height to its width, else the garment's; a page shows both rows whole."""

SKIN_COLOUR = np.array([0.90, 0.85, 0.80])
"""Colour of skin, RGB in 0..1: pale, for contrast with the cloth."""
SCAN_COLOUR = np.array([0.62, 0.66, 0.70])
"""Colour of a scan without its own, RGB in 0..1: grey as clay."""
CLOTH_COLOUR = np.array([0.40, 0.58, 0.74])
"""Colour of the recovered garment, RGB in 0..1: blue."""
DRAPE_COLOUR = np.array([0.48, 0.66, 0.58])
"""Colour of the simulation mesh and of a garment worn again, RGB in 0..1: green."""
REDRAPE_COLOUR = np.array([0.72, 0.62, 0.46])
"""Colour of the re-draped mesh, RGB in 0..1: sand."""

ERROR_COLOUR_STOPS = (
    (0.00, (0.90, 0.92, 0.90)),
    (0.25, (0.98, 0.86, 0.55)),
    (0.50, (0.95, 0.60, 0.26)),
    (0.75, (0.80, 0.25, 0.20)),
    (1.00, (0.42, 0.05, 0.24)),
)
"""Fractions and colours of the error map's scale, RGB in 0..1; readable in print and without red-green vision."""

INFERRED_COLOUR = np.array([0.42, 0.46, 0.62])
"""Colour of cloth that the scan does not show, RGB in 0..1: slate, which the error map's scale does not have."""

MIN_ERROR_RANGE_MM = 5.0
"""Smallest upper end of the colour bar [mm]; below it a scanner's noise would look like an error."""


@dataclass(frozen=True)
class View:
    """Describe one row of pictures: each a PNG as base64 text, by what it shows."""

    title: str
    pictures: dict[str, str]


def error_colours(fraction: np.ndarray) -> np.ndarray:
    """Return the error map's RGB for fractions of its range, shape [n, 3]."""
    at = [stop for stop, _ in ERROR_COLOUR_STOPS]
    return np.stack([np.interp(fraction, at, [rgb[k] for _, rgb in ERROR_COLOUR_STOPS]) for k in range(3)], axis=-1)


def render_views(recovery: Recovery) -> tuple[tuple[View, ...], float]:
    """Draw front and back.

    Returns:
        The rows, and the end of the error map's colour bar [mm].
    """
    scan, body, faces = recovery.scan, recovery.body, recovery.garment.faces
    distance = scan.surface.distance(recovery.meshes.detail)
    millimetres = 1e3 * distance
    inferred = recovery.inferred_nodes
    shown = millimetres if inferred.all() else millimetres[~inferred]
    end = float(np.ceil(max(MIN_ERROR_RANGE_MM, float(np.quantile(shown, 0.99)))))
    person = ColouredMesh(body.vertices, body.faces, SKIN_COLOUR)
    scanned = ColouredMesh(scan.vertices, scan.faces, SCAN_COLOUR if scan.colours is None else scan.colours)
    result = ColouredMesh(recovery.meshes.detail, faces, CLOTH_COLOUR)
    shades = error_colours(np.minimum(millimetres / end, 1.0))
    shades[inferred] = INFERRED_COLOUR
    error = ColouredMesh(recovery.meshes.detail, faces, shades)
    surfaces = {"Scan": scanned, "Detail mesh": result, "Distance, detail to scan": error}
    if recovery.meshes.simulation is not None:
        surfaces["Simulation mesh"] = ColouredMesh(recovery.meshes.simulation, faces, DRAPE_COLOUR)
    if recovery.meshes.redraped is not None:
        surfaces["Dressed anew from the pattern"] = ColouredMesh(recovery.meshes.redraped, faces, REDRAPE_COLOUR)
    both = np.concatenate([recovery.target.vertices, recovery.meshes.detail])
    low, high = both.min(axis=0), both.max(axis=0)
    aspect = (high[1] - low[1]) / max(float(np.hypot(high[0] - low[0], high[2] - low[2])), 1e-6)
    height = int(REPORT_VIEW_WIDTH_PX * np.clip(aspect, MIN_VIEW_ASPECT_RATIO, MAX_VIEW_ASPECT_RATIO))
    views = []
    for title, turn in (("Front", np.eye(3)), ("Back", np.diag([-1.0, 1.0, -1.0]))):
        camera = aim_camera(both, turn @ body.heading, REPORT_VIEW_WIDTH_PX, height)
        wearer = Canvas.empty(camera).with_meshes([person])
        pictures = {name: png_base64(wearer.with_meshes([surface]).shade()) for name, surface in surfaces.items()}
        views.append(View(title, pictures))
    return tuple(views), end
