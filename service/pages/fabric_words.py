"""Text about the identified and unidentified parameters of a result's fabric."""

from __future__ import annotations

import math
from typing import Any

from .markup import Html, html, join

NAMES = {
    "H00": "stiffness along the grain",
    "H11": "stiffness across the grain",
    "H01": "coupling of both stiffnesses",
    "H22": "shear stiffness",
    "k": "bending stiffness",
    "density": "weight",
    "friction": "friction",
    "thickness": "thickness",
}


def draw_fabric(name: str | None, fit: Any) -> Html:
    """Return the section on the fabric.

    Args:
        name: The fabric of the result.
        fit: Content of `fit.json`; None if the method fits no fabric.
    """
    known: list[Html] = []
    unknown: list[Html] = []
    fabric = fit.get("fabric", {}) if isinstance(fit, dict) else {}
    for parameter, estimate in fabric.items() if isinstance(fabric, dict) else ():
        (known if estimate.get("identifiable") else unknown).append(_describe_parameter(str(parameter), estimate))
    chosen = html("<p>Chosen: {}.</p>", name.replace("_", " ")) if name else Html()
    if not known and not unknown:
        estimate = "The method fits no fabric: all numbers are those of the chosen one."
        return html("<h2>Fabric</h2>{}<p class=soft>{}</p>", chosen, estimate)
    nearest = fit.get("nearest_fabrics") or []
    alike = ", ".join(str(one).replace("_", " ") for one in nearest)
    similar = html("<p>Most similar in bending: {}.</p>", alike) if nearest else Html()
    folded = "<details><summary>Not identifiable from this scan ({})</summary><ul>{}</ul></details>"
    rest = html(folded, len(unknown), join(html("<li>{}</li>", line) for line in unknown)) if unknown else Html()
    return html("<h2>Fabric</h2>{}{}{}", chosen, join([_list("Known", known), rest]), similar)


def _describe_parameter(parameter: str, estimate: dict[str, Any]) -> Html:
    """Return the text of one parameter: the factor of its uncertainty, or that it is not identifiable."""
    name, note = NAMES.get(parameter, parameter), str(estimate.get("note") or "")
    if not estimate.get("identifiable"):
        return html("{}{}", name, f": {note}" if note else "")
    value, std = estimate.get("value"), estimate.get("std")
    factor = f", within a factor of {math.exp(std):.2f}" if isinstance(std, int | float) and std < 5 else ""
    shown = f"{value:.3g}" if isinstance(value, int | float) else str(value)
    return html("{}: {}{}{}", name, shown, factor, f" ({note})" if note else "")


def _list(title: str, lines: list[Html]) -> Html:
    if not lines:
        return Html()
    return html("<h3>{}</h3><ul>{}</ul>", title, join(html("<li>{}</li>", line) for line in lines))
