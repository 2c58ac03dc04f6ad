"""Measure ease: the length of cloth around a body less the body's girth, where a tailor measures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...body.body import Body
from ...body.girths import GIRTHS, Girth, TapeMeasure
from ...body.skinning import unskin, weights_at
from ...garment.garment import Garment
from ...geometry.connectivity import find_components
from ...geometry.intersections import self_intersections
from ...recover.drape.waist import flat_length

LEG_OFFSET_SHARE = 0.5
"""Share of the hip joint's distance from the median plane beyond which cloth is one leg's; a skirt's is centred."""


EASE_LEVEL_OFFSETS = (0.0, 0.02, 0.04, 0.06)
"""Offsets of the levels at which cloth is measured from the body's level [m], over a hand's breadth: downward at chest
and thigh, upward at the hips, outward along the arm. At the chest the shortest line counts, since a wide sleeve joins
the line of the chest's level. Elsewhere the least ease counts, where the garment is tightest: a line at a fork (a low
crotch, the end of an armhole) is longer than those beside it and changes abruptly."""


@dataclass(frozen=True)
class Ease:
    """Describe the unstretched length of cloth around the body and the body's girth at one of `GIRTHS` [m]."""

    place: str
    garment: float
    body: float

    @property
    def value(self) -> float:
        """Return the ease [m]; negative where the cloth is shorter than the girth."""
        return self.garment - self.body


@dataclass(frozen=True)
class MeasuredBody:
    """Describe a body's measures, taken once for many garments: the tape on its T-pose, and the girths by place."""

    tape: TapeMeasure
    girths: Mapping[str, Girth]

    @classmethod
    def of(cls, body: Body) -> MeasuredBody:
        """Measure a body."""
        tape = TapeMeasure.of(body)
        return cls(tape, {place: tape.measure(place) for place in GIRTHS})

    @property
    def leg_offset(self) -> float:
        """Return the distance from the median plane beyond which cloth is one leg's [m]."""
        return LEG_OFFSET_SHARE * abs(float(self.tape.body.joint("left_hip")[0]) - self.centre)

    @property
    def centre(self) -> float:
        """Return x of the body's median plane [m]."""
        return float(self.tape.body.joint("pelvis")[0])

    def trunk(self, level: float) -> np.ndarray:
        """Return the centre of the trunk [m], shape [3], at a height, on the line from pelvis to neck."""
        pelvis, neck = (self.tape.body.joint(name) for name in ("pelvis", "neck"))
        found: np.ndarray = pelvis + (level - pelvis[1]) / (neck[1] - pelvis[1]) * (neck - pelvis)
        return found

    def arm(self, side: str, level: float) -> np.ndarray:
        """Return the centre of an arm [m], shape [3], at the same distance from the median plane as x = level."""
        shoulder, elbow = (self.tape.body.joint(f"{side}_{joint}") for joint in ("shoulder", "elbow"))
        share = (abs(level - self.centre) - abs(shoulder[0] - self.centre)) / abs(elbow[0] - shoulder[0])
        found: np.ndarray = shoulder + share * (elbow - shoulder)
        return found


def measure_ease(garment: Garment, body: Body) -> tuple[Ease, ...]:
    """Measure the ease of a worn garment wherever cloth surrounds the body.

    The levels are those of the body's T-pose, to which the cloth is mapped back; the cloth's length at such a level is
    measured flat, in the pattern. A garment that hangs from the waist is measured there along its own edge. Lines near
    crossed faces are ignored, since cloth there is not in a possible state.

    Args:
        garment: The garment, nodes on the body.
        body: The wearer.
    """
    return measure_unposed_ease(_drop_crossed_faces(garment), unpose_points(garment.nodes, body), MeasuredBody.of(body))


def _drop_crossed_faces(garment: Garment) -> Garment:
    """Drop the cloth within a hand's breadth of crossed faces, where it is crumpled and level lines are longer."""
    crossed = self_intersections(garment.nodes, garment.faces)
    if not len(crossed):
        return garment
    is_far = cKDTree(garment.nodes[np.unique(garment.faces[crossed])]).query(garment.nodes)[0] > EASE_LEVEL_OFFSETS[-1]
    kept = is_far[garment.faces].any(axis=1)
    return replace(
        garment,
        faces=garment.faces[kept],
        uv_faces=garment.uv_faces[kept],
        panel_of_face=garment.panel_of_face[kept],
    )


def unpose_points(nodes: np.ndarray, body: Body) -> np.ndarray:
    """Map points on a wearer [m], shape [n, 3], with the skin to the T-pose."""
    return unskin(nodes, weights_at(body, nodes, rest=False), body.transforms)


