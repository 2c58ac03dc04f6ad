"""Find the person in a scan, drop floor, walls, stands, clutter and flyers, and note what was dropped.

All decisions are made on samples that are uniform over the surface, so that meshes and clouds of any density are one
case, and in shares of the extent, since the unit is not known yet. The piece whose profile is most like a person's is
kept; a second such piece is kept too, so that nobody is dropped silently.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.connectivity import HalfEdges, find_components
from ..geometry.geometry import face_areas, face_normals
from ..geometry.point_normals import find_normals, thin_points
from .planes import find_planes
from .upright import MAX_PERSON_MISFIT, Profile, UprightAxis, find_upright, turn_upright

CLEANING_SAMPLE_COUNT = 24_000
"""Number of surface samples on which all decisions are made: one every 9 mm of a person."""
MAX_CLEANING_ITERATIONS = 3
"""Largest number of iterations, each with new samples of what is left: a person in a room has few of the first."""
MIN_PERSON_SAMPLE_SHARE = 0.5
"""Share of the person's samples above which no iteration follows: thicknesses are shares of the extent, which is then a
person's and not a room's."""
PERSON_BOX_MARGIN_SHARE = 0.1
"""Margin around the box of the person's samples that is kept for the next iteration, as a share of the height."""
LINK_SPACING_RATIO = 2.5
"""Distance up to which samples are linked to one piece [sample spacings]: in a random sample of a surface nearly all
have a neighbour within 1.5, and a hand beyond a hole at the wrist is linked to the arm."""
LINK_DIAGONAL_SHARE = 0.015
"""Distance up to which samples are linked whatever their density, as a share of the diagonal: 3 cm of a person. A
scanner's points are denser on a face than on a leg."""
MAX_PART_GAP_SHARE = 0.04
"""Distance up to which smaller pieces (hair, shoes, hands) are the person's, as a share of the height: 7 cm."""
MIN_SCAN_PIECE_SHARE = 0.002
"""Share of the samples, or of a mesh's area, below which a piece is dropped as flyers: 40 cm2 of a person."""
MIN_SECOND_PERSON_SHARES = (0.35, 0.6)
"""Least ratios of a second person's surface and diagonal to the first one's: a child beside an adult has 0.4, 0.6."""
MAX_SECOND_MISFIT_RATIO = 2.0
"""Largest ratio of a second person's misfit to the first one's; boxes and chairs have more than 3."""
MIN_CANDIDATE_PIECE_SHARE = 0.25
"""Share of the largest piece's samples from which on a piece is a candidate for the person."""


@dataclass(frozen=True)
class CleanedScan:
    """Describe the part of a scan that is kept.

    Attributes:
        is_person: True at points of the person, shape [n].
        samples: Points uniform over the person's surface, in the file's unit and axes, shape [m, 3].
        pieces: Number of separate pieces of a person's size, all of them kept.
        fragment_share: Share of the person's points dropped because their mesh piece is below `MIN_SCAN_PIECE_SHARE`.
        notes: What was dropped, one sentence each.
    """

    is_person: np.ndarray
    samples: np.ndarray
    pieces: int
    fragment_share: float
    notes: tuple[str, ...]


