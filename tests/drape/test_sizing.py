"""Base patterns come in the library's size, and for a wearer whom that does not go over in his own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.garment.curves import flat_contours
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.sizing import measure_wearer, oversize_measures
from garmentq.core.recover.drape.stage import drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.recover.start import find_template
from garmentq.core.scan.contours.target import Target
from sized_template import size_template


@pytest.fixture(scope="module")
def heavy() -> Body:
    return builtin_body("builtin:male,height=1.75,weight=120,pose=A")


@pytest.mark.parametrize("spec", ["builtin:female,height=1.70", "builtin:female,height=1.55,weight=45"])
def test_usual_wearers_get_the_size_of_the_library(spec):
    """Broken where every wearer gets a draft of his own, and with it a recovery that nobody has measured."""
    assert oversize_measures(builtin_body(spec)) is None


@pytest.mark.parametrize("named", [None, pytest.param("tank", marks=pytest.mark.nightly)])
def test_a_large_wearer_gets_a_pattern_that_goes_over_him(heavy, named):
    """Broken where a man of 1.22 m round the chest is dressed in a top of 1.02 m, which slides down his arms."""
    worn = drape_template(size_template("tank", heavy), WearerGeometry(heavy))
    assert len(worn.contours) == 4
    normals = vertex_normals(worn.nodes, worn.faces)
    target = Target(worn.nodes, worn.faces, normals, worn.contours, (), "tank")
    request = Request(
        Path("tank.ply"), BuiltinWearer("builtin:male"), settings=replace(RecoverySettings(), template=named)
    )
    found = find_template(request, target, heavy)
    bust = measure_wearer(heavy).bust
    assert found.template.partition("+")[0] == "tank"
    assert flat_contours(load_template("tank"))["hem"] < bust < flat_contours(found.pattern)["hem"]
