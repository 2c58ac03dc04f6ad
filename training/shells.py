"""What follows the body: underwear, leggings, tight and padded tops and suits, as shells of it cut to drawn ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core.body.body import Body
from ..core.people.part import Part
from .cloth import clip, hem_height, thicken, wave_field
from .wardrobe import Layer
from .wearer import size_of

THICKNESS = (0.001, 0.0025)
"""Range of the thickness of elastic cloth [m], hems aside."""

PADDED = (0.004, 0.025)
"""Range of the thickness of cloth that keeps its shape on the body: felt, quilts, padding [m]."""

PADDED_SHARE = 0.35
"""Share of tops, suits and leggings that are padded."""

HEM = (0.012, 0.0008)
"""Width and height [m] of an elastic's edge."""

CROTCH = 0.09
"""Height of the pelvis joint above the crotch [m] of an adult."""


@dataclass(frozen=True)
class Shell:
    """Describe something that lies on the skin.

    Attributes:
        part: What it is labelled as: `SKIN` for underwear and swimwear.
        name: Its kind.
        keep: Field over the body's vertices that is positive where it is, shape [n].
        thickness: Of its cloth [m].
    """

    part: Part
    name: str
    keep: np.ndarray
    thickness: float


@dataclass(frozen=True)
class _Rest:
    """Describe the T-pose: its vertices, their distance from the middle, and the heights that ends are drawn from."""

    body: Body

    @property
    def points(self) -> np.ndarray:
        """Return the vertices [m], shape [n, 3]."""
        return self.body.rest_vertices

    @property
    def aside(self) -> np.ndarray:
        """Return how far each vertex is from the middle [m], shape [n]."""
        return np.abs(self.points[:, 0])

    def joint(self, name: str) -> np.ndarray:
        """Return a joint in the T-pose [m], shape [3]."""
        return self.body.joint(name)

    @property
    def scale(self) -> float:
        """Return the height as a share of 1.7 m."""
        return size_of(self.body)

    def below(self, height: float) -> np.ndarray:
        """Return how far each vertex is below a height [m]."""
        return height - self.points[:, 1]


def draw_underwear(rest: Body, gender: str, rng: np.random.Generator) -> list[Shell]:
    """Draw underwear or swimwear, or none at all.

    Args:
        rest: The wearer in the T-pose.
        gender: `female`, `male` or `child`.
        rng: The generator.
    """
    own = _Rest(rest)
    kind = rng.random()
    if kind < 0.2:
        return []
    if kind < 0.35 and gender != "male":
        return [_shell(Part.SKIN, "swimsuit", _swimsuit(own, rng), rng)]
    low = _trunks(own, rng) if gender == "male" and kind < 0.6 else _briefs(own, rng)
    shells = [_shell(Part.SKIN, "briefs", low, rng)]
    if gender == "female" and kind < 0.9:
        shells.append(_shell(Part.SKIN, "bra", _bra(own, rng), rng))
    return shells


def draw_leggings(rest: Body, rng: np.random.Generator) -> Shell:
    """Draw leggings or tights that end between knee and ankle."""
    return _shell(Part.LOWER, "leggings", _legs(_Rest(rest), rng), rng)


def draw_tight_top(rest: Body, rng: np.random.Generator) -> Shell:
    """Draw a top of stretched cloth whose ends are drawn."""
    own = _Rest(rest)
    hem = own.joint("pelvis")[1] + rng.uniform(-0.1, 0.2) * own.scale
    return _shell(Part.UPPER, "tight top", np.minimum(_top(own, rng), -own.below(hem)), rng)


def draw_tight_suit(rest: Body, rng: np.random.Generator) -> Shell:
    """Draw a suit of stretched cloth from the neck to the legs."""
    own = _Rest(rest)
    waist = own.below(own.joint("spine1")[1])
    keep = np.where(waist > 0, np.minimum(_legs(own, rng), 1.0) + np.maximum(waist, 0.0), _top(own, rng))
    legs = own.points[:, 1] - rng.uniform(own.joint("left_ankle")[1], own.joint("left_knee")[1] + 0.3 * own.scale)
    return _shell(Part.ONE_PIECE, "tight suit", np.minimum(keep, np.where(waist > 0, legs, keep)), rng)


