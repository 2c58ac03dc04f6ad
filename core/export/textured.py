"""Write a recovered garment with the colours of its scan: textured meshes, the texture, and prints at true scale."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..scan.coloured import ColouredScan
from ..scan.texture import sample_image
from ..texture import BakedTexture, bake_texture, find_texels, spread_border
from ..texture.bake import check_texel
from .sewn_files import write_sewn_glb, write_sewn_obj
from .sewn_mesh import SewnMesh, plain_names
from .sewn_usd import write_sewn_usd
from .usd_mesh import can_write_usd

BLEED = 0.04
"""Print beyond the sew line [m]: the widest seam allowance of the default table, that of a leg's hem."""


@dataclass(frozen=True)
class PrintPlace:
    """Say where a panel lies in a print: print = panel @ rotation.T + translation.

    Attributes:
        panel: Index of the panel in the pattern.
        rotation: Orthogonal, shape [2, 2].
        translation: Shape [2] [m].
    """

    panel: int
    rotation: np.ndarray
    translation: np.ndarray


@dataclass(frozen=True)
class Textured:
    """Hold what was written, and how much of the cloth the scan shows.

    Attributes:
        files: The files.
        coverage: Share of the cloth's texels that show the scan.
    """

    files: list[Path]
    coverage: float


def write_textured(mesh: SewnMesh, scan: ColouredScan, folder: Path, stem: str, texel_mm: float = 1.0) -> Textured:
    """Bake a scan's colours and write them.

    Writes `STEM_texture.png`, `STEM_texture_mask.png` (white: seen, grey: filled from around it, black: no cloth),
    `STEM_textured.glb`, `.obj` with `.mtl` and `.json`, `.usd` where the extra is installed, and for each panel
    `STEM_print_PANEL.png`: at true scale by the resolution that it states, `BLEED` beyond the sew line, clear beyond.

    Args:
        mesh: The detail mesh, which lies on the scan.
        scan: The scan in the same place.
        folder: Where to.
        stem: Beginning of the files' names.
        texel_mm: Width of a texel [mm], one of `TEXELS_MM`.

    Raises:
        TexelBad: where the width is none of them.
    """
    texel = check_texel(texel_mm)
    flat, side = mesh.unit_uv
    baked = bake_texture(mesh.garment, mesh.nodes, scan, flat, side, texel)
    image, mask = folder / f"{stem}_texture.png", folder / f"{stem}_texture_mask.png"
    content = _png(baked.image, texel)
    image.write_bytes(content)
    levels = np.where(baked.seen, 255, np.where(baked.cloth, 128, 0)).astype(np.uint8)
    mask.write_bytes(_png(levels, texel))
    files = [image, mask, write_sewn_glb(mesh, folder / f"{stem}_textured.glb", content)]
    files += write_sewn_obj(mesh, folder / f"{stem}_textured.obj", image)
    if can_write_usd():
        files.append(write_sewn_usd(mesh, folder / f"{stem}_textured.usd", image))
    for index, name in enumerate(plain_names([panel.name for panel in mesh.garment.pattern.panels])):
        path = folder / f"{stem}_print_{name}.png"
        drawn = draw_print(mesh, baked, [PrintPlace(index, np.eye(2), np.zeros(2))], texel)
        path.write_bytes(_png(drawn, texel))
        files.append(path)
    return Textured(files, baked.coverage)


def draw_print(mesh: SewnMesh, baked: BakedTexture, places: Sequence[PrintPlace], texel: float) -> np.ndarray:
    """Draw panels as they lie in one piece, RGBA bytes from the top, shape [height, width, 4].

    The print goes on for `BLEED` beyond the sew line, in the colours at it.

    Args:
        mesh: What the texture was baked for.
        baked: The texture.
        places: Panels that lie side by side in the piece.
        texel: Width of a pixel [m].
    """
    garment = mesh.garment
    laid = np.zeros((len(garment.uv), 2))
    used = np.zeros(len(garment.uv), dtype=bool)
    for place in places:
        own = garment.panel_of_uv == place.panel
        laid[own] = garment.uv[own] @ place.rotation.T + place.translation
        used |= own
    faces = garment.uv_faces[used[garment.uv_faces[:, 0]]]
    low = laid[used].min(axis=0) - BLEED
    width, height = (int(np.ceil(length / texel)) for length in laid[used].max(axis=0) + BLEED - low)
    size = max(width, height)
    shifted = np.where(used[:, None], (laid - low) / (size * texel), 0.0)
    texels = find_texels(shifted, faces, size, 0.0)
    uv = np.einsum("nk,nkd->nd", texels.barycentric, mesh.unit_uv[0][faces[texels.face]])
    row = texels.row - (size - height)  # rows count from the top, and the panels stand at the lower end
    image, known = np.zeros((height, width, 3)), np.zeros((height, width), dtype=bool)
    image[row, texels.column], known[row, texels.column] = sample_image(baked.image, uv), True
    image, near = spread_border(image, known, BLEED / texel)
    drawn = np.zeros((height, width, 4), dtype=np.uint8)
    drawn[..., :3] = np.where(near[..., None], np.clip(np.round(image), 0, 255), 255)
    drawn[..., 3] = np.where(near, 255, 0)
    return drawn


def _png(pixels: np.ndarray, texel: float) -> bytes:
    """Return a PNG that says its scale."""
    from PIL import Image

    buffer = io.BytesIO()
    resolution = 0.0254 / texel
    Image.fromarray(pixels).save(buffer, format="PNG", dpi=(resolution, resolution))
    return buffer.getvalue()
