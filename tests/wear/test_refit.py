"""Made to measure: nothing moves for the wearer, there and back is where it was, and girths follow the body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body import builtin_body
from garmentq.core.drape import size_template
from garmentq.core.pattern import list_templates, mesh_pattern, seam_mismatch
from garmentq.core.simulate import get_fabric
from garmentq.core.wear import Worn, refit_pattern

OLD, NEW = "builtin:female,height=1.70", "builtin:female,height=1.60,weight=80"


@pytest.fixture(scope="module")
def bodies():
    """Return a wearer and another body."""
    return builtin_body(OLD), builtin_body(NEW)


def wear(name: str, pattern, body) -> Worn:
    """Return a pattern as somebody's, not draped."""
    return Worn(mesh_pattern(pattern, 500), get_fabric("cotton_poplin"), body, None, None, name, "tshirt")


@pytest.mark.parametrize("name", [info.name for info in list_templates()])
def test_there_and_back(name, bodies):
    """Broken where a template's drafts do not correspond point by point, or seams pull the pattern elsewhere."""
    old, new = bodies
    pattern = size_template(name, old)
    shifted = pattern.with_points(pattern.points * 1.02)  # no draft any more, as a recovered pattern is none
    worn = wear(name, shifted, old)
    there = refit_pattern(worn, new)
    assert there.is_drafted and seam_mismatch(there.pattern) < 1e-4 + seam_mismatch(shifted)
    back = refit_pattern(wear(name, there.pattern, new), old)
    assert np.linalg.norm(back.pattern.points - shifted.points, axis=1).max() < 5e-4
    assert np.abs(there.pattern.points - shifted.points).max() > 5e-3


def test_wearer_himself_keeps_every_point(bodies):
    """Broken where measuring, drafting or equalising moves what nobody asked to move."""
    worn = wear("tshirt", size_template("tshirt", bodies[0]), bodies[0])
    assert refit_pattern(worn, bodies[0]).pattern is worn.pattern
    posed = builtin_body(f"{OLD},pose=stride")
    assert refit_pattern(worn, posed).pattern is worn.pattern


def test_a_draft_follows_the_draft(bodies):
    """Broken where the difference is taken the wrong way round: a draft for one body must become the other's."""
    old, new = bodies
    found = refit_pattern(wear("trousers", size_template("trousers", old), old), new).pattern
    wanted = size_template("trousers", new)
    assert np.linalg.norm(found.points - wanted.points, axis=1).max() < 1e-3


def test_pattern_without_a_draft_is_scaled(bodies):
    """Broken where an imported pattern is refused, left as it is, or taken for the template of its name."""
    old, new = bodies
    worn = wear("mine", size_template("tshirt", old), old)
    for each in (worn, replace(worn, template="trousers")):
        found = refit_pattern(each, new)
        assert not found.is_drafted
        assert found.pattern.points[:, 0].std() > worn.pattern.points[:, 0].std()
        assert seam_mismatch(found.pattern) < 1e-3
