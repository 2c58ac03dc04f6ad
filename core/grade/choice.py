"""Choose the base pattern for a target."""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import BadInput
from ..segment import Target

TEMPLATE_OF = {
    "tshirt": "tshirt",
    "long_sleeve_tshirt": "tshirt",
    "tank": "tank",
    "dress": "dress",
    "trousers": "trousers",
    "shorts": "trousers",
    "skirt": "skirt",
}
"""The shipped template of each category: sleeves and legs of any length are graded from one."""


class TemplateMissing(BadInput):
    """No template fits this garment; name one with --template NAME or give a pattern file."""

    code = "template.none_fits"


def choose_template(target: Target, names: Sequence[str]) -> str:
    """Name the template for a target's category.

    Args:
        target: The target; its category was chosen from its contours and the bones they encircle.
        names: The templates there are.

    Raises:
        TemplateMissing: where there is none for the category.
    """
    name = TEMPLATE_OF.get(target.category)
    if name is None or name not in names:
        raise TemplateMissing(
            f"no template fits the category '{target.category}'; name one of {', '.join(names)} with --template."
        )
    return name
