"""Read a file into a `RawScan`: a whole person, mesh or cloud, in any unit and with any axis up."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..geometry.geometry import unit, vertex_normals
from ..geometry.point_normals import find_normal_orientation, find_normals
from ..run.units import METRIC, UNITS
from . import refusal
from .clean import CleanedScan, clean_person
from .colour_meaning import find_shown_geometry
from .counts import check_counts
from .header import DeclaredContent, check_header
from .labels import read_labels
from .limits import Limits
from .mend import MendedMesh, mend_mesh, merge_points
from .parse import parse_file
from .raw import RawScan
from .upright import (
    AXES_UP,
    Profile,
    UprightAxis,
    build_profiles,
    find_length_unit,
    find_upright,
    is_normalised,
    turn_upright,
)

MIN_PERSON_POINT_COUNT = 100
"""Least number of points of a person's scan. Segmentation needs far more, and checks that itself."""
MAX_FRAGMENT_POINT_SHARE = 0.5
"""Share of a person's points in fragments of the mesh from which on its faces are ignored: all points of a cloud that
was written with made-up faces are in fragments, few of any scanner's mesh."""
MAX_LOST_POINT_DISTANCE = 0.01
"""Largest distance from a vertex in no face or in a fragment to the kept point that replaces it [m]: two spacings."""

MIN_SPLAT_OPACITY = 0.5
"""Least opacity of a splat [1] that is a point of the surface: of a clearer one, what lies behind is seen more."""


@dataclass(frozen=True)
class _File:
    """Describe a file's content in its own unit and axes: one entry for each of its vertices."""

    name: str
    sha256: str
    arrays: dict[str, np.ndarray]
    declared: DeclaredContent


def load_raw(
    path: Path,
    units: str | None = None,
    up: str | None = None,
    limits: Limits | None = None,
    labels: Path | None = None,
    labels_key: str | None = None,
    stature: float | None = None,
) -> RawScan:
    """Read a person's scan: parse it in a limited process, repair and clean it, and turn it upright in metres.

    Args:
        path: A PLY, OBJ, STL, OFF or GLB with or without faces, or a PCD or XYZ.
        units: A name of `UNITS`, or None to find it from the person's height.
        up: One of `AXES_UP`, or None to find it from the person's shape.
        limits: What reading may cost.
        labels: A file with one label for each vertex of the scan's file; None: those in the scan's file, if any.
        labels_key: Name of the array in that file.
        stature: Height of the person, standing [m], instead of a unit; None: the unit tells.

    Raises:
        BadInput: with a code `scan.*` where the file cannot be used.
    """
    _check_choice(units, up)
    limits = limits or Limits()
    file = _read(Path(path), limits)
    found = file.arrays["vertices"]
    if labels is not None:
        values = read_labels(Path(labels), labels_key, limits)
        if len(values) != len(found):
            raise refusal.LabelsMismatch(
                f"{Path(labels).name} holds {len(values)} labels for the {len(found)} vertices of {file.name}; "
                "give one label per vertex, in the order of the scan's file."
            )
        file.arrays["labels"] = values
    return _build(file, units, up, stature)


def _check_choice(units: str | None, up: str | None) -> None:
    if units is not None and units not in UNITS:
        raise refusal.ChoiceBad(f"units '{units}' are not known; give {', '.join(UNITS)}.")
    if up is not None and up not in AXES_UP:
        raise refusal.ChoiceBad(f"up axis '{up}' is not known; give {', '.join(AXES_UP)}.")


def _read(path: Path, limits: Limits) -> _File:
    declared = check_header(path, limits, needs_faces=False)
    with path.open("rb") as file:
        sha256 = hashlib.file_digest(file, "sha256").hexdigest()
    arrays = parse_file(path, declared.format, limits, textures=True)
    _check_arrays(path.name, arrays, declared, limits)
    return _File(path.stem, sha256, arrays, declared)


