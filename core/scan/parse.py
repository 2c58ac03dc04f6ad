"""Parse one untrusted file into plain arrays, in a limited process."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ..run.errors import BadInput
from ..run.sandbox import call_limited, is_memory_short
from . import refusal
from .cloud import parse_pcd, parse_xyz
from .columns import as_bytes, find_colours, find_labels, find_opacity, read_fields
from .limits import Limits
from .obj import read_obj
from .off import load_off
from .texture import add_texture

_UNUSED_MODULES = ("networkx", "scipy")
"""Modules that trimesh imports where they are installed, and no reader here needs: two thirds of a reader's time."""


def parse_file(path: Path, form: str, limits: Limits, textures: bool = False) -> dict[str, np.ndarray]:
    """Parse a file in a limited process, which is this one if it is limited already.

    Args:
        path: The file.
        form: The `format` that its header declares.
        limits: What parsing may cost.
        textures: Whether colours may come from a texture.

    Raises:
        BadInput: where the content cannot be read, or costs too much.
    """
    if limits.is_confined:
        return _parse_or_refuse(path, form, textures)
    with tempfile.TemporaryDirectory(prefix="garmentq-parse-") as folder:
        target = Path(folder) / "arrays.npz"
        names = {"source": str(path.resolve()), "form": form, "target": str(target), "textures": textures}
        call_limited(f"{__name__}:write_arrays", names, limits)
        with np.load(target, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}


def write_arrays(source: str, form: str, target: str, textures: bool = False) -> dict[str, Any]:
    """Parse a file and write its arrays without pickle; runs in a limited process."""
    if form in ("ply", "stl"):
        for name in _UNUSED_MODULES:
            sys.modules.setdefault(name, None)  # type: ignore[arg-type]
    np.savez(target, **_parse_or_refuse(Path(source), form, textures))  # type: ignore[arg-type]
    return {}


def _parse_or_refuse(path: Path, form: str, textures: bool = False) -> dict[str, np.ndarray]:
    """Parse a file; raise `Unreadable` with one line of text for any other failure of a parser."""
    try:
        return parse(path, form, textures)
    except BadInput as error:
        error.message = f"{path.name} cannot be read: {error.message}; export the mesh again."
        raise
    except Exception as error:
        if is_memory_short(error):
            raise MemoryError from error
        first = (str(error) or type(error).__name__).strip().split("\n", 1)[0]
        raise refusal.Unreadable(f"{path.name} cannot be read: {first[:160]}; export the mesh again.") from error


def parse(path: Path, form: str, textures: bool = False) -> dict[str, np.ndarray]:
    """Parse a file into `vertices`, `faces` and, where it has them, `normals`, `colours` (RGB bytes) and `labels`.

    With `textures` colours may come from a texture; where that fails, `told` has the reason.
    """
    if form == "pcd":
        return parse_pcd(path)
    if form == "xyz":
        return parse_xyz(path)
    if form == "obj":
        content = read_obj(path, textures)
        arrays = {"vertices": content.vertices, "faces": content.corners[content.fans()[0]]}
        arrays |= {} if content.colours is None else {"colours": content.colours}
        return add_texture(arrays, path, form, content) if textures else arrays
    if form == "glb":
        return _parse_glb(path, textures)
    if form == "ply":
        from trimesh.exchange.ply import load_ply

        with path.open("rb") as file:
            loaded = load_ply(file, skip_materials=True, fix_texture=False)
        arrays = _pick(loaded)
        return add_texture(arrays, path, form, loaded) if textures else arrays
    if form == "stl":
        from trimesh.exchange.stl import load_stl

        with path.open("rb") as file:
            return _pick(load_stl(file))
    return _pick(load_off(path))


def _pick(loaded: dict[str, Any]) -> dict[str, np.ndarray]:
    """Return positions, faces, colours and labels from what a loader of trimesh returns before making a mesh."""
    vertices = np.asarray(loaded.get("vertices", np.zeros((0, 3))), dtype=np.float64)
    faces = loaded.get("faces")
    arrays = {
        "vertices": vertices,
        "faces": np.zeros((0, 3), np.int64) if faces is None or len(faces) == 0 else np.asarray(faces, np.int64),
    }
    colours = loaded.get("vertex_colors")
    if colours is not None and len(colours) == len(vertices) and np.ndim(colours) == 2:
        arrays["colours"] = as_bytes(np.asarray(colours)[:, :3])
    rows = loaded.get("metadata", {}).get("_ply_raw", {}).get("vertex", {}).get("data")
    fields = read_fields(rows)
    if "colours" not in arrays and (found := find_colours(fields, len(vertices))) is not None:
        arrays["colours"] = found
    if (opacity := find_opacity(fields, len(vertices))) is not None:
        arrays["opacity"] = opacity
    if {"nx", "ny", "nz"} <= set(fields):
        normals = np.stack([np.ravel(fields[name]).astype(np.float64) for name in ("nx", "ny", "nz")], axis=-1)
        if normals.shape == vertices.shape:
            arrays["normals"] = normals
    labels = find_labels(fields, len(vertices))
    if labels is not None:
        arrays["labels"] = labels
    return arrays


def _parse_glb(path: Path, textures: bool) -> dict[str, np.ndarray]:
    import trimesh

    with path.open("rb") as file:
        scene = trimesh.load_scene(file, file_type=path.suffix.lower()[1:], skip_materials=not textures, process=False)
    dumped = scene.dump()
    parts = [part for part in dumped if isinstance(part, trimesh.Trimesh) and len(part.faces)]
    if not parts:
        return _join_clouds([part for part in dumped if isinstance(part, trimesh.PointCloud)])
    offsets = np.cumsum([0, *(len(part.vertices) for part in parts)])
    arrays = {
        "vertices": np.concatenate([np.asarray(part.vertices, np.float64) for part in parts]),
        "faces": np.concatenate([np.asarray(p.faces, np.int64) + o for p, o in zip(parts, offsets[:-1], strict=True)]),
    }
    visuals = [part.visual for part in parts if isinstance(part.visual, trimesh.visual.ColorVisuals)]
    if len(visuals) == len(parts) and all(look.kind == "vertex" for look in visuals):
        arrays["colours"] = as_bytes(np.concatenate([np.asarray(look.vertex_colors)[:, :3] for look in visuals]))
    return add_texture(arrays, path, "glb", parts) if textures else arrays


def _join_clouds(parts: list[Any]) -> dict[str, np.ndarray]:
    if not parts:
        raise refusal.MeshEmpty("it holds neither triangles nor points")
    arrays = {
        "vertices": np.concatenate([np.asarray(part.vertices, np.float64) for part in parts]),
        "faces": np.zeros((0, 3), np.int64),
    }
    colours = [getattr(part, "colors", None) for part in parts]
    if all(each is not None and len(each) == len(part.vertices) for each, part in zip(colours, parts, strict=True)):
        arrays["colours"] = as_bytes(np.concatenate([np.asarray(each)[:, :3] for each in colours]))
    return arrays
