"""Drape the shipped templates on the built-in female body: `python -m garmentq.core.recover.drape.shipped`."""

from __future__ import annotations

from pathlib import Path

from ...body.builtin import builtin_body
from ...body.projection import project_outside
from ...cloth.fabrics import DEFAULT_FABRIC, get_fabric
from ...cloth.scene import Scene
from ...cloth.statics import equilibrium
from ...cloth.topology import Topology
from ...garment.sewing import mesh_pattern
from ...garment.templates import DRAPED_VERTICES, LIBRARY, list_templates, load_template, save_draped_template
from ...scan.contours.contours import name_contours
from .dress import dress
from .waist import waist_loop
from .waist_placement import pin_waist
from .wearer import WearerGeometry

TEMPLATE_WEARER = "builtin:female,height=1.70"
"""The body that the templates were drafted for."""

TEMPLATE_FABRIC = DEFAULT_FABRIC
"""The default fabric of a recovery."""


def drape_library(folder: Path) -> None:
    """Drape every template on its body in T-pose, its waist pinned at the draft's height, and write its nodes."""
    body = builtin_body(TEMPLATE_WEARER)
    wearer = WearerGeometry(body)
    for info in list_templates():
        garment = mesh_pattern(load_template(info.name), DRAPED_VERTICES)
        waist = waist_loop(garment)
        height = None if waist is None else float(garment.nodes[waist, 1].mean())
        nodes = dress(garment, body, wearer.grid, waist_height=height)
        pins = pin_waist(garment.at(nodes))
        rest = equilibrium(Scene(Topology.from_garment(garment), get_fabric(TEMPLATE_FABRIC), wearer.grid, pins), nodes)
        nodes = project_outside(rest.nodes, wearer.exposed, garment.faces)
        contours, _ = name_contours(nodes, garment.faces, body)
        save_draped_template(garment.at(nodes, contours), folder / f"{info.name}.npz")


if __name__ == "__main__":
    drape_library(LIBRARY)
