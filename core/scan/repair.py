"""Repair defects of scanners and exporters in any unit, and note the repairs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..geometry.connectivity import HalfEdges, find_components
from ..geometry.geometry import area_vectors, face_areas, signed_volume, vertex_normals
from .refusal import PiecesTooMany

MERGE_DISTANCE_SHARE = 1e-7
"""Distance below which vertices are merged, as a share of the bounding box's diagonal: the resolution of float32, in
which STL and most PLY files store the same point once per triangle."""
MAX_SLIVER_HEIGHT_RATIO = 1e-6
"""Ratio of a triangle's height to its longest side up to which its direction is undefined in float32."""
MIN_MESH_PIECE_SHARE = 0.05
"""Share of the largest piece's area below which a separate piece is dropped: it is dust or an eye, never a garment."""
MAX_MESH_PIECE_COUNT = 5000
"""Largest number of separate pieces of a surface: a garment with buttons has a hundred, loose triangles millions."""
MAX_VOTING_FACE_COUNT = 20000
"""Largest number of faces that vote on the outward direction; more change no result."""


@dataclass(frozen=True)
class RepairedMesh:
    """Describe a triangle mesh during the repair.

    Attributes:
        vertices: Positions in the file's unit, shape [vertex_count, 3].
        faces: Vertex indices, shape [face_count, 3].
        origin: Index in the file of each vertex, shape [vertex_count].
        repairs: What was repaired so far, one sentence each.
    """

    vertices: np.ndarray
    faces: np.ndarray
    origin: np.ndarray
    repairs: tuple[str, ...] = ()

    @cached_property
    def edges(self) -> HalfEdges:
        """Return the half-edges, which take seconds for millions of faces; steps that change nothing share them."""
        return HalfEdges.of(self.faces)

    def note(self, count: int, singular: str, plural: str) -> tuple[str, ...]:
        """Return the repairs with one more sentence, or unchanged where `count` is 0."""
        return self.repairs if count == 0 else (*self.repairs, singular if count == 1 else plural.format(count))


def repair_surface(vertices: np.ndarray, faces: np.ndarray) -> RepairedMesh:
    """Return a manifold, consistently and outward oriented surface without dust.

    Merges duplicate vertices; removes degenerate, doubled and non-manifold faces; orients each piece; splits vertices
    of separate fans; drops stray pieces and unused vertices. A clean mesh comes back unchanged and without a note.
    """
    surface = RepairedMesh(vertices, faces, np.arange(len(vertices)))
    for step in (
        _merge_duplicates,
        _drop_degenerate,
        _drop_nonmanifold_faces,
        _orient_pieces,
        _split_fans,
        _drop_stray_pieces,
    ):
        surface = step(surface)
        if len(surface.faces) == 0:
            return surface
    return _turn_outward(_drop_unused(surface))


def mend_surface(surface: RepairedMesh) -> RepairedMesh:
    """Make a surface without duplicate vertices manifold and each of its pieces consistent; no piece is dropped."""
    for step in (_drop_degenerate, _drop_nonmanifold_faces, _orient_pieces, _split_fans):
        if len(surface.faces) == 0:
            return surface
        surface = step(surface)
    return _drop_unused(surface) if len(surface.faces) else surface


def clean_cut(surface: RepairedMesh) -> RepairedMesh:
    """Repair a cut through a repaired surface: split fans that meet in a vertex, drop islands."""
    return _drop_unused(_drop_stray_pieces(_split_fans(surface)))


def _merge_duplicates(surface: RepairedMesh) -> RepairedMesh:
    vertices = surface.vertices
    step = MERGE_DISTANCE_SHARE * float(np.linalg.norm(np.ptp(vertices, axis=0))) or 1.0
    keys = np.round((vertices - vertices.min(axis=0)) / step).astype(np.int64)
    if _are_distinct(_as_numbers(keys)):
        return surface
    first, inverse = _find_equal(keys)
    if len(first) == len(vertices):
        return surface
    # Keep the file's order: each group is represented by its earliest vertex.
    order = np.argsort(first)
    rank = np.argsort(order)
    kept = first[order]
    merged = len(vertices) - len(kept)
    notes = surface.note(merged, "Merged 1 duplicate vertex.", "Merged {} duplicate vertices.")
    return RepairedMesh(vertices[kept], rank[inverse][surface.faces], surface.origin[kept], notes)


