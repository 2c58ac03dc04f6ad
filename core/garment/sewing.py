"""Mesh a pattern's panels and weld them along the seams into one mesh of nodes."""

from __future__ import annotations

import numpy as np

from ..geometry.connectivity import HalfEdges, find_components
from .errors import MeshTooCoarse, NotOrientable, Place
from .garment import Garment
from .meshing import FlatMesh, MeshSettings, choose_edge_length, count_segments, mesh_panel, refine_counts, split_edges
from .orientation import place_points
from .pattern import EdgeRef, Pattern
from .validity import check_outline

__all__ = ["mesh_pattern"]

MAX_EDGE_SPLIT_ITERATIONS = 4
"""Largest number of iterations that split edges which four triangles would share; one sufficed on all patterns."""


def mesh_pattern(
    pattern: Pattern, vertex_count: int = 4000, edge_length: float | None = None, sweeps: int = MeshSettings.sweeps
) -> Garment:
    """Mesh all panels evenly and sew them. Both sides of every seam, gathered ones too, get the same number of
    vertices, uniform in arc length.

    Args:
        pattern: What to mesh.
        vertex_count: Nodes of the sewn mesh, met within about 4 %.
        edge_length: Edge length [m]; overrides vertex_count.
        sweeps: Force sweeps that make triangles regular; 0 where only lengths and areas are needed.

    Raises:
        MeshTooCoarse: where a panel cannot be meshed at this edge length.
        PanelCrossing: where the reason is a panel's outline that crosses itself.
        NotOrientable: where the seams make a one-sided surface.
    """
    settings = MeshSettings(sweeps)
    size = edge_length or choose_edge_length(pattern, vertex_count)
    counts = count_segments(pattern, size)
    for _ in range(settings.refinements):
        meshes, lost = [], set()
        for panel in pattern.panels:
            mesh, missing = mesh_panel(
                panel, [counts[EdgeRef(panel.name, i)] for i in range(len(panel.edges))], size, settings
            )
            meshes.append(mesh)
            lost |= {EdgeRef(panel.name, i) for i in missing}
        if not lost:
            return sew_panels(pattern, meshes)
        for name in sorted({ref.panel for ref in lost}):
            check_outline(pattern.panel(name))
        counts = refine_counts(pattern, counts, lost)
    names = ", ".join(sorted({ref.panel for ref in lost}))
    places = [Place(ref.panel, edge=ref.edge) for ref in sorted(lost, key=lambda ref: (ref.panel, ref.edge))]
    raise MeshTooCoarse(
        f"the panels {names} are too narrow for edges of {1e3 * size:.0f} mm; raise vertex_count.", *places
    )


def sew_panels(pattern: Pattern, meshes: list[FlatMesh]) -> Garment:
    """Weld the panels' meshes along the seams; a node is at the mean of its vertices' placed positions. Corners of
    triangles become one node where a chain of triangles joins them through shared edges, inner or sewn. So every node
    has one fan of triangles and every open contour is a simple loop, also where seams meet or end.

    Raises:
        NotOrientable: where a seam is not `reversed`: its two loops then have the same direction along it.
        MeshTooCoarse: where a seam joins the ends of one short edge.
    """
    if not all(seam.reversed for seam in pattern.seams):
        raise NotOrientable
    for _ in range(MAX_EDGE_SPLIT_ITERATIONS):
        starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
        uv_faces = np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)])
        edge_uv = _edge_vertices(pattern, meshes, starts)
        uv_node = _weld(uv_faces, edge_uv, pattern, int(starts[-1]))
        crowded = _find_nonmanifold_edges(uv_faces, uv_node, edge_uv)
        if not len(crowded):
            return _assemble(pattern, meshes, starts, uv_faces, edge_uv, uv_node)
        meshes = _split(meshes, starts, crowded)
    raise MeshTooCoarse("a panel is too narrow beside a seam for this edge length; raise vertex_count.")


def _edge_vertices(pattern: Pattern, meshes: list[FlatMesh], starts: np.ndarray) -> dict[EdgeRef, np.ndarray]:
    """Return the uv vertices along every edge, ends included."""
    found = {}
    for panel, mesh, start in zip(pattern.panels, meshes, starts, strict=False):
        ends = np.append(mesh.corner, mesh.boundary_count)
        for i in range(len(panel.edges)):
            found[EdgeRef(panel.name, i)] = start + np.arange(ends[i], ends[i + 1] + 1) % mesh.boundary_count
    return found


def _weld(uv_faces: np.ndarray, edge_uv: dict[EdgeRef, np.ndarray], pattern: Pattern, count: int) -> np.ndarray:
    """Return the node of each uv vertex: ends of sewn segments are joined, nodes numbered by their first uv vertex."""
    pairs = []
    for seam in pattern.seams:
        a, b = edge_uv[seam.a], edge_uv[seam.b][::-1]
        pairs.append(np.stack([a, b], axis=1))
    joined = np.concatenate(pairs) if pairs else np.zeros((0, 2), int)
    label = find_components(count, joined[:, 0], joined[:, 1])[1]
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))
    return rank[inverse]


def _find_nonmanifold_edges(
    uv_faces: np.ndarray, uv_node: np.ndarray, edge_uv: dict[EdgeRef, np.ndarray]
) -> np.ndarray:
    """Return the inner uv edges, shape [n, 2], that once welded join a node to itself or more than two triangles."""
    flat, welded = HalfEdges.of(uv_faces), HalfEdges.of(uv_node[uv_faces])
    crowded = (welded.face_counts[welded.edge] > 2) | (welded.tail == welded.head)
    inner = flat.face_counts[flat.edge] == 2
    if np.any(crowded) and not np.any(crowded & inner):
        ends = flat.edges[np.unique(flat.edge[crowded])]
        places = [Place(ref.panel, edge=ref.edge) for ref, line in edge_uv.items() if np.isin(ends, line).all(1).any()]
        raise MeshTooCoarse("two seams share both ends with one short edge; raise vertex_count.", *places)
    found: np.ndarray = flat.edges[np.unique(flat.edge[crowded & inner])]
    return found


def _split(meshes: list[FlatMesh], starts: np.ndarray, crowded: np.ndarray) -> list[FlatMesh]:
    owner = np.searchsorted(starts, crowded[:, 0], side="right") - 1
    return [
        split_edges(mesh, crowded[owner == i] - starts[i]) if np.any(owner == i) else mesh
        for i, mesh in enumerate(meshes)
    ]


def _assemble(
    pattern: Pattern,
    meshes: list[FlatMesh],
    starts: np.ndarray,
    uv_faces: np.ndarray,
    edge_uv: dict[EdgeRef, np.ndarray],
    uv_node: np.ndarray,
) -> Garment:
    placed = np.concatenate([place_points(p, m.vertices) for p, m in zip(pattern.panels, meshes, strict=True)])
    count = int(uv_node.max()) + 1
    weight = np.bincount(uv_node, minlength=count)
    nodes = np.stack([np.bincount(uv_node, placed[:, k], count) / weight for k in range(3)], axis=1)
    index = np.arange(len(meshes))
    return Garment(
        pattern=pattern,
        nodes=nodes,
        faces=uv_node[uv_faces],
        uv=np.concatenate([mesh.vertices for mesh in meshes]),
        uv_faces=uv_faces,
        uv_node=uv_node,
        panel_of_face=np.repeat(index, [len(mesh.faces) for mesh in meshes]),
        panel_of_uv=np.repeat(index, np.diff(starts)),
        edge_uv=edge_uv,
    )
