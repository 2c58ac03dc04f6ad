"""Select panels of a sewn garment: the part of its mesh that they make."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .garment import Garment


def select_panels(garment: Garment, names: frozenset[str]) -> tuple[Garment, np.ndarray]:
    """Return the part of a garment that some of its panels make, and the number in the garment of each of its nodes."""
    kept = np.array([panel.name in names for panel in garment.pattern.panels])
    faces, vertices = kept[garment.panel_of_face], kept[garment.panel_of_uv]
    nodes, uv_node = np.unique(garment.uv_node[vertices], return_inverse=True)
    of_node, of_uv = np.zeros(len(garment.nodes), np.int64), np.cumsum(vertices) - 1
    of_node[nodes] = np.arange(len(nodes))
    number = np.cumsum(kept) - 1
    pattern = replace(
        garment.pattern,
        panels=tuple(panel for panel in garment.pattern.panels if panel.name in names),
        seams=tuple(seam for seam in garment.pattern.seams if {seam.a.panel, seam.b.panel} <= names),
    )
    part = replace(
        garment,
        pattern=pattern,
        nodes=garment.nodes[nodes],
        faces=of_node[garment.faces[faces]],
        uv=garment.uv[vertices],
        uv_faces=of_uv[garment.uv_faces[faces]],
        uv_node=uv_node,
        panel_of_face=number[garment.panel_of_face[faces]],
        panel_of_uv=number[garment.panel_of_uv[vertices]],
        edge_uv={ref: of_uv[line] for ref, line in garment.edge_uv.items() if ref.panel in names},
        contours=(),
    )
    return part, nodes
