"""Find which bones pass through the disk that a contour spans, which way, and where along the bone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...body.body import JOINT_PARENTS, JOINTS, Body
from .loop import smooth_loop, span_disk

LEAF_LENGTHS = {"head": 0.3, "left_foot": 0.5, "right_foot": 0.5, "left_hand": 0.3, "right_hand": 0.3}
"""Lengths by which the skeleton's ends are extended [m], for hoods, hems at the floor and sleeves over the hand."""


@dataclass(frozen=True)
class Crossing:
    """Describe how one bone passes through a contour's disk.

    Attributes:
        bone: The bone's name (its child joint).
        distal: True where the garment is on the far side of the contour seen from the pelvis, as at a waist's spine
            bone for a shirt; False where it is on the near side, as at a cuff.
        place: Where along the bone, 0 at its parent joint and 1 at its child joint.
    """

    bone: str
    distal: bool
    place: float


def find_crossings(points: np.ndarray, body: Body) -> tuple[Crossing, ...]:
    """Find the bones that a closed contour encircles.

    The contour is smoothed and spanned by a harmonic disk whose normal points into the garment (on the contour's left).
    A bone is encircled where its signed passages do not cancel, which depends on the contour and not on the disk. A
    contour that encircles no bone may still be that of a hood on the head, around the face: it is passed by the head's
    forward direction, and counts as one around the head.

    Args:
        points: Positions along the contour [m], garment on the left, shape [n, 3].
        body: The wearer, in the same place and pose.
    """
    vertices, faces = span_disk(smooth_loop(points))
    crossings = _cross(bone_segments(body), vertices[faces])
    return crossings or _cross([_face_segment(body)], vertices[faces])


def _cross(segments: list[tuple[str, np.ndarray, np.ndarray, float]], triangles: np.ndarray) -> tuple[Crossing, ...]:
    """Return the crossings of segments with a disk of triangles [m], shape [n, 3, 3], one per bone."""
    found = []
    for name, start, end, offset in segments:
        signs, places = _pass_triangles(start, end, triangles)
        net = int(signs.sum())
        if net:
            found.append(Crossing(name, net > 0, float(np.mean(places[signs == np.sign(net)])) + offset))
    return _merge(found)


def _face_segment(body: Body) -> tuple[str, np.ndarray, np.ndarray, float]:
    """Return the head's extension in the direction of the face, as `bone_segments`."""
    index = JOINTS.index("head")
    start = body.joints[index]
    return "head", start, start + LEAF_LENGTHS["head"] * body.transforms[index, :3, 2], 1.0


def bone_segments(body: Body) -> list[tuple[str, np.ndarray, np.ndarray, float]]:
    """Return each bone's name, start [m], end [m] and place of its start: 0, or 1 for a leaf's extension."""
    segments = []
    for index, parent in enumerate(JOINT_PARENTS):
        if parent >= 0:
            segments.append((JOINTS[index], body.joints[parent], body.joints[index], 0.0))
    for name, length in LEAF_LENGTHS.items():
        index = JOINTS.index(name)
        parent = JOINT_PARENTS[index]
        # A foot extends the shin below the ankle; a head or hand is extended from its own joint.
        before = JOINT_PARENTS[parent]
        start = body.joints[parent] if name.endswith("foot") else body.joints[index]
        direction = body.joints[parent] - body.joints[before]
        norm = float(np.linalg.norm(direction))
        if norm > 0.0:
            segments.append((name, start, start + direction * (length / norm), 0.0 if name.endswith("foot") else 1.0))
    return segments


def _merge(found: list[Crossing]) -> tuple[Crossing, ...]:
    """Keep one crossing per bone: a leaf's own segment before its extension."""
    single: dict[str, Crossing] = {}
    for crossing in found:
        single.setdefault(crossing.bone, crossing)
    return tuple(single[name] for name in JOINTS if name in single)


def _pass_triangles(start: np.ndarray, end: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Intersect a segment with triangles [n, 3, 3]; return signs (+1 along the face normal) and places of passages.

    The orientations of the segment against the three edges agree where it passes inside (Segura and Feito 2001).
    """
    direction = end - start
    a, b, c = (triangles[:, k] - start for k in range(3))
    u, v, w = (np.cross(p, q) @ direction for p, q in ((b, c), (c, a), (a, b)))
    total = u + v + w
    inside = ((u >= 0) & (v >= 0) & (w >= 0)) | ((u <= 0) & (v <= 0) & (w <= 0))
    normal = np.cross(b - a, c - a)
    height = np.einsum("ij,ij->i", normal, a)
    rate = normal @ direction
    hit = inside & (total != 0.0) & (rate != 0.0)
    place = np.full(len(a), -1.0)
    place[hit] = height[hit] / rate[hit]
    hit &= (place >= 0.0) & (place < 1.0)
    return np.sign(rate[hit]).astype(np.int64), place[hit]
