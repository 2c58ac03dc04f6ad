"""Read a file into a checked `Scan`, alone or together with the body that wears it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..body.models.model_file import load_body_model
from ..body.spec import is_body_model
from ..geometry.connectivity import HalfEdges
from ..geometry.geometry import vertex_normals
from . import refusal
from .counts import check_counts
from .header import DeclaredContent, check_header
from .limits import Limits
from .parse import parse_file
from .scan import Scan
from .units import AXES, check_choice, check_size, find_units, find_up, possible_units, to_metres

MAX_WORN_DISTANCE = 0.5
"""Largest distance of a worn garment from the body [m]; a flared hem hangs at most so far from the legs."""
MAX_WORN_DEPTH = 0.03
"""Depth in the body beyond which a garment's vertex is not worn there [m]; scans reach up to 5 mm into their body."""
MAX_MISPLACED_SHARE = 0.2
"""Share of a garment's vertices far from or deep in the body from which on the two do not belong together."""


@dataclass(frozen=True)
class _Mesh:
    """Describe a repaired mesh in the file's own unit and axes."""

    name: str
    sha256: str
    format: str
    vertices: np.ndarray
    faces: np.ndarray
    colours: np.ndarray | None
    labels: np.ndarray | None
    repairs: tuple[str, ...]
    origin: np.ndarray
    """Index in the file of each vertex."""
    count: int
    """Number of vertices in the file."""
    edges: HalfEdges
    """The half-edges, which the repair has found."""


def load_scan(
    path: Path, *, units: str | None = None, up: str | None = None, kind: str = "garment", limits: Limits | None = None
) -> Scan:
    """Read, check and repair one mesh file.

    Args:
        path: A PLY, OBJ, STL, OFF or GLB file.
        units: A name of `UNITS`, or None to find it from the size.
        up: `y` or `z`, or None to find it.
        kind: `garment` or `body`: whose sizes are expected.
        limits: What reading may cost.

    Raises:
        BadInput: with a code `scan.*` where the file cannot be used.
    """
    check_choice(units, up)
    mesh = _read(Path(path), limits or Limits())
    return _to_scan(mesh, *_find_unit_and_axis(mesh, units, up, kind))


def load_pair(
    scan: Path, body: Path | None, *, units: str | None = None, up: str | None = None, limits: Limits | None = None
) -> tuple[Scan, Scan | None]:
    """Read a garment and the body that wears it, and find units and axes of both together.

    The body's size and shape decide; the garment has the same unit and axis, or else the only ones that put it on the
    body, and is turned to face away from it. A body model's file (`.npz`, `.json`) is in metres and y up.

    Raises:
        BadInput: with a code `scan.*` where a file cannot be used, or the garment is not on the body.
    """
    if body is None:
        return load_scan(scan, units=units, up=up, limits=limits), None
    check_choice(units, up)
    garment_mesh = _read(Path(scan), limits or Limits())
    if is_body_model(body):
        model = load_body_model(Path(body))
        wearer = Scan(model.vertices, model.faces, name=Path(body).stem)
        garment = _place(garment_mesh, wearer, (units or "m", up or "y"), units is not None, up is not None)
        return _face_outward(garment, wearer), wearer
    body_mesh = _read(Path(body), limits or Limits())
    try:
        settled = _find_unit_and_axis(body_mesh, units, up, "body")
    except refusal.UpAmbiguous:
        settled = _find_unit_and_axis(body_mesh, units, find_up(garment_mesh.vertices, garment_mesh.edges), "body")
    wearer = _to_scan(body_mesh, *settled)
    garment = _place(garment_mesh, wearer, settled, units is not None, up is not None)
    return _face_outward(garment, wearer), wearer


def _find_unit_and_axis(mesh: _Mesh, units: str | None, up: str | None, kind: str) -> tuple[str, str]:
    """Return the unit and up axis: as given by the user or by the format (glTF: y up), or found from the size."""
    if units is not None:
        check_size(mesh.vertices, units, kind)
    else:
        units = find_units(mesh.vertices, kind, faces=mesh.faces if kind == "garment" else None)
    if up is None:
        up = "y" if mesh.format == "glb" else find_up(mesh.vertices, mesh.edges, kind)
    return units, up


