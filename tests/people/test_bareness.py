"""A person with nothing on, or in underwear, is given no clothes; a dressed one keeps them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.people.bareness import add_bare_readings, find_loose_skin
from garmentq.core.people.confidence import NoCloth
from garmentq.core.people.hints import Hints
from garmentq.core.people.limbs import FOLDED_BODY_PARTS, BodyPlace, Limb
from garmentq.core.people.part import PARTS, Part
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


def placed(limb: Limb, count: int) -> BodyPlace:
    """Return samples on the shanks or forearms of a limb."""
    parts = np.zeros((count, len(FOLDED_BODY_PARTS)))
    parts[:, list(FOLDED_BODY_PARTS).index("shank" if limb >= Limb.LEFT_LEG else "forearm")] = 1.0
    one, three = np.zeros(count), np.zeros((count, 3))
    return BodyPlace(
        three, three, one, one, three, parts, np.zeros((count, 24)), np.full(count, int(limb)), three, three, one
    )


@pytest.mark.parametrize("limb", [Limb.LEFT_LEG, Limb.RIGHT_ARM])
def test_skin_lies_on_the_body(limb: Limb) -> None:
    """Breaks where wide trousers in the skin's colour are bare legs, or bare legs and a patch of skin are cloth."""
    spacing, count = 0.007, 3000
    posterior = np.full((count, len(PARTS)), 0.08 / (len(PARTS) - 1))
    posterior[:, PARTS.index(Part.SKIN)] = 0.92
    rng, place = np.random.default_rng(0), placed(limb, count)
    bare, wide = rng.normal(0.0, 0.004, count), rng.uniform(0.0, 0.03, count)
    assert not find_loose_skin(bare, posterior, place, spacing).any()
    assert find_loose_skin(wide, posterior, place, spacing).all()
    few = posterior.copy()
    few[200:] = np.eye(len(PARTS))[PARTS.index(Part.LOWER)]
    assert not find_loose_skin(wide, few, place, spacing).any(), "100 cm2 are no garment"
    sure = posterior.copy()
    sure[:, PARTS.index(Part.SKIN)] = 0.9999
    assert not find_loose_skin(0.45 * wide, sure, place, spacing).any(), "its height is one evidence of two"


@pytest.mark.nightly
def test_trousers_may_have_the_colour_of_skin() -> None:
    """Breaks where beige trousers are bare legs since face and hands have their colour."""
    body = builtin_body("builtin:female,pose=A")
    hip, ankle = body.joint("left_hip")[1], body.joint("left_ankle")[1]
    aside, height, depth = np.abs(body.vertices[:, 0]), body.vertices[:, 1], body.vertices[:, 2]
    is_top = (height >= hip - 0.25) & (height < body.joint("neck")[1] - 0.03) & (aside < body.joint("left_elbow")[0])
    is_leg = (height > ankle + 0.02) & (height < hip - 0.25) & (aside < 0.4)
    creases = 0.05 + 0.95 * np.cos(2.0 * np.arctan2(depth, aside - 0.15)) ** 2
    wide = np.where(is_leg, np.interp(height, [ankle, hip], [0.04, 0.002]) * creases, 0.0)
    raw = scan("builtin:female,pose=A", np.where(is_top, 0.03, wide))
    colours = np.where(is_top[:, None], [0.05, 0.08, 0.25], [0.8, 0.62, 0.5])
    colours = np.clip(colours + np.random.default_rng(1).normal(0.0, 0.02, colours.shape), 0.0, 1.0)
    found = label_person(replace(raw, colours=colours))
    assert (found.label[is_leg] == Part.LOWER).mean() > 0.8


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
