"""Ease: how much longer the cloth is round a body than the body's girth, at the places where a tailor measures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..body import GIRTHS, Body, Tape, unskin, weights_at
from ..drape import flat_length
from ..mesh import find_components
from ..pattern import Garment

APART = 0.25
"""Share of the hip joint's distance from the middle beyond which cloth is one leg's: a skirt's is in the middle."""


BELOW = ((0.0,), (0.0, 0.02, 0.04, 0.06))
"""How far below the body's level cloth is measured [m], and at the chest: a wide sleeve joins the line of its level
there, so the shortest line of a hand's breadth counts."""


@dataclass(frozen=True)
class Ease:
    """Compare a garment with its wearer at one place.

    Attributes:
        place: One of `GIRTHS`.
        garment: Length of the cloth round the body there, unstretched [m].
        body: The body's girth there [m].
    """

    place: str
    garment: float
    body: float

    @property
    def value(self) -> float:
        """Return the ease [m]; negative where the cloth is shorter than the girth."""
        return self.garment - self.body


def measure_ease(garment: Garment, body: Body) -> tuple[Ease, ...]:
    """Measure the ease of a worn garment wherever cloth goes round the body.

    The body's levels are those of its T-pose, to which the cloth is carried back; the cloth's length along such a level
    is measured flat, in the pattern. A garment that hangs from the waist is measured there along its own edge.

    Args:
        garment: The garment, nodes on the body.
        body: The wearer.
    """
    tape, found = Tape.of(body), []
    nodes = unskin(garment.nodes, weights_at(body, garment.nodes, rest=False), body.transforms)
    centre = float(tape.body.joint("pelvis")[0])
    waist = garment.contour("waist")
    for place in GIRTHS:
        if place == "waist" and waist is not None:
            own = flat_length(garment, waist.vertices)
            girth = tape.trunk(float(nodes[waist.vertices, 1].mean())).value
            found.append(Ease(place, own, girth))
            continue
        taken = tape.measure(place)
        if place in ("thigh", "upper_arm"):
            sides = [_limb(garment, nodes, tape.body, place, sign, taken.level) for sign in (1.0, -1.0)]
            lengths = [length for length in sides if length is not None]
            length = None if len(lengths) < len(sides) else float(np.mean(lengths))
        else:
            half = abs(float(tape.body.joint("left_shoulder")[0]) - centre)
            cuts = [cut_cloth(garment, nodes, 1, taken.level - below) for below in BELOW[place == "chest"]]
            around = [cut.length(np.abs(cut.middles - centre) < half) for cut in cuts]
            length = min((one for one in around if one is not None), default=None)
        if length is not None:
            found.append(Ease(place, length, taken.value))
    return tuple(found)


@dataclass(frozen=True)
class ClothCut:
    """Hold the closed lines along which a plane cuts cloth.

    Attributes:
        lengths: Length of each line in the flat pattern [m], shape [line_count].
        middles: Mean x of each [m], shape [line_count].
    """

    lengths: np.ndarray
    middles: np.ndarray

    def length(self, chosen: np.ndarray) -> float | None:
        """Return the length of the longest of chosen lines [m], or None where there is none."""
        return float(self.lengths[chosen].max()) if chosen.any() else None


def cut_cloth(garment: Garment, nodes: np.ndarray, axis: int, level: float) -> ClothCut:
    """Cut cloth by the plane across an axis at a level [m]; lines that end at the cloth's border are left out.

    Args:
        garment: The cloth.
        nodes: Where it is cut [m], shape [node_count, 3].
        axis: 0 to 2.
        level: Where the plane is [m].
    """
    side = nodes[:, axis] > level
    inside = side[garment.faces]
    cut = np.flatnonzero(inside.any(axis=1) & ~inside.all(axis=1))
    if not len(cut):
        return ClothCut(np.zeros(0), np.zeros(0))
    faces, flat = garment.faces[cut], garment.rest[cut]
    ahead = np.roll(faces, -1, axis=1)
    crossed = side[faces] != side[ahead]  # two of a face's three edges
    share = (level - nodes[faces, axis]) / np.where(crossed, nodes[ahead, axis] - nodes[faces, axis], 1.0)
    points = flat + share[..., None] * (np.roll(flat, -1, axis=1) - flat)
    ends = points[crossed].reshape(-1, 2, 2)
    keys = (np.sort(np.stack([faces, ahead], axis=2), axis=2) @ [len(nodes), 1])[crossed].reshape(-1, 2)
    edges, number = np.unique(keys, return_inverse=True)
    number = number.reshape(-1, 2)
    count, part = find_components(len(edges), number[:, 0], number[:, 1])
    of_face = part[number[:, 0]]
    lengths = np.bincount(of_face, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), count)
    middles = np.bincount(of_face, nodes[faces, 0].mean(axis=1), count) / np.maximum(np.bincount(of_face), 1)
    closed = np.bincount(of_face, minlength=count) == np.bincount(part, minlength=count)
    return ClothCut(lengths[closed], middles[closed])


def _limb(garment: Garment, nodes: np.ndarray, rest: Body, place: str, sign: float, level: float) -> float | None:
    """Return the length of the cloth round one leg or arm [m], or None where there is none of its own."""
    centre = float(rest.joint("pelvis")[0])
    if place == "upper_arm":
        parts = cut_cloth(garment, nodes, 0, centre + sign * (level - centre))
        return parts.length(np.ones(len(parts.middles), dtype=bool))
    parts = cut_cloth(garment, nodes, 1, level)
    apart = APART * abs(float(rest.joint("left_hip")[0]) - centre)
    return parts.length(sign * (parts.middles - centre) > apart)
