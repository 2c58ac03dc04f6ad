"""A base pattern that is far too large for its wearer still has all its contours named."""

import numpy as np
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.templates import load_template
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.scan.contours.contours import name_contours


def test_legs_that_crumple_about_the_feet_keep_their_names() -> None:
    """Breaks if legs' ends that pile up and go round nothing lose their names: grading could not shorten them."""
    pattern = load_template("trousers")
    longer = pattern.with_points({panel.name: panel.points * [1.0, 1.15] for panel in pattern.panels})
    wearer = WearerGeometry(builtin_body("builtin:female,height=1.50"))
    worn = drape_template(longer, wearer, settings=DrapeSettings(template_vertices=450))
    piled, _ = name_contours(worn.nodes, worn.faces, wearer.body)
    assert len(piled) < 3, "the case no longer crumples: make the legs longer"
    assert [contour.name for contour in worn.contours] == ["leg.left", "leg.right", "waist"]
    left, right, waist = (worn.nodes[contour.vertices].mean(axis=0) for contour in worn.contours)
    assert left[0] > waist[0] > right[0] and waist[1] > max(left[1], right[1]) + 0.5
    assert np.all([contour.length > 0.1 for contour in worn.contours])
