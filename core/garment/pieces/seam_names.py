"""Names of seams as a tailor says them: by the labels of a draft, else by the places of the panels on the wearer."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..orientation import place_points
from ..panel_parts import Side, find_arm_panels, find_part, find_side
from ..pattern import EdgeRef, Panel, Pattern, Seam
from ..seams import find_sewn_partners

LABEL_NAMES: Mapping[str, str] = MappingProxyType({
    "shoulder": "shoulder seam", "scye": "armhole seam", "side": "side seam", "outseam": "side seam",
    "inseam": "inseam", "crotch": "{face} crotch seam", "centre": "centre {face} seam",
    "princess": "{face} princess seam", "gore": "{face} gore seam", "pleat": "{face} pleat",
    "yoke": "{face} yoke seam", "yokeside": "yoke side seam", "hipyoke": "hip yoke seam", "waist": "waist seam",
    "band": "waistband seam", "bandside": "waistband end seam", "tie": "wrap seam",
    "undersleeve": "sleeve seam", "oversleeve": "overarm seam", "forearm": "forearm seam", "hindarm": "hindarm seam",
    "cuffseam": "cuff seam", "cuffover": "cuff end seam", "cuffunder": "cuff end seam",
    "collar": "neck seam", "collarside": "collar side seam", "collarend": "collar end seam", "gorge": "gorge seam",
    "hood": "neck seam", "hoodcrown": "hood crown seam", "hemrib": "hem rib seam", "hemribside": "hem rib end seam",
    "fold": "collar stand seam",
})  # fmt: skip
"""Names of seams by the first word of an edge's label in a draft; `{face}` is front or back."""

CLOSURE_NAMES: Mapping[str, str] = MappingProxyType({
    "front.zip": "front zip", "front.buttons": "front buttons", "front.placket": "centre front seam",
    "cuff.buttons": "cuff buttons",
})  # fmt: skip
"""Names of closed edges by the first two words of an edge's label."""

LOWER_PARTS = ("skirt", "leg")
"""First words of the labels of what is sewn to a bodice at the waist; its seams are called after it."""

MIDDLE_SEAMS = ("waist seam", "waistband seam", "neck seam", "hem rib seam", "hip yoke seam", "hem band seam")
"""Names of seams that go round the wearer, and so have no side; those of tiers are such too."""

MIN_UPRIGHT_SEAM_SINE = np.sin(np.radians(45.0))
"""Smallest sine between a placed seam and the level at which it is upright (45 degrees): a shoulder slopes by 20 to 30,
a side seam leans by less than 30."""


@dataclass(frozen=True)
class SeamName:
    """Describe a seam's name, `side seam`, and its side of the wearer: `left`, `right`, or an empty text."""

    name: str
    side: str


def name_seam(pattern: Pattern, seam: Seam) -> SeamName:
    """Return the name of a seam by its label; where there is no label of a draft, by the places of its panels."""
    label = pattern.panel(seam.a.panel).edges[seam.a.edge].label
    words = label.split(".")
    lower = words[0] if words[0] in LOWER_PARTS and len(words) > 1 else ""
    words = words[1:] if lower else words
    if is_dart(pattern, seam):
        name = f"{lower} {_name_dart(pattern, seam)}".strip()
    elif (closed := ".".join(words[:2])) in CLOSURE_NAMES:
        name = CLOSURE_NAMES[closed]
    elif tier := re.fullmatch(r"tier(\d+)", words[0]):
        return SeamName(f"tier {int(tier[1]) + 1} seam", "")
    elif words[0] in LABEL_NAMES:
        faces = [word for word in words[1:] if word in (Side.FRONT, Side.BACK)]
        face = faces[0] if faces else str(find_side(pattern.panel(seam.a.panel)))
        name = LABEL_NAMES[words[0]].format(face=face)
        tier = re.search(r"tier(\d+)", seam.a.panel)
        if words[0] == "shoulder" and {seam.a.panel, seam.b.panel} <= set(find_arm_panels(pattern)):
            name = LABEL_NAMES["oversleeve"]
        elif words[:2] == ["fold", "lapel"]:
            name = "lapel crease seam"
        elif tier or lower:
            name = f"tier {int(tier[1]) + 1} {name}" if tier else f"{lower} {name}"
    else:
        name = _name_by_place(pattern, seam)
    if name in MIDDLE_SEAMS:
        return SeamName(name, "")
    sides = [word for word in words if word in ("left", "right")]
    return SeamName(name, sides[0] if sides else _find_lateral_side(pattern, seam))


def is_dart(pattern: Pattern, seam: Seam) -> bool:
    """Check whether a seam joins two neighbouring edges of one panel."""
    count = len(pattern.panel(seam.a.panel).edges)
    apart = (seam.a.edge - seam.b.edge) % count
    return seam.a.panel == seam.b.panel and apart in (1, count - 1)


