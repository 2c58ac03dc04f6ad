"""Draw a stored garment on its wearer beside its pattern, as one picture for a notebook."""

from __future__ import annotations

import base64
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...garment.curves import panel_outline
from ...garment.pattern import Pattern
from ...garment.pieces.shelf_packing import pack_on_shelves
from ...reuse.wear.worn import WornGarment
from .person import composite_on_white
from .picture import ColouredMesh, aim_camera, png_base64, render_meshes
from .sewn_mesh import SewnMesh
from .views import CLOTH_COLOUR, SKIN_COLOUR

RESULT_VIEW_WIDTH_PX, RESULT_VIEW_HEIGHT_PX = 360, 540
"""Size of each view of the wearer [pixel]: three of them are as wide as a notebook's page."""

PATTERN_OVERSAMPLING_FACTOR = 3
"""Number of pixels drawn each way for a pixel shown of the pattern's lines; they are averaged."""

RESULT_PIECE_GAP = 0.05
"""Free space between pieces [m]."""

PAPER_COLOUR, OUTLINE_COLOUR = (255, 255, 255), (60, 70, 80)
"""Colours of the pattern's ground and of its outlines, RGB in 0..255."""
PIECE_FILL_COLOUR = tuple(int(255 * (0.5 + 0.5 * part)) for part in CLOTH_COLOUR)
"""Colours of the pattern: pieces in the garment's colour, paler."""


@dataclass(frozen=True)
class Picture:
    """Describe a picture as the bytes of a PNG file; a notebook displays it."""

    png: bytes = field(repr=False)

    def _repr_png_(self) -> bytes:
        """Return the PNG for a notebook."""
        return self.png

    def save(self, path: str | Path) -> Path:
        """Write the picture as a PNG file, and return its path."""
        path = Path(path)
        path.write_bytes(self.png)
        return path


def draw_result(state: SewnMesh, worn: WornGarment) -> Picture:
    """Draw a state of a garment on its wearer, front and back, and its pattern beside them.

    Args:
        state: The garment.
        worn: Its wearer, who is shown whole.
    """
    person, cloth = worn.body, ColouredMesh(state.vertices, state.faces, CLOTH_COLOUR)
    surfaces = [ColouredMesh(person.vertices, person.faces, SKIN_COLOUR), cloth]
    everything = np.concatenate([person.vertices, state.vertices])
    tiles = []
    for turn in (np.eye(3), np.diag([-1.0, 1.0, -1.0])):
        tiles.append(
            composite_on_white(
                render_meshes(
                    surfaces, aim_camera(everything, turn @ person.heading, RESULT_VIEW_WIDTH_PX, RESULT_VIEW_HEIGHT_PX)
                )
            )
        )
    tiles.append(_draw_pattern(worn.pattern))
    return Picture(base64.b64decode(png_base64(np.concatenate(tiles, axis=1))))


def _draw_pattern(pattern: Pattern) -> np.ndarray:
    """Draw the pieces at one scale, RGB in 0..255, shape [height, width, 3], in the layout that fills the tile best."""
    from PIL import Image, ImageDraw

    outlines = [panel_outline(panel, 24) for panel in pattern.panels]
    low = np.array([outline.min(axis=0) for outline in outlines])
    sizes = np.array([outline.max(axis=0) for outline in outlines]) - low
    widest = float(sizes[:, 0].max())
    layouts = [
        pack_on_shelves(sizes, RESULT_PIECE_GAP, width)
        for width in np.linspace(widest, float((sizes[:, 0] + RESULT_PIECE_GAP).sum()), 40)
    ]
    extents = np.array([(places + sizes).max(axis=0) for places in layouts]) + 2.0 * RESULT_PIECE_GAP
    scales = np.min([RESULT_VIEW_WIDTH_PX, RESULT_VIEW_HEIGHT_PX] / extents, axis=1)
    best = int(scales.argmax())
    scale, margin = (
        float(scales[best]) * PATTERN_OVERSAMPLING_FACTOR,
        0.5 * ([RESULT_VIEW_WIDTH_PX, RESULT_VIEW_HEIGHT_PX] / scales[best] - extents[best]),
    )
    sheet = Image.new(
        "RGB",
        (RESULT_VIEW_WIDTH_PX * PATTERN_OVERSAMPLING_FACTOR, RESULT_VIEW_HEIGHT_PX * PATTERN_OVERSAMPLING_FACTOR),
        PAPER_COLOUR,
    )
    pen = ImageDraw.Draw(sheet)
    for outline, corner, place in zip(outlines, low, layouts[best], strict=True):
        points = (outline - corner + place + RESULT_PIECE_GAP + margin) * scale * [1.0, -1.0] + [
            0.0,
            RESULT_VIEW_HEIGHT_PX * PATTERN_OVERSAMPLING_FACTOR,
        ]
        closed = [*map(tuple, points.tolist()), tuple(points[0].tolist())]
        pen.polygon(closed, fill=PIECE_FILL_COLOUR)
        pen.line(closed, fill=OUTLINE_COLOUR, width=PATTERN_OVERSAMPLING_FACTOR + 1, joint="curve")
    return np.asarray(sheet.resize((RESULT_VIEW_WIDTH_PX, RESULT_VIEW_HEIGHT_PX), Image.Resampling.LANCZOS))
