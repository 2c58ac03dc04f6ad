"""A person with nothing on, or in underwear, is given no clothes; a dressed one keeps them."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.people.bareness import add_bare_readings
from garmentq.core.people.confidence import NoCloth
from garmentq.core.people.hints import Hints
from garmentq.core.people.part import Part
from garmentq.core.people.separate import label_person
from garmentq.core.people.separation import Outfit
from garmentq.core.scan.raw import RawScan

TWO = (Part.UPPER, Part.LOWER)


def scan(spec: str, lift: np.ndarray | float = 0.0) -> RawScan:
    """Return a built-in body as a scanner sees it, with 1 mm of noise; `lift` [m] is what lies on its skin."""
    body = builtin_body(spec)
    noise = np.random.default_rng(0).normal(0.0, 0.001, len(body.vertices))
    normals = vertex_normals(body.vertices, body.faces)
    points = body.vertices + (lift + noise)[:, None] * normals
    every = np.arange(len(points))
    return RawScan(points, body.faces, normals, True, None, None, every, every)


@pytest.mark.parametrize(
    "spec",
    [
        "builtin:male,height=1.82,weight=105,pose=A",
        pytest.param("builtin:female,height=1.63", marks=pytest.mark.nightly),
        pytest.param("builtin:female,pose=stride", marks=pytest.mark.nightly),
    ],
)
def test_a_bare_person_wears_nothing(spec: str) -> None:
    """Breaks where a body scan without clothes, or in briefs of 1.5 mm, is given a top and trousers."""
    body = builtin_body(spec)
    hips = body.joint("pelvis")
    briefs = (np.abs(body.vertices[:, 1] - hips[1]) < 0.09) & (np.abs(body.vertices[:, 0] - hips[0]) < 0.25)
    found = label_person(scan(spec, np.where(briefs, 0.0015, 0.0)))
    assert found.garments == () and isinstance(found.problem, NoCloth)
    assert found.outfits[0].parts == ()
    assert not np.isin(found.label, [int(part) for part in TWO]).any()


def test_who_says_nothing_gets_a_body() -> None:
    """Breaks where `--wearing nothing` is refused, or finds clothes."""
    found = label_person(scan("builtin:female,pose=A"), Hints(wearing=()))
    assert found.garments == () and found.problem is None
    assert found.body.fit_rms < 0.004


def test_each_garment_may_be_skin() -> None:
    """Breaks where a bare chest above trousers takes the trousers along, or odds count the wrong way round."""
    outfits = (Outfit(TWO, -1.0), Outfit((Part.ONE_PIECE,), -4.0))
    found = add_bare_readings(outfits, {Part.UPPER: 2.5, Part.LOWER: -9.0})
    assert [(one.parts, one.score) for one in found] == [
        ((Part.LOWER,), 1.5), (TWO, -1.0), ((Part.ONE_PIECE,), -4.0), ((), -7.5), ((Part.UPPER,), -10.0)
    ]  # fmt: skip
    assert add_bare_readings(outfits, {})[0] == outfits[0]
