"""A garment small enough to be moved in a test: a skirt on the body that it was drafted for."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.distance import DistanceGrid
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.body.projection import project_outside
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.locking import reduce_membrane_stiffness
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.recover.drape.stage import remesh
from garmentq.core.recover.drape.waist_placement import pin_waist
from garmentq.core.reuse.wear.worn import WornGarment


@pytest.fixture(scope="session")
def worn() -> WornGarment:
    """Return a pencil skirt of 500 vertices at rest on its wearer."""
    whole = load_draped_template("pencil_skirt")
    assert whole is not None
    body = builtin_body("builtin:female,height=1.70")
    garment = remesh(whole, 500)
    fabric = get_fabric("cotton_poplin")
    grid = DistanceGrid.from_mesh(body.vertices, body.faces)
    nodes = project_outside(garment.nodes, ExposedSurface.of(body), garment.faces, 3e-3)
    scene = Scene(Topology.from_garment(garment), reduce_membrane_stiffness(fabric), grid, pin_waist(garment.at(nodes)))
    nodes = project_outside(equilibrium(scene, nodes).nodes, ExposedSurface.of(body), garment.faces)
    return WornGarment(garment.at(np.asarray(nodes)), fabric, body, None, None, "pencil_skirt", "skirt")
