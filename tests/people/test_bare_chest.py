"""A chest of which the skin shows wears nothing; a loose top in the skin's colour is one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.people.bare_chest import bare_chest_probability
from garmentq.core.people.colour import link_alike, use_colours
from garmentq.core.people.diffusion import diffuse, link_points
from garmentq.core.people.features import Features, describe_points
from garmentq.core.people.outfit import above_waist_probability, rank_outfits
from garmentq.core.people.part import PARTS, Part
from garmentq.core.people.points import sample_person
from garmentq.core.people.rules import predict_by_rules
from garmentq.core.people.tone import skin_evidence
from garmentq.core.scan.raw import RawScan

TAN, GREY = (0.76, 0.60, 0.48), (0.30, 0.30, 0.32)


@dataclass(frozen=True)
class Fit:
    """Stand for a fit: the body is known."""

    body: Body


def tell(thick: float, coloured: bool = True) -> tuple[tuple[Part, ...], float]:
    """Return the likeliest outfit of one in shorts and what may be a top, and the share of the chest that is one.

    Args:
        thick: Height over the skin of what has its colour, from the hips to the neck and to the elbows [m].
        coloured: Whether the scan has colours.
    """
    body = builtin_body("builtin:male,pose=A")
    x, y = np.abs(body.rest_vertices[:, 0]), body.rest_vertices[:, 1]
    joint = dict(zip(("hip", "knee", "neck", "elbow"), body.rest_joints[[1, 4, 12, 18]], strict=True))
    arm = body.weights[:, 16:24].sum(axis=1) > 0.5
    shorts = ~arm & (y < joint["hip"][1] + 0.08) & (y > joint["knee"][1] + 0.05)
    top = ~shorts & (y > joint["hip"][1]) & (y < joint["neck"][1] - 0.03) & (x < joint["elbow"][0])
    rgb = np.where(shorts[:, None], GREY, TAN) + np.random.default_rng(0).normal(0.0, 0.02, (len(y), 3))
    every, height = np.arange(len(y)), np.select([shorts, top], [0.015, thick], 0.0)
    worn = body.raised(height).vertices
    raw = RawScan(worn, body.faces, None, False, rgb.clip(0.0, 1.0) if coloured else None, None, every, every)
    fit = Fit(body)
    points = sample_person(raw, fit)
    features = describe_points(points, fit)
    links = link_points(points.positions, points.normals)
    tone = skin_evidence(points.lab, features.place, body) if coloured else None
    posterior = diffuse(predict_by_rules(points, features, fit, tone), links)
    if coloured:
        posterior = use_colours(posterior, points.lab, features.place, link_alike(links, points.lab), tone)
    rest = features.place.rest[:, 1]
    chest = (features.column("part_chest") > 0.8) & (rest < joint["neck"][1] - 0.08)
    assert chest.sum() > 500
    is_top = posterior.argmax(axis=1) == PARTS.index(Part.UPPER)
    return rank_outfits(posterior, above_waist_probability(features.place, body))[0].parts, float(is_top[chest].mean())


@pytest.mark.parametrize(
    ("thick", "coloured", "outfit"),
    [
        (0.0, True, (Part.LOWER,)),
        (0.02, True, (Part.UPPER, Part.LOWER)),
        (0.0, False, (Part.UPPER, Part.LOWER)),
    ],
)
def test_a_bare_chest_wears_no_top(thick, coloured, outfit):
    """Broken where bare skin becomes a T-shirt in its colour, or a loose top in that colour becomes skin."""
    found, share = tell(thick, coloured)
    assert found == outfit
    assert share > 0.9 if Part.UPPER in outfit else share < 0.05


@pytest.mark.parametrize(
    ("height", "thin", "skin", "wanted"),
    [
        (0.0075, 0.85, 0.95, 0.98),
        (0.0090, 0.85, 0.95, 0.735),
        (0.0110, 0.85, 0.95, 0.245),
        (0.0125, 0.85, 0.95, 0.0),
        (0.0075, 0.75, 0.95, 0.0),
        (0.0075, 0.85, 0.85, 0.817),
        (0.0075, 0.85, 0.65, 0.163),
        (0.0075, 0.85, 0.55, 0.0),
    ],
)
def test_a_chest_is_bare_by_its_height_and_its_colour(height, thin, skin, wanted):
    """Broken where a limit moves by 1 mm or by 5 % of the samples, or the folds of a top are not looked at.

    Args:
        height: Height over the body of a share `thin` of 200 samples, the others are 5 cm off [m].
        skin: Share of them in the skin's colour.
        wanted: Probability that the chest is bare.
    """
    share = (np.arange(200) + 0.5) / 200
    offset = np.where(share < thin, height, 0.05) / 0.02
    features = Features(offset[:, None], ("offset",), None)
    tone, worn = np.where(share < skin, 1.0, -1.0), np.ones(200, dtype=bool)
    assert bare_chest_probability(features, tone, worn) == pytest.approx(wanted, abs=0.01)
    assert bare_chest_probability(features, tone, share < 0.25) == 0.0  # 50 samples show too little
