"""Pictures of a garment in motion: a contact sheet, and a small preview that loops."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .picture import Camera, ColouredMesh, aim_camera, render_meshes, rotate_view
from .views import DRAPE_COLOUR, SKIN_COLOUR

if TYPE_CHECKING:
    from ...reuse.animate.animation import Animation

CONTACT_SHEET_GRID = (6, 4)
"""Numbers of columns and rows of pictures on a contact sheet."""

CONTACT_TILE_SIZE_PX = (200, 300)
"""Width and height of a picture on the contact sheet [pixels]."""

PREVIEW_SIZE_PX = (240, 320)
"""Width and height of the preview [pixels]."""

MAX_PREVIEW_FRAME_COUNT = 40
"""Largest number of frames of the preview: the file stays under a megabyte."""

MOTION_CAMERA_ANGLE = np.deg2rad(25.0)
"""Angle of the camera from the front to the wearer's left [rad], from which swinging legs and arms are visible."""


def write_sheet(animation: Animation, path: Path) -> Path:
    """Write a contact sheet of evenly spaced frames as PNG, in rows."""
    from PIL import Image

    count = min(CONTACT_SHEET_GRID[0] * CONTACT_SHEET_GRID[1], len(animation.frames))
    tiles = _draw(
        animation, np.unique(np.linspace(0, len(animation.frames) - 1, count).astype(np.int64)), CONTACT_TILE_SIZE_PX
    )
    rows = -(-len(tiles) // CONTACT_SHEET_GRID[0])
    sheet = Image.new("RGB", (CONTACT_SHEET_GRID[0] * CONTACT_TILE_SIZE_PX[0], rows * CONTACT_TILE_SIZE_PX[1]), "white")
    for n, tile in enumerate(tiles):
        picture = Image.fromarray(tile)
        sheet.paste(
            picture,
            (n % CONTACT_SHEET_GRID[0] * CONTACT_TILE_SIZE_PX[0], n // CONTACT_SHEET_GRID[0] * CONTACT_TILE_SIZE_PX[1]),
            picture,
        )
    sheet.save(path, format="PNG")
    return path


def write_preview(animation: Animation, path: Path) -> Path:
    """Write a small GIF that loops in the motion's own time."""
    from PIL import Image

    every = max(1, -(-len(animation.frames) // MAX_PREVIEW_FRAME_COUNT))
    tiles = _draw(animation, np.arange(0, len(animation.frames), every), PREVIEW_SIZE_PX)
    pictures = []
    for tile in tiles:
        ground = Image.new("RGB", PREVIEW_SIZE_PX, "white")
        ground.paste(Image.fromarray(tile), (0, 0), Image.fromarray(tile))
        pictures.append(ground.quantize(64))
    pictures[0].save(
        path, format="GIF", save_all=True, append_images=pictures[1:], loop=0,
        duration=max(20, round(1000 * every / animation.fps)),
    )  # fmt: skip
    return path


def _draw(animation: Animation, indices: np.ndarray, size: tuple[int, int]) -> list[np.ndarray]:
    """Draw wearer and garment in some frames from one camera that moves with the pelvis; RGBA each."""
    body, faces = animation.worn.body, animation.worn.garment.faces
    scenes = []
    for index, wearer in zip(indices, animation.bodies(indices), strict=True):
        transforms = animation.transforms[index]
        pelvis = transforms[0, :3, :3] @ body.rest_joints[0] + transforms[0, :3, 3]
        place = pelvis * np.array([1.0, 0.0, 1.0])
        scenes.append((wearer - place, animation.frames[index] - place))
    camera = _aim(np.concatenate([part for scene in scenes for part in scene]), body.heading, size)
    return [
        render_meshes([ColouredMesh(wearer, body.faces, SKIN_COLOUR), ColouredMesh(cloth, faces, DRAPE_COLOUR)], camera)
        for wearer, cloth in scenes
    ]


def _aim(points: np.ndarray, heading: np.ndarray, size: tuple[int, int]) -> Camera:
    return aim_camera(points, rotate_view(heading, -MOTION_CAMERA_ANGLE), *size)
