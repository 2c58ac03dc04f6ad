"""Write a recovered garment with the colours of its scan: textured meshes, the texture, and prints at true scale."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...scan.coloured import ColouredScan
from ..texture.bake import bake_texture, check_texel
from .prints import draw_print, list_prints
from .sewn_files import write_sewn_glb, write_sewn_obj
from .sewn_mesh import SewnMesh
from .sewn_usd import write_sewn_usd, write_usdz
from .usd_mesh import can_write_usd


@dataclass(frozen=True)
class TexturedFiles:
    """Describe written texture files; `coverage` is the share of the cloth's texels that show the scan."""

    files: list[Path]
    coverage: float


def write_textured(mesh: SewnMesh, scan: ColouredScan, folder: Path, stem: str, texel_mm: float = 1.0) -> TexturedFiles:
    """Bake a scan's colours and write them.

    Writes `STEM_texture.png`, `STEM_texture_mask.png` (white: seen, grey: filled from around it, black: no cloth),
    `STEM_textured.glb`, `.obj` with `.mtl` and `.json`, `.usd` and `.usdz` where the extra is installed, and the prints
    of `list_prints` as `STEM_print_PIECE.png`, at true scale by their stated resolution.

    Args:
        mesh: The detail mesh, on the scan's surface.
        scan: The scan in the same place.
        folder: Folder of the files.
        stem: Beginning of the files' names.
        texel_mm: Width of a texel [mm], one of `TEXELS_MM`.

    Raises:
        TexelBad: where the width is another one.
    """
    texel = check_texel(texel_mm)
    flat, side = mesh.unit_uv
    baked = bake_texture(mesh.garment, mesh.nodes, scan, flat, side, texel)
    image, mask = folder / f"{stem}_texture.png", folder / f"{stem}_texture_mask.png"
    content = _png(baked.image, texel)
    image.write_bytes(content)
    levels = np.where(baked.covered, 255, np.where(baked.cloth, 128, 0)).astype(np.uint8)
    mask.write_bytes(_png(levels, texel))
    files = [image, mask, write_sewn_glb(mesh, folder / f"{stem}_textured.glb", content)]
    files += write_sewn_obj(mesh, folder / f"{stem}_textured.obj", image)
    if can_write_usd():
        files.append(write_sewn_usd(mesh, folder / f"{stem}_textured.usd", image))
        files.append(write_usdz(files[-1]))
    for name, places in list_prints(mesh.garment.pattern):
        path = folder / f"{stem}_print_{name}.png"
        path.write_bytes(_png(draw_print(mesh, baked, places, texel), texel))
        files.append(path)
    return TexturedFiles(files, baked.coverage)


def _png(pixels: np.ndarray, texel: float) -> bytes:
    """Return a PNG with its resolution."""
    from PIL import Image

    buffer = io.BytesIO()
    resolution = 0.0254 / texel
    Image.fromarray(pixels).save(buffer, format="PNG", dpi=(resolution, resolution))
    return buffer.getvalue()