def _check_arrays(name: str, arrays: dict[str, np.ndarray], declared: DeclaredContent, limits: Limits) -> None:
    """Check parsed arrays against what the header declares and what a scan requires."""
    vertices, faces = arrays["vertices"], arrays["faces"]
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) == 0:
        raise refusal.MeshEmpty(f"{name} holds no vertices; export the scan again.")
    check_counts(name, vertices, faces, declared, limits)
    finite = np.isfinite(vertices).all(axis=1)
    if len(faces) and not finite.all() and not finite[faces].all():
        raise refusal.NotFinite(f"{name}: vertices of faces are NaN or infinite; clean the scan and export it again.")
    if finite.sum() < MIN_PERSON_POINT_COUNT:
        raise refusal.MeshEmpty(f"{name} holds {int(finite.sum())} points, too few for a person; export it again.")
    extent = np.ptp(vertices[finite], axis=0)
    if not (1e-6 < extent.max() < 1e6) or np.abs(vertices[finite]).max() > 1e7:
        raise refusal.ExtentBroken(
            f"{name} measures {' x '.join(f'{v:.3g}' for v in extent)}; check what was exported."
        )


def _build(file: _File, units: str | None, up: str | None, stature: float | None) -> RawScan:
    """Repair, clean, turn and scale a file's content."""
    arrays, notes = file.arrays, []
    finite = np.isfinite(arrays["vertices"]).all(axis=1)
    if not finite.all():
        notes.append(_count(int((~finite).sum()), "point without a position", "points without a position"))
    if "opacity" in arrays:
        clear = finite & (arrays["opacity"] < MIN_SPLAT_OPACITY)
        notes.append("Read the centres of a Gaussian splat's points.")
        if clear.any():
            notes.append(_count(int(clear.sum()), "transparent splat", "transparent splats"))
        finite &= ~clear
    notes += [str(text) for text in arrays.get("told", ())]
    profiles = build_profiles()
    known_axis = None if up is None else (up,)
    axes = known_axis or (("y", *AXES_UP[1:]) if file.declared.format != "glb" else ("y",))
    mesh, cleaned = _find_person(file, finite, profiles, axes)
    notes += [*mesh.notes, *cleaned.notes]
    found = find_upright(cleaned.samples, profiles, axes)
    notes += _describe_axis(found, axes, up is not None)
    turned = turn_upright(cleaned.samples, found.up)
    longest = float(np.ptp(mesh.points[cleaned.is_person], axis=0).max())
    units, scale, unit_notes = _find_scale(turned, longest, found, units, stature)
    notes += unit_notes
    raw = _gather(file, mesh, cleaned, (turned, scale, found.up))
    if raw.colours is not None:
        shown = find_shown_geometry(raw.points, raw.normals if raw.is_oriented else None, raw.colours)
        if shown is not None:
            notes.append(f"The colours show {shown}, not what is worn, and were left out.")
            raw = replace(raw, colours=None)
    return replace(raw, units=units, scale=scale, up_axis=found.up, notes=tuple(notes))


def _count(count: int, one: str, many: str) -> str:
    return f"Dropped {count} {one if count == 1 else many}."


def _find_person(
    file: _File, finite: np.ndarray, profiles: list[Profile], axes: tuple[str, ...]
) -> tuple[MendedMesh, CleanedScan]:
    """Repair a file's content and find the person, by points alone if the faces are no surface; `MeshEmpty` if none."""
    points, faces = file.arrays["vertices"], file.arrays["faces"]
    mesh = mend_mesh(points, faces) if len(faces) else merge_points(points, finite)
    if len(faces) and (len(mesh.faces) == 0 or len(mesh.points) < MIN_PERSON_POINT_COUNT):
        mesh = _drop_faces(points, finite)
    if len(mesh.points) >= MIN_PERSON_POINT_COUNT:
        cleaned = clean_person(mesh.points, mesh.faces, profiles, axes)
        if cleaned.fragment_share >= MAX_FRAGMENT_POINT_SHARE:
            mesh = _drop_faces(points, finite)
            cleaned = clean_person(mesh.points, mesh.faces, profiles, axes)
        if cleaned.is_person.sum() >= MIN_PERSON_POINT_COUNT:
            return mesh, cleaned
    raise refusal.MeshEmpty(f"{file.name} holds too few points of a person; check what was exported.")


