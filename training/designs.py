"""Draw what a person wears: the cut of each garment, its measures, and where it is cut shorter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..core.body.body import Body
from ..core.garment.measures import BodyMeasures
from ..core.garment.parts.cut import Collar, Cuff, Cut, Front, HemBand, Hood, Legs, Skirt, Sleeve, Vent
from ..core.garment.parts.part_words import parse_parts
from ..core.garment.templates import find_cut, name_cut
from ..core.people.part import Part
from ..core.recover.drape.sizing import measure_wearer

UPPERS = ("long_sleeve_tshirt", "tshirt", "tank")
LOWERS = ("trousers", "shorts", "skirt", "four_panel_skirt")
DRESSES = ("dress", "sleeved_dress")
JUMPSUITS = ("jumpsuit", "sleeved_jumpsuit")
HELD_OUT = "pencil_skirt"
"""Design that is kept for measuring when a set is drawn without it."""

OVER = 0.12
"""Share of persons in an outer layer."""

TOP_FINISHES = {
    "": 0.63,
    "front=wrap,neckline=v": 0.03,
    "collar=shirt,front=buttons": 0.10,
    "collar=convertible,front=buttons": 0.02,
    "collar=polo,front=placket": 0.05,
    "front=placket": 0.02,
    "collar=stand,front=placket": 0.01,
    "collar=stand,front=zip": 0.02,
    "collar=rib": 0.03,
    "collar=turtleneck": 0.03,
    "hood": 0.04,
    "hood,front=zip": 0.02,
}
"""What a top has at its neck and centre front, and how often: estimates for daily wear, a third of the tops."""

OUTER_FINISHES = {
    "front=open": 0.08,
    "collar=shirt,front=open": 0.08,
    "collar=convertible,front=open": 0.06,
    "collar=notched,front=open": 0.16,
    "collar=shawl,front=open": 0.07,
    "collar=stand,front=open": 0.05,
    "hood,front=open": 0.12,
    "collar=stand,front=zip": 0.12,
    "hood,front=zip": 0.12,
    "collar=shirt,front=buttons": 0.05,
    "collar=convertible,front=buttons": 0.02,
    "collar=notched,front=buttons": 0.07,
}
"""The same of outer layers: six in ten are open, a quarter is zipped up."""

DRESS_FINISHES = {
    "": 0.64,
    "front=wrap,neckline=v": 0.06,
    "front=wrap,neckline=v,waist=seam": 0.06,
    "shaping=gathers,waist=seam": 0.04,
    "collar=shirt,front=buttons": 0.12,
    "collar=convertible,front=buttons": 0.04,
    "collar=turtleneck": 0.04,
}
"""The same of dresses, and how a waist seam is shaped: one dress in eight is wrapped."""

SKIRTS = {"": 0.78, "vent=back": 0.07, "vent=sides": 0.05, "skirt=gathered,waistband=band": 0.10}
"""Vents and gathers of skirts that are not held out, and how often each is drawn: estimates, as all shares."""

TOP_VENTS = {"none": 0.86, "sides": 0.10, "back": 0.04}
"""Vents of tops without a band at the hem."""

SHIRT_CUFFED = 0.8
"""Share of shirt cuffs among long sleeves below a shirt's or convertible collar: the others end in a hem."""

GATHERED_LEGS = 0.2
"""Share of gathers among trousers with a band."""

HOOD_UP = 0.2
"""Share of hoods that are worn on the head: most people put them down to be scanned."""

HOOD_THREE = 0.3
"""Share of hoods of three pieces."""

RIBBED, RIBBED_SWEATSHIRT = 0.08, 0.7
"""Shares of tops with ribs at hem and cuffs: of all, and of those with a hood or a rib at the neck."""

DROPPED = 0.15
"""Share of tops with sleeves whose shoulders are dropped."""

SLEEVELESS_OUTER = 0.08
"""Share of outer layers without sleeves: gilets."""

LEGS = {"straight": 0.45, "tapered": 0.23, "flared": 0.08, "wide": 0.12, "leggings": 0.12}
"""Lines of trousers' legs and how often each is drawn."""

WAISTBANDS = {"none": 0.5, "band": 0.25, "elastic": 0.25}
"""Finishes of trousers' waists and how often each is drawn."""

Trim = Callable[[np.ndarray], np.ndarray]
"""From points around the T-pose [m], [n, 3], to a field [n] that is positive where cloth stays."""


