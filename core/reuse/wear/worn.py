"""The garment at rest on its wearer in a stored result, as one file of plain arrays for later jobs."""

from __future__ import annotations

import json
import zipfile
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np

from ...body.body import Body
from ...cloth.fabric import Fabric
from ...cloth.scene import SteadyRotation
from ...garment.garment import Garment
from ...garment.pattern import EdgeRef, Pattern
from ...recover.drape.waist import waist_loop
from ...recover.recovery import Recovery
from ...run.checkpoints import pack, unpack
from ...run.errors import BadInput
from ...scan.contours.target import OPEN_FRONT_CONTOURS, Contour, Target

WORN_FILE_NAME = "worn.npz"
"""Name of the file in the folder of a result."""

WORN_FORMAT_VERSION = 1
"""Version of the file's format; it increases with every change of its fields (`_StoredWorn`)."""

_VERSION_KEY = "version"
"""Key of the version beside the fields."""


class ResultOld(BadInput):
    """The result was stored by another version and lacks what is worn again; submit its scan anew, then this."""

    code = "result.old"


@dataclass(frozen=True)
class WornGarment:
    """Describe a garment at rest on its wearer, with all that dressing another body or animating it needs.

    Attributes:
        garment: Pattern, mesh and named contours; nodes at rest on the wearer [m].
        fabric: The cloth, recovered or chosen.
        body: The wearer.
        waist: The curve on the wearer from which the garment hangs [m], shape [n, 3]; None if it has no pinned waist.
        rotation: The rotation of the wearer, or None for cloth at rest under its weight alone.
        template: Name of the base pattern.
        category: One of `CATEGORIES`.
    """

    garment: Garment
    fabric: Fabric
    body: Body
    waist: np.ndarray | None
    rotation: SteadyRotation | None
    template: str
    category: str

    def __repr__(self) -> str:
        """Return a one-line summary without the arrays."""
        return f"<Worn {self.category} on {self.body.source}: {len(self.garment.nodes)} nodes>"

    @property
    def pattern(self) -> Pattern:
        """Return the garment's pattern."""
        return self.garment.pattern

    @property
    def target(self) -> Target:
        """Return the target of a drape: the waist, or nothing where the garment has none."""
        return make_waist_target(self.waist, self.category)


def make_waist_target(waist: np.ndarray | None, category: str) -> Target:
    """Return a target without a surface: a garment's category, and the curve from which it hangs.

    Args:
        waist: Points of the curve in order [m], shape [n, 3], or None.
        category: One of `CATEGORIES`.
    """
    points = np.zeros((0, 3)) if waist is None else waist
    length = float(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).sum())
    contours = () if waist is None else (Contour("waist", np.arange(len(points)), length),)
    faces = np.zeros((0, 3), dtype=np.int64)
    return Target(points, faces, np.zeros_like(points), contours, (), category)


def worn_from_recovery(recovery: Recovery) -> WornGarment:
    """Return the recovered garment at rest: its simulation mesh, or the graded drape if the method makes none."""
    meshes = recovery.meshes
    garment = recovery.garment.at(meshes.graded if meshes.simulation is None else meshes.simulation)
    return WornGarment(
        garment=garment,
        fabric=recovery.fabric,
        body=recovery.body,
        waist=find_waist(garment, recovery.target),
        rotation=recovery.rotation,
        template=recovery.template,
        category=recovery.pattern.category or recovery.target.category,
    )


def find_waist(garment: Garment, target: Target) -> np.ndarray | None:
    """Return the curve from which a recovered garment hangs [m], shape [n, 3]; None where it hangs from the shoulders.

    It is the scan's waist. Where another garment covers that, the scan's border is below it, often by a hand or more;
    then it is the garment's own waist, as completed by the recovery.

    Args:
        garment: The garment at rest on its wearer.
        target: The scanned garment.
    """
    if target.waist is not None:
        return np.asarray(target.vertices[target.waist.vertices])
    loop = waist_loop(garment)
    return None if loop is None else garment.nodes[loop]


