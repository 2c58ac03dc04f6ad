"""Colours of simulated scans: skin, hair, cloth with stripes and prints, shade, and a camera's faults."""

from __future__ import annotations

import colorsys
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ..core.body.body import JOINTS
from ..core.body.template import load_template
from ..core.people.part import Part
from .cloth import wave_field
from .scanner import NO_SURFACE
from .shards import Shard

WITHOUT = 0.25
"""Share of scans without colours."""

ALIKE = 0.1
"""Share of outfits of several garments that are all of one cloth: suits, tracksuits, black on black."""

BLOCKED = 0.1
"""Share of garments whose cloth changes at a height or that have a belt there; of one piece, at the waist."""

SLEEVED = 0.06
"""Share of garments whose sleeves, or sides of the legs, are of another cloth."""

SKIN_COLOURED = 0.06
"""Share of garments in the colour of the wearer's skin."""

TINTS = {
    "skin": ((0.93, 0.76, 0.66), (0.36, 0.23, 0.17)),
    "hair": ((0.78, 0.66, 0.47), (0.10, 0.08, 0.07)),
}
"""The lightest and the darkest skin and hair (sRGB): persons lie between them."""

NEUTRAL = 0.4
"""Share of cloth in black, white, grey or navy."""

SHADE = (0.65, 1.05)
"""Range of the light that folds and the turning away from the lamps leave."""

GRAIN = (0.005, 0.03)
"""Range of a camera's noise, standard deviation in sRGB."""

BLEED = 6
"""Neighbours that a texture is blended over: 1 cm at the density of the scans."""

Cloth = Callable[[np.ndarray], np.ndarray]
"""From places on the T-pose [m], [n, 3], to sRGB colours, [n, 3]."""


def paint(shard: Shard, always: bool = False) -> np.ndarray | None:
    """Return sRGB colours in 0..1 of a simulated scan's points, shape [n, 3], or None where its scanner gave none.

    The same person wears the same colours in each of its scans; light and camera are each scan's own.

    Args:
        shard: The scan.
        always: Paint it, too, where its scanner gave no colours.
    """
    person = np.random.default_rng([int(shard.about["seed"]), 7])
    scan = np.random.default_rng([int(shard.about["seed"]), int(shard.about["scan"]), 7])
    cloths = draw_cloths(shard.about, person)
    if scan.random() < WITHOUT and not always:
        return None
    near = cKDTree(shard.body_vertices).query(shard.points)[1]
    rest = load_template().vertices[near] + shard.points - shard.body_vertices[near]
    rgb = np.zeros((len(rest), 3))
    for number in np.unique(shard.surface):
        own = shard.surface == number
        rgb[own] = cloths[int(number)](rest[own])
    rgb = _expose(_blend(rgb, shard.points), shard, scan)
    if shard.about["scanner"]["kind"] == "image":
        rgb = _paint_back(rgb, shard)
    return np.asarray(np.clip(rgb, 0.0, 1.0))


def _paint_back(rgb: np.ndarray, shard: Shard) -> np.ndarray:
    """Return colours, shape [n, 3], of which an image shows those in front; what is behind them has the same."""
    front = np.flatnonzero(shard.normals[:, 2] > 0.0)
    painted = rgb.copy()
    behind = shard.normals[:, 2] <= 0.0
    near = cKDTree(shard.points[front, :2]).query(shard.points[behind, :2])[1]
    painted[behind] = rgb[front[near]]
    return painted


def draw_cloths(about: dict[str, Any], rng: np.random.Generator) -> dict[int, Cloth]:
    """Draw what each surface of a person looks like, and the remains of a floor.

    What is drawn first does not depend on the surfaces, of which each scan of a person has its own.

    Args:
        about: The scan's, with its `materials`.
        rng: The generator.
    """
    joints = dict(zip(JOINTS, load_template().joints, strict=True))
    waist = float(joints["pelvis"][1]) + rng.uniform(0.02, 0.18)
    tints = {}
    for name, (light, dark) in TINTS.items():
        share = rng.beta(0.8, 0.8)
        tints[name] = (1 - share) * np.array(light) + share * np.array(dark) + rng.normal(0.0, 0.015, 3)
    shared = _draw_cloth(rng) if rng.random() < ALIKE else None
    seeds = rng.integers(2**31, size=256)
    found: dict[int, Cloth] = {NO_SURFACE: _draw_cloth(np.random.default_rng(int(seeds[NO_SURFACE])))}
    for number, (part, material) in enumerate(about["materials"]):
        own = np.random.default_rng(int(seeds[number]))
        if material in tints:
            found[number] = _stain(tints[material], 0.03, own)
        elif shared is not None and part in (Part.UPPER, Part.LOWER):
            found[number] = shared
        else:
            found[number] = _draw_garment(Part(part), tints["skin"], waist, own)
    return found