_ROW_HASH_FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
"""Factors, odd, for three integers, without a bit pattern (multiplicative hash): few unlike rows have equal sums."""


def _find_equal(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the first of each set of equal rows of integers, shape [k], and the set of each row, shape [n].

    Rows are sorted by hash, in a tenth of the time, or as they are where two unlike rows have the same one.
    """
    _, first, inverse = np.unique(_as_numbers(rows), return_index=True, return_inverse=True)
    if not np.array_equal(rows[first[inverse]], rows):
        _, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, np.ravel(inverse)


def _as_numbers(rows: np.ndarray) -> np.ndarray:
    """Return a hash of each row of three integers, shape [n]."""
    found: np.ndarray = (rows.astype(np.uint64) * _ROW_HASH_FACTORS).sum(axis=1)
    return found


def _are_distinct(numbers: np.ndarray) -> bool:
    ordered = np.sort(numbers)
    return not (ordered[1:] == ordered[:-1]).any()


def _drop_degenerate(surface: RepairedMesh) -> RepairedMesh:
    faces = surface.faces
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    single = _mark_first(np.sort(faces, axis=1))
    doubled = int((distinct & ~single).sum())
    kept = faces[distinct & single]
    kept, flat = _flip_slivers(surface.vertices, kept)
    count = int((~distinct).sum()) + flat
    if doubled + count == 0:
        return surface
    notes = surface.note(count, "Removed 1 degenerate face.", "Removed {} degenerate faces.")
    surface = replace(surface, faces=kept, repairs=notes)
    return replace(surface, repairs=surface.note(doubled, "Removed 1 doubled face.", "Removed {} doubled faces."))


def _mark_first(rows: np.ndarray) -> np.ndarray:
    """Mark the first of equal rows of three indices, shape [n]."""
    found = np.zeros(len(rows), bool)
    if _are_distinct(_as_numbers(rows)):
        return ~found
    found[_find_equal(rows)[0]] = True
    return found


def _flip_slivers(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, int]:
    """Remove flat triangles without opening a crack: each gives its middle vertex to the neighbour at its long side."""
    corners = vertices[faces]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    sides = np.stack([np.sqrt(np.einsum("ij,ij->i", side, side)) for side in (c - b, a - c, b - a)], axis=1)
    area = 2.0 * face_areas(vertices, faces)
    longest = sides.max(axis=1) if len(faces) else np.zeros(0)
    slivers = np.flatnonzero(area <= MAX_SLIVER_HEIGHT_RATIO * longest**2)
    if len(slivers) == 0:
        return faces, 0
    alive = np.ones(len(faces), bool)
    users: dict[int, set[int]] = {int(vertex): set() for vertex in faces[slivers].ravel()}
    touched = np.flatnonzero(np.isin(faces, list(users)).any(axis=1))
    table = {row: faces[row].tolist() for row in touched.tolist()}
    for row, face in table.items():
        for vertex in face:
            if vertex in users:
                users[vertex].add(row)
    extra: list[list[int]] = []
    for sliver in slivers.tolist():
        middle = table[sliver][int(np.argmax(sides[sliver]))]
        ends = [v for v in table[sliver] if v != middle]
        alive[sliver] = False
        shared = [f for f in users[ends[0]] & users[ends[1]] if alive[f] and {*ends} <= {*table[f]}]
        if len(shared) == 1 and middle not in table[shared[0]]:
            face = table[shared[0]]
            extra.append([middle if v == ends[0] else v for v in face])
            table[shared[0]] = [middle if v == ends[1] else v for v in face]
            alive[shared[0]] = area[shared[0]] > MAX_SLIVER_HEIGHT_RATIO * longest[shared[0]] ** 2
    faces = faces.copy()
    faces[touched] = np.array(list(table.values()), np.int64)
    return np.concatenate([faces[alive], np.array(extra, np.int64).reshape(-1, 3)]), len(slivers)


def _drop_nonmanifold_faces(surface: RepairedMesh) -> RepairedMesh:
    """Keep two faces, those of the largest sheets, at each edge that three or more share."""
    faces = surface.faces
    edges = surface.edges
    edge, counts = edges.edge, edges.face_counts
    if counts.max() <= 2:
        return surface
    number, sheet = edges.face_pieces
    size = np.bincount(sheet, weights=face_areas(surface.vertices, faces), minlength=number)
    # Rank the faces of each crowded edge by the area of their sheet; the file's order breaks ties.
    half = np.flatnonzero(counts[edge] > 2)
    order = half[np.lexsort((half, -size[sheet[half // 3]], edge[half]))]
    group = edge[order]
    starts = np.flatnonzero(np.r_[True, group[1:] != group[:-1]])
    position = np.arange(len(order)) - np.repeat(starts, np.diff(np.r_[starts, len(order)]))
    dropped = np.zeros(len(faces), bool)
    dropped[order[position >= 2] // 3] = True
    notes = surface.note(int(dropped.sum()), "Removed 1 non-manifold face.", "Removed {} non-manifold faces.")
    return replace(surface, faces=faces[~dropped], repairs=notes)


def _orient_pieces(surface: RepairedMesh) -> RepairedMesh:
    """Make the faces of each piece agree by turning the minority (by area).

    On the double cover each face occurs twice, as it is and turned; a link joins the versions of two faces that agree.
    The component of a piece's first face has the right versions. A one-sided piece is one component, and is cut next.
    """
    faces = surface.faces
    edges = surface.edges
    if edges.opposed.all():
        return surface
    a, b = edges.pairs.T // 3
    count = len(faces)
    number, piece = edges.face_pieces
    shift = np.where(edges.opposed, 0, count)
    _, version = find_components(2 * count, np.r_[a, a + count], np.r_[b + shift, b + count - shift])
    _, starts = np.unique(piece, return_index=True)
    turned = version[:count] != version[starts][piece]
    area = face_areas(surface.vertices, faces)
    against = np.bincount(piece, weights=area * turned, minlength=number)
    turned ^= (against > 0.5 * np.bincount(piece, weights=area, minlength=number))[piece]
    notes = surface.note(
        int(turned.sum()), "Turned 1 face to agree with the others.", "Turned {} faces to agree with the others."
    )
    return replace(surface, faces=np.where(turned[:, None], faces[:, ::-1], faces), repairs=notes)


def _split_fans(surface: RepairedMesh) -> RepairedMesh:
    """Give each fan of faces around a vertex a vertex of its own.

    Corners of neighbouring faces at a vertex are one where both faces share an edge and agree on its direction; the
    connected sets of corners are the vertices. This cuts what cannot be oriented (a Mobius band).
    """
    faces = surface.faces
    edges = surface.edges
    first, second = edges.pairs[edges.opposed].T
    # Half-edge h starts at corner h and ends where the next one starts.
    first_end, second_end = edges.following[first], edges.following[second]
    number, label = find_components(3 * len(faces), np.r_[first, first_end], np.r_[second_end, second])
    corner = faces.ravel()
    if number == np.count_nonzero(np.bincount(corner)):
        return surface
    _, sample = np.unique(label, return_index=True)
    owner = corner[sample]
    order = np.lexsort((sample, owner))
    kept = owner[order]
    rank = np.argsort(order)
    again = np.r_[False, kept[1:] == kept[:-1]]
    # The first fan keeps the vertex, copies go to the end.
    place = np.zeros(number, np.int64)
    place[~again] = kept[~again]
    place[again] = len(surface.vertices) + np.arange(int(again.sum()))
    copies = kept[again]
    cut = int((~edges.opposed).sum())
    notes = surface.note(len(copies), "Split 1 non-manifold vertex.", "Split {} non-manifold vertices.")
    surface = RepairedMesh(
        np.concatenate([surface.vertices, surface.vertices[copies]]),
        place[rank][label].reshape(-1, 3),
        np.concatenate([surface.origin, surface.origin[copies]]),
        notes,
    )
    return replace(surface, repairs=surface.note(cut, "Cut 1 one-sided edge.", "Cut {} one-sided edges."))


def _drop_stray_pieces(surface: RepairedMesh) -> RepairedMesh:
    number, piece = surface.edges.face_pieces
    if number == 1:
        return surface
    size = np.bincount(piece, weights=face_areas(surface.vertices, surface.faces), minlength=number)
    kept = size >= MIN_MESH_PIECE_SHARE * size.max()
    notes = surface.note(int((~kept).sum()), "Dropped 1 stray piece.", "Dropped {} stray pieces.")
    return replace(surface, faces=surface.faces[kept[piece]], repairs=notes)


def _drop_unused(surface: RepairedMesh) -> RepairedMesh:
    used = np.flatnonzero(np.bincount(surface.faces.ravel(), minlength=len(surface.vertices)))
    if len(used) == len(surface.vertices):
        return surface
    index = np.zeros(len(surface.vertices), np.int64)
    index[used] = np.arange(len(used))
    return RepairedMesh(surface.vertices[used], index[surface.faces], surface.origin[used], surface.repairs)


def boundary_pieces(vertices: np.ndarray, edges: HalfEdges) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return boundary edges [e, 2], the piece of each [e], and each piece's mean [k, 3] and area vector [k, 3].

    The area vector is half the sum of u x v over the directed edges (u, v) about the mean; for outward faces it points
    from the opening into the garment.
    """
    rim = np.stack([edges.tail[edges.border], edges.head[edges.border]], axis=1)
    if len(rim) == 0:
        return rim, np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3))
    used, local = np.unique(rim, return_inverse=True)
    local = local.reshape(-1, 2)
    number, label = find_components(len(used), local[:, 0], local[:, 1])
    piece = label[local[:, 0]]
    sums = np.stack([np.bincount(label, vertices[used, k], number) for k in range(3)], axis=1)
    means = sums / np.bincount(label, minlength=number)[:, None]
    cross = 0.5 * np.cross(vertices[rim[:, 0]] - means[piece], vertices[rim[:, 1]] - means[piece])
    areas = np.stack([np.bincount(piece, cross[:, k], number) for k in range(3)], axis=1)
    return rim, piece, means, areas


