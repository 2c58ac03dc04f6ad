"""Where sleeves and legs end on their limbs, and what else they may be."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.geometry.geometry import unit
from garmentq.core.people.confidence import check_confidence
from garmentq.core.people.limb_ends import find_alternative, place_limb_ends, third_probabilities
from garmentq.core.people.part import Part
from garmentq.core.people.separation import CategoryAlternative, FoundContour, FoundGarment, LimbEnd, Outfit
from garmentq.core.recover.drape.shipped import TEMPLATE_WEARER
from garmentq.core.scan.contours.target import Contour
from garmentq.service.describe_person import describe_garment
from garmentq.service.outfit_readings import name_category, name_end

DEVIATION = 1.645
"""Half of the 0.9 interval of a normal distribution in standard deviations."""


@pytest.fixture(scope="module")
def body():
    """Return a body whose bones are known."""
    return builtin_body(BuiltinWearer(TEMPLATE_WEARER))


def ring(body, bone: tuple[str, str], share: float, radius: float = 0.08) -> np.ndarray:
    """Return a circle around a bone, shape [60, 3]."""
    first, last = (body.joint(name) for name in bone)
    along = unit(last - first)
    across = unit(np.cross(along, [0.3, 0.2, 1.0]))
    t = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)[:, None]
    return first + share * (last - first) + radius * (np.cos(t) * across + np.sin(t) * np.cross(along, across))


@pytest.mark.parametrize(("share", "interval"), [(0.2, 0.01), (0.8, None)])
def test_an_end_is_placed_along_its_limb(body, share, interval):
    """Broken where bones are mixed up, or metres are divided by the wrong bone."""
    contour = Contour("cuff.left", np.arange(60), 0.5, ())
    opening = FoundContour("cuff.left", 0.9, interval is None, interval)
    (found,) = place_limb_ends((opening,), (contour,), ring(body, ("left_elbow", "left_wrist"), share), body)
    upper, lower = (
        np.linalg.norm(body.joint(f"left_{a}") - body.joint(f"left_{b}"))
        for a, b in (("shoulder", "elbow"), ("elbow", "wrist"))
    )
    assert found.limb_end.bone_place == pytest.approx(1.0 + share, abs=0.02)
    assert found.limb_end.limb_share == pytest.approx((upper + share * lower) / (upper + lower), abs=0.02)
    if interval is None:
        assert found.limb_end.bone_deviation is None and found.limb_end.share_deviation is None
    else:
        assert found.limb_end.bone_deviation == pytest.approx(interval / DEVIATION / lower)
        assert found.limb_end.share_deviation == pytest.approx(interval / DEVIATION / (upper + lower))


def test_what_is_around_no_limb_has_no_place(body):
    """Broken where a waist is placed on a leg."""
    opening = FoundContour("waist", 0.9, False, 0.01)
    contour = Contour("waist", np.arange(60), 0.5, ())
    placed = place_limb_ends((opening,), (contour,), ring(body, ("left_hip", "left_knee"), 0.5), body)
    assert placed == (opening,)


def ends(kind: str, *places: float, deviation: float | None = 0.1) -> tuple[FoundContour, ...]:
    """Return openings at places in bones."""
    return tuple(
        FoundContour(f"{kind}.{side}", 0.9, deviation is None, limb_end=LimbEnd(place, place / 2, deviation, deviation))
        for side, place in zip(("left", "right"), places, strict=False)
    )


def test_a_category_is_doubted_by_the_interval_of_what_decides_it():
    """Broken where the sign is turned round, or one of two ends alone decides."""
    assert find_alternative("tshirt", ends("cuff", 1.5, 1.5)) == CategoryAlternative("long_sleeve_tshirt", 0.5)
    near = find_alternative("tshirt", ends("cuff", 1.3, 1.5))
    assert near.category == "long_sleeve_tshirt" and near.probability == pytest.approx(0.1587, abs=1e-4)
    far = find_alternative("trousers", ends("leg", 1.6))
    assert far.category == "shorts" and far.probability == pytest.approx(0.0228, abs=1e-4)
    assert find_alternative("skirt", ends("leg", 1.4)) is None
    assert find_alternative("tshirt", ends("cuff", 1.5, 1.5, deviation=None)) is None  # nothing shows either end


def test_thirds_are_probabilities():
    """Broken where the thirds do not sum to one, or an end on a limit is sure to be on one side of it."""
    assert third_probabilities(LimbEnd(0.7, 1 / 3, 0.1, 0.05)) == pytest.approx((0.5, 0.5, 0.0), abs=1e-6)
    assert third_probabilities(LimbEnd(1.9, 0.95, None, None)) == pytest.approx((0.0, 0.0, 1.0))
    assert sum(third_probabilities(LimbEnd(1.0, 0.6, 0.4, 0.3))) == pytest.approx(1.0)


def test_the_doubt_is_said():
    """Broken where a near category is not warned of, a far one is, or the page names no third of the arm."""
    doubtful, sure = (
        FoundGarment(Part.UPPER, 0.9, "tshirt", ends("cuff", place), alternative=CategoryAlternative("tank", chance))
        for place, chance in ((0.7, 0.3), (0.2, 0.01))
    )
    outfits = (Outfit((Part.UPPER,), 0.0),)
    assert "may be tank (30 %)" in check_confidence((doubtful,), outfits, is_given=False)[0][0]
    assert check_confidence((sure,), outfits, is_given=False)[0] == ()
    first, second = describe_garment(doubtful), describe_garment(sure)
    assert name_category(first) == "tshirt, or tank (30 %)" and name_category(second) == "tshirt"
    assert name_end(first["contours"][0]) == "cuff.left (middle or upper third)"
    assert name_end(second["contours"][0]) == "cuff.left (upper third)"
