"""Read target packs: garments of other authors with their true patterns, against which `garmentq bench` measures."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...core.judge.true_pattern import TruePanel, TruePattern, TrueSeam
from ...core.run.errors import BadInput, NotFound

FABRIC_PARAMETERS = ("H00", "H01", "H11", "H22", "k", "density")
"""Parameters of a fabric that a pack may have, in the simulator's units (N/m, N m, kg/m2)."""


class PacksMissing(NotFound):
    """No folder with a meta.json was found there; give the folder that holds the target packs."""

    code = "bench.no_packs"


class PackUnknown(NotFound):
    """There is no pack of that name; list the folder to see the names."""

    code = "bench.unknown_pack"


class PackBad(BadInput):
    """A pack's file cannot be read; see the format of target packs in docs/reference/files.md."""

    code = "bench.pack_bad"


@dataclass(frozen=True)
class Pack:
    """Describe the files of one target.

    Attributes:
        name: The folder's name.
        folder: The folder.
        category: The author's category; only for the table, it is not passed to a recovery.
        garment: The target's surface.
        body: The wearer's mesh, or None.
        template: The base pattern, or None.
        scan: The fused scan of person and garment that is the input instead of `garment`, or None.
        labels: Which of its vertices are the garment (`is_garment`, 0 or 1), or None.
        truth_body: The person below the cloth, only to measure, or None.
        fabric: Known parameters of the true cloth, by name (N/m, N m, kg/m2); only to measure. Empty if the author has
            other units, or does not give them.
    """

    name: str
    folder: Path
    category: str
    garment: Path
    body: Path | None
    template: Path | None
    scan: Path | None = None
    labels: Path | None = None
    truth_body: Path | None = None
    fabric: dict[str, float] = field(default_factory=dict)


def read_packs(folder: Path, only: tuple[str, ...] = ()) -> tuple[Pack, ...]:
    """Read the packs of single garments in a folder, in the order of their names; raw packs are skipped.

    Args:
        folder: Folder with one folder per pack; or itself a pack.
        only: Names to keep; empty: all.

    Raises:
        PacksMissing: if no folder has a meta.json.
        PackUnknown: if a name in `only` does not exist.
        PackBad: if a meta.json is not a JSON object.
    """
    return tuple(_read_pack(path) for path in find_packs(folder, only) if not is_raw_pack(path))


def find_packs(folder: Path, only: tuple[str, ...] = ()) -> tuple[Path, ...]:
    """Find the folders of packs of any kind, in the order of their names.

    Raises:
        PacksMissing: if no folder has a meta.json.
        PackUnknown: if a name in `only` does not exist.
    """
    folders = [folder] if (folder / "meta.json").is_file() else sorted(p.parent for p in folder.glob("*/meta.json"))
    if not folders:
        raise PacksMissing(f"'{folder}' has no folder with a meta.json; give the folder that holds the target packs.")
    unknown = sorted(set(only) - {path.name for path in folders})
    if unknown:
        names = ", ".join(path.name for path in folders)
        raise PackUnknown(f"no pack is named {', '.join(repr(name) for name in unknown)}; there are {names}.")
    return tuple(path for path in folders if not only or path.name in only)


def is_raw_pack(folder: Path) -> bool:
    """Return whether a folder holds a raw scan with its truth, and no garment that was cut out of it."""
    return (folder / "scan.ply").is_file() and (folder / "truth").is_dir() and not (folder / "garment.ply").exists()


def read_true_mesh(pack: Pack, path: Path | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Read the truth's surface, or another file of the pack, as `read_mesh_file` does."""
    return read_mesh_file(path or pack.garment)


def read_mesh_file(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Read a surface unchanged: nothing merged, nothing repaired.

    Returns:
        Positions [m], shape [n, 3], and faces, shape [m, 3].

    Raises:
        PackBad: if the file is not a triangle mesh.
    """
    import trimesh

    try:
        mesh: Any = trimesh.load(path, process=False)
        vertices = np.array(mesh.vertices, dtype=np.float64)
        faces = np.array(mesh.faces, dtype=np.int64)
    except Exception as error:  # trimesh raises whatever its reader raised
        raise PackBad(f"the truth '{path}' cannot be read as a triangle mesh.") from error
    if not len(faces) or not np.isfinite(vertices).all():
        raise PackBad(f"the truth '{path}' has no faces, or positions that are not numbers.")
    return vertices, faces


def read_true_pattern(pack: Pack) -> TruePattern | None:
    """Read the truth's pattern, or return None if the pack has none.

    Raises:
        PackBad: if pattern.json does not have the format of target packs.
    """
    path = pack.folder / "pattern.json"
    return read_pattern_file(path) if path.is_file() else None


def read_pattern_file(path: Path) -> TruePattern:
    """Read a true pattern, panels as outlines in metres.

    Raises:
        PackBad: if the file does not have the format of target packs.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        if data.get("unit", "m") != "m":
            raise ValueError("unit")
        panels = tuple(
            TruePanel(
                name,
                np.asarray(panel["outline"], dtype=np.float64).reshape(-1, 2),
                tuple(np.asarray(line, dtype=np.float64).reshape(-1, 2) for line in panel.get("edges") or ()),
            )
            for name, panel in data["panels"].items()
        )
        seams = tuple(TrueSeam(_side(seam["a"]), _side(seam["b"])) for seam in data.get("stitches") or ())
    except (ValueError, KeyError, TypeError, AttributeError, OSError) as error:
        raise PackBad(f"'{path}' is not a true pattern in metres; see docs/reference/files.md.") from error
    return TruePattern(panels, seams)


def _side(side: Any) -> tuple[str, int]:
    return str(side[0]), int(side[1])


def _read_pack(folder: Path) -> Pack:
    try:
        meta = json.loads((folder / "meta.json").read_text(encoding="utf-8"))
        category = str(meta.get("category", ""))
        fabric = {name: float(meta["fabric"][name]) for name in FABRIC_PARAMETERS if name in (meta.get("fabric") or {})}
    except (ValueError, TypeError, AttributeError, OSError) as error:
        raise PackBad(f"'{folder / 'meta.json'}' is not a JSON object; see docs/reference/files.md.") from error

    def find(name: str) -> Path | None:
        return folder / name if (folder / name).is_file() else None

    return Pack(
        name=folder.name,
        folder=folder,
        category=category,
        garment=folder / "garment.ply",
        body=find("body.ply"),
        template=find("template.json"),
        scan=find("scan.ply"),
        labels=find("labels.npz"),
        truth_body=find("truth_body.ply"),
        fabric=fabric,
    )
