"""Write a labelled person: labels, coloured surface, body, and a picture of them."""

from __future__ import annotations

import base64
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ...geometry.geometry import unit
from ...people.colours import COLOURS, SURE, UNSURE
from ...people.labels import write_labels
from ...people.part import Part
from ...people.separation import LabelledPerson
from ...scan.raw import RawScan
from ...scan.thin import thin_raw_scan
from .meshes import write_ply
from .picture import ColouredMesh, aim_camera, png_base64, render_meshes, rotate_view

PERSON_SCAN_COLOUR, PERSON_BODY_COLOUR = np.array([0.66, 0.69, 0.72]), np.array([0.90, 0.85, 0.80])
"""Colours of a scan without its own, and of the body, RGB in 0..1."""

PERSON_VIEW_WIDTH_PX, PERSON_VIEW_HEIGHT_PX = 300, 480
"""Size of one of the pictures [pixel]: three views of four things are a page wide."""

MAX_SPLAT_COUNT = 120_000
"""Largest number of points of a cloud that are drawn: more than a picture has pixels."""

PERSON_VIEW_ANGLES = (0.0, np.pi, 0.5 * np.pi)
"""Angles about the vertical from which a person is drawn: front, back, left side."""


def write_person(raw: RawScan, separation: LabelledPerson, folder: Path) -> list[Path]:
    """Write `labels.npz`, `segmented.ply`, `scan.ply`, `body.ply` and `picture.png` into an existing folder.

    `labels.npz` has a label for each point of the given file, in its order; in `place` the point of the cleaned scan
    that replaces it (-1: none), and in `origin` the file's point of each of those. `segmented.ply` is the cleaned scan
    in metres, y up, each point coloured by its part and with its `label` and `confidence`; `scan.ply` the same in the
    scan's own colours, thinned for a view.

    Returns:
        The files.
    """
    label = separation.label[raw.origin]
    picture = folder / "picture.png"
    picture.write_bytes(draw_person(raw, separation))
    return [
        write_labels(separation.label, separation.confidence, folder / "labels.npz", raw.place, raw.origin),
        write_segmented(raw, label, separation.confidence[raw.origin], folder / "segmented.ply"),
        write_scan_ply(raw, folder / "scan.ply"),
        write_ply(separation.body.vertices, separation.body.faces, folder / "body.ply"),
        picture,
    ]


def write_scan_ply(raw: RawScan, path: Path) -> Path:
    """Write a scan in its own colours as PLY, thinned by `thin_raw_scan`."""
    seen = thin_raw_scan(raw)
    colours = None if seen.colours is None else (255.0 * seen.colours + 0.5).astype(np.uint8)
    return write_ply(seen.points, seen.faces, path, colours=colours)


def colour_parts(label: np.ndarray) -> np.ndarray:
    """Return the colour of each label, RGB in 0..1, shape [n, 3]."""
    table = np.tile(np.array(COLOURS[Part.OTHER]), (256, 1))
    for part, colour in COLOURS.items():
        table[part] = colour
    return np.asarray(table[label])


def write_segmented(raw: RawScan, label: np.ndarray, confidence: np.ndarray, path: Path) -> Path:
    """Write the scan as binary PLY with colours and labels of its parts; `garmentq` reads the labels back.

    Args:
        raw: The scan.
        label: A `Part` for each of its points, shape [point_count].
        confidence: Probability of each label, shape [point_count].
        path: The file.
    """
    kind = [(axis, "<f8") for axis in "xyz"] + [(name, "u1") for name in ("red", "green", "blue", "label")]
    kind.append(("confidence", "<f4"))
    rows = np.zeros(len(raw.points), dtype=kind)
    for k, axis in enumerate("xyz"):
        rows[axis] = raw.points[:, k]
    colours = (255.0 * colour_parts(label) + 0.5).astype(np.uint8)
    for k, name in enumerate(("red", "green", "blue")):
        rows[name] = colours[:, k]
    rows["label"], rows["confidence"] = label, confidence
    corners = np.zeros(len(raw.faces), dtype=[("count", "u1"), ("corners", "<i4", (3,))])
    corners["count"], corners["corners"] = 3, raw.faces
    properties = [f"property double {axis}" for axis in "xyz"]
    properties += [f"property uchar {name}" for name in ("red", "green", "blue", "label")]
    properties.append("property float confidence")
    lines = ["ply", "format binary_little_endian 1.0", "comment metres, y up", f"element vertex {len(rows)}"]
    lines += properties
    if len(raw.faces):
        lines += [f"element face {len(raw.faces)}", "property list uchar int vertex_indices"]
    header = "\n".join([*lines, "end_header", ""])
    path.write_bytes(header.encode("ascii") + rows.tobytes() + corners.tobytes())
    return path


def draw_person(raw: RawScan, separation: LabelledPerson) -> bytes:
    """Return a PNG: in rows the scan, the body, the parts and their confidence; in columns front, back and side."""
    label, sure = separation.label[raw.origin], separation.confidence[raw.origin]
    body = separation.body
    share = np.clip(2.0 * sure - 1.0, 0.0, 1.0)[:, None]
    scanned = np.tile(PERSON_SCAN_COLOUR, (len(raw.points), 1)) if raw.colours is None else raw.colours
    surfaces = [_surface(raw, colours) for colours in (scanned, colour_parts(label), UNSURE + share * (SURE - UNSURE))]
    surfaces.insert(1, ColouredMesh(body.vertices, body.faces, PERSON_BODY_COLOUR))
    columns = []
    for turn in PERSON_VIEW_ANGLES:
        camera = aim_camera(
            np.concatenate([raw.points, body.vertices]),
            rotate_view(body.heading, turn),
            PERSON_VIEW_WIDTH_PX,
            PERSON_VIEW_HEIGHT_PX,
        )
        columns.append(
            np.concatenate([composite_on_white(render_meshes([surface], camera)) for surface in surfaces], axis=1)
        )
    return base64.b64decode(png_base64(np.concatenate(columns, axis=0)))


def composite_on_white(pixels: np.ndarray) -> np.ndarray:
    """Composite a picture with transparency, RGBA in 0..255, on white: RGB, uint8, shape [height, width, 3]."""
    cover = pixels[..., 3:] / 255.0
    return np.asarray(255.0 + cover * (pixels[..., :3] - 255.0) + 0.5).clip(0, 255).astype(np.uint8)


def _surface(raw: RawScan, colours: np.ndarray) -> ColouredMesh:
    """Return the mesh to draw, or a small triangle at each point of a cloud."""
    if not raw.is_cloud:
        return ColouredMesh(raw.points, raw.faces, colours)
    step = -(-len(raw.points) // MAX_SPLAT_COUNT)
    points, colours = raw.points[::step], colours[::step]
    spacing = float(np.median(cKDTree(points).query(points[:: max(1, len(points) // 2000)], 2)[0][:, 1]))
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1)) if raw.normals is None else raw.normals[::step]
    side = unit(np.cross(normals, np.where(np.abs(normals[:, 1:2]) < 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])))
    up = np.cross(normals, side)
    corners = [points + 2.0 * spacing * (np.cos(a) * side + np.sin(a) * up) for a in (0.5 * np.pi, 3.66, 5.76)]
    vertices = np.stack(corners, axis=1).reshape(-1, 3)
    return ColouredMesh(vertices, np.arange(len(vertices)).reshape(-1, 3), np.repeat(colours, 3, axis=0))