def _draw_garment(part: Part, skin: np.ndarray, waist: float, rng: np.random.Generator) -> Cloth:
    """Draw the cloth, or the two cloths, of a garment."""
    if rng.random() < SKIN_COLOURED:
        return _stain(skin + rng.normal(0.0, 0.04, 3), 0.02, rng)
    cloth, kind = _draw_cloth(rng), rng.random()
    if kind < BLOCKED:
        height = waist if part is Part.ONE_PIECE else waist + rng.uniform(-0.5, 0.35)
        return _block(cloth, _draw_cloth(rng), height, rng)
    if kind < BLOCKED + SLEEVED:
        return _side(cloth, _draw_cloth(rng), rng)
    return cloth


def _side(one: Cloth, other: Cloth, rng: np.random.Generator) -> Cloth:
    """Return a cloth with another one from a distance from the middle on: sleeves, and stripes down the legs."""
    aside = rng.uniform(0.14, 0.22)

    def sided(rest: np.ndarray) -> np.ndarray:
        return np.where((np.abs(rest[:, 0]) > aside)[:, None], other(rest), one(rest))

    return sided


def _draw_cloth(rng: np.random.Generator) -> Cloth:
    """Draw a cloth: plain, striped, or printed."""
    first, second = _draw_tint(rng), _draw_tint(rng)
    kind = rng.random()
    if kind < 0.65:
        return _stain(first, 0.02, rng)
    if kind < 0.8:
        width, across = rng.uniform(0.006, 0.06), rng.random() < 0.3
        share = rng.uniform(0.2, 0.8)

        def striped(rest: np.ndarray) -> np.ndarray:
            # Around a T-pose's trunk and legs, and around its arms, which are level.
            along = np.where(np.abs(rest[:, 0]) > 0.2, np.abs(rest[:, 0]), rest[:, 1])
            place = rest[:, 0] if across else along
            return np.where(((place / width) % 1.0 < share)[:, None], first, second)

        return striped
    field_seed, size, level = int(rng.integers(2**31)), rng.uniform(0.02, 0.1), rng.uniform(0.3, 1.5)

    def printed(rest: np.ndarray) -> np.ndarray:
        field = wave_field(rest, (size, 3 * size), np.random.default_rng(field_seed))
        return np.where((field > level)[:, None], second, first)

    return printed


def _draw_tint(rng: np.random.Generator) -> np.ndarray:
    """Draw a dyed cloth's colour."""
    if rng.random() < NEUTRAL:
        return np.array([(0.07, 0.07, 0.08), (0.9, 0.9, 0.88), (0.5, 0.5, 0.5), (0.11, 0.13, 0.25)][rng.integers(4)])
    return np.array(colorsys.hsv_to_rgb(rng.random(), rng.beta(2.0, 1.5), rng.uniform(0.2, 0.95)))


def _stain(tint: np.ndarray, amount: float, rng: np.random.Generator) -> Cloth:
    """Return a plain surface that is a little lighter and darker over 5 to 20 cm."""
    seed = int(rng.integers(2**31))

    def stained(rest: np.ndarray) -> np.ndarray:
        field = wave_field(rest, (0.05, 0.2), np.random.default_rng(seed))
        return tint + amount * np.clip(field, -2, 2)[:, None]

    return stained


def _block(one: Cloth, other: Cloth, waist: float, rng: np.random.Generator) -> Cloth:
    """Return a cloth that changes at the waist, or that has a band there."""
    width = rng.uniform(0.03, 0.06) if rng.random() < 0.5 else np.inf

    def blocked(rest: np.ndarray) -> np.ndarray:
        below = waist - rest[:, 1]
        return np.where(((below > 0) & (below < width))[:, None], other(rest), one(rest))

    return blocked


def _blend(rgb: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Blend colours over neighbours, as a texture's resolution and the views' registration do."""
    return np.asarray(rgb[cKDTree(points).query(points, k=BLEED)[1]].mean(axis=1))


def _expose(rgb: np.ndarray, shard: Shard, rng: np.random.Generator) -> np.ndarray:
    """Return colours as they are lit and photographed: lamps from a side and above, folds, white balance, noise."""
    lamp = np.array([rng.normal(), 1.0, rng.normal()])
    facing = 0.5 + 0.5 * shard.normals @ (lamp / np.linalg.norm(lamp))
    soft = rng.uniform(0.0, 1.0)
    light = SHADE[0] + (SHADE[1] - SHADE[0]) * (1.0 - soft * (1.0 - facing))
    light = light * (1.0 + 0.04 * wave_field(shard.points, (0.05, 0.3), rng))
    balance = 1.0 + rng.normal(0.0, 0.03, 3)
    noise = rng.uniform(*GRAIN) * rng.normal(size=rgb.shape)
    # Light is linear; sRGB is about its 1 / 2.2 power.
    return np.asarray(rgb * np.maximum(light, 0.0)[:, None] ** (1 / 2.2) * balance + noise)
