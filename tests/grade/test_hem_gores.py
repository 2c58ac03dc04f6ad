"""The number and the flare of a skirt's gores, read from its hem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.garment.parts.cut import Cut, Gores, Skirt
from garmentq.core.garment.parts.draft import draft_cut
from garmentq.core.garment.parts.shipped_cuts import CUTS
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.grade.hem_gores import HemGores, find_gores
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.contours.target import Contour, Target
from standing_gores import stand_gores


def stand_up(cut: Cut) -> Target:
    """Return a skirt that stands by itself, with its hem named."""
    garment = mesh_pattern(draft_cut(cut), 2500)
    nodes = stand_gores(garment)
    loop = min(find_loops(garment.faces), key=lambda each: nodes[each, 1].mean())
    return Target(nodes, garment.faces, vertex_normals(nodes, garment.faces), (Contour("hem", loop, 3.0),), (), "skirt")


def gored(gores: Gores, sweep: float) -> Cut:
    """Return a skirt of so many gores that flare by an angle in all [rad]."""
    return Cut(skirt=Skirt.GORED, gores=gores, sweep=sweep)


@pytest.mark.parametrize(("gores", "sweep"), [(Gores.SIX, 4.0), (Gores.EIGHT, 5.5), (Gores.TWELVE, 5.5)])
def test_a_hem_tells_number_and_flare_of_its_gores(gores: Gores, sweep: float) -> None:
    """Breaks where a corner is missed or met twice, or the draft's sides do not flare by what it is asked for."""
    found = find_gores(stand_up(gored(gores, sweep)))
    assert found is not None and found.gores is gores
    assert found.sweep == pytest.approx(sweep, rel=0.02)


def test_other_hems_show_no_gores() -> None:
    """Breaks where four panels, a noisy hem or one that is not trusted are taken for gores."""
    assert find_gores(stand_up(gored(Gores.FOUR, 3.0))) is None
    target = stand_up(gored(Gores.EIGHT, 5.5))
    noise = 0.003 * np.random.default_rng(0).standard_normal(target.vertices.shape)
    assert find_gores(replace(target, vertices=target.vertices + noise)) is None
    (hem,) = target.contours
    assert find_gores(replace(target, contours=(replace(hem, trusted=False),))) is None
    assert find_gores(replace(target, contours=())) is None


def test_only_as_many_gores_are_flared_and_the_parts_are_told() -> None:
    """Breaks where another skirt takes the angle, or a dress is told parts that cannot be sewn."""
    seen = HemGores(Gores.EIGHT, 5.5)
    eight = CUTS["skirt"].choose({"skirt": "gored", "gores": "8"})
    assert seen.flare(eight) == replace(eight, sweep=5.5)
    assert seen.flare(CUTS["skirt"]) == CUTS["skirt"]
    assert seen.flare(eight.choose({"gores": "6"})).sweep is None
    darted = CUTS["dress"].choose({"skirt": "gored", "shaping": "darts", "waist": "seam"})
    assert draft_cut(HemGores(Gores.SIX, 5.5).flare(darted))
    found = seen.describe(CUTS["skirt"])
    assert "--part skirt=gored,gores=8'" in found and "315 degrees" in found
    parts = seen.describe(CUTS["dress"]).split("--part ")[1].split("'")[0]
    assert draft_cut(CUTS["dress"].choose(dict(word.split("=") for word in parts.split(","))))
