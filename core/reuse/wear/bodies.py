"""Find the body that is to wear a garment: a file's, a described one, or the wearer in another pose."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...body.body import Body
from ...body.builtin import builtin_body
from ...body.posing import pose_body
from ...body.registration import register_body
from ...body.smpl import is_smpl, load_smpl
from ...body.spec import BuiltinWearer
from ...run.hooks import SILENT_HOOKS, Hooks
from ...scan.limits import Limits
from ...scan.load import load_scan
from ...scan.scan import Scan, describe_scan


@dataclass(frozen=True)
class BodyFile:
    """What the file of a body holds.

    Attributes:
        mesh: The mesh of a person, or None.
        body: The person, where the file is of SMPL's format and has its own skeleton, or None.
    """

    mesh: Scan | None = None
    body: Body | None = None


def read_body_file(path: Path, units: str | None, up: str | None, limits: Limits | None = None) -> BodyFile:
    """Read the file of a body.

    Args:
        path: A mesh, or an `.npz` of SMPL's format.
        units: A name of `UNITS`, of the file, or None to find it.
        up: Its axis that points up, or None to find it.
        limits: What the file may be at most.

    Raises:
        BadInput: where it cannot be used.
    """
    if is_smpl(path):
        return BodyFile(body=load_smpl(path))
    return BodyFile(load_scan(path, units=units, up=up, kind="body", limits=limits))


def describe_body_file(given: BodyFile) -> dict[str, Any]:
    """Return what was understood of the file, as JSON values."""
    return {"body": {"format": "smpl"} if given.mesh is None else describe_scan(given.mesh)}


def find_wearer(
    wanted: BodyFile | BuiltinWearer | None, own: Body, pose: str | None = None, hooks: Hooks = SILENT_HOOKS
) -> Body:
    """Return the body that is to wear a garment.

    Args:
        wanted: What a file holds, a built-in body, or None for the wearer.
        own: The wearer.
        pose: One of `POSES` that the body is to take; None: its own.
        hooks: Progress and cancellation.

    Raises:
        BodySpecBad: where the description, or the pose, is none.
        NotHuman: where the mesh is no person's.
    """
    if isinstance(wanted, BodyFile):
        body = wanted.body
        if body is None and wanted.mesh is not None:
            body = register_body(wanted.mesh.vertices, wanted.mesh.faces, name=wanted.mesh.name, hooks=hooks)
        found = own if body is None else body
    else:
        found = own if wanted is None else builtin_body(wanted)
    return found if pose is None else pose_body(found, pose)