def clean_person(points: np.ndarray, faces: np.ndarray, profiles: list[Profile], axes: tuple[str, ...]) -> CleanedScan:
    """Find the person among the points of a scan.

    Args:
        points: Positions in any unit, shape [n, 3].
        faces: Triangles, shape [f, 3]; of a cloud none.
        profiles: Profiles of people, from `build_profiles`.
        axes: Axes that may point up.
    """
    kept = np.ones(len(points), bool)
    counts: dict[str, int] = {}
    for turn in range(MAX_CLEANING_ITERATIONS):
        rows = np.flatnonzero(kept)
        samples, normals = sample_surface(points, faces, kept)
        judged = _classify_samples(samples, normals, profiles, axes)
        category = _transfer_classes(points[rows], samples, judged.category, judged.link)
        is_last = turn == MAX_CLEANING_ITERATIONS - 1 or judged.is_person.mean() > MIN_PERSON_SAMPLE_SHARE
        if not is_last:
            category[_is_near(points[rows], samples[judged.category == 0])] = 0  # decided in the next iteration
        for number, name in enumerate(SAMPLE_CLASSES[1:], 1):
            counts[name] = counts.get(name, 0) + int((category == number).sum())
        kept[rows[category > 0]] = False
        if is_last or not (category > 0).any() or not kept.any():
            break
    fragments = _find_fragments(points, faces, kept)
    counts["flyers"] = counts.get("flyers", 0) + int(fragments.sum())
    share = float(fragments.sum() / max(kept.sum(), 1))
    kept &= ~fragments
    return CleanedScan(kept, samples[judged.is_person], judged.pieces, share, _describe_dropped(counts, judged.pieces))


SAMPLE_CLASSES = ("kept", "floor or walls", "clutter", "flyers")
"""Names of the classes of samples, by their numbers."""


@dataclass(frozen=True)
class _SampleClassification:
    """Describe each sample's class, which are the first person's, the number of people, and a link's length."""

    category: np.ndarray
    is_person: np.ndarray
    pieces: int
    link: float


def _classify_samples(
    samples: np.ndarray, normals: np.ndarray, profiles: list[Profile], axes: tuple[str, ...]
) -> _SampleClassification:
    from scipy.spatial import cKDTree

    category = np.zeros(len(samples), np.int64)
    for plane in find_planes(samples, normals):
        category[plane.dropped] = 1
    if (category == 0).mean() < MIN_SCAN_PIECE_SHARE:
        category[:] = 0  # With nothing but planes, these are what was scanned.
    left = np.flatnonzero(category == 0)
    tree = cKDTree(samples[left])
    spacing = float(np.median(tree.query(samples[left], min(7, len(left)))[0][:, -1]) * np.sqrt(np.pi / 6))
    link = max(LINK_SPACING_RATIO * spacing, LINK_DIAGONAL_SHARE * float(np.linalg.norm(np.ptp(samples[left], axis=0))))
    pairs = tree.query_pairs(link, output_type="ndarray")
    number, piece = find_components(len(left), pairs[:, 0], pairs[:, 1])
    size = np.bincount(piece, minlength=number)
    rivals = [
        k for k in np.argsort(-size, kind="stable")[:8].tolist() if size[k] >= MIN_CANDIDATE_PIECE_SHARE * size.max()
    ]
    found = {k: find_upright(samples[left[piece == k]], profiles, axes) for k in rivals}
    best = min(rivals, key=lambda k: found[k].misfit / np.sqrt(size[k]))
    is_person = np.zeros(len(samples), bool)
    is_person[left[piece == best]] = True
    whole, is_like = is_person.copy(), found[best].misfit < MAX_PERSON_MISFIT  # else these may be a garment's panels
    pieces = 1
    for k in rivals:
        if k != best and _is_second_person(samples[left[piece == k]], samples[is_person], found[k], found[best]):
            whole[left[piece == k]] = True
            pieces += is_like and _stands_beside(samples[left[piece == k]], samples[is_person], found[best].up)
    height = float(np.ptp(samples[is_person], axis=0).max())
    least = max(3, int(MIN_SCAN_PIECE_SHARE * is_person.sum()))
    for k in np.flatnonzero(size >= least).tolist():
        members = left[piece == k]
        if not whole[members[0]] and _is_part(samples[members], samples[is_person], MAX_PART_GAP_SHARE * height):
            whole[members] = is_person[members] = True
    category[(category == 0) & ~whole] = 2
    category[left[size[piece] < least]] = 3
    return _SampleClassification(category, is_person, pieces, link)


