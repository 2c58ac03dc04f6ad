"""A pattern that leaves as a file and comes back drapes as it did; a pattern alone can be dressed anew."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.settings import SolveSettings
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.garmentcode import load_pattern
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.seams import equalise_seams
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.curves import Curve
from garmentq.core.judge.fit import measure_distance
from garmentq.core.recover.drape.stage import DrapeSettings, drape_graded, drape_template, redrape, remesh
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.scan.contours.target import Target
from scipy.spatial import cKDTree
from wearers import find_wearer

COARSE = DrapeSettings(template_vertices=500, solve=SolveSettings(max_iterations=150))
FABRIC = get_fabric("cotton_poplin")


@pytest.fixture(scope="module")
def wearer() -> WearerGeometry:
    return find_wearer()


@pytest.fixture(scope="module")
def worn(wearer: WearerGeometry) -> tuple[Garment, Target]:
    """Dress a skirt whose pattern is no template's: wider, longer, with a slanted hem."""
    template = load_template("skirt")
    points = template.points * [1.04, 1.02] + 0.02 * np.sin(3.0 * template.points[:, ::-1])
    pattern = equalise_seams(template.with_points(points), base=template)
    garment = drape_template(pattern, wearer, settings=COARSE)
    normals = np.zeros_like(garment.nodes)
    return garment, Target(garment.nodes, garment.faces, normals, garment.contours, (), "skirt")


@pytest.mark.slow
def test_an_exported_pattern_drapes_to_the_same_shape(worn, wearer: WearerGeometry, tmp_path: Path) -> None:
    """Breaks if a file loses an edge's curve, a panel's place, a seam or the grain: 1 mm RMS between both drapes."""
    garment, target = worn
    save_pattern(garment.pattern, tmp_path / "pattern.json")
    read = load_pattern(tmp_path / "pattern.json")
    np.testing.assert_allclose(read.points, garment.pattern.points, atol=1e-6)
    ours, drape = drape_graded(remesh(garment, 500), wearer, FABRIC, target, settings=COARSE)
    assert drape.converged
    again, _ = drape_graded(remesh(replace(garment, pattern=read), 500), wearer, FABRIC, target, settings=COARSE)
    found = measure_distance(again.nodes, again.faces, ours.nodes, ours.faces, samples=2000)
    assert found["surface_rms_mm.s2t"] < 1.0
    assert found["surface_rms_mm.t2s"] < 1.0


@pytest.mark.slow
def test_a_pattern_is_dressed_anew_on_its_own_mesh(worn, wearer: WearerGeometry) -> None:
    """Breaks if the new drape starts from the nodes it is given, changes the mesh, or lets go of the waist."""
    garment, target = worn
    lost = garment.at(np.random.default_rng(0).normal(size=garment.nodes.shape))
    draped, drape = redrape(lost, wearer, FABRIC, target, settings=COARSE)
    nodes = draped.nodes
    assert nodes.shape == garment.nodes.shape
    assert drape.converged
    away = measure_distance(nodes, garment.faces, garment.nodes, garment.faces, samples=2000)
    assert away["surface_rms_mm.s2t"] < 25.0  # a drape on another mesh: other folds, the same garment
    waist = next(contour for contour in garment.contours if contour.name == "waist")
    line = Curve(target.vertices[target.waist.vertices]).resample(2000)
    assert cKDTree(line).query(nodes[waist.vertices])[0].max() < 2e-3
    assert wearer.grid.distance(nodes).min() > -2e-3