def _place(mesh: _Mesh, body: Scan, frame: tuple[str, str], units_given: bool, up_given: bool) -> Scan:
    """Return the garment in the body's unit and axis, or in its own where only those put it on the body."""
    sizes = [frame[0]] if units_given else possible_units(mesh.vertices, mesh.faces)
    if frame[0] in sizes and lies_on((garment := _to_scan(mesh, *frame)).vertices, body):
        return garment
    if not sizes:
        find_units(mesh.vertices, faces=mesh.faces)  # Says why none fits.
    axes = [frame[1]] if up_given else list(AXES)
    found = [
        candidate
        for unit in sizes
        for axis in axes
        if (unit, axis) != frame and lies_on((candidate := _to_scan(mesh, unit, axis)).vertices, body)
    ]
    if len({garment.units for garment in found}) > 1:
        raise refusal.UnitsAmbiguous(f"{mesh.name} lies on its body in several units; say which with --units.")
    if len(found) > 1:
        up = find_up(mesh.vertices, mesh.edges)
        found = [garment for garment in found if garment.up_axis == up]
    if not found:
        units = " or ".join(sizes)
        raise refusal.BodyApart(
            f"{mesh.name} does not lie on the body in {units} with y or z up; export both from the same scene, "
            "with the same unit and axes."
        )
    garment = found[0]
    note = f"Read the garment in {garment.units}, {garment.up_axis} up, and the body in {frame[0]}, {frame[1]} up."
    return replace(garment, repairs=(*garment.repairs, note))


def lies_on(vertices: np.ndarray, body: Scan) -> bool:
    """Check whether positions [m], shape [n, 3], can be a garment worn on the body: around it, near it, not inside."""
    from scipy.spatial import cKDTree

    if float(np.ptp(vertices, axis=0).max()) < 0.2:
        return False  # Smaller than any garment: it would fit between the legs.
    sample = vertices[np.linspace(0, len(vertices) - 1, min(len(vertices), 2000)).astype(np.int64)]
    distance, nearest = cKDTree(body.vertices).query(sample)
    depth = -np.einsum("ij,ij->i", sample - body.vertices[nearest], vertex_normals(body.vertices, body.faces)[nearest])
    return float(((distance > MAX_WORN_DISTANCE) | (depth > MAX_WORN_DEPTH)).mean()) < MAX_MISPLACED_SHARE


def _face_outward(garment: Scan, body: Scan) -> Scan:
    from .repair import is_facing_body

    if not is_facing_body(garment.vertices, garment.faces, body.vertices, body.faces):
        return garment
    note = "Turned the surface away from the body."
    return replace(garment, faces=garment.faces[:, ::-1].copy(), repairs=(*garment.repairs, note))


def _to_scan(mesh: _Mesh, units: str, up: str) -> Scan:
    return Scan(
        vertices=to_metres(mesh.vertices, units, up),
        faces=mesh.faces,
        name=mesh.name,
        sha256=mesh.sha256,
        units=units,
        up_axis=up,
        colours=mesh.colours,
        labels=mesh.labels,
        repairs=mesh.repairs,
    )


def _read(path: Path, limits: Limits) -> _Mesh:
    """Check, parse and repair one file."""
    declared = check_header(path, limits)
    with path.open("rb") as file:
        sha256 = hashlib.file_digest(file, "sha256").hexdigest()
    arrays = parse_file(path, declared.format, limits)
    vertices, faces = arrays["vertices"], arrays["faces"]
    _check_arrays(path.name, vertices, faces, declared, limits)
    from .repair import repair_surface

    surface = repair_surface(vertices, faces)
    if len(surface.faces) == 0:
        raise refusal.NoFaces(f"{path.name} holds no face with an area; export the mesh again.")
    colours, labels = arrays.get("colours"), arrays.get("labels")
    return _Mesh(
        name=path.stem,
        sha256=sha256,
        format=declared.format,
        vertices=surface.vertices,
        faces=surface.faces,
        colours=None if colours is None else colours[surface.origin].astype(np.float64) / 255.0,
        labels=None if labels is None else labels[surface.origin],
        repairs=surface.repairs,
        origin=surface.origin,
        count=len(vertices),
        edges=surface.edges,
    )


def _check_arrays(
    name: str, vertices: np.ndarray, faces: np.ndarray, declared: DeclaredContent, limits: Limits
) -> None:
    """Check parsed arrays against what the header declares and what a mesh requires."""
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) == 0:
        raise refusal.MeshEmpty(f"{name} holds no vertices; export the mesh again.")
    if faces.ndim != 2 or faces.shape[1] != 3 or len(faces) == 0:
        raise refusal.NoFaces(f"{name} holds no triangles; export the garment's mesh.")
    check_counts(name, vertices, faces, declared, limits)
    if not np.isfinite(vertices).all():
        count = int((~np.isfinite(vertices).all(axis=1)).sum())
        raise refusal.NotFinite(f"{name}: {count} vertices are NaN or infinite; clean the mesh and export it again.")
    used = np.bincount(faces.ravel(), minlength=len(vertices)) > 0
    extent = np.ptp(vertices[used], axis=0)
    # A garment or body is nowhere flat, and no unit makes it larger than 1e6 or smaller than 1e-6 of that unit.
    if not (1e-6 < extent.max() < 1e6) or extent.min() < 1e-6 * extent.max() or np.abs(vertices).max() > 1e7:
        raise refusal.ExtentBroken(
            f"{name} measures {' x '.join(f'{v:.3g}' for v in extent)}; check what was exported."
        )