def _is_second_person(piece: np.ndarray, person: np.ndarray, found: UprightAxis, first: UprightAxis) -> bool:
    size = np.linalg.norm(np.ptp(piece, axis=0)) / np.linalg.norm(np.ptp(person, axis=0))
    is_large = len(piece) >= MIN_SECOND_PERSON_SHARES[0] * len(person) and size >= MIN_SECOND_PERSON_SHARES[1]
    return bool(is_large and found.misfit <= MAX_SECOND_MISFIT_RATIO * first.misfit)


def _stands_beside(piece: np.ndarray, person: np.ndarray, up: str) -> bool:
    """Check whether a piece is beside a person, not half of one: heights overlap by over half of the smaller one."""
    heights = [turn_upright(points, up)[:, 1] for points in (piece, person)]
    overlap = min(h.max() for h in heights) - max(h.min() for h in heights)
    return bool(overlap > 0.5 * min(float(np.ptp(h)) for h in heights))


def _is_part(piece: np.ndarray, person: np.ndarray, reach: float) -> bool:
    """Check whether a piece is in the person's box, and most of it near the person."""
    from scipy.spatial import cKDTree

    low, high = person.min(axis=0) - reach, person.max(axis=0) + reach
    if not ((piece >= low) & (piece <= high)).all():
        return False
    distance = cKDTree(person).query(piece)[0]
    return bool(distance.min() < reach and np.median(distance) < 3.0 * reach)


def _transfer_classes(points: np.ndarray, samples: np.ndarray, category: np.ndarray, link: float) -> np.ndarray:
    """Return the class of each point: the nearest sample's, but flyers for kept ones beyond `link`."""
    from scipy.spatial import cKDTree

    distance, nearest = cKDTree(samples).query(points)
    found: np.ndarray = category[nearest]
    found[(distance > link) & (found == 0)] = 3
    return found


def _is_near(points: np.ndarray, person: np.ndarray) -> np.ndarray:
    """Mark points in the box of the person's samples and a margin around it, shape [n]."""
    low, high = person.min(axis=0), person.max(axis=0)
    margin = PERSON_BOX_MARGIN_SHARE * float((high - low).max())
    found: np.ndarray = ((points >= low - margin) & (points <= high + margin)).all(axis=1)
    return found


def _find_fragments(points: np.ndarray, faces: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Mark kept points in pieces of the mesh below `MIN_SCAN_PIECE_SHARE`, or in no kept face, shape [n]."""
    inside = faces[kept[faces].all(axis=1)] if len(faces) else faces
    if not len(inside):
        return np.zeros(len(points), bool)
    number, piece = HalfEdges.of(inside, len(points)).vertex_pieces
    area = face_areas(points, inside)
    size = np.bincount(piece[inside[:, 0]], area, number)
    found: np.ndarray = kept & (size[piece] < MIN_SCAN_PIECE_SHARE * area.sum())
    return found


def _describe_dropped(counts: dict[str, int], pieces: int) -> tuple[str, ...]:
    notes = [f"Dropped {count} points as {name}." for name, count in counts.items() if count]
    if pieces > 1:
        notes.append(f"There are {pieces} separate pieces of a person's size.")
    return tuple(notes)


def sample_surface(points: np.ndarray, faces: np.ndarray, kept: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return about `CLEANING_SAMPLE_COUNT` points uniform over the kept part of a mesh or cloud, with unit normals."""
    if len(faces):
        faces = faces[kept[faces].all(axis=1)]
    if not len(faces):
        sampled = points[kept]
        found = sampled[thin_points(sampled, CLEANING_SAMPLE_COUNT)]
        return found, find_normals(found)
    rng = np.random.default_rng(0)
    area = face_areas(points, faces)
    face = np.sort(rng.choice(len(faces), CLEANING_SAMPLE_COUNT, p=area / area.sum()))
    u, v = np.sqrt(rng.random((CLEANING_SAMPLE_COUNT, 1))), rng.random((CLEANING_SAMPLE_COUNT, 1))
    a, b, c = (points[faces[face, k]] for k in range(3))
    return (1 - u) * a + u * (1 - v) * b + u * v * c, face_normals(points, faces[face])[0]
