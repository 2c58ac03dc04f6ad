"""The template library: base patterns that a recovery starts from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..geometry.curves import Curve
from ..run.errors import NotFound
from ..scan.contours.target import Contour
from .garment import Garment
from .garmentcode import load_pattern
from .measures import BodyMeasures
from .parts.cut import Cut
from .parts.draft import draft_cut
from .parts.part_words import differing_parts, parse_parts
from .parts.shipped_cuts import CUTS
from .pattern import Pattern
from .sewing import mesh_pattern

__all__ = ["TemplateUnknown", "list_templates", "load_draped_template", "load_template"]


class TemplateUnknown(NotFound):
    """No template has that name; `garmentq templates list` shows what there is."""

    code = "template.unknown"


@dataclass(frozen=True)
class TemplateInfo:
    """Describe one shipped template: its name, its category, one of `target.CATEGORIES`, and one line for display."""

    name: str
    category: str
    title: str


TEMPLATES = (
    TemplateInfo("tshirt", "tshirt", "T-shirt with short sleeves: front, back, four half sleeves"),
    TemplateInfo("long_sleeve_tshirt", "long_sleeve_tshirt", "T-shirt with sleeves to the wrist"),
    TemplateInfo("tank", "tank", "tank top: front, back"),
    TemplateInfo("dress", "dress", "sleeveless dress in one piece: front, back"),
    TemplateInfo("sleeved_dress", "dress", "dress with sleeves to the elbow: front, back, four half sleeves"),
    TemplateInfo("trousers", "trousers", "straight trousers: front and back of each leg"),
    TemplateInfo("shorts", "shorts", "shorts to mid-thigh: front and back of each leg"),
    TemplateInfo("skirt", "skirt", "A-line skirt: front, back"),
    TemplateInfo("four_panel_skirt", "skirt", "A-line skirt of four panels, to the knee"),
    TemplateInfo("pencil_skirt", "skirt", "pencil skirt with a waistband: front, back, two halves of the band"),
    TemplateInfo("jumpsuit", "jumpsuit", "sleeveless jumpsuit in one piece: front and back of each half"),
    TemplateInfo("sleeved_jumpsuit", "jumpsuit", "jumpsuit with sleeves to the elbow: four halves, four half sleeves"),
)
"""Every shipped template."""


DRAPED_VERTICES = 1500
"""Number of nodes of the shipped drapes: edges of 2.5 cm, enough for a start, and 20 kB a file."""

LIBRARY = Path(__file__).parent / "library"
"""Folder of the pattern files, which `drafting.write_library` writes."""


def list_templates() -> tuple[TemplateInfo, ...]:
    """Return the shipped templates."""
    return TEMPLATES


def load_template(name: str) -> Pattern:
    """Read a shipped base pattern, or draft it with other parts: `tshirt` or `tshirt+neckline=v,sleeve=long`.

    Raises:
        TemplateUnknown: where there is none of that name; the message lists the known names.
        PartUnknown: where there is no such part.
        PartsConflict: where the parts cannot be sewn to each other.
    """
    if "+" in name:
        return draft_cut(_find_placed_cut(name), name=name)
    _check_name(name)
    return load_pattern(LIBRARY / f"{name}.json")


def find_cut(name: str) -> Cut:
    """Return the cut of a shipped base pattern, with the other parts in its name after a `+`.

    Raises:
        TemplateUnknown: where there is none of that name.
        PartUnknown: where there is no such part.
    """
    stem, _, parts = name.partition("+")
    _check_name(stem)
    return CUTS[stem].choose(parse_parts(parts))


def _find_placed_cut(name: str) -> Cut:
    """Return the cut of a name whose parts all have a place in it."""
    cut = find_cut(name)
    cut.check_places(parse_parts(name.partition("+")[2]))
    return cut


def name_cut(stem: str, cut: Cut) -> str:
    """Return the name by which `load_template` drafts a cut that differs from a shipped one in its parts.

    Raises:
        TemplateUnknown: where there is no shipped base pattern of that name.
    """
    parts = ",".join(f"{part}={choice}" for part, choice in differing_parts(find_cut(stem), cut).items())
    return f"{stem}+{parts}" if parts else stem


def _check_name(name: str) -> None:
    if name not in (info.name for info in TEMPLATES):
        known = ", ".join(info.name for info in TEMPLATES)
        raise TemplateUnknown(f"template '{name}' is not one of {known}; `garmentq templates list` shows them.")


def draft_template(name: str, measures: BodyMeasures) -> Pattern:
    """Draft a base pattern of the library, or one with other parts, for a body of other measures.

    Raises:
        TemplateUnknown: where there is none of that name.
        PartUnknown: where there is no such part.
        PartsConflict: where the parts cannot be sewn to each other.
    """
    return draft_cut(_find_placed_cut(name), measures, name)


def load_draped_template(name: str) -> Garment | None:
    """Read a shipped template draped on the built-in female body, contours named; None where no drape is shipped. The
    file has node positions only; the mesh is computed again. Where another machine's triangulation gives another number
    of nodes the drape is invalid and None is returned.

    Raises:
        TemplateUnknown: where there is no template of that name.
    """
    pattern = load_template(name)
    path = LIBRARY / f"{name}.npz"
    if not path.exists():
        return None
    garment = mesh_pattern(pattern, DRAPED_VERTICES)
    with np.load(path) as kept:
        nodes = kept["nodes"].astype(np.float64)
        lines = [(key, kept[key].astype(np.int64)) for key in kept.files if key != "nodes"]
    if len(nodes) != len(garment.nodes):
        return None
    contours = []
    for key, vertices in lines:
        kind, _, contour = key.partition(".")
        curve = Curve(nodes[vertices], kind == "loop")
        contours.append(Contour(contour, vertices, curve.length, is_closed=curve.is_closed))
    return garment.at(nodes, tuple(contours))


def save_draped_template(garment: Garment, path: Path) -> None:
    """Write the nodes [m], to 32 bits, and the named contours of a drape for `load_draped_template`."""
    arrays: dict[str, Any] = {
        f"{'loop' if contour.is_closed else 'arc'}.{contour.name}": contour.vertices.astype(np.int32)
        for contour in garment.contours
    }
    np.savez_compressed(path, nodes=garment.nodes.astype(np.float32), **arrays)
