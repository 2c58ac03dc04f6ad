"""Sample a scan's texture at its vertices: image and coordinates of an OBJ, a PLY or a GLB.

It is read in the limited process that reads the mesh, and the size of an image is known from its header before a pixel
is decoded. Where a texture cannot be read, the scan has no colours and a note with the reason.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .columns import as_bytes
from .head import read_head
from .header import PLY_END
from .obj import ObjContent

MAX_TEXTURE_PIXEL_COUNT = 150_000_000
"""Largest number of pixels of an image that is read: two of 8K by 8K, 0.5 GB decoded."""
JPEG_DRAFT_SIDE_PX = 4096
"""Side from which on a JPEG is decoded at half its size or less [pixels]: on a person one pixel per half millimetre."""
DEFAULT_MATERIAL_COLOUR = np.array([255, 255, 255])
"""Colour without a material [RGB, 0 to 255]: white, glTF's default."""
_FORMATS = ("PNG", "JPEG", "BMP", "WEBP", "TGA", "TIFF")
_MTL_BYTES = 1 << 20
"""Largest material file that is read [bytes]."""


class TextureBad(Exception):
    """A texture cannot be used; the text says why, for the scan's notes."""


def open_image(path: Path, file: str) -> np.ndarray:
    """Decode an image that a scan's file names to RGB, bytes, shape [height, width, 3].

    Raises:
        TextureBad: where it is not beside the scan, is too large, which is known before it is decoded, or in no format
            that is read.
    """
    from PIL import Image

    source, name = find_referenced_file(path, file), f"the texture '{Path(file).name[:60]}'"
    try:
        with Image.open(source, formats=_FORMATS) as image:
            return decode(image, name)
    except (MemoryError, TextureBad):
        raise
    except Exception as error:  # Pillow's readers fail in any way on a hostile file
        raise TextureBad(f"{name} is no image that is read") from error


def decode(image: Any, name: str) -> np.ndarray:
    """Decode an image whose header Pillow has read, as `open_image` does."""
    width, height = image.size
    if width * height > MAX_TEXTURE_PIXEL_COUNT:
        raise TextureBad(f"{name} has {width} x {height} pixels, more than are read")
    try:
        image.draft("RGB", (JPEG_DRAFT_SIDE_PX, JPEG_DRAFT_SIDE_PX))
        return np.asarray(image.convert("RGB"))
    except MemoryError:
        raise
    except Exception as error:
        raise TextureBad(f"{name} cannot be decoded") from error


