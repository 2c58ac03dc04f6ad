"""Name a garment's open contours by the bones that each one encircles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...body.body import Body
from ...body.girths import MIN_LIMB_GIRTH
from .encirclement import Crossing, find_crossings
from .laps import divide_lap
from .legs import split_legs
from .loop import find_loops, smoothed_length
from .open_front import FrontBorder, divide_front
from .rim_gaps import average_normals, bridge_bays, bridge_bites
from .slits import name_slit
from .target import Contour
from .zigzag import find_cut_contours

TRUNK_BONES = ("spine1", "spine2", "spine3", "neck", "head")
"""Bones of the trunk from the pelvis upward."""
ARM_BONES = ("collar", "shoulder", "elbow", "wrist", "hand")
"""Bones of an arm from the chest outward, without their side."""
LEG_BONES = ("hip", "knee", "ankle", "foot")
"""Bones of a leg from the pelvis outward, without their side."""
ARMHOLE_END = 0.31
"""Share of the upper arm above which a sleeveless garment's armhole is: a dropped shoulder reaches 0.26, and the
shortest sleeves of T-shirts, 9 cm long, end at 0.35; this is the middle."""
WAIST_END = 0.6
"""Share of the way from the pelvis to the neck joint below which a skirt's or trousers' waist is: a high waist reaches
0.53, below the bust; the upper edge of a strapless top is at 0.65 to 0.75, at the armpits."""
MAX_BRIDGED_SHARE = 0.3
"""Largest share of a trusted contour that was bridged; above it the chords determine its shape more than the cloth."""


@dataclass(frozen=True)
class _Candidate:
    vertices: np.ndarray
    length: float
    crossings: tuple[Crossing, ...]
    name: str | None
    bridged: float = 0.0
    """Share of the contour's length that was bridged."""
    is_closed: bool = True
    """Whether it is a whole loop, and no part of one."""


def name_contours(
    vertices: np.ndarray,
    faces: np.ndarray,
    body: Body,
    unseen: np.ndarray | None = None,
    scanned: bool = False,
    hidden: np.ndarray | None = None,
) -> tuple[tuple[Contour, ...], tuple[np.ndarray, ...]]:
    """Name the open contours of a worn garment and separate them from holes.

    | bones through the contour's disk | garment is | name |
    |---|---|---|
    | trunk, beyond 0.6 of the way to the neck, or both collars | towards the pelvis | neck |
    | trunk, otherwise | towards the pelvis | waist |
    | trunk | away from the pelvis | hem |
    | bones of both legs | towards the pelvis | hem |
    | bones of both legs | away from the pelvis | waist |
    | bones of one arm, beyond 0.31 of the upper arm | | cuff.SIDE |
    | bones of one arm, otherwise | | armhole.SIDE |
    | bones of one leg | towards the pelvis | leg.SIDE |

    The border of an open front is neckline, front edges and hem in one loop (`divide_front`): its neckline and hem are
    named by what they encircle when their ends are joined, its edges front.left and front.right. The border of a
    wrapped front that is scanned crosses itself (`divide_lap`): what is seen of it is the neck, closed by that step,
    what the outer front covers is `wrap`.

    A hole that broke through a contour is bridged at its mouth. Holes are loops that encircle no bone, the shorter of
    two of one name, and names that no category has beside the others (a hem beside two legs, a waist beside a neck).

    Args:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: Outward faces, shape [face_count, 3].
        body: The wearer.
        unseen: True at vertices beyond which the scanner saw nothing, shape [vertex_count], or None. Skin beyond a
            contour proves design; a bay with nothing beyond is damage, however wide its mouth.
        scanned: Whether the surface is a scan's, in which holes can break through a contour and a contour can be a cut.
            Our own meshes have no holes, however deep a neckline, and teeth only where they are coarse.
        hidden: True at vertices where the garment may go on beyond its border, shape [vertex_count], or None.

    Returns:
        The contours in the order of their names, not trusted where much of one is bridged or hidden, or it alone has
        the teeth of a cut; and the vertex loops of the holes, longest first.
    """
    candidates = []
    for loop in find_loops(faces, vertices):
        front = _divide_front(loop, vertices, body)
        if front:
            candidates += front
            continue
        length = smoothed_length(vertices[loop])
        crossings = find_crossings(vertices[loop], body) if length >= MIN_LIMB_GIRTH else ()
        candidates.append(_Candidate(loop, length, crossings, name_crossings(crossings, body)))
    if scanned:
        candidates = [part for candidate in candidates for part in _divide_lap(candidate, vertices, body)]
    if unseen is not None:
        candidates = [part for candidate in candidates for part in _bridge_bays(candidate, vertices, faces, unseen)]
    if scanned:
        candidates = [part for candidate in candidates for part in _bridge_bites(candidate, vertices, faces, body)]
        candidates = [part for candidate in candidates for part in _split_legs(candidate, vertices, body)]
    chosen = _choose(candidates)
    loops = {name: c.vertices for name, c in chosen.items()}
    cut = find_cut_contours(loops, vertices, faces) if scanned and unseen is None else frozenset()
    contours = tuple(
        Contour(
            name,
            c.vertices,
            c.length,
            tuple(crossing.bone for crossing in c.crossings),
            max(c.bridged, _share(c.vertices, hidden)) <= MAX_BRIDGED_SHARE and name not in cut,
            _share(c.vertices, hidden) > MAX_BRIDGED_SHARE,
            c.is_closed,
        )
        for name, c in sorted(chosen.items())
    )
    holes = [c for c in candidates if chosen.get(c.name or "") is not c]
    return contours, tuple(c.vertices for c in sorted(holes, key=lambda c: -c.length))