def measure_unposed_ease(garment: Garment, nodes: np.ndarray, figure: MeasuredBody) -> tuple[Ease, ...]:
    """Measure the ease as `measure_ease` does, of cloth on a body's T-pose.

    Args:
        garment: The cloth.
        nodes: Its nodes there [m], shape [node_count, 3].
        figure: The body.
    """
    found = []
    for place in GIRTHS:
        if place == "waist" and (waist := garment.contour("waist")) is not None:
            girth = figure.tape.trunk(float(nodes[waist.vertices, 1].mean())).value
            found.append(Ease(place, flat_length(garment, waist.vertices), girth))
            continue
        around = {"hip": _hip_ease, "thigh": _thigh_ease, "upper_arm": _arm_ease}.get(place, _trunk_ease)
        one = around(garment, nodes, figure, place)
        if one is not None:
            found.append(one)
    return tuple(found)


@dataclass(frozen=True)
class ClothSlice:
    """Describe the closed lines along which a plane cuts cloth.

    Attributes:
        lengths: Length of each line in the flat pattern [m], straight across each panel, shape [line_count].
        middles: Mean coordinate of each on the other of x and y [m], shape [line_count].
        pieces: The segments of each line in the plane [m], the other of x and y first, then z; shape [n, 2, 2] each.
    """

    lengths: np.ndarray
    middles: np.ndarray
    pieces: tuple[np.ndarray, ...] = ()

    def length(self, chosen: np.ndarray) -> float | None:
        """Return the length of the longest of chosen lines [m], or None where there is none."""
        return float(self.lengths[chosen].max()) if chosen.any() else None

    def encloses(self, point: np.ndarray) -> np.ndarray:
        """Check which lines enclose a point of the plane [m], shape [2], by the parity of a ray's crossings.

        Returns:
            Shape [line_count].
        """
        return np.array([_crosses_ray(piece - point) % 2 == 1 for piece in self.pieces], dtype=bool)


def slice_cloth(garment: Garment, nodes: np.ndarray, axis: int, level: float) -> ClothSlice:
    """Cut cloth by the plane normal to an axis at a level [m]; lines that end at the cloth's border are left out.

    Args:
        garment: The cloth.
        nodes: Its nodes [m], shape [node_count, 3].
        axis: 0 for x, 1 for y.
        level: Coordinate of the plane [m].
    """
    side = nodes[:, axis] > level
    inside = side[garment.faces]
    cut = np.flatnonzero(inside.any(axis=1) & ~inside.all(axis=1))
    if not len(cut):
        return ClothSlice(np.zeros(0), np.zeros(0))
    faces, flat = garment.faces[cut], garment.rest[cut]
    ahead = np.roll(faces, -1, axis=1)
    crossed = side[faces] != side[ahead]  # two of a face's three edges
    share = (level - nodes[faces, axis]) / np.where(crossed, nodes[ahead, axis] - nodes[faces, axis], 1.0)
    points = flat + share[..., None] * (np.roll(flat, -1, axis=1) - flat)
    ends = points[crossed].reshape(-1, 2, 2)
    number, part = _join_segments(faces, crossed, len(nodes))
    of_face = part[number[:, 0]]
    count = int(part.max()) + 1
    lengths = np.zeros(count)
    for line, length in _measure_panel_chords(ends, garment.uv_faces[cut], crossed, len(garment.uv), of_face):
        lengths[line] += length
    beside = nodes[faces, 1 - axis].mean(axis=1)
    middles = np.bincount(of_face, beside, count) / np.maximum(np.bincount(of_face), 1)
    closed = np.bincount(of_face, minlength=count) == np.bincount(part, minlength=count)
    within = nodes[faces][..., [1 - axis, 2]]
    worn = (within + share[..., None] * (np.roll(within, -1, axis=1) - within))[crossed].reshape(-1, 2, 2)
    pieces = tuple(worn[of_face == line] for line in np.flatnonzero(closed))
    return ClothSlice(lengths[closed], middles[closed], pieces)


def _crosses_ray(pieces: np.ndarray) -> int:
    """Count the segments, shape [n, 2, 2], that cross the ray from the origin along the first axis."""
    start, end = pieces[:, 0], pieces[:, 1]
    rises = (start[:, 1] > 0.0) != (end[:, 1] > 0.0)
    start, end = start[rises], end[rises]
    along = start[:, 0] - start[:, 1] * (end[:, 0] - start[:, 0]) / (end[:, 1] - start[:, 1])
    return int((along > 0.0).sum())


def _join_segments(corners: np.ndarray, crossed: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of the two cut edges of each cut face, [face_count, 2], and the line of each edge. Corners
    [face_count, 3] are numbered below `count`; `crossed` marks a face's cut edges, two of three."""
    sides = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2)
    edges, number = np.unique((sides @ [count, 1])[crossed], return_inverse=True)
    number = number.reshape(-1, 2)
    return number, find_components(len(edges), number[:, 0], number[:, 1])[1]


