"""Read a stored garment from the files of its folder: pattern, meshes, fabric, wearer and numbers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...body.body import Body
from ...cloth.fabric import Fabric
from ...garment.pattern import Pattern
from ...reuse.wear.worn import WORN_FILE_NAME, WornGarment, load_worn
from ...run.errors import BadInput, NotFound
from .sewn_mesh import SewnMesh
from .stored import RECOVERED_MESHES, REUSED_MESHES, garment_stem, load_stored_meshes

if TYPE_CHECKING:
    from .result_picture import Picture

METRICS, MANIFEST, PATTERN = "metrics.json", "manifest.json", "pattern.json"

FILES = (WORN_FILE_NAME, METRICS, MANIFEST, PATTERN, *(f"{name}.ply" for name in (*RECOVERED_MESHES, *REUSED_MESHES)))
"""Names of the files that are read of a result, where it has them."""


class ResultUnreadable(BadInput):
    """This folder has no garment's result; name one with a worn.npz, as `garmentq export JOB --out DIR` writes."""

    code = "result.unreadable"


class MeshUnknown(NotFound):
    """The result has no mesh of that name; `result.meshes` lists them."""

    code = "result.mesh_unknown"


@dataclass(frozen=True)
class StoredResult:
    """Describe the stored result of one garment.

    Attributes:
        name: The scan's name in plain letters.
        worn: The garment at rest on its wearer.
        states: The stored states of the garment, each a mesh of the same topology.
        metrics: Flat dotted names, each with its unit, to numbers; None where one does not apply.
        manifest: Versions, hashes and settings that reproduce it.
    """

    name: str
    worn: WornGarment
    states: tuple[SewnMesh, ...]
    metrics: Mapping[str, float | None]
    manifest: Mapping[str, Any]

    def __repr__(self) -> str:
        """Return a one-line summary; `plot()` draws it."""
        return f"<StoredResult {self.name}: {len(self.pattern.panels)} panels, meshes {', '.join(self.meshes)}>"

    @property
    def pattern(self) -> Pattern:
        """Return the pattern."""
        return self.worn.pattern

    @property
    def fabric(self) -> Fabric:
        """Return the cloth, recovered or chosen."""
        return self.worn.fabric

    @property
    def body(self) -> Body:
        """Return the wearer in the scan's pose."""
        return self.worn.body

    @cached_property
    def meshes(self) -> tuple[str, ...]:
        """Return the names of the meshes."""
        return tuple(state.name for state in self.states)

    def mesh(self, name: str) -> SewnMesh:
        """Return a mesh: its `vertices` [m], shape [n, 3], and `faces`, shape [m, 3].

        Raises:
            MeshUnknown: where there is none of that name.
        """
        for state in self.states:
            if state.name == name:
                return state
        raise MeshUnknown(f"{self.name} has no mesh '{name[:40]}'; it has {', '.join(self.meshes)}.")

    def plot(self, name: str | None = None) -> Picture:
        """Draw a mesh on its wearer, front and back, beside the pattern; a notebook displays the result.

        Args:
            name: A mesh; None: the detail mesh, or the last one if there is none.

        Raises:
            MeshUnknown: where there is none of that name.
        """
        from .result_picture import draw_result

        name = name or ("detail" if "detail" in self.meshes else self.meshes[-1])
        return draw_result(self.mesh(name), self.worn)


def load_result(folder: Path) -> StoredResult:
    """Read a stored garment from the folder of its files.

    Raises:
        ResultUnreadable: where the folder has no garment's result.
        ResultOld: where it was stored by another version.
    """
    if not (folder / WORN_FILE_NAME).is_file():
        below = sorted(path.parent.name for path in folder.glob(f"*/{WORN_FILE_NAME}")) if folder.is_dir() else []
        hint = f"open one of the garments in it: {', '.join(below)}." if below else ResultUnreadable().message
        raise ResultUnreadable(f"{folder}: {hint}")
    worn = load_worn(folder)
    states = tuple(load_stored_meshes(folder, worn))
    return StoredResult(garment_stem(folder), worn, states, _read(folder / METRICS), _read(folder / MANIFEST))


def _read(path: Path) -> dict[str, Any]:
    """Read a JSON object; raise `ResultUnreadable` where the file is not one."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise ResultUnreadable(f"{path.name} of the result cannot be read; get its files anew.")
    return found