def _share(loop: np.ndarray, marked: np.ndarray | None) -> float:
    """Return the share of a loop's vertices that are marked."""
    return 0.0 if marked is None else float(marked[loop].mean())


def _divide_front(loop: np.ndarray, vertices: np.ndarray, body: Body) -> list[_Candidate]:
    """Return neckline, hem and front edges of a loop that is the border of an open front; none where it is not. A hood
    that stands behind the head begins below the jaw, at the neck."""
    for limit in ("head", "neck"):
        parts = divide_front(vertices[loop], body, limit)
        found = [] if parts is None else _name_front(parts, loop, vertices, body)
        if found:
            return found
    return []


def _name_front(parts: FrontBorder, loop: np.ndarray, vertices: np.ndarray, body: Body) -> list[_Candidate]:
    """Return the parts of a loop by name; none where they do not go around the trunk as neckline and hem."""
    found = []
    for name, part in (("neck", parts.neck), ("hem", parts.hem)):
        points = vertices[loop[part]]
        if smoothed_length(points) < MIN_LIMB_GIRTH:
            return []
        crossings = find_crossings(points, body)
        if name_crossings(crossings, body) != name:
            return []
        found.append(_Candidate(loop[part], arc_length(points), crossings, name, is_closed=False))
    for name, part in (("front.left", parts.left), ("front.right", parts.right)):
        found.append(_Candidate(loop[part], arc_length(vertices[loop[part]]), (), name, is_closed=False))
    return found


def _divide_lap(candidate: _Candidate, vertices: np.ndarray, body: Body) -> list[_Candidate]:
    """Return the neck and the covered part of the border of a wrapped front, or else the candidate."""
    if candidate.name != "neck" or not candidate.is_closed:
        return [candidate]
    loop = candidate.vertices
    parts = divide_lap(vertices[loop], body)
    if parts is None:
        return [candidate]
    seen, covered = loop[parts.seen], loop[parts.covered]
    length = smoothed_length(vertices[seen])
    crossings = find_crossings(vertices[seen], body) if length >= MIN_LIMB_GIRTH else ()
    if name_crossings(crossings, body) != "neck":
        return [candidate]
    step = float(np.linalg.norm(vertices[seen[-1]] - vertices[seen[0]]))
    return [
        _Candidate(seen, length, crossings, "neck", step / length),
        _Candidate(covered, arc_length(vertices[covered]), (), "wrap", is_closed=False),
    ]


def arc_length(points: np.ndarray) -> float:
    """Return the length of an open line [m], shape [n, 3], smoothed as a contour's."""
    return smoothed_length(points) - float(np.linalg.norm(points[-1] - points[0]))


def _split_legs(candidate: _Candidate, vertices: np.ndarray, body: Body) -> list[_Candidate]:
    """Return the hems of two legs for a hem that is pinched between them, or else the candidate."""
    parts = split_legs(vertices[candidate.vertices]) if candidate.name == "hem" else None
    legs = []
    for part in parts or ():
        loop = candidate.vertices[part]
        crossings = find_crossings(vertices[loop], body)
        name, length = name_crossings(crossings, body), smoothed_length(vertices[loop])
        legs.append(_Candidate(loop, length, crossings, name, candidate.bridged))
    return legs if {leg.name for leg in legs} == {"leg.left", "leg.right"} else [candidate]


def _bridge_bites(candidate: _Candidate, vertices: np.ndarray, faces: np.ndarray, body: Body) -> list[_Candidate]:
    """Cut holes that broke through a contour off it; return it and them. A placket or a vent is no hole."""
    if candidate.name is None or not candidate.is_closed:
        return [candidate]
    loop, is_neck = candidate.vertices, candidate.name == "neck"
    find_normals = partial(average_normals, vertices, faces, loop)
    kept, gaps = bridge_bites(vertices[loop], find_normals, pointed=is_neck)
    names = [name_slit(candidate.name, vertices[loop[gap]], body) for gap in gaps]
    slits = [gap for gap, name in zip(gaps, names, strict=True) if name is not None]
    holes = tuple(gap for gap, name in zip(gaps, names, strict=True) if name is None)
    kept = np.unique(np.concatenate([kept, *slits])) if slits else kept
    return _cut_off(candidate, vertices, kept, holes)


