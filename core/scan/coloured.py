"""Read a scan's colours: at its vertices, or in images by the coordinates of its faces' corners."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..run.errors import BadInput
from ..run.records import read_record, write_record
from ..run.sandbox import ReaderCrashed, call_limited, is_memory_short
from ..run.units import UNITS
from . import refusal
from .columns import as_bytes
from .header import check_header
from .limits import Limits
from .obj import read_obj
from .parse import parse
from .scan import Scan
from .texture import (
    DEFAULT_MATERIAL_COLOUR,
    MAX_TEXTURE_PIXEL_COUNT,
    TextureBad,
    decode,
    list_images,
    open_image,
    sample_image,
)
from .upright import AXES_UP, turn_upright


class ColoursMissing(BadInput):
    """The scan has neither colours of its vertices nor a texture in it; a GLB holds its texture itself."""

    code = "scan.colours_missing"


@dataclass(frozen=True)
class ColouredScan:
    """Describe a scan's surface with the colours of its file, neither repaired nor cut.

    Attributes:
        vertices: Positions [m], y up, shape [vertex_count, 3].
        faces: Vertex indices, shape [face_count, 3].
        colours: RGB bytes of the vertices, shape [vertex_count, 3], or None.
        corner_uv: Image coordinates, from the lower left, of faces' corners (0: no image), shape [face_count, 3, 2].
        image: Index of each face's image, -1 for none, shape [face_count].
        images: RGB bytes, shape [height, width, 3] each.
        fault: Reason why a texture that the file names was not read, or an empty text.
        is_cut: Whether the surface was cut out of a person's: near its border it may show another part.
    """

    vertices: np.ndarray
    faces: np.ndarray
    colours: np.ndarray | None
    corner_uv: np.ndarray
    image: np.ndarray
    images: tuple[np.ndarray, ...] = ()
    fault: str = ""
    is_cut: bool = False

    @property
    def is_coloured(self) -> np.ndarray:
        """Mark the faces that have a colour, shape [face_count]."""
        return np.ones(len(self.faces), dtype=bool) if self.colours is not None else self.image >= 0

    def colours_at(self, face: np.ndarray, barycentric: np.ndarray) -> np.ndarray:
        """Return RGB in 0..255 at places of faces, shape [n] and [n, 3]; 0 on a face without a colour; shape [n, 3]."""
        found = np.zeros((len(face), 3))
        if self.colours is not None:
            found = np.einsum("nk,nkd->nd", barycentric, self.colours[self.faces[face]].astype(np.float64))
        for index, image in enumerate(self.images):
            rows = np.flatnonzero(self.image[face] == index)
            uv = np.einsum("nk,nkd->nd", barycentric[rows], self.corner_uv[face[rows]])
            found[rows] = sample_image(image, uv)
        return found


def load_coloured(path: Path, units: str, up: str, limits: Limits | None = None) -> ColouredScan:
    """Read a scan's surface with its colours in a limited process, which is this one if it is limited already.

    Args:
        path: A PLY, OBJ, OFF or GLB file.
        units: Its unit, one of `UNITS`.
        up: Its axis that points up, one of `AXES_UP`.
        limits: What reading may cost.

    Raises:
        ColoursMissing: where it has none; the message has the reason where it names a texture.
        BadInput: with a code `scan.*` where it cannot be used.
    """
    if units not in UNITS or up not in AXES_UP:
        raise refusal.ChoiceBad(f"a scan in '{units}' with '{up}' up is not known; submit it anew.")
    limits = limits or Limits()
    form = check_header(path, limits).format
    if limits.is_confined:
        found = _read_or_refuse(path, form)
    else:
        with tempfile.TemporaryDirectory(prefix="garmentq-colours-") as folder:
            target = Path(folder) / "coloured.npz"
            names = {"source": str(path.resolve()), "form": form, "target": str(target)}
            call_limited(f"{__name__}:write_coloured", names, limits)
            found = read_record(ColouredScan, target)
    _check(found)
    if not found.is_coloured.any():
        raise ColoursMissing(f"{path.name} has no colours: {found.fault}." if found.fault else None)
    return ColouredScan(
        UNITS[units] * turn_upright(found.vertices, up),
        found.faces.astype(np.int64),
        found.colours,
        found.corner_uv,
        found.image,
        found.images,
        found.fault,
    )


def write_coloured(source: str, form: str, target: str) -> dict[str, Any]:
    """Read a file's colours and write them as a record; runs in a limited process."""
    write_record(_read_or_refuse(Path(source), form), Path(target))
    return {}


def _read_or_refuse(path: Path, form: str) -> ColouredScan:
    """Read a file; raise `Unreadable` with one line of text for any other failure of a parser."""
    try:
        return _read(path, form)
    except BadInput:
        raise
    except Exception as error:
        if is_memory_short(error):
            raise MemoryError from error
        first = (str(error) or type(error).__name__).strip().split("\n", 1)[0]
        raise refusal.Unreadable(f"{path.name} cannot be read: {first[:160]}; export the mesh again.") from error


def _read(path: Path, form: str) -> ColouredScan:
    if form == "glb":
        return _read_glb(path)
    if form == "obj":
        return _read_obj(path)
    arrays = parse(path, form, textures=True)  # an image of a PLY is sampled at its vertices
    count = len(arrays["faces"])
    corner_uv, image = np.zeros((count, 3, 2)), np.full(count, -1)
    return ColouredScan(arrays["vertices"], arrays["faces"], arrays.get("colours"), corner_uv, image)


