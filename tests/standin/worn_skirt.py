"""A skirt of a known pattern at rest on a wearer, for fits that begin at its template."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from garmentq.core.body.body import Body
from garmentq.core.body.distance import DistanceGrid
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.pins import Pins
from garmentq.core.cloth.scene import Scene, SteadyRotation
from garmentq.core.cloth.settings import SolveSettings
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.garment.curves import panel_area
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.seams import equalise_seams
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.waist import waist_loop
from garmentq.core.recover.fit.scene import FitScene
from garmentq.core.recover.fit.settings import ShapeSettings
from garmentq.core.recover.fit.shape import ShapeProblem
from garmentq.core.recover.grade.grading import move_pattern
from garmentq.core.scan.contours.contours import name_contours
from garmentq.core.scan.contours.target import Target
from wearers import find_wearer

FINE = SolveSettings(max_iterations=150)


@dataclass(frozen=True)
class Worn:
    """A worn skirt: the template's drape, and the drape of a true pattern 3 % wider and 5 % longer."""

    template: Pattern
    true: Pattern
    worn: Garment
    registered: np.ndarray
    fabric: Fabric
    body: Body
    grid: DistanceGrid
    pins: Pins
    target: Target


def bring_to_rest(garment: Garment, fabric: Fabric, grid: DistanceGrid, pins: Pins) -> np.ndarray:
    drape = equilibrium(Scene(Topology.from_garment(garment), fabric, grid, pins), garment.nodes, settings=FINE)
    assert drape.converged
    return drape.nodes


@cache
def drape_skirt() -> Worn:
    """Drape template and true pattern, once in a process."""
    template = load_template("skirt")
    wearer = find_wearer()
    fabric = get_fabric("cotton_poplin")
    worn = drape_template(template, wearer, settings=DrapeSettings(template_vertices=600))
    waist = waist_loop(worn)
    assert waist is not None
    pins = Pins(waist, worn.nodes[waist])
    worn = worn.at(bring_to_rest(worn, fabric, wearer.grid, pins))
    true = equalise_seams(template.with_points(template.points * [1.03, 1.05]), base=template)
    registered = bring_to_rest(move_pattern(worn, true), fabric, wearer.grid, pins)
    normals = vertex_normals(registered, worn.faces)
    contours = name_contours(registered, worn.faces, wearer.body)[0]
    target = Target(registered, worn.faces, normals, contours, (), "skirt")
    return Worn(template, true, worn, registered, fabric, wearer.body, wearer.grid, pins, target)


UNMEASURED = ShapeSettings(area_spread=np.inf)
"""For a first pattern that no metric has measured: a template's, in another size."""


def state(scene: Worn, settings: ShapeSettings | None = None, locked: np.ndarray | None = None) -> ShapeProblem:
    """Pose the problem from the template's own pattern: nothing of the truth but its drape."""
    problem = pose(scene, scene.worn.at(scene.registered), settings)
    return problem if locked is None else replace(problem, scene=replace(problem.scene, locked=locked))


def pose(
    scene: Worn, at: Garment, settings: ShapeSettings | None = None, rotation: SteadyRotation | None = None
) -> ShapeProblem:
    """Pose the problem from any mesh of the template's pattern."""
    cloth = Scene(Topology.from_garment(at), scene.fabric, scene.grid, scene.pins, rotation)
    return ShapeProblem.of(FitScene.of(at, scene.template, cloth), settings or ShapeSettings())


def area_errors(pattern: Pattern, true: Pattern) -> np.ndarray:
    pairs = zip(pattern.panels, true.panels, strict=True)
    return np.array([abs(panel_area(ours) / panel_area(theirs) - 1.0) for ours, theirs in pairs])
