"""Colours of simulated scans: skin, hair, cloth with stripes and prints, shade, and a camera's faults.

Nothing is learnt from them: they let the rules that read colours be calibrated on scans as most scanners give them.
"""

from __future__ import annotations

import colorsys
from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from ..core.body.body import JOINTS
from ..core.body.template import load_template
from ..core.people.part import GARMENTS, Part
from .cloth import wave_field
from .shards import Shard

WITHOUT = 0.25
"""Share of scans without colours."""

ALIKE = 0.1
"""Share of outfits of several garments that are all of one cloth: suits, tracksuits, black on black."""

BLOCKED = 0.1
"""Share of one-piece garments whose cloth changes at the waist or that have a belt there."""

TINTS = {
    Part.SKIN: ((0.93, 0.76, 0.66), (0.36, 0.23, 0.17)),
    Part.HAIR: ((0.78, 0.66, 0.47), (0.10, 0.08, 0.07)),
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
    cloths = _draw_cloths(person)
    if scan.random() < WITHOUT and not always:
        return None
    near = cKDTree(shard.body_vertices).query(shard.points)[1]
    rest = load_template().vertices[near] + shard.points - shard.body_vertices[near]
    rgb = np.zeros((len(rest), 3))
    for part in Part:
        own = shard.label == part
        if own.any():
            rgb[own] = cloths[part](rest[own])
    rgb = _blend(rgb, shard.points)
    return np.asarray(np.clip(_expose(rgb, shard, scan), 0.0, 1.0))


def _draw_cloths(rng: np.random.Generator) -> dict[Part, Cloth]:
    """Draw what each part of a person looks like."""
    template = load_template()
    joints = dict(zip(JOINTS, template.joints, strict=True))
    waist = float(joints["pelvis"][1]) + rng.uniform(0.02, 0.18)
    shared = rng.random() < ALIKE
    cloth = _draw_cloth(rng)
    found: dict[Part, Cloth] = {}
    for part in Part:
        own = _draw_cloth(rng)
        found[part] = cloth if shared and part in (Part.UPPER, Part.LOWER) else own
    if rng.random() < BLOCKED:
        found[Part.ONE_PIECE] = _block(found[Part.ONE_PIECE], _draw_cloth(rng), waist, rng)
    for part, (light, dark) in TINTS.items():
        share = rng.beta(0.8, 0.8)
        tint = (1 - share) * np.array(light) + share * np.array(dark) + rng.normal(0.0, 0.015, 3)
        found[part] = _stain(tint, 0.03, rng)
    assert set(GARMENTS) <= set(found)
    return found


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