def _read_obj(path: Path) -> ColouredScan:
    """Read an OBJ; a face has an image where each of its corners has a coordinate and its material names one."""
    content = read_obj(path, textures=True)
    corners, polygon = content.fans()
    place, uv, material = content.places[corners], content.uv, content.material[polygon]
    corner_uv, image, fault = np.zeros((len(corners), 3, 2)), np.full(len(corners), -1), ""
    images: list[np.ndarray] = []
    try:
        if len(uv) and content.libraries and (place >= 0).any():
            if place.max() >= len(uv):
                raise TextureBad("its texture coordinates are not all there")
            for name, file in list_images(path, content.libraries).items():
                rows = np.isin(material, [n for n, used in enumerate(content.materials) if used == name])
                rows &= (place >= 0).all(axis=1)
                if rows.any():
                    images.append(open_image(path, file))
                    _check_pixel_count(images)
                    image[rows] = len(images) - 1
            corner_uv = uv[np.maximum(place, 0)]
    except TextureBad as error:
        image, images, fault = np.full(len(corners), -1), [], str(error)
    faces = content.corners[corners]
    return ColouredScan(content.vertices, faces, content.colours, corner_uv, image, tuple(images), fault)


def _read_glb(path: Path) -> ColouredScan:
    """Read all parts of a scene; each has an image, vertex colours or the colour of its material."""
    import trimesh

    with path.open("rb") as file:
        scene = trimesh.load_scene(file, file_type=path.suffix.lower()[1:], process=False)
    parts = [part for part in scene.dump() if isinstance(part, trimesh.Trimesh) and len(part.faces)]
    if not parts:
        raise refusal.NoFaces(f"{path.name} holds no triangles; export the garment's mesh.")
    offsets = np.cumsum([0, *(len(part.vertices) for part in parts)])
    images, place = [], {}
    uv, image, colours = [], [], []
    has_colours, fault = False, ""
    for part in parts:
        material = getattr(part.visual, "material", None)
        picture, flat = getattr(material, "baseColorTexture", None), getattr(part.visual, "uv", None)
        index, corner_uv = -1, np.zeros((len(part.faces), 3, 2))
        tone = getattr(material, "baseColorFactor", None)
        colour = np.tile(
            DEFAULT_MATERIAL_COLOUR if tone is None else as_bytes(np.asarray(tone)[:3]), (len(part.vertices), 1)
        )
        has_colours |= tone is not None
        if picture is not None and flat is not None and len(flat) == len(part.vertices):
            try:
                if id(picture) not in place:
                    images.append(decode(picture, "the texture"))
                    _check_pixel_count(images)
                    place[id(picture)] = len(images) - 1
                index, corner_uv = place[id(picture)], np.asarray(flat, np.float64)[part.faces]
            except TextureBad as error:
                fault = str(error)
        elif isinstance(part.visual, trimesh.visual.ColorVisuals) and part.visual.kind == "vertex":
            colour, has_colours = as_bytes(np.asarray(part.visual.vertex_colors)[:, :3]), True
        uv.append(corner_uv)
        image.append(np.full(len(part.faces), index))
        colours.append(colour)
    return ColouredScan(
        np.concatenate([np.asarray(part.vertices, np.float64) for part in parts]),
        np.concatenate([np.asarray(p.faces, np.int64) + o for p, o in zip(parts, offsets[:-1], strict=True)]),
        np.concatenate(colours).astype(np.uint8) if has_colours else None,
        np.concatenate(uv),
        np.concatenate(image),
        tuple(images),
        fault,
    )


def _check_pixel_count(images: list[np.ndarray]) -> None:
    """Raise `TextureBad` where images have more than `MAX_TEXTURE_PIXEL_COUNT` pixels together."""
    if sum(image.shape[0] * image.shape[1] for image in images) > MAX_TEXTURE_PIXEL_COUNT:
        raise TextureBad("its textures have more pixels together than are read")


def _check(found: ColouredScan) -> None:
    """Check shapes and indices (`ReaderCrashed`) and vertices (`NotFinite`) from a limited process."""
    faces, count = found.faces, len(found.faces)
    shapes = found.vertices.shape[1:] == (3,) and faces.shape == (count, 3) and found.image.shape == (count,)
    shapes &= found.corner_uv.shape == (count, 3, 2) and faces.dtype.kind == found.image.dtype.kind == "i"
    shapes &= found.colours is None or found.colours.shape == found.vertices.shape
    shapes &= all(image.ndim == 3 and image.shape[2] == 3 and image.dtype == np.uint8 for image in found.images)
    if not shapes or not count or faces.min() < 0 or faces.max() >= len(found.vertices):
        raise ReaderCrashed()
    if found.image.max() >= len(found.images):
        raise ReaderCrashed()
    if not np.isfinite(found.vertices).all():
        raise refusal.NotFinite("a vertex is NaN or infinite; clean the mesh and export it again.")


def to_coloured_scan(scan: Scan, is_cut: bool = False) -> ColouredScan:
    """Return a checked scan's surface with its vertex colours; `is_cut` as in `ColouredScan`.

    Raises:
        ColoursMissing: where it has none.
    """
    if scan.colours is None:
        raise ColoursMissing()
    colours = np.clip(np.round(255.0 * scan.colours), 0, 255).astype(np.uint8)
    count = len(scan.faces)
    return ColouredScan(scan.vertices, scan.faces, colours, np.zeros((count, 3, 2)), np.full(count, -1), is_cut=is_cut)
