"""Check parsed arrays against the counts that the file's header declares."""

from __future__ import annotations

import numpy as np

from . import refusal
from .header import DeclaredContent
from .limits import Limits


def check_counts(name: str, vertices: np.ndarray, faces: np.ndarray, declared: DeclaredContent, limits: Limits) -> None:
    """Check the numbers of vertices and faces, and that faces refer to existing vertices.

    Args:
        name: The file's name, for the message.
        vertices: Positions, shape [n, 3].
        faces: Indices, shape [m, 3]; of a cloud there are none.
        declared: Content of the header; a parser may split polygons into more faces than declared.
        limits: What reading may cost.

    Raises:
        CountTooLarge, CountsDiffer, IndicesBroken: where that is not so.
    """
    if max(len(vertices), len(faces)) > limits.count:
        raise refusal.CountTooLarge(f"{name} holds more than {limits.count} elements; decimate the mesh.")
    if declared.vertices is not None and len(vertices) != declared.vertices:
        raise refusal.CountsDiffer(
            f"{name} declares {declared.vertices} vertices and holds {len(vertices)}; export the mesh again."
        )
    if declared.faces is not None and len(faces) < declared.faces:
        raise refusal.CountsDiffer(
            f"{name} declares {declared.faces} faces and holds {len(faces)}; export the mesh again."
        )
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        bad = int(faces.min() if faces.min() < 0 else faces.max())
        raise refusal.IndicesBroken(f"{name}: a face refers to vertex {bad} of {len(vertices)}; export the mesh again.")
