"""Find the body for a garment: a file's, a described one, or the wearer in another pose."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...body.body import Body
from ...body.builtin import builtin_body
from ...body.dress_form import register_wearer
from ...body.models.model_file import load_body_model
from ...body.posing import pose_body
from ...body.spec import BuiltinWearer, is_body_model
from ...run.hooks import SILENT_HOOKS, Hooks
from ...scan.limits import Limits
from ...scan.load import load_scan
from ...scan.scan import Scan, describe_scan


@dataclass(frozen=True)
class BodyFile:
    """Describe a body's file: the mesh of a person, or the person if it is of a body model and has its own
    skeleton."""

    mesh: Scan | None = None
    body: Body | None = None


def read_body_file(path: Path, units: str | None, up: str | None, limits: Limits | None = None) -> BodyFile:
    """Read the file of a body.

    Args:
        path: A mesh, or the file of a body model.
        units: Unit of the file, a name of `UNITS`, or None to find it.
        up: Its upward axis, or None to find it.
        limits: Limits of the file.

    Raises:
        BadInput: where it cannot be used.
    """
    if is_body_model(path):
        return BodyFile(body=load_body_model(path))
    return BodyFile(load_scan(path, units=units, up=up, kind="body", limits=limits))


def describe_body_file(file: BodyFile) -> dict[str, Any]:
    """Return how the file was interpreted, as JSON values."""
    if file.body is not None:
        return {"body": {"format": file.body.source.partition(":")[0]}}
    return {"body": describe_scan(file.mesh)} if file.mesh is not None else {"body": {}}


def find_file_body(file: BodyFile, hooks: Hooks = SILENT_HOOKS) -> Body | None:
    """Return the body of a file, registered to its mesh; None where it has neither.

    Raises:
        NotHuman: where the mesh is not a person's.
    """
    if file.body is not None or file.mesh is None:
        return file.body
    return register_wearer(file.mesh.vertices, file.mesh.faces, name=file.mesh.name, hooks=hooks)


def find_wearer(
    chosen: BodyFile | BuiltinWearer | None, wearer: Body, pose: str | None = None, hooks: Hooks = SILENT_HOOKS
) -> Body:
    """Return the body that is to wear a garment.

    Args:
        chosen: A file's body, a built-in body, or None for the wearer.
        wearer: The wearer.
        pose: The body's pose, one of `POSES`; None: its own.
        hooks: Progress and cancellation.

    Raises:
        BodySpecBad: where description or pose is not valid.
        NotHuman: where the mesh is not a person's.
    """
    if isinstance(chosen, BodyFile):
        found = find_file_body(chosen, hooks) or wearer
    else:
        found = wearer if chosen is None else builtin_body(chosen)
    return found if pose is None else pose_body(found, pose)