def _bridge_bays(
    candidate: _Candidate, vertices: np.ndarray, faces: np.ndarray, unseen: np.ndarray
) -> list[_Candidate]:
    """Cut bays beyond which the scanner saw nothing off a contour; return it and them."""
    if candidate.name is None or not candidate.is_closed:
        return [candidate]
    loop = candidate.vertices
    bays = bridge_bays(vertices[loop], average_normals(vertices, faces, loop), unseen[loop])
    return _cut_off(candidate, vertices, *bays)


def _cut_off(
    candidate: _Candidate, vertices: np.ndarray, kept: np.ndarray, gaps: tuple[np.ndarray, ...]
) -> list[_Candidate]:
    """Return a contour without its bites, and these as holes; whole and not trusted if little would be left."""
    if not gaps:
        return [candidate]
    loop, rims = candidate.vertices[kept], [candidate.vertices[gap] for gap in gaps]
    mouths = sum(float(np.linalg.norm(vertices[rim[-1]] - vertices[rim[0]])) for rim in rims)
    length = smoothed_length(vertices[loop])
    if length < MIN_LIMB_GIRTH:  # what is left encircles nothing
        return [replace(candidate, bridged=1.0)]
    parts = [replace(candidate, vertices=loop, length=length, bridged=candidate.bridged + mouths / length)]
    return parts + [_Candidate(rim, smoothed_length(vertices[rim]), (), None) for rim in rims]


def name_crossings(crossings: tuple[Crossing, ...], body: Body) -> str | None:
    """Name a contour by the bones that cross its disk, or None where it encircles nothing."""
    legs = {side: _limb_crossings(crossings, side, LEG_BONES) for side in ("left", "right")}
    arms = {side: _limb_crossings(crossings, side, ARM_BONES) for side in ("left", "right")}
    trunk = [crossing for crossing in crossings if crossing.bone in TRUNK_BONES]
    if trunk:
        if trunk[-1].distal:
            return "hem"
        return "neck" if trunk_place(trunk[-1], body) > WAIST_END else "waist"
    if legs["left"] and legs["right"]:
        return "waist" if legs["left"][0].distal and legs["right"][0].distal else "hem"
    if arms["left"] and arms["right"]:
        return "hem" if arms["left"][0].distal else "neck"
    for side in ("left", "right"):
        if arms[side]:
            return f"cuff.{side}" if limb_place(crossings, side, ARM_BONES) > ARMHOLE_END else f"armhole.{side}"
        if legs[side]:
            return None if all(crossing.distal for crossing in legs[side]) else f"leg.{side}"
    return None


def trunk_place(crossing: Crossing, body: Body) -> float:
    """Place a contour along the spine by arc length: 0 at the pelvis, 1 at the neck joint, more at the head."""
    joints = np.stack([body.joint(name) for name in ("pelvis", *TRUNK_BONES)])
    lengths = np.linalg.norm(np.diff(joints, axis=0), axis=1)
    bone = TRUNK_BONES.index(crossing.bone)
    to_neck = float(lengths[: TRUNK_BONES.index("neck") + 1].sum())
    return (float(lengths[:bone].sum()) + crossing.place * float(lengths[bone])) / to_neck


def limb_place(crossings: tuple[Crossing, ...], side: str, limb: tuple[str, ...]) -> float:
    """Place a contour along a limb: 0 at the shoulder (hip), 1 at the elbow (knee), 2 at the wrist (ankle).

    If several bones of a bent limb meet the disk, the one nearest to the trunk counts.
    """
    limb_crossings = _limb_crossings(crossings, side, limb)
    first = 2 if limb is ARM_BONES else 1
    return min((limb.index(c.bone.split("_", 1)[1]) - first + c.place for c in limb_crossings), default=float("nan"))


def _limb_crossings(crossings: tuple[Crossing, ...], side: str, limb: tuple[str, ...]) -> list[Crossing]:
    return [crossing for crossing in crossings if crossing.bone in {f"{side}_{part}" for part in limb}]


def _choose(candidates: list[_Candidate]) -> dict[str, _Candidate]:
    """Keep the longest candidate of each name, and only names that one category has together."""
    chosen: dict[str, _Candidate] = {}
    for candidate in candidates:
        name = candidate.name
        if name and (name not in chosen or candidate.length > chosen[name].length):
            chosen[name] = candidate
    if "leg.left" in chosen and "leg.right" in chosen:
        chosen.pop("hem", None)
    if "neck" in chosen:
        chosen.pop("waist", None)
    for side in ("left", "right"):
        if f"cuff.{side}" in chosen:
            chosen.pop(f"armhole.{side}", None)
    # One leg alone beside no other lower contour is a hem that misses the other, lifted leg.
    legs = [name for name in ("leg.left", "leg.right") if name in chosen]
    if len(legs) == 1 and "hem" not in chosen:
        chosen["hem"] = chosen.pop(legs[0])
    return chosen