def _measure_panel_chords(
    ends: np.ndarray, corners: np.ndarray, crossed: np.ndarray, count: int, of_face: np.ndarray
) -> list[tuple[int, float]]:
    """Return the line and the length [m] of each piece of a line in one panel: straight from border to border, or its
    own length where it ends at no border. Worn cloth bags and folds, and a level line then wiggles in the panel; the
    girth is the straight distance between the seams.

    Args:
        ends: Where each face is cut, in the flat pattern [m], shape [face_count, 2, 2].
        corners: Corners of the faces in the flat pattern, shape [face_count, 3], numbered below `count`.
        crossed: Which of a face's edges are cut.
        of_face: The line of each face.
    """
    number, piece = _join_segments(corners, crossed, count)
    times = np.bincount(number.ravel())
    at_border = times[number] == 1
    of_piece = piece[number[:, 0]]
    along = np.bincount(of_piece, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))
    found = []
    for each in range(len(along)):
        of_panel = of_piece == each
        tips = ends[of_panel][at_border[of_panel]]
        length = float(np.linalg.norm(tips[1] - tips[0])) if len(tips) == 2 else float(along[each])
        found.append((int(of_face[of_panel][0]), length))
    return found


def _trunk_ease(garment: Garment, nodes: np.ndarray, figure: MeasuredBody, place: str) -> Ease | None:
    """Return the ease at chest or waist, or None where no cloth surrounds it."""
    below = EASE_LEVEL_OFFSETS if place == "chest" else EASE_LEVEL_OFFSETS[:1]
    girth = figure.girths[place]
    lengths = [_trunk_length(garment, nodes, figure, girth.level - down) for down in below]
    length = min((length for length in lengths if length is not None), default=None)
    return None if length is None else Ease(place, length, girth.value)


def _hip_ease(garment: Garment, nodes: np.ndarray, figure: MeasuredBody, place: str) -> Ease | None:
    """Return the least ease at the hips and above, or None where no cloth surrounds them."""
    found = []
    for up in EASE_LEVEL_OFFSETS:
        level = figure.girths[place].level + up
        cut = slice_cloth(garment, nodes, 1, level)
        if not len(cut.lengths):
            break
        length = cut.length(np.abs(cut.middles - figure.centre) < figure.leg_offset)
        if length is not None:  # else the cloth is the legs', below a low crotch
            found.append(Ease(place, length, figure.tape.trunk(level).value))
    return min(found, key=lambda ease: ease.value, default=None)


def _trunk_length(garment: Garment, nodes: np.ndarray, figure: MeasuredBody, level: float) -> float | None:
    """Return the length of the cloth around the trunk at a height [m], or None where there is none."""
    cut = slice_cloth(garment, nodes, 1, level)
    return cut.length(cut.encloses(figure.trunk(level)[::2]))  # a fold that the plane cuts off is not a girth


def _arm_ease(garment: Garment, nodes: np.ndarray, figure: MeasuredBody, place: str) -> Ease | None:
    """Return the least ease of the sleeves there and further out, the mean of both, or None if an arm has none."""
    found = []
    for out in EASE_LEVEL_OFFSETS:
        level = figure.girths[place].level + out
        lengths = []
        for side in ("left", "right"):
            middle = figure.arm(side, level)
            cut = slice_cloth(garment, nodes, 0, float(middle[0]))
            lengths.append(cut.length(cut.encloses(middle[1:])))  # excludes cloth of the hips that moved with a hand
        length = _mean(lengths)
        if length is not None:
            found.append(Ease(place, length, figure.tape.arms(level).value))
    return min(found, key=lambda ease: ease.value, default=None)


def _thigh_ease(garment: Garment, nodes: np.ndarray, figure: MeasuredBody, place: str) -> Ease | None:
    """Return the least ease at the thighs and below, the mean of both, or None if a leg has no cloth of its own."""
    found = []
    for down in EASE_LEVEL_OFFSETS:
        level = figure.girths[place].level - down
        cut = slice_cloth(garment, nodes, 1, level)
        length = _mean([cut.length(sign * (cut.middles - figure.centre) > figure.leg_offset) for sign in (1.0, -1.0)])
        if length is not None:  # else the crotch hangs lower
            found.append(Ease(place, length, figure.tape.thighs(level).value))
    return min(found, key=lambda ease: ease.value, default=None)


def _mean(lengths: list[float | None]) -> float | None:
    """Return the mean of both sides' lengths, or None where one is missing."""
    known = [length for length in lengths if length is not None]
    return float(np.mean(known)) if len(known) == len(lengths) else None
