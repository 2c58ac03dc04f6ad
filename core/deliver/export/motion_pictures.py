"""Pictures of a garment in motion: a contact sheet, and a small preview that loops."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .picture import Camera, ColouredMesh, aim, draw, turn_view
from .views import DRAPED, SKIN

if TYPE_CHECKING:
    from ...reuse.animate.animation import Animation

SHEET = (6, 4)
"""Pictures beside and below each other on a contact sheet."""

TILE = (200, 300)
"""Width and height of each [pixel]."""

PREVIEW = (240, 320)
"""Width and height of the preview [pixel]."""

PREVIEW_FRAMES = 40
"""Frames of the preview at most: under a megabyte."""

TURN = np.deg2rad(25.0)
"""Angle by which the camera stands to the wearer's left of the front [rad]: legs and arms that swing are then seen."""


def write_sheet(animation: Animation, path: Path) -> Path:
    """Write a contact sheet of evenly spaced frames as PNG, read row by row."""
    from PIL import Image

    count = min(SHEET[0] * SHEET[1], len(animation.frames))
    tiles = _draw(animation, np.unique(np.linspace(0, len(animation.frames) - 1, count).astype(np.int64)), TILE)
    rows = -(-len(tiles) // SHEET[0])
    sheet = Image.new("RGB", (SHEET[0] * TILE[0], rows * TILE[1]), "white")
    for n, tile in enumerate(tiles):
        picture = Image.fromarray(tile)
        sheet.paste(picture, (n % SHEET[0] * TILE[0], n // SHEET[0] * TILE[1]), picture)
    sheet.save(path, format="PNG")
    return path


def write_preview(animation: Animation, path: Path) -> Path:
    """Write a small GIF that loops in the motion's own time."""
    from PIL import Image

    every = max(1, -(-len(animation.frames) // PREVIEW_FRAMES))
    tiles = _draw(animation, np.arange(0, len(animation.frames), every), PREVIEW)
    pictures = []
    for tile in tiles:
        ground = Image.new("RGB", PREVIEW, "white")
        ground.paste(Image.fromarray(tile), (0, 0), Image.fromarray(tile))
        pictures.append(ground.quantize(64))
    pictures[0].save(
        path, format="GIF", save_all=True, append_images=pictures[1:], loop=0,
        duration=max(20, round(1000 * every / animation.fps)),
    )  # fmt: skip
    return path


def _draw(animation: Animation, indices: np.ndarray, size: tuple[int, int]) -> list[np.ndarray]:
    """Draw wearer and garment in some frames from one camera that goes with the pelvis; RGBA each."""
    body, faces = animation.worn.body, animation.worn.garment.faces
    scenes = []
    for index, wearer in zip(indices, animation.bodies(indices), strict=True):
        transforms = animation.transforms[index]
        pelvis = transforms[0, :3, :3] @ body.rest_joints[0] + transforms[0, :3, 3]
        place = pelvis * np.array([1.0, 0.0, 1.0])
        scenes.append((wearer - place, animation.frames[index] - place))
    camera = _aim(np.concatenate([part for scene in scenes for part in scene]), body.heading, size)
    return [
        draw([ColouredMesh(wearer, body.faces, SKIN), ColouredMesh(cloth, faces, DRAPED)], camera)
        for wearer, cloth in scenes
    ]


def _aim(points: np.ndarray, heading: np.ndarray, size: tuple[int, int]) -> Camera:
    return aim(points, turn_view(heading, -TURN), *size)
