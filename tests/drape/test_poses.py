"""Every template is carried into the built-in body's poses, whole and outside it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from garmentq.core.body import Body, DistanceGrid, builtin_body, signed_distance
from garmentq.core.drape import carry, dress, follow, lay_threads, waist_loop
from garmentq.core.drape.stage import look_up
from garmentq.core.measure import self_intersections
from garmentq.core.pattern import list_templates, load_template, mesh_pattern
from garmentq.core.simulate import push_out

NODES = 350
"""Edges of 5 cm: the coarsest at which a sleeve still is a tube."""

STATURES = {"female": "builtin:female,height=1.70", "male": "builtin:male"}


@cache
def wearer(gender: str, pose: str) -> tuple[Body, DistanceGrid]:
    """Give the built-in body in a pose with its distance grid."""
    body = builtin_body(f"{STATURES[gender]},pose={pose}")
    return body, DistanceGrid.from_mesh(body.vertices, body.faces)


TIGHT = pytest.mark.xfail(strict=True, reason="drafted for the female body: a few faces cross where it is too tight")

WORN = [
    pytest.param(info.name, gender, marks=TIGHT if gender == "male" and info.category == "dress" else ())
    for info in list_templates()
    for gender in sorted(STATURES)
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "gender"), WORN)
def test_template_hangs_in_the_standing_poses(name: str, gender: str) -> None:
    """Breaks if the way into a pose pushes a garment through itself, through the body, or leaves it swinging."""
    garment = mesh_pattern(load_template(name), NODES)
    threads, waist = lay_threads(garment), waist_loop(garment)
    rest, grid = wearer(gender, "T")
    worn = dress(garment, rest, look_up(grid), threads=threads)
    tangled = len(self_intersections(push_out(worn, rest, garment.faces), garment.faces))
    for pose in ("A", "stride"):
        body, grid = wearer(gender, pose)
        nodes = carry(threads, worn, body, held=waist)
        nodes, velocity = follow(threads, nodes, look_up(grid), 60, gravity=9.81, held=waist)
        nodes = push_out(nodes, body, garment.faces)
        assert len(self_intersections(nodes, garment.faces)) <= tangled
        assert signed_distance(body, nodes)[0].min() > -1e-3
        assert np.median(np.linalg.norm(velocity, axis=1)) < 0.02
