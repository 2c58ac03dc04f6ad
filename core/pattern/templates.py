"""The template library: base patterns that a recovery starts from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..errors import NotFound
from .garmentcode import load_pattern
from .pattern import Pattern


class TemplateUnknown(NotFound):
    """No template has that name; `garmentq templates list` shows what there is."""

    code = "template.unknown"


@dataclass(frozen=True)
class TemplateInfo:
    """Describe one shipped template.

    Attributes:
        name: What `load_template` takes.
        category: One of `segment.CATEGORIES`.
        title: One line for people.
    """

    name: str
    category: str
    title: str


TEMPLATES = (
    TemplateInfo("tshirt", "tshirt", "T-shirt with short sleeves: front, back, four half sleeves"),
    TemplateInfo("tank", "tank", "tank top: front, back"),
    TemplateInfo("dress", "dress", "sleeveless dress in one piece: front, back"),
    TemplateInfo("trousers", "trousers", "straight trousers: front and back of each leg"),
    TemplateInfo("skirt", "skirt", "A-line skirt: front, back"),
)
"""Every shipped template."""


LIBRARY = Path(__file__).parent / "library"
"""Where the pattern files are; `drafting.write_library` makes them."""


def list_templates() -> tuple[TemplateInfo, ...]:
    """List the shipped templates."""
    return TEMPLATES


def load_template(name: str) -> Pattern:
    """Load a shipped base pattern.

    Raises:
        TemplateUnknown: where there is none of that name; the message lists those there are.
    """
    if name not in (info.name for info in TEMPLATES):
        known = ", ".join(info.name for info in TEMPLATES)
        raise TemplateUnknown(f"template '{name}' is not one of {known}; `garmentq templates list` shows them.")
    return load_pattern(LIBRARY / f"{name}.json")
