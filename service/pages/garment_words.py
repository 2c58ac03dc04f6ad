"""Garments, parts, base patterns and checks in words of tailors; what has no word of its own keeps its name."""

from __future__ import annotations

GARMENTS = {
    "tshirt": "T-shirt",
    "long_sleeve_tshirt": "Long-sleeved T-shirt",
    "tank": "Tank top",
}
"""Categories of garments whose word is not their name."""

CHECKS = {
    "surface_fit_s2t": "Mesh to scan",
    "surface_fit_t2s": "Scan to mesh",
    "hidden": "Cloth that the scan does not show",
    "ends": "Ends of sleeves and legs",
    "sides": "Left and right length",
    "seams": "Lengths of seams",
    "fairness": "Smooth curves",
    "pointed": "Pointed corners",
    "edge_corners": "Corners of hem and edges",
    "neck_finish": "Finish of the neck",
    "contour_shape": "Shape of open edges",
    "plausible": "Plausible lengths",
    "penetration": "Cloth inside the body",
    "undeclared": "Clothes taken for skin",
    "pinched": "Cloth between touching limbs",
    "flips": "Faces turned over",
    "self_intersections": "Cloth through cloth",
    "simulation_fit": "Simulation mesh to scan",
    "rest": "Support by the body",
    "upright": "Waist to hem",
    "redrape": "Re-drape made",
    "redrape_fit": "Re-drape to scan",
    "redrape_stretch": "Stretch of the re-drape",
    "redrape_intersections": "Cloth through cloth in the re-drape",
    "drape_residual": "Balance of the drapes",
    "at_rest": "Drapes at rest",
}
"""Checks whose word is not their name."""


def title_garment(category: str) -> str:
    """Return the title of a garment or a part of an outfit by its name: `tshirt` is `T-shirt`."""
    return GARMENTS.get(category) or _capitalise(category)


def title_check(name: str) -> str:
    """Return the title of a check; one of a garment of an outfit begins with that: `Upper: drapes at rest`."""
    before, _, own = name.rpartition(".")
    title = CHECKS.get(own) or _capitalise(own)
    return f"{_capitalise(before)}: {title[0].lower()}{title[1:]}" if before else title


def describe_template(template: str) -> str:
    """Return a base pattern in words: `tshirt+neckline=v` is `T-shirt, neckline v`."""
    cut, *parts = template.split("+")
    return ", ".join([title_garment(cut), *(part.replace("=", " ").replace("_", " ") for part in parts)])


def _capitalise(name: str) -> str:
    text = name.replace("_", " ")
    return text[:1].upper() + text[1:]