def _name_dart(pattern: Pattern, seam: Seam) -> str:
    """Return the name of a dart by its face, and by the seam or opening that its mouth is on."""
    panel, partners = pattern.panel(seam.a.panel), find_sewn_partners(pattern)
    count = len(panel.edges)
    first, last = sorted((seam.a.edge, seam.b.edge))
    before = (last if last - first > 1 else first) - 1
    edge, ref = panel.edges[before % count], EdgeRef(panel.name, before % count)
    face = str(find_side(panel))
    if edge.contour == "waist" or "waist" in edge.label or "band" in edge.label or "hipyoke" in edge.label:
        return f"{face} waist dart"
    if ref in partners and "shoulder" in edge.label:
        return f"{face} shoulder dart"
    if ref in partners and "side" in edge.label.split("."):
        return "bust dart" if face == Side.FRONT else f"{face} side dart"
    return f"{face} dart"


def _middle(pattern: Pattern, seam: Seam) -> np.ndarray:
    """Return the mean of both placed edges' ends [m], shape [3]."""
    return np.asarray(np.concatenate([_ends(pattern, ref) for ref in (seam.a, seam.b)]).mean(axis=0))


def _ends(pattern: Pattern, ref: EdgeRef) -> np.ndarray:
    panel = pattern.panel(ref.panel)
    return place_points(panel, panel.points[[ref.edge, (ref.edge + 1) % len(panel.points)]])


def _centre(panel: Panel) -> np.ndarray:
    return np.asarray(place_points(panel, panel.points).mean(axis=0))


def _find_lateral_side(pattern: Pattern, seam: Seam) -> str:
    """Return the wearer's side that a seam's panels or edges are on; +x is the wearer's left."""
    names = [set(re.split(r"[\W_]+", ref.panel.lower())) for ref in (seam.a, seam.b)]
    for word, letter in (("left", "l"), ("right", "r")):
        if all({word, letter} & words for words in names):
            return word
    x = np.concatenate([place_points(panel, panel.points)[:, 0] for panel in pattern.panels])
    middle, reach = (x.min() + x.max()) / 2.0, 0.02 * float(np.ptp(x))
    at = float(_middle(pattern, seam)[0]) - float(middle)
    return "" if abs(at) <= reach else "left" if at > 0.0 else "right"


def _name_by_place(pattern: Pattern, seam: Seam) -> str:
    """Return the name of a seam by the parts and sides of its panels; an empty text where they do not show it."""
    one, other = (pattern.panel(ref.panel) for ref in (seam.a, seam.b))
    arms, parts = find_arm_panels(pattern), {find_part(one), find_part(other)}
    depths = [arms.get(panel.name, 0) for panel in (one, other)]
    middle, centres = _middle(pattern, seam), (_centre(one), _centre(other))
    height = float(np.mean([centre[1] for centre in centres]))
    if all(depths):
        if depths[0] != depths[1]:
            return "cuff seam"
        return "overarm seam" if middle[1] > height else "sleeve seam"
    if any(depths):
        return "armhole seam"
    for words, edge_name, own_name in (
        (("collar",), "neck seam", "collar side seam"),
        (("hood",), "neck seam", "hood crown seam"),
    ):
        if parts & set(words):
            return own_name if len(parts) == 1 else edge_name
    if parts & {"band", "wb"}:
        if parts <= {"band", "wb"}:
            return "waistband end seam"
        of_band = [find_part(panel) in ("band", "wb") for panel in (one, other)]
        is_above = centres[of_band.index(True)][1] > centres[of_band.index(False)][1]
        return "waistband seam" if is_above else "hem band seam"
    return _name_trunk_seam(pattern, seam)


def _name_trunk_seam(pattern: Pattern, seam: Seam) -> str:
    one, other = (pattern.panel(ref.panel) for ref in (seam.a, seam.b))
    middle, centres = _middle(pattern, seam), (_centre(one), _centre(other))
    start, end = _ends(pattern, seam.a)
    rise = abs(float(end[1] - start[1])) / max(float(np.hypot(end[0] - start[0], end[1] - start[1])), 1e-9)
    faces = {find_side(one), find_side(other)}
    side = _find_lateral_side(pattern, seam)
    if faces == {Side.FRONT, Side.BACK}:
        if rise < MIN_UPRIGHT_SEAM_SINE:
            return "shoulder seam" if middle[1] > np.mean([centre[1] for centre in centres]) else ""
        reach = [abs(float(centre[0])) for centre in centres]
        return "inseam" if abs(float(middle[0])) < min(reach) - 0.01 else "side seam"
    if len(faces) == 1 and Side.BESIDE not in faces:
        face = str(next(iter(faces)))
        if rise < MIN_UPRIGHT_SEAM_SINE:
            return ""
        return f"{face} panel seam" if side else f"centre {face} seam"
    return ""