def sample_image(image: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Sample an image at coordinates from its lower left corner, repeated beyond 0..1, bilinear; shape [n, 3]."""
    height, width = image.shape[:2]
    uv = np.nan_to_num(uv)
    edge = (uv == 1.0) | ((uv > 0.0) & (uv < 1.0))
    uv = np.where(edge, uv, uv - np.floor(uv))
    x = np.clip(uv[:, 0] * width - 0.5, 0.0, width - 1.0)
    y = np.clip((1.0 - uv[:, 1]) * height - 0.5, 0.0, height - 1.0)
    left, top = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    right, low = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    s, t = (x - left)[:, None], (y - top)[:, None]
    above = (1.0 - s) * image[top, left] + s * image[top, right]
    below = (1.0 - s) * image[low, left] + s * image[low, right]
    found: np.ndarray = (1.0 - t) * above + t * below
    return found


def add_texture(arrays: dict[str, np.ndarray], path: Path, form: str, loaded: Any = None) -> dict[str, np.ndarray]:
    """Add `colours` from a texture where a file has no others and names one; where that fails `told`, the reason."""
    if "colours" in arrays or form not in ("obj", "ply", "glb"):
        return arrays
    try:
        if form == "obj":
            colours = _colour_obj(path, loaded)
        elif form == "ply":
            colours = _colour_ply(path, loaded)
        else:
            colours = _colour_glb(loaded)
    except TextureBad as error:
        text = f"Colours were not read: {error}; a GLB holds its texture itself."
        return arrays | {"told": np.array([text])}
    return arrays if colours is None else arrays | {"colours": as_bytes(np.round(colours).astype(np.int64))}


def find_referenced_file(path: Path, name: str) -> Path:
    """Find a named file in a scan's folder or below it.

    Raises:
        TextureBad: where there is none, as in a job, which has only the scan's own file.
    """
    name = name.strip().strip('"').replace("\\", "/")
    folder = path.parent.resolve()
    for candidate in (name, Path(name).name):
        try:
            found = (folder / candidate).resolve()
            if found.is_relative_to(folder) and found.is_file():
                return found
        except (OSError, ValueError):
            continue
    raise TextureBad(f"its file '{Path(name).name[:60]}' is not beside the scan")


def _colour_obj(path: Path, content: ObjContent) -> np.ndarray | None:
    """Return the mean colour at the corners of each vertex, or None where no material has an image."""
    count, has_uv = len(content.vertices), content.places >= 0
    corners, places = content.corners[has_uv], content.places[has_uv]
    if len(corners) and (places.max() >= len(content.uv) or corners.max() >= count):
        raise TextureBad("its texture coordinates are not all there")
    if not len(content.uv) or not content.libraries:
        return None
    images = list_images(path, content.libraries)
    material = np.array(content.materials)[np.repeat(content.material, content.sizes)[has_uv]]
    sums, hits = np.zeros((count, 3)), np.zeros(count)
    for name in sorted(set(content.materials) & set(images)):
        of_material = material == name
        found = sample_image(open_image(path, images[name]), content.uv[places[of_material]])
        hits += np.bincount(corners[of_material], minlength=count)
        sums += np.stack([np.bincount(corners[of_material], found[:, k], count) for k in range(3)], axis=1)
    return sums / np.maximum(hits, 1.0)[:, None] if hits.any() else None


def list_images(path: Path, libraries: Sequence[str]) -> dict[str, str]:
    """Return the image's name of each material that has one, of the libraries beside an OBJ.

    Raises:
        TextureBad: where a library is missing.
    """
    read = [_read_mtl(find_referenced_file(path, library)) for library in libraries]
    return {name: file for images in read for name, file in images.items()}


def _read_mtl(path: Path) -> dict[str, str]:
    """Read the image's name of each material, without the options before it."""
    found, name = {}, ""
    with path.open("rb") as file:
        text = file.read(_MTL_BYTES).decode("utf-8", "replace")
    for line in text.splitlines():
        words = line.strip().split(None, 1)
        if len(words) == 2 and words[0] == "newmtl":
            name = words[1].strip()
        elif len(words) == 2 and words[0].lower() == "map_kd":
            found[name] = re.sub(r"^(-\w+(\s+[-+.\deE]+|\s+on|\s+off)*\s+)+", "", words[1]).strip()
    return found


def _colour_ply(path: Path, loaded: Any) -> np.ndarray | None:
    head = PLY_END.split(read_head(path, PLY_END), 1)[0]
    named = re.search(rb"(?m)^comment[ \t]+TextureFile[ \t]+([^\r\n]+)", head)
    uv = getattr(loaded.get("visual"), "uv", None)
    if named is None or uv is None:
        return None
    name = named.group(1).decode("utf-8", "replace")
    return sample_image(open_image(path, name), np.asarray(uv))


def _colour_glb(parts: Any) -> np.ndarray | None:
    """Return the vertex colours of all parts of a scene, from images in the file; None where no part has an image."""
    decoded: dict[int, np.ndarray] = {}
    colours, found = [], False
    for part in parts:
        uv, material = getattr(part.visual, "uv", None), getattr(part.visual, "material", None)
        image = getattr(material, "baseColorTexture", None)
        if image is None or uv is None or len(uv) != len(part.vertices):
            factor = getattr(material, "baseColorFactor", None)
            colours.append(
                np.tile(
                    DEFAULT_MATERIAL_COLOUR if factor is None else as_bytes(np.asarray(factor)[:3]),
                    (len(part.vertices), 1),
                )
            )
            continue
        if id(image) not in decoded:
            decoded[id(image)] = decode(image, "the texture")
        colours.append(sample_image(decoded[id(image)], np.asarray(uv)))
        found = True
    return np.concatenate(colours) if found else None
