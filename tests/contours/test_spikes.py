"""Outliers are told from the corners of a coarse hem."""

from __future__ import annotations

import numpy as np
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.contours.spikes import flatten_spikes


def test_a_coarse_clean_garment_has_no_outliers(wearers, skin):
    """Breaks where the corners of a hem with edges of 2 cm are cut off: their neighbours all lie to one side."""
    vertices, faces = skin(wearers["T"], "tshirt")
    found, moved = flatten_spikes(vertices, faces)
    assert not moved.any()
    np.testing.assert_array_equal(found, vertices)


def test_outliers_on_a_hem_are_found(wearers, skin):
    """Breaks where border vertices are spared altogether: points thrown 5 cm off lengthen the hem."""
    vertices, faces = skin(wearers["T"], "tshirt")
    hem = max(find_loops(faces), key=len)
    hit = hem[2:-2:7]
    thrown = vertices.copy()
    thrown[hit] += 0.05 * np.array([[0.0, -1.0, 0.0]])
    found, moved = flatten_spikes(thrown, faces)
    assert len(hit) > 5 and moved[hit].all() and moved.sum() <= 1.5 * len(hit)
    assert np.median(np.linalg.norm(found - vertices, axis=1)[hit]) < 0.03