def enclosed_volume(vertices: np.ndarray, edges: HalfEdges) -> float:
    """Return the signed volume [unit cubed] of the surface with each opening closed by a fan; outward is positive."""
    rim, piece, means, _ = boundary_pieces(vertices, edges)
    # The lid's triangles run against the boundary's direction.
    lids = np.column_stack([rim[:, 1], rim[:, 0], len(vertices) + piece])
    return signed_volume(np.concatenate([vertices, means]), np.concatenate([edges.faces, lids]))


def _turn_outward(surface: RepairedMesh) -> RepairedMesh:
    """Turn each piece whose volume is negative once its openings are closed."""
    number, piece = surface.edges.face_pieces
    if number > MAX_MESH_PIECE_COUNT:
        raise PiecesTooMany()
    faces = surface.faces
    if number == 1:
        turned = int(enclosed_volume(surface.vertices, surface.edges) < 0.0)
        faces = faces[:, ::-1].copy() if turned else faces
    else:
        faces = faces.copy()
        turned = _turn_inverted(surface.vertices, faces, piece)
    if turned == 0:
        return surface
    notes = surface.note(turned, "Turned the surface outward.", "Turned {} pieces outward.")
    return replace(surface, faces=faces, repairs=notes)


def _turn_inverted(vertices: np.ndarray, faces: np.ndarray, piece: np.ndarray) -> int:
    """Turn, in place, the faces of each piece, shape [face_count], whose volume is negative; return how many are."""
    turned = 0
    for members in np.split(np.argsort(piece, kind="stable"), np.cumsum(np.bincount(piece))[:-1]):
        used, local = np.unique(faces[members], return_inverse=True)  # its own only: there may be thousands of pieces
        if enclosed_volume(vertices[used], HalfEdges.of(local.reshape(-1, 3))) < 0.0:
            faces[members] = faces[members][:, ::-1]
            turned += 1
    return turned


def is_facing_body(vertices: np.ndarray, faces: np.ndarray, body_vertices: np.ndarray, body_faces: np.ndarray) -> bool:
    """Check by an area-weighted vote whether faces point towards the body: against the nearest vertices' normals."""
    from scipy.spatial import cKDTree

    normals = vertex_normals(body_vertices, body_faces)
    pick = np.unique(np.linspace(0, len(faces) - 1, min(MAX_VOTING_FACE_COUNT, len(faces))).astype(np.int64))
    nearest = cKDTree(body_vertices).query(vertices[faces[pick]].mean(axis=1))[1]
    return bool((area_vectors(vertices, faces[pick]) * normals[nearest]).sum() < 0.0)