@dataclass(frozen=True)
class Piece:
    """Describe one garment before it is draped.

    Attributes:
        template: Name of its cut, one of the shipped ones or one with other parts, as `draft_template` reads it.
        part: What it is labelled as.
        measures: What it is drafted to.
        wide: Whether it lies over what was put on before.
        tucked: Whether it is tucked into what is put on next.
    """

    template: str
    part: Part
    measures: BodyMeasures
    wide: bool = False
    tucked: bool = False

    @property
    def cut(self) -> Cut:
        """Return its parts."""
        return find_cut(self.template)

    @property
    def is_finished(self) -> bool:
        """Return whether it has a collar, a hood or a front of its own."""
        cut = self.cut
        return (cut.collar, cut.hood, cut.front) != (Collar.NONE, Hood.NONE, Front.NONE)


def draw_outfit(body: Body, rng: np.random.Generator, held_out: bool) -> list[Piece]:
    """Draw the garments of a person, the innermost first.

    Args:
        body: The wearer, whose measures they are drafted to with drawn ease.
        rng: The generator.
        held_out: Draw a jumpsuit, or a top over `HELD_OUT`.
    """
    m = measure_wearer(body)
    ease = float(rng.uniform(0.97, 1.2))
    m = replace(
        m,
        bust=m.bust * ease,
        waist=m.waist * float(rng.uniform(0.98, 1.12)),
        hip=m.hip * float(rng.uniform(0.98, 1.14)),
        hip_height=m.hip_height - float(rng.uniform(-0.06, 0.05)),
    )
    kind, is_over = rng.random(), rng.random() < OVER
    if kind < (0.5 if held_out else 0.1):
        pieces = [Piece(str(rng.choice(JUMPSUITS)), Part.ONE_PIECE, m)]
    elif not held_out and kind < 0.27:
        pieces = [Piece(name_finished(str(rng.choice(DRESSES)), draw_word(DRESS_FINISHES, rng)), Part.ONE_PIECE, m)]
    elif not held_out and kind < 0.35:
        pieces = [_lower(m, rng, False) if rng.random() < 0.8 else _upper(m, rng, is_over)]
    else:
        upper, lower = _upper(m, rng, is_over), _lower(m, rng, held_out)
        tucked = upper.cut.hem_band is HemBand.NONE and rng.random() < 0.35
        pieces = [replace(upper, tucked=True), lower] if tucked else [lower, upper]
        pieces[1] = replace(pieces[1], wide=True)
    if is_over:
        roomy = widen_for_layers(m, rng)
        sleeve = "none" if rng.random() < SLEEVELESS_OUTER else "long"
        pieces.append(Piece(_draw_top(sleeve, OUTER_FINISHES, rng), Part.OUTER, roomy, wide=True))
    return pieces


def widen_for_layers(m: BodyMeasures, rng: np.random.Generator) -> BodyMeasures:
    """Return the measures that an outer layer is drafted to, its length drawn: it goes over what is worn below it."""
    length = float(rng.uniform(-0.05, 0.25))
    return replace(m, bust=m.bust * 1.14 + 0.06, hip=m.hip * 1.12, hip_height=m.hip_height - length)


def _upper(m: BodyMeasures, rng: np.random.Generator, is_below: bool) -> Piece:
    """Draw a top; one below an outer layer has no hood, which would lie flat between the two backs."""
    long = replace(m, hip_height=m.hip_height - float(rng.choice([0.0, 0.0, rng.uniform(0.0, 0.22)])))
    name = str(rng.choice(UPPERS, p=(0.6, 0.2, 0.2)))
    if name == "tank":
        return Piece(name, Part.UPPER, long)
    finishes = {word: share for word, share in TOP_FINISHES.items() if not (is_below and word.startswith("hood"))}
    return Piece(_draw_top("long" if name == "long_sleeve_tshirt" else "short", finishes, rng), Part.UPPER, long)


def _lower(m: BodyMeasures, rng: np.random.Generator, held_out: bool) -> Piece:
    slim = replace(m, waist=min(m.waist, 0.5 * (m.waist + m.hip)), hip_height=m.hip_height)
    name = HELD_OUT if held_out else str(rng.choice(LOWERS, p=(0.5, 0.15, 0.2, 0.15)))
    if name == "trousers":
        legs, waistband = draw_word(LEGS, rng), draw_word(WAISTBANDS, rng)
        if (legs, waistband) == ("leggings", "elastic"):  # leggings hold by their own stretch
            waistband = "none"
        is_gathered = waistband == "band" and legs != "leggings" and rng.random() < GATHERED_LEGS
        gathers = ",shaping=gathers" if is_gathered else ""
        name = name_finished(name, f"legs={legs},waistband={waistband}{gathers}")
    elif name == "skirt":
        name = name_finished(name, draw_word(SKIRTS, rng))
    return Piece(name, Part.LOWER, slim)