@dataclass(frozen=True)
class _StoredContour:
    """Describe a `Contour` for storage, without whether it is closed, which results of 0.2.0 do not have."""

    name: str
    vertices: np.ndarray
    length: float
    bones: tuple[str, ...]
    trusted: bool
    hidden: bool

    @classmethod
    def of(cls, contour: Contour) -> _StoredContour:
        """Return a contour's stored form."""
        return cls(**{field.name: getattr(contour, field.name) for field in fields(cls)})

    def restore(self, is_open_in_front: bool) -> Contour:
        """Return the contour, of a garment that is open in front or not."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return Contour(**values, is_closed=not (is_open_in_front and self.name in OPEN_FRONT_CONTOURS))


@dataclass(frozen=True)
class _StoredGarment:
    """Describe a `Garment` for storage: its edges' uv vertices are in two lists, since names of arrays are texts."""

    pattern: Pattern
    extra: str
    nodes: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    uv_faces: np.ndarray
    uv_node: np.ndarray
    panel_of_face: np.ndarray
    panel_of_uv: np.ndarray
    edges: tuple[EdgeRef, ...]
    edge_uv: tuple[np.ndarray, ...]
    contours: tuple[_StoredContour, ...]

    @classmethod
    def of(cls, garment: Garment) -> _StoredGarment:
        """Return a garment's stored form."""
        pattern, arrays = garment.pattern, ("nodes", "faces", "uv", "uv_faces", "uv_node")
        return cls(
            pattern=replace(pattern, extra={}),
            extra=json.dumps(pattern.extra),
            panel_of_face=garment.panel_of_face,
            panel_of_uv=garment.panel_of_uv,
            edges=tuple(garment.edge_uv),
            edge_uv=tuple(garment.edge_uv.values()),
            contours=tuple(map(_StoredContour.of, garment.contours)),
            **{name: getattr(garment, name) for name in arrays},
        )

    def restore(self) -> Garment:
        """Return the garment."""
        arrays = ("nodes", "faces", "uv", "uv_faces", "uv_node", "panel_of_face", "panel_of_uv")
        is_open = any(contour.name.startswith("front.") for contour in self.contours)
        return Garment(
            pattern=replace(self.pattern, extra=json.loads(self.extra)),
            edge_uv=dict(zip(self.edges, self.edge_uv, strict=True)),
            contours=tuple(contour.restore(is_open) for contour in self.contours),
            **{name: getattr(self, name) for name in arrays},
        )


@dataclass(frozen=True)
class _StoredWorn:
    """Describe a `WornGarment` for storage, each field as there."""

    garment: _StoredGarment
    fabric: Fabric
    body: Body
    waist: np.ndarray | None
    rotation: SteadyRotation | None
    template: str
    category: str


def save_worn(worn: WornGarment, folder: Path) -> Path:
    """Write a worn garment as compressed arrays into a folder, and return the file."""
    names = ("fabric", "body", "waist", "rotation", "template", "category")
    kept = _StoredWorn(_StoredGarment.of(worn.garment), **{name: getattr(worn, name) for name in names})
    path = folder / WORN_FILE_NAME
    with path.open("wb") as file:
        np.savez_compressed(file, **pack(kept), **{_VERSION_KEY: np.array(WORN_FORMAT_VERSION)})  # type: ignore[arg-type]
    return path


def load_worn(folder: Path) -> WornGarment:
    """Read the worn garment of a stored result from the folder of its files.

    Raises:
        ResultOld: where the result has none, or one of another version.
    """
    try:
        with (folder / WORN_FILE_NAME).open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            if _VERSION_KEY not in arrays.files or not np.array_equal(arrays[_VERSION_KEY], WORN_FORMAT_VERSION):
                raise ResultOld()
            kept = unpack(_StoredWorn, {name: arrays[name] for name in arrays.files if name != _VERSION_KEY})
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise ResultOld() from error
    if kept is None:
        raise ResultOld()
    names = ("fabric", "body", "waist", "rotation", "template", "category")
    return WornGarment(kept.garment.restore(), **{name: getattr(kept, name) for name in names})
