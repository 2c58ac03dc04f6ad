"""Templates that hang in their own lengths before they are graded."""

from __future__ import annotations

import numpy as np
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import deformation_gradients, principal_stretches
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from wearers import find_wearer


def test_an_eased_dress_hangs_no_longer_than_it_is_cut() -> None:
    """Breaks where a drape that its own weight stretches is graded: waist and hem then lie centimetres too low."""
    dress = load_template("dress+neckline=v,waist=seam,shaping=darts")
    settings = DrapeSettings(template_vertices=900)
    heavy, eased = (drape_template(dress, find_wearer(), settings=each) for each in (settings, settings.eased()))
    assert stretch(heavy) > 1.15
    assert stretch(eased) < 1.06
    assert eased.nodes[:, 1].min() - heavy.nodes[:, 1].min() > 0.02
    assert len(eased.contours) == len(heavy.contours) == 4


def stretch(worn: Garment) -> float:
    """Return by how much nine tenths of a garment's faces are stretched at most."""
    found = principal_stretches(deformation_gradients(worn.nodes, worn.faces, worn.rest))
    return float(np.quantile(found[:, 0], 0.9))