def _drop_faces(points: np.ndarray, finite: np.ndarray) -> MendedMesh:
    merged = merge_points(points, finite)
    return replace(merged, notes=("The faces are no surface, so the points alone were read.", *merged.notes))


def _describe_axis(found: UprightAxis, axes: tuple[str, ...], is_given: bool) -> list[str]:
    """Return notes on an up axis that is unusual or not sure."""
    notes = []
    if not is_given and len(axes) > 1 and found.up not in ("y", "z"):
        notes.append(f"Took the file's axis {found.up} for up, by the person's shape; --up says another.")
    if not found.is_sure:
        second = min((axis for axis in axes if axis != found.up), key=lambda axis: found.others[axis])
        notes.append(f"It is not sure that {found.up} points up, and not {second}; say it with --up.")
    return notes


def _find_scale(
    turned: np.ndarray, longest: float, found: UprightAxis, units: str | None, stature: float | None
) -> tuple[str, float, list[str]]:
    """Return the unit's name, metres per unit, and notes, of samples upright [unit] and their longest side [unit]."""
    height = float(np.ptp(turned[:, 1]))
    if units is not None:
        return units, UNITS[units], []
    if stature is not None:
        return "unknown", stature / (height * found.ratio), [f"Scaled to a person {stature:.2f} m high, standing."]
    units, scale = find_length_unit(height, found, is_normalised(longest))
    if units == "unknown":
        text = (
            f"The person measures {height:.3g} in the file's unit, which is not known; took {1 / scale:.3g} of it "
            f"for a metre, so that the person stands {height * scale * found.ratio:.2f} m high."
        )
        return units, scale, [text]
    if units not in METRIC:
        text = f"Took the file's unit for the {units}, by the person's height of {height * scale:.2f} m."
        return units, scale, [text]
    return units, scale, []


def _map_lost_points(place: np.ndarray, file_points: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Map points of the file that are in no face to the nearest kept point within `MAX_LOST_POINT_DISTANCE`."""
    from scipy.spatial import cKDTree

    lost = np.flatnonzero((place < 0) & np.isfinite(file_points).all(axis=1))
    if not len(lost):
        return place
    distance, nearest = cKDTree(points).query(file_points[lost])
    place = place.copy()
    place[lost] = np.where(distance < MAX_LOST_POINT_DISTANCE, nearest, -1)
    return place


def _gather(file: _File, mesh: MendedMesh, cleaned: CleanedScan, how: tuple[np.ndarray, float, str]) -> RawScan:
    """Return the kept part of the file's arrays as a scan in metres, y up."""
    arrays = file.arrays
    _, scale, axis = how
    kept = np.flatnonzero(cleaned.is_person)
    index = np.full(len(mesh.points), -1)
    index[kept] = np.arange(len(kept))
    faces = index[mesh.faces]
    faces = faces[(faces >= 0).all(axis=1)] if len(faces) else faces.reshape(0, 3)
    origin = mesh.origin[kept]
    place = np.where(mesh.place >= 0, index[mesh.place], -1)
    points = turn_upright(mesh.points[kept], axis) * scale
    place = _map_lost_points(place, turn_upright(arrays["vertices"], axis) * scale, points) if len(faces) else place
    colours, labels, normals = (arrays.get(name) for name in ("colours", "labels", "normals"))
    is_oriented = True
    if len(faces):
        normals = vertex_normals(points, faces)
    elif normals is not None and np.linalg.norm(np.nan_to_num(normals[origin]), axis=1).min() > 0.1:
        normals = unit(turn_upright(normals[origin], axis))
        side = find_normal_orientation(points, normals)
        normals, is_oriented = normals * (side or 1), side != 0
    else:
        normals, is_oriented = find_normals(points), False
    return RawScan(
        points=points,
        faces=faces,
        normals=normals,
        is_oriented=is_oriented,
        colours=None if colours is None else colours[origin].astype(np.float64) / 255.0,
        labels=None if labels is None else labels[origin],
        origin=origin,
        place=place,
        name=file.name,
        sha256=file.sha256,
        pieces=cleaned.pieces,
    )
