"""One state of a garment with the data for other programs: flat rest shape, panels, seams and fabric."""

from __future__ import annotations

import colorsys
import re
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...cloth.fabric import Fabric
from ...garment.curves import edge_length
from ...garment.garment import Garment
from ...garment.pattern import EdgeRef
from ...garment.pieces.shelf_packing import pack_on_shelves
from ...geometry.geometry import vertex_normals
from .meshes import UV_GAP, uv_layout

FABRIC_UNITS = {
    "H00": "N/m", "H01": "N/m", "H11": "N/m", "H22": "N/m", "k": "N m", "density": "kg/m2", "thickness": "m",
    "friction": "1",
}  # fmt: skip
"""Unit of each number of a fabric."""

LAYOUT_WIDTH_COUNT = 80
"""Number of widths, in steps of 2 % from the widest panel on, tried for a layout in the smallest square."""


LAYOUT_SIDE_STEP = 0.01
"""Step of a layout's side [m]: a multiple of it has whole texels of 0.5, 1 or 2 mm."""


@dataclass(frozen=True)
class SewnMesh:
    """Describe one state of a garment and its cloth.

    Attributes:
        name: `simulation`, `graded`, `redrape` or `detail`.
        garment: Topology, flat rest shape, panels and seams.
        nodes: Positions [m], shape [node_count, 3].
        fabric: The cloth.
    """

    name: str
    garment: Garment
    nodes: np.ndarray
    fabric: Fabric

    def __repr__(self) -> str:
        """Return a one-line summary without the arrays."""
        return f"<SewnMesh {self.name}: {len(self.nodes)} vertices, {len(self.faces)} faces>"

    @property
    def vertices(self) -> np.ndarray:
        """Return the positions [m], shape [node_count, 3]."""
        return self.nodes

    @property
    def faces(self) -> np.ndarray:
        """Return the triangles, shape [face_count, 3]."""
        return self.garment.faces

    @cached_property
    def normals(self) -> np.ndarray:
        """Return unit normals of the welded nodes, shape [node_count, 3]."""
        return vertex_normals(self.nodes, self.garment.faces)

    @cached_property
    def metre_uv(self) -> np.ndarray:
        """Return the flat positions of `uv_layout` [m], shape [uv_count, 2]."""
        return uv_layout(self.garment)

    @cached_property
    def unit_uv(self) -> tuple[np.ndarray, float]:
        """Return flat positions within 0..1, shape [uv_count, 2], and the metres of cloth that 1 is."""
        return square_layout(self.garment)


def square_layout(garment: Garment) -> tuple[np.ndarray, float]:
    """Arrange panels unrotated at one scale in a small square, `UV_GAP` apart and half of that from its sides.

    Returns:
        Coordinates within 0..1, shape [uv_count, 2], and the side of the square [m], a multiple of `LAYOUT_SIDE_STEP`.
    """
    uv = np.array(garment.uv, dtype=np.float64)
    panels = np.unique(garment.panel_of_uv)
    members = [garment.panel_of_uv == panel for panel in panels]
    low = np.array([uv[mask].min(axis=0) for mask in members])
    sizes = np.array([uv[mask].max(axis=0) for mask in members]) - low
    widest = float(sizes[:, 0].max())
    best, side = np.zeros_like(low), np.inf
    for width in widest * 1.02 ** np.arange(LAYOUT_WIDTH_COUNT):
        places = pack_on_shelves(sizes, UV_GAP, width + 1e-9)
        needed = float((places + sizes).max())
        if needed < side - 1e-12:
            best, side = places, needed
    for mask, corner, place in zip(members, low, best, strict=True):
        uv[mask] += place - corner + 0.5 * UV_GAP
    side = LAYOUT_SIDE_STEP * np.ceil((side + UV_GAP) / LAYOUT_SIDE_STEP - 1e-9)
    return uv / side, float(side)


def seams_of_uv(garment: Garment) -> np.ndarray:
    """Return the seams (index in the pattern) of each uv vertex, -1 for none, the lower first, shape [uv_count, 2]."""
    found = np.full((len(garment.uv), 2), -1, dtype=np.int64)
    for index, seam in enumerate(garment.pattern.seams):
        for side in (seam.a, seam.b):
            uv = garment.edge_uv[side]
            free = found[uv, 0] < 0
            found[uv[free], 0] = index
            second = uv[~free]
            found[second[found[second, 0] != index], 1] = index
    return found


def sanitise_names(names: tuple[str, ...] | list[str]) -> list[str]:
    """Return unique names of letters, digits, `_` and `-`; a number is added to repeated ones."""
    found: list[str] = []
    for index, name in enumerate(names):
        plain = re.sub(r"[^A-Za-z0-9_-]+", "_", name)[:60].strip("_") or f"panel_{index}"
        found.append(plain if plain.lower() not in {each.lower() for each in found} else f"{plain}_{index}")
    return found


def describe_cloth(mesh: SewnMesh, is_textured: bool = False) -> dict[str, Any]:
    """Return panels, seams, rest shape and fabric of a mesh as JSON values; lengths in metres.

    Args:
        mesh: The mesh.
        is_textured: Whether its first uv set is the one within 0..1, for a texture.
    """
    garment, pattern = mesh.garment, mesh.garment.pattern

    def tell(ref: EdgeRef) -> dict[str, Any]:
        return {
            "panel": ref.panel, "edge": ref.edge,
            "length_m": round(edge_length(pattern.panel(ref.panel), ref.edge), 6),
        }  # fmt: skip

    names = sanitise_names([panel.name for panel in pattern.panels])
    return {
        "garment": pattern.name,
        "mesh": mesh.name,
        "units": "m",
        "up": "y",
        "rest": "flat panels are the uv set in metres; the warp stands at grainline_rad from +v",
        "metres_per_unit_of_uv": [mesh.unit_uv[1], 1.0] if is_textured else [1.0, mesh.unit_uv[1]],
        "panels": [
            {"index": n, "name": panel.name, "group": names[n], "grainline_rad": round(panel.grainline, 6)}
            for n, panel in enumerate(pattern.panels)
        ],
        "seams": [
            {"index": n, "a": tell(seam.a), "b": tell(seam.b), "gathered": seam.gathered}
            for n, seam in enumerate(pattern.seams)
        ],
        "contours": sorted(contour.name for contour in garment.contours),
        "fabric": describe_fabric(mesh.fabric),
    }


def describe_fabric(fabric: Fabric) -> dict[str, Any]:
    """Return a fabric's name and numbers, with their units, as JSON values."""
    numbers = asdict(fabric)
    return {
        "name": fabric.name,
        "units": FABRIC_UNITS,
        **{name: float(numbers[name]) for name in FABRIC_UNITS},
        "meaning": "H00 weft, H11 warp, H01 both, H22 shear stiffness; k bending stiffness; friction against skin",
    }


def panel_colour(index: int, count: int) -> list[float]:
    """Return a pale colour for a panel, RGB in 0..1, with another hue than its neighbours'."""
    return [round(channel, 4) for channel in colorsys.hsv_to_rgb(index / max(count, 1), 0.35, 0.85)]
