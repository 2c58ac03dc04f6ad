"""Bake a scan's colours onto the flat panels of the garment that was recovered from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...garment.garment import Garment
from ...geometry.geometry import vertex_normals
from ...run.errors import BadInput
from ...scan.coloured import ColouredScan
from .fill import fill_gaps, spread_border
from .lookup import look_up_colours
from .texels import Texels, find_texels

TEXELS_MM = (0.5, 1.0, 2.0)
"""Accepted sizes of a texel [mm]; a scan's own colours are seldom finer than 1 mm."""

GUTTER_WIDTH_TEXELS = 8
"""Width of the gutter around each panel in its colours [texels], enough for mip maps of an eighth of the size."""

BORDER_MARGIN_TEXELS = 2.0
"""Width of the ground beside the border that shows the scan itself [texels]: the support of bilinear sampling there."""


class TexelBad(BadInput):
    """A texel is 0.5, 1 or 2 mm wide; give one of them."""

    code = "texture.texel"


@dataclass(frozen=True)
class BakedTexture:
    """Describe a square texture of all panels of a garment.

    Attributes:
        image: RGB bytes from the top, shape [size, size, 3]; white where neither cloth nor its gutter is.
        cloth: Which texels show cloth, shape [size, size].
        covered: Which of them show the scan, shape [size, size]; the others were filled from around them.
        texel: Width of a texel [m].
    """

    image: np.ndarray
    cloth: np.ndarray
    covered: np.ndarray
    texel: float

    @property
    def coverage(self) -> float:
        """Return the share of the cloth that shows the scan."""
        return float(self.covered.sum() / max(int(self.cloth.sum()), 1))


def check_texel(texel_mm: float) -> float:
    """Return a texel's width in metres.

    Raises:
        TexelBad: where it is none of `TEXELS_MM`.
    """
    if texel_mm not in TEXELS_MM:
        raise TexelBad(f"a texel of {texel_mm:g} mm is not made; give {', '.join(f'{t:g}' for t in TEXELS_MM)}.")
    return 1e-3 * texel_mm


def bake_texture(
    garment: Garment, nodes: np.ndarray, scan: ColouredScan, flat: np.ndarray, side: float, texel: float
) -> BakedTexture:
    """Bake the colours of a scan into a texture.

    Each texel has the colour of the scan's surface nearest to its place on the garment, if that is within
    `MAX_COLOUR_LOOKUP_DISTANCE` and faces the same way; if it belongs to another fold, the nearest face that faces the
    same way is used. Beside a panel's border the garment is extended, so that both sides of a seam show the scan across
    it. In a scan cut out of a person's, parts beside the cut with skin or the cloth's inside are excluded.

    Args:
        garment: Topology.
        nodes: Positions on the scan [m], shape [node_count, 3].
        scan: The scan in the same place.
        flat: Panels within 0..1, shape [uv_count, 2].
        side: Metres of cloth that 1 is.
        texel: Width of a texel [m]; divides `side`.
    """
    size = round(side / texel)
    texels = find_texels(flat, garment.uv_faces, size, BORDER_MARGIN_TEXELS)
    colours, seen = _look_up(garment, nodes, scan, texels)
    image, known = np.zeros((size, size, 3)), np.zeros((size, size), dtype=bool)
    cloth = np.zeros((size, size), dtype=bool)
    image[texels.row[seen], texels.column[seen]] = colours[seen]
    known[texels.row[seen], texels.column[seen]] = True
    cloth[texels.row[texels.inside], texels.column[texels.inside]] = True
    return BakedTexture(_fill_panels(garment, flat, image, known, cloth), cloth, known & cloth, texel)


def _look_up(garment: Garment, nodes: np.ndarray, scan: ColouredScan, texels: Texels) -> tuple[np.ndarray, np.ndarray]:
    """Return the colour of each texel, shape [n, 3], and whether the scan shows it, shape [n]."""
    normals = vertex_normals(nodes, garment.faces)
    corners = garment.faces[texels.face]
    points = np.einsum("nk,nkd->nd", texels.barycentric, nodes[corners])
    inner = np.clip(texels.barycentric, 0.0, None)  # beside the border the direction is that on it
    facing = np.einsum("nk,nkd->nd", inner, normals[corners])
    facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-30)
    return look_up_colours(scan, points, facing)


def _fill_panels(
    garment: Garment, flat: np.ndarray, image: np.ndarray, known: np.ndarray, cloth: np.ndarray
) -> np.ndarray:
    """Return the image in bytes, each panel's gaps and gutter filled from the panel itself."""
    size = len(image)
    found = np.full(image.shape, 255, dtype=np.uint8)
    for panel in np.unique(garment.panel_of_uv):
        corners = flat[garment.panel_of_uv == panel]
        left, right = corners[:, 0].min() * size, corners[:, 0].max() * size
        top, low = (1.0 - corners[:, 1].max()) * size, (1.0 - corners[:, 1].min()) * size
        box = (
            slice(max(int(top) - GUTTER_WIDTH_TEXELS, 0), min(int(np.ceil(low)) + GUTTER_WIDTH_TEXELS, size)),
            slice(max(int(left) - GUTTER_WIDTH_TEXELS, 0), min(int(np.ceil(right)) + GUTTER_WIDTH_TEXELS, size)),
        )
        filled = fill_gaps(image[box], known[box]) if known[box].any() else np.full(image[box].shape, 128.0)
        filled, in_gutter = spread_border(filled, cloth[box] | known[box], GUTTER_WIDTH_TEXELS)
        part = found[box]
        part[in_gutter] = np.clip(np.round(filled[in_gutter]), 0, 255).astype(np.uint8)
    return found