def _draw_top(sleeve: str, finishes: dict[str, float], rng: np.random.Generator) -> str:
    """Draw the cut of a top with sleeves of a given length and return its name.

    Args:
        sleeve: A choice of `Sleeve`.
        finishes: What it has at its neck and centre front, with shares; `hood` stands for any hood.
        rng: The generator.
    """
    word = draw_word(finishes, rng)
    is_sweatshirt = "hood" in word or "collar=rib" in word
    is_ribbed = rng.random() < (RIBBED_SWEATSHIRT if is_sweatshirt else RIBBED)
    if "hood" in word:
        pieces = "three" if rng.random() < HOOD_THREE else "two"
        worn = "up" if rng.random() < HOOD_UP else "down"
        word = word.replace("hood", f"hood={pieces},hood_worn={worn}")
    parts = [f"sleeve={sleeve}", word]
    if sleeve != "none" and rng.random() < DROPPED:
        parts.append("sleeve_head=dropped")
    if is_ribbed:
        parts += ["hem_band=rib", "cuff=rib" if sleeve == "long" else ""]
    else:
        is_shirt = word.startswith(("collar=shirt", "collar=convertible"))
        parts.append("cuff=shirt" if sleeve == "long" and is_shirt and rng.random() < SHIRT_CUFFED else "")
        parts.append(f"vent={draw_word(TOP_VENTS, rng)}")
    return name_finished("tshirt" if sleeve == "short" else "long_sleeve_tshirt", ",".join(parts))


def name_finished(stem: str, parts: str) -> str:
    """Return the name of a shipped cut with other parts, `front=zip,collar=stand`; an empty text changes none."""
    return name_cut(stem, find_cut(stem).choose(parse_parts(parts)))


def draw_word(shares: dict[str, float], rng: np.random.Generator) -> str:
    """Draw one of some words by their shares, whose sum need not be 1."""
    weights = np.array(list(shares.values()))
    return list(shares)[int(rng.choice(len(weights), p=weights / weights.sum()))]


def draw_trims(piece: Piece, rest: Body, rng: np.random.Generator) -> list[Trim]:
    """Draw where a garment is cut shorter than its draft: sleeves, legs, hem, neckline, none of which is finished, as a
    hem is by a vent."""
    trims: list[Trim] = []
    cut = piece.cut
    shoulder, wrist = rest.joint("left_shoulder"), rest.joint("left_wrist")
    neck, knee, ankle, pelvis = (rest.joint(name) for name in ("neck", "left_knee", "left_ankle", "pelvis"))
    tilt = rng.normal(0.0, 0.06, 3)
    shortened = 0.25 if piece.part is Part.OUTER else 0.6
    if cut.sleeve in (Sleeve.LONG, Sleeve.ELBOW) and cut.cuff is Cuff.NONE and rng.random() < shortened:
        reach = shoulder[0] + rng.uniform(0.08, 1.0) * (wrist[0] - shoulder[0])
        slant = rng.normal(0.0, 0.12)
        trims.append(lambda p: reach - np.abs(p[:, 0]) + slant * (p[:, 1] - shoulder[1]))
    is_hemmed = cut.hem_band is HemBand.NONE and cut.vent is Vent.NONE
    if piece.part is Part.UPPER and is_hemmed and rng.random() < 0.35:
        hem = pelvis[1] + rng.uniform(-0.12, 0.12)
        wave = rng.normal(0.0, 0.1)
        trims.append(lambda p: p[:, 1] - hem - wave * np.abs(p[:, 0]) + tilt[0] * p[:, 2])
    if piece.tucked:
        end = pelvis[1] + rng.uniform(-0.03, 0.03)
        trims.append(lambda p: p[:, 1] - end)
    if cut.legs not in (Legs.NONE, Legs.SHORT) and rng.random() < 0.55:
        leg = ankle[1] + rng.uniform(-0.02, 0.75) * (pelvis[1] - ankle[1])
        trims.append(lambda p: p[:, 1] - leg + tilt[1] * p[:, 2])
    if cut.skirt is not Skirt.NONE and is_hemmed and rng.random() < 0.4:
        low = knee[1] + rng.uniform(-0.05, 0.25) * (pelvis[1] - knee[1]) * 2
        trims.append(lambda p: p[:, 1] - low + tilt[2] * p[:, 2])
    if piece.part is not Part.LOWER and not piece.is_finished and rng.random() < 0.5:
        depth, width = rng.uniform(0.04, 0.2), rng.uniform(0.06, 0.12)
        front = rng.random() < 0.8
        # A V or a U: what lies above the line through the lowest point, on one side of the neck.
        power = rng.uniform(1.0, 2.5)

        def neckline(p: np.ndarray) -> np.ndarray:
            side = (p[:, 2] - neck[2]) * (1.0 if front else -1.0)
            line = neck[1] - depth * (1 - (np.abs(p[:, 0]) / width) ** power)
            return np.maximum(line + 0.02 - p[:, 1], np.maximum(np.abs(p[:, 0]) - width, -side - 0.01))

        trims.append(neckline)
    return trims
