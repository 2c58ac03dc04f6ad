"""Prints of a garment's pieces, to be printed on cloth before cutting."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...garment.pattern import Pattern
from ...garment.pieces.errors import PieceBad
from ...garment.pieces.make import make_pieces
from ...scan.texture import sample_image
from ..texture.bake import BakedTexture
from ..texture.fill import spread_border
from ..texture.texels import find_texels
from .sewn_mesh import SewnMesh, sanitise_names

PRINT_BLEED_WIDTH = 0.04
"""Width of the print beyond the sew line [m]: the widest usual seam allowance, that of a leg's hem."""

PRINT_MIRROR_MATRIX = np.diag([-1.0, 1.0])
"""Matrix that mirrors, shape [2, 2], from a pair's mirrored copy as it is drawn to the copy as it is cut."""


@dataclass(frozen=True)
class PrintPlace:
    """Describe the place of a panel, by its index in the pattern, in a print: print = panel @ rotation.T + translation
    [m]. The rotation is proper, shape [2, 2]."""

    panel: int
    rotation: np.ndarray
    translation: np.ndarray


def list_prints(pattern: Pattern) -> list[tuple[str, list[PrintPlace]]]:
    """Return a name and the panels of each print. A print is a production piece, grain up; joined halves are one. Left
    and right of a pair have different colours, so each has its own, the mirrored copy as it is cut. A pattern without
    production pieces has a print for each panel."""
    index = {panel.name: n for n, panel in enumerate(pattern.panels)}
    prints = []
    try:
        pieces = make_pieces(pattern).pieces
    except PieceBad:
        names = sanitise_names([panel.name for panel in pattern.panels])
        return [(name, [PrintPlace(n, np.eye(2), np.zeros(2))]) for n, name in enumerate(names)]
    for piece in pieces:
        upright = [place for place in piece.places if np.linalg.det(place.rotation) > 0.0]
        prints.append((piece.name, [PrintPlace(index[p.panel], p.rotation, p.translation) for p in upright]))
        copy = [place for place in piece.places if np.linalg.det(place.rotation) < 0.0]
        if piece.pair and copy:
            turned = [
                PrintPlace(index[p.panel], PRINT_MIRROR_MATRIX @ p.rotation, PRINT_MIRROR_MATRIX @ p.translation)
                for p in copy
            ]
            prints.append((f"{piece.name}_MIRRORED", turned))
    return prints


def draw_print(mesh: SewnMesh, baked: BakedTexture, places: Sequence[PrintPlace], texel: float) -> np.ndarray:
    """Draw panels as placed in one piece, RGBA bytes from the top, shape [height, width, 4].

    The print extends by `PRINT_BLEED_WIDTH` beyond the sew line, in the colours at it.

    Args:
        mesh: The mesh of the texture.
        baked: The texture.
        places: Panels that are side by side in the piece.
        texel: Width of a pixel [m].
    """
    garment = mesh.garment
    laid = np.zeros((len(garment.uv), 2))
    used = np.zeros(len(garment.uv), dtype=bool)
    for place in places:
        in_panel = garment.panel_of_uv == place.panel
        laid[in_panel] = garment.uv[in_panel] @ place.rotation.T + place.translation
        used |= in_panel
    faces = garment.uv_faces[used[garment.uv_faces[:, 0]]]
    low = laid[used].min(axis=0) - PRINT_BLEED_WIDTH
    width, height = (int(np.ceil(length / texel)) for length in laid[used].max(axis=0) + PRINT_BLEED_WIDTH - low)
    size = max(width, height)
    shifted = np.where(used[:, None], (laid - low) / (size * texel), 0.0)
    texels = find_texels(shifted, faces, size, 0.0)
    uv = np.einsum("nk,nkd->nd", texels.barycentric, mesh.unit_uv[0][faces[texels.face]])
    row = texels.row - (size - height)  # rows count from the top, and the panels are at the lower end
    image, known = np.zeros((height, width, 3)), np.zeros((height, width), dtype=bool)
    image[row, texels.column], known[row, texels.column] = sample_image(baked.image, uv), True
    image, in_bleed = spread_border(image, known, PRINT_BLEED_WIDTH / texel)
    drawn = np.zeros((height, width, 4), dtype=np.uint8)
    drawn[..., :3] = np.where(in_bleed[..., None], np.clip(np.round(image), 0, 255), 255)
    drawn[..., 3] = np.where(in_bleed, 255, 0)
    return drawn
