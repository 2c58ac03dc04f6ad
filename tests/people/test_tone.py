"""The skin's own colour: learnt from face and hands, it ends garments where geometry shows nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.people.colour import SURE, find_strays, link_alike, use_colours
from garmentq.core.people.diffusion import diffuse, link_points
from garmentq.core.people.features import Features, describe_points
from garmentq.core.people.lab import to_lab
from garmentq.core.people.part import CLOTH, PARTS, Part
from garmentq.core.people.points import PersonPoints, sample_person
from garmentq.core.people.prior import scalp, scalp_hair_probability
from garmentq.core.people.rules import predict_by_rules
from garmentq.core.people.tone import skin_evidence
from garmentq.core.scan.raw import RawScan

TAN, BLUE, GREY, BLACK = (0.76, 0.60, 0.48), (0.15, 0.25, 0.65), (0.30, 0.30, 0.32), (0.08, 0.07, 0.06)


@dataclass(frozen=True)
class Fit:
    """Stand for a fit: the body is known."""

    body: Body


@dataclass(frozen=True)
class Painted:
    """A bare body painted like clothes: no step shows where any of them ends."""

    fit: Fit
    points: PersonPoints
    features: Features
    part: np.ndarray


@pytest.fixture(scope="module")
def painted() -> Painted:
    """Return a person with a painted top to below the bust, bare to the hips, then painted to the shins; bald."""
    body = builtin_body("builtin:female,pose=A")
    x, y = np.abs(body.rest_vertices[:, 0]), body.rest_vertices[:, 1]
    joint = dict(zip(("hip", "spine2", "ankle", "neck", "shoulder"), body.rest_joints[[1, 6, 7, 12, 16]], strict=True))
    arm = body.weights[:, 16:24].sum(axis=1) > 0.5
    top = (y > joint["spine2"][1]) & (y < joint["neck"][1] - 0.03) & (x < joint["shoulder"][0] + 0.15)
    bottom = ~arm & (y < joint["hip"][1] + 0.05) & (y > joint["ankle"][1] + 0.15)
    part = np.select([top, bottom], [Part.UPPER, Part.LOWER], Part.SKIN)
    rgb = np.select([top[:, None], bottom[:, None]], [BLUE, GREY], TAN)
    rgb = (rgb + np.random.default_rng(0).normal(0.0, 0.02, rgb.shape)).clip(0.0, 1.0)
    every, fit = np.arange(len(y)), Fit(body)
    raw = RawScan(body.raised(np.where(part, 0.008, 0.0)).vertices, body.faces, None, False, rgb, None, every, every)
    points = sample_person(raw, fit)
    near = np.array([[each == int(column) for column in PARTS] for each in part], dtype=float)
    return Painted(fit, points, describe_points(points, fit), np.array(PARTS)[points_part(points, raw, near)])


def points_part(points: PersonPoints, raw: RawScan, near: np.ndarray) -> np.ndarray:
    """Return the column of the part of the raw point nearest to each sample."""
    from scipy.spatial import cKDTree

    return np.asarray(near[cKDTree(raw.points).query(points.positions)[1]].argmax(axis=1))


def tone_of(painted: Painted, rgb: np.ndarray | None = None) -> np.ndarray | None:
    """Return the evidence of the person's colours, or of others."""
    lab = painted.points.lab if rgb is None else to_lab(rgb)
    assert lab is not None
    return skin_evidence(lab, painted.features.place, painted.fit.body)


def test_the_skins_colour_is_told_from_cloth(painted):
    """Broken where the model is learnt from clothes, or cloth of another colour passes for skin."""
    tone = tone_of(painted)
    assert tone is not None
    assert np.median(tone[painted.part == Part.SKIN]) > 0.5
    assert np.median(tone[np.isin(painted.part, CLOTH)]) == pytest.approx(-3.0)


def test_gloves_show_no_skin(painted):
    """Broken where the colour of gloves or of a mask is taken for the skin's."""
    hands = painted.features.column("part_hand") > 0.5
    assert tone_of(painted, np.where(hands[:, None], BLACK, painted.points.colours)) is None


def test_one_colour_tells_nothing(painted):
    """Broken where someone in clothes of the skin's colour is called bare: all evidence must be near 0."""
    tone = tone_of(painted, np.tile(TAN, (len(painted.part), 1)))
    assert tone is not None and np.abs(tone).max() < 0.2


def test_a_bare_midriff_is_skin(painted):
    """Broken where skin between two garments is given to one of them, or its colour goes into their models."""
    points, features, tone = painted.points, painted.features, tone_of(painted)
    links = link_points(points.positions, points.normals)
    posterior = diffuse(predict_by_rules(points, features, painted.fit, tone), links)
    assert points.lab is not None
    links = link_alike(links, points.lab)
    found = np.array(PARTS)[use_colours(posterior, points.lab, features.place, links, tone).argmax(axis=1)]
    joints = painted.fit.body.rest_joints
    height = features.place.rest[:, 1]
    belly = (height > joints[1, 1] + 0.07) & (height < joints[6, 1] - 0.02) & (features.column("part_forearm") < 0.1)
    belly &= (painted.part == Part.SKIN) & (features.column("part_hand") < 0.1)
    assert belly.sum() > 300
    assert (found[belly] == Part.SKIN).mean() > 0.9
    assert (found == painted.part).mean() > 0.93


def test_strays_are_kept_out_of_a_garments_colours():
    """Broken where a garment learns the colour of skin that was taken for it, or one in skin colour loses its own."""
    posterior = np.zeros((100, len(PARTS)))
    posterior[:, PARTS.index(Part.LOWER)] = SURE
    tone = np.where(np.arange(100) < 30, 1.0, -3.0)
    assert find_strays(posterior, tone)[:, PARTS.index(Part.LOWER)].tolist() == (tone > 0).tolist()
    assert not find_strays(posterior, -tone).any()


def test_a_crown_in_the_skins_colour_is_bald(painted):
    """Broken where a bald head gets hair, or black, cropped or unseen hair is lost."""
    grows, features = scalp(painted.features.place, painted.fit.body), painted.features
    assert scalp_hair_probability(features, grows, tone_of(painted)) < 0.3
    assert scalp_hair_probability(features, grows, None) > 0.85
    dark = np.where(grows[:, None] > 0.3, BLACK, painted.points.colours)
    assert scalp_hair_probability(features, grows, tone_of(painted, dark)) > 0.95
