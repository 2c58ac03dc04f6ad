"""Draw a stored garment on its wearer beside its pattern, as one picture that a notebook shows."""

from __future__ import annotations

import base64
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...garment import Pattern, panel_outline
from ...garment.pieces import lay_out
from ...reuse.wear import Worn
from .person import on_white
from .picture import ColouredMesh, aim, draw, png_base64
from .sewn_mesh import SewnMesh
from .views import CLOTH, SKIN

WIDTH, HEIGHT = 360, 540
"""Size of each view of the wearer [pixel]: three of them are as wide as a notebook's page."""

FINE = 3
"""Pixels drawn for each that is shown of the pattern's lines, which are averaged."""

GAP = 0.05
"""Free space between pieces [m]."""

PAPER, LINE = (255, 255, 255), (60, 70, 80)
FILL = tuple(int(255 * (0.5 + 0.5 * part)) for part in CLOTH)
"""Colours of the pattern: pieces in the garment's colour, paler."""


@dataclass(frozen=True)
class Picture:
    """Describe a picture; a notebook shows it by itself.

    Attributes:
        png: Bytes of a PNG file.
    """

    png: bytes = field(repr=False)

    def _repr_png_(self) -> bytes:
        """Return what a notebook shows."""
        return self.png

    def save(self, path: str | Path) -> Path:
        """Write the picture as a PNG file, and return its path."""
        path = Path(path)
        path.write_bytes(self.png)
        return path


def draw_result(state: SewnMesh, worn: Worn) -> Picture:
    """Draw a state of a garment on its wearer, front and back, and its pattern beside them.

    Args:
        state: The garment.
        worn: Its wearer; the camera takes in the whole of it.
    """
    person, cloth = worn.body, ColouredMesh(state.vertices, state.faces, CLOTH)
    surfaces = [ColouredMesh(person.vertices, person.faces, SKIN), cloth]
    everything = np.concatenate([person.vertices, state.vertices])
    tiles = []
    for turn in (np.eye(3), np.diag([-1.0, 1.0, -1.0])):
        tiles.append(on_white(draw(surfaces, aim(everything, turn @ person.heading, WIDTH, HEIGHT))))
    tiles.append(_draw_pattern(worn.pattern))
    return Picture(base64.b64decode(png_base64(np.concatenate(tiles, axis=1))))


def _draw_pattern(pattern: Pattern) -> np.ndarray:
    """Draw the pieces at one scale, RGB in 0..255, shape [HEIGHT, WIDTH, 3]; the layout that fills the tile best."""
    from PIL import Image, ImageDraw

    outlines = [panel_outline(panel, 24) for panel in pattern.panels]
    low = np.array([outline.min(axis=0) for outline in outlines])
    sizes = np.array([outline.max(axis=0) for outline in outlines]) - low
    widest = float(sizes[:, 0].max())
    layouts = [lay_out(sizes, GAP, width) for width in np.linspace(widest, float((sizes[:, 0] + GAP).sum()), 40)]
    extents = np.array([(places + sizes).max(axis=0) for places in layouts]) + 2.0 * GAP
    scales = np.min([WIDTH, HEIGHT] / extents, axis=1)
    best = int(scales.argmax())
    scale, margin = float(scales[best]) * FINE, 0.5 * ([WIDTH, HEIGHT] / scales[best] - extents[best])
    sheet = Image.new("RGB", (WIDTH * FINE, HEIGHT * FINE), PAPER)
    pen = ImageDraw.Draw(sheet)
    for outline, corner, place in zip(outlines, low, layouts[best], strict=True):
        points = (outline - corner + place + GAP + margin) * scale * [1.0, -1.0] + [0.0, HEIGHT * FINE]
        closed = [*map(tuple, points.tolist()), tuple(points[0].tolist())]
        pen.polygon(closed, fill=FILL)
        pen.line(closed, fill=LINE, width=FINE + 1, joint="curve")
    return np.asarray(sheet.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS))
