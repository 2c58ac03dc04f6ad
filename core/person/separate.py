"""Take a dressed person's scan apart: the body under the clothes, and what each point of the file is."""

from __future__ import annotations

import numpy as np

from ..body import PointWeights, fit_person, refit_person
from ..hooks import SILENT, Hooks
from ..scan.raw import RawScan
from .colour import use_colours
from .confidence import judge
from .crumbs import give_crumbs
from .diffusion import diffuse, link_points
from .features import describe_points
from .garments import find_garments
from .hints import Hints
from .outfit import rank_outfits, read_as
from .part import CLOTH, PARTS, Part
from .points import sample_person
from .rules import predict_by_rules
from .separation import Separation

ROUNDS = 2
"""Times that the parts are predicted, each on a body fitted with what the one before found."""

IGNORED = (Part.HAIR, Part.SHOES, Part.OTHER)
"""What is neither skin nor cloth: the body lies somewhere below."""

NUMBERS = np.array([int(part) for part in PARTS], np.uint8)
"""The label of each column of a posterior."""


def separate(raw: RawScan, hints: Hints | None = None, hooks: Hooks = SILENT) -> Separation:
    """Find the wearer under the clothes, and tell skin, hair, shoes and garments apart.

    Args:
        raw: The person.
        hints: What the user knows already.
        hooks: Progress, cancellation and checkpoints.
    """
    hints = hints or Hints()
    fit = fit_person(raw.points, raw.normals, raw.is_oriented, hooks)
    points = sample_person(raw, fit)
    links = link_points(points.positions, points.normals)
    for _ in range(ROUNDS):
        features = describe_points(points, fit)
        posterior = diffuse(predict_by_rules(points, features, fit), links)
        fit = refit_person(fit, points.positions, points.normals, weigh(posterior), hooks)
    if points.colours is not None:
        posterior = use_colours(posterior, points.colours, features.place, links)
    waist = fit.body.joint("pelvis")[1]
    above = 1.0 / (1.0 + np.exp(-(points.positions[:, 1] - waist) / 0.03))
    outfits = rank_outfits(posterior, above, hints.wearing)
    posterior = read_as(posterior, outfits[0].parts, above)
    posterior /= posterior.sum(axis=1, keepdims=True)
    area = np.full(len(posterior), points.spacing**2)
    column = give_crumbs(posterior.argmax(axis=1), points.positions, area, links)
    posterior = _believe(posterior, column)
    carried = points.carry(posterior.astype(np.float32))
    at, sure = NUMBERS[carried.argmax(axis=1)], carried.max(axis=1)
    garments = find_garments(raw, at, sure, fit.body)
    warnings, problem = judge(garments, outfits, hints.wearing is not None)
    label, confidence = to_file(raw, at, sure)
    return Separation(fit.body, label, confidence, garments, outfits, warnings, problem)


def weigh(posterior: np.ndarray) -> PointWeights:
    """Return what a posterior, shape [n, part_count], says of where the body is."""
    cloth, ignored = (posterior[:, [PARTS.index(part) for part in parts]].sum(axis=1) for parts in (CLOTH, IGNORED))
    return PointWeights(cloth, ignored)


def to_file(raw: RawScan, label: np.ndarray, confidence: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return label and confidence of each point of the file, shape [file_count]; what was dropped is OTHER, surely."""
    kept = raw.place >= 0
    labels = np.full(len(raw.place), int(Part.OTHER), np.uint8)
    sure = np.ones(len(raw.place), np.float32)
    labels[kept], sure[kept] = label[raw.place[kept]], confidence[raw.place[kept]]
    return labels, sure


def _believe(posterior: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Return the posterior with the chosen part likeliest: where another was, the two change places."""
    rows, best = np.arange(len(column)), posterior.argmax(axis=1)
    changed = posterior.copy()
    changed[rows, column], changed[rows, best] = posterior[rows, best], posterior[rows, column]
    return changed