def wear_shell(shell: Shell, body: Body, rng: np.random.Generator) -> Layer:
    """Return a shell on the wearer in a pose."""
    waves = np.clip(wave_field(body.rest_vertices, (0.03, 0.12), rng), -1.0, 1.0)
    height = shell.thickness * (1.0 + 0.3 * waves)
    mesh = clip(thicken((body.vertices, body.faces), height), shell.keep)
    return Layer(shell.part, thicken(mesh, hem_height(mesh, *HEM)))


def _shell(part: Part, name: str, keep: np.ndarray, rng: np.random.Generator) -> Shell:
    padded = rng.random()
    if part is Part.SKIN or padded > PADDED_SHARE:
        return Shell(part, name, keep, THICKNESS[0] + padded * (THICKNESS[1] - THICKNESS[0]))
    return Shell(part, name, keep, PADDED[0] + padded / PADDED_SHARE * (PADDED[1] - PADDED[0]))


def _leg_line(own: _Rest, rise: float) -> np.ndarray:
    """Return how far each vertex is above briefs' leg openings, which rise by `rise` m a metre to the side."""
    crotch = own.joint("pelvis")[1] - (CROTCH + 0.02) * own.scale
    return np.asarray(own.points[:, 1] - crotch - rise * own.aside)


def _briefs(own: _Rest, rng: np.random.Generator) -> np.ndarray:
    top = own.joint("pelvis")[1] + rng.uniform(0.0, 0.12) * own.scale
    return np.minimum(own.below(top), _leg_line(own, rng.uniform(0.1, 0.8)))


def _trunks(own: _Rest, rng: np.random.Generator) -> np.ndarray:
    top = own.joint("pelvis")[1] + rng.uniform(0.0, 0.1) * own.scale
    end = own.joint("pelvis")[1] - (CROTCH + rng.uniform(0.03, 0.18)) * own.scale
    return np.minimum(own.below(top), -own.below(end))


def _straps(own: _Rest, rng: np.random.Generator) -> np.ndarray:
    """Return the field of two straps over the shoulders."""
    place, half = rng.uniform(0.07, 0.1) * own.scale, rng.uniform(0.004, 0.02)
    return np.asarray(half - np.abs(own.aside - place))


def _bra(own: _Rest, rng: np.random.Generator) -> np.ndarray:
    low = own.joint("spine3")[1] - rng.uniform(0.04, 0.12) * own.scale
    high = low + rng.uniform(0.08, 0.17) * own.scale
    band = np.minimum(own.below(high), -own.below(low))
    worn = np.maximum(band, np.minimum(_straps(own, rng), -own.below(low)))
    return np.minimum(
        worn, np.minimum(own.joint("left_shoulder")[0] - own.aside, own.below(own.joint("neck")[1] + 0.03))
    )


def _swimsuit(own: _Rest, rng: np.random.Generator) -> np.ndarray:
    high = own.joint("spine3")[1] + rng.uniform(-0.02, 0.1) * own.scale
    worn = np.maximum(own.below(high), np.minimum(_straps(own, rng), own.below(own.joint("neck")[1] + 0.03)))
    inside = np.minimum(own.joint("left_shoulder")[0] - own.aside, _leg_line(own, rng.uniform(0.1, 0.9)))
    return np.minimum(worn, inside)


def _legs(own: _Rest, rng: np.random.Generator) -> np.ndarray:
    top = own.joint("pelvis")[1] + rng.uniform(0.02, 0.18) * own.scale
    ankle, knee = own.joint("left_ankle")[1], own.joint("left_knee")[1]
    end = rng.uniform(ankle - 0.03, ankle + 0.05) if rng.random() < 0.6 else rng.uniform(ankle, knee + 0.25 * own.scale)
    return np.minimum(own.below(top), -own.below(end))


def _top(own: _Rest, rng: np.random.Generator) -> np.ndarray:
    """Return the field of a top without its hem: a neckline, and sleeves to a drawn length or none."""
    shoulder, wrist = own.joint("left_shoulder")[0], own.joint("left_wrist")[0]
    reach = rng.choice([shoulder - 0.02, rng.uniform(shoulder + 0.03, wrist), wrist])
    neck = own.joint("neck")[1] + rng.uniform(-0.1, 0.07) * own.scale
    open_neck = np.where(own.aside < 0.13 * own.scale, own.below(neck), 1.0)
    return np.minimum(reach - own.aside, open_neck)
