"""Label a dressed person's scan: find the body under the clothes, and the part of each point of the file."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ..body.body import Body
from ..body.person import PersonFit, PointWeights, fit_person, refit_person
from ..body.presence import SeveralPersons
from ..run.hooks import SILENT_HOOKS, Hooks
from ..scan.raw import RawScan
from ..scan.thin import thin_raw_scan
from .bareness import add_bare_readings, find_bare_odds, find_loose_skin, measure_bare_heights
from .coat import Coat, find_coat
from .colour import link_alike, use_colours
from .confidence import apply_temperature, check_confidence, check_garments
from .depth import find_depth
from .diffusion import Links, diffuse, link_points
from .features import Features, describe_points
from .garments import PointLabels, build_person_surface, find_garments
from .hints import Hints
from .limbs import BodyPlace
from .marks import apply_marks, list_marked_garments
from .networks import NetworkEnsemble, load_ensemble, predict_by_networks
from .outfit import above_waist_probability, condition_on_outfit, give_to_skin, marginalise_outfits, rank_outfits
from .part import CLOTH, PARTS, Part
from .points import FittedPerson, PersonPoints, sample_person
from .rules import predict_by_rules
from .separation import LabelledPerson
from .small_pieces import relabel_beyond_skin, relabel_small_pieces
from .tone import SKIN_COLOUR_EVIDENCE, skin_evidence

STAGE = "separate"
"""Name under which progress is reported."""

BODY_REFIT_ITERATIONS = 2
"""Number of fits of the body below the cloth found on the previous fit, before the parts are predicted once more."""

COVERING_PARTS = (*CLOTH, Part.SHOES)
"""Parts closely above the body. Shoes cover standing feet: with a low weight nothing constrained the feet of suits'
wearers, and legs rose by 13 cm within their trousers."""

IGNORED_PARTS = (Part.HAIR, Part.OTHER)
"""Parts that are neither skin nor cover: the body is somewhere below."""

PART_NUMBERS = np.array([int(part) for part in PARTS], np.uint8)
"""The label of each column of a posterior."""

USER_LABEL_PROBABILITY = 0.98
"""Probability of a label that the user gave: a border drawn by hand is off by a few millimetres."""


@dataclass(frozen=True)
class _GivenBody:
    """Describe a wearer that the user gave, who is not fitted again."""

    body: Body


def label_person(raw: RawScan, hints: Hints | None = None, hooks: Hooks = SILENT_HOOKS) -> LabelledPerson:
    """Find the wearer under the clothes, and label skin, hair, shoes and garments.

    The body is fitted as if bare; the parts are predicted by rules from where each point is on it and from the scan's
    colours; the body is fitted again below the cloth; and so on. The last prediction is by rules and trained networks.
    Then the outfit is chosen, and every point of the file gets the label that is likeliest under it.

    Args:
        raw: The person.
        hints: What the user gave.
        hooks: Progress, cancellation and checkpoints.

    Returns:
        The labelled person. A garment that is too unsure to recover has the reason as its `problem`, and the person
        where all are.

    Raises:
        BadInput: where the scan is no person.
    """
    hints = hints or Hints()
    if hints.label is None:
        check_single_person(raw)
    fit: PersonFit | _GivenBody
    if hints.body is not None:
        fit = _GivenBody(hints.body)
    else:
        fit = fit_person(raw.points, raw.normals, raw.is_oriented, hooks)
    points = sample_person(raw, fit)
    links = link_points(points.positions, points.normals)
    if points.lab is not None:
        links = link_alike(links, points.lab)
    known = None if hints.label is None else _sample_labels(raw, points, hints.label[raw.origin])
    if not isinstance(fit, _GivenBody):
        fit = fit_below_clothes(fit, points, links, known, hooks)
    height: np.ndarray | None = None
    if known is not None:
        posterior, features = known, describe_points(points, fit)
    else:
        posterior, features = predict_parts(points, fit, links, load_ensemble())
    if known is None and not isinstance(fit, _GivenBody):
        height = measure_bare_heights(fit, points, hooks)
        loose = find_loose_skin(height, posterior, features.place, points.spacing)
        if points.lab is not None and loose.any():
            fit = fit_below_clothes(fit, points, links, loose=loose, hooks=hooks)
            posterior, features = predict_parts(points, fit, links, load_ensemble(), loose)
    hooks.progress(STAGE, 0.8, "choosing the outfit")
    above = above_waist_probability(features.place, fit.body)
    coat = Coat() if known is not None else find_coat(points, features, posterior, links, fit.body)
    outfits = rank_outfits(posterior, above, _hinted_garments(hints), list_marked_garments(hints.marks), coat)
    marginal = marginalise_outfits(posterior, outfits, above, coat.over)
    posterior = condition_on_outfit(posterior, outfits[0].parts, above, coat.over)
    posterior /= posterior.sum(axis=1, keepdims=True)
    area = np.full(len(posterior), points.spacing**2)
    column = posterior.argmax(axis=1)
    if known is None:
        column = relabel_small_pieces(column, points.positions, area, links)
        column = relabel_beyond_skin(column, posterior, features.place, links)
        column = apply_marks(column, hints.marks, raw, points, links)
    first = posterior.argmax(axis=1)
    marginal, posterior = (_swap_probabilities(one, first, column) for one in (marginal, posterior))
    if height is not None and hints.wearing is None:
        odds, marked = find_bare_odds(height, column), list_marked_garments(hints.marks)
        worn = outfits[0].parts
        outfits = add_bare_readings(outfits, {part: value for part, value in odds.items() if part not in marked})
        bare = tuple(part for part in worn if part not in outfits[0].parts)
        marginal, posterior = (give_to_skin(one, bare) for one in (marginal, posterior))
    if not isinstance(fit, _GivenBody):
        fit = refit_person(fit, points.positions, points.normals, to_point_weights(posterior, features.place), hooks)
    labels = _carry_labels(points, posterior, marginal)
    if hints.label is not None:
        sure = np.full(len(raw.origin), USER_LABEL_PROBABILITY, np.float32)
        labels = PointLabels(hints.label[raw.origin], sure, sure)
    hooks.progress(STAGE, 0.9, "finding the garments' openings")
    body = fit.body if isinstance(fit, _GivenBody) else replace(fit.body, source=f"scan:{raw.name}")
    thinned = thin_raw_scan(raw)
    surface = build_person_surface(thinned, body)
    garments = find_garments(raw, labels, surface, body)
    is_given = hints.wearing is not None or hints.label is not None
    garments = garments if is_given else check_garments(garments, outfits)
    warnings, problem = check_confidence(garments, outfits, is_given)
    label, confidence = expand_to_file(raw, labels.part, labels.confidence)
    if hints.label is not None:
        label = hints.label.astype(np.uint8)
    whole = surface if thinned is raw else None
    return LabelledPerson(body, label, confidence, garments, outfits, warnings, problem, whole)


def _carry_labels(points: PersonPoints, posterior: np.ndarray, marginal: np.ndarray) -> PointLabels:
    """Return the labels of the scan's points, from the samples' posterior under the best reading and over all."""
    certain = points.carry(apply_temperature(posterior).astype(np.float32))
    best = points.carry(posterior.astype(np.float32)).argmax(axis=1)
    row = np.arange(len(best))
    confidence = points.carry(marginal.astype(np.float32))[row, best]
    return PointLabels(PART_NUMBERS[best], confidence, certain[row, best])


def check_single_person(raw: RawScan) -> None:
    """Check that one person is in a scan, as far as that is known before any body is fitted.

    Raises:
        SeveralPersons: where two stand apart.
    """
    if raw.pieces > 1:
        raise SeveralPersons()


def fit_below_clothes(
    fit: PersonFit,
    points: PersonPoints,
    links: Links,
    known: np.ndarray | None = None,
    hooks: Hooks = SILENT_HOOKS,
    loose: np.ndarray | None = None,
) -> PersonFit:
    """Fit the body again, `BODY_REFIT_ITERATIONS` times, each below the cloth predicted on the previous fit.

    Args:
        fit: As if bare.
        points: The samples.
        links: Their neighbours.
        known: The posterior where it is known, shape [n, part_count]; else it is predicted.
        hooks: Progress and cancellation.
        loose: Which samples of the skin's colour hang off the body and are no skin, bool, shape [n], or None.
    """
    for turn in range(BODY_REFIT_ITERATIONS):
        hooks.progress(STAGE, turn / (BODY_REFIT_ITERATIONS + 1), "labelling the parts")
        posterior = known if known is not None else predict_parts(points, fit, links, loose=loose)[0]
        fit = refit_person(fit, points.positions, points.normals, to_point_weights(posterior), hooks)
    return fit


def to_point_weights(posterior: np.ndarray, place: BodyPlace | None = None) -> PointWeights:
    """Return the weights of a body fit from a posterior, and for a last fit how deep below the cloth the body is.

    Args:
        posterior: Of the parts, shape [n, part_count].
        place: Where the samples are on a fit that took all cloth alike; None: no depth is expected.
    """
    # Clamped: a sum that is rounded to more than 1 would give a pair a negative weight.
    cloth, ignored = (
        np.minimum(posterior[:, [PARTS.index(part) for part in parts]].sum(axis=1), 1.0)
        for parts in (COVERING_PARTS, IGNORED_PARTS)
    )
    inside, spread = (None, None) if place is None else find_depth(place, posterior)
    return PointWeights(cloth, ignored, inside, spread)


def expand_to_file(raw: RawScan, label: np.ndarray, confidence: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return label and confidence of each point of the file, shape [file_count]; dropped points are OTHER with 1."""
    kept = raw.place >= 0
    labels = np.full(len(raw.place), int(Part.OTHER), np.uint8)
    certainty = np.ones(len(raw.place), np.float32)
    labels[kept], certainty[kept] = label[raw.place[kept]], confidence[raw.place[kept]]
    return labels, certainty


def predict_parts(
    points: PersonPoints,
    fit: FittedPerson,
    links: Links,
    committee: NetworkEnsemble | None = None,
    loose: np.ndarray | None = None,
) -> tuple[np.ndarray, Features]:
    """Return the posterior by geometry and colour, shape [n, part_count], and the features.

    Args:
        points: The samples.
        fit: The body fitted to them.
        links: Their neighbours, as `link_alike` gives them where there are colours.
        committee: The trained networks, for a body fitted below the rules' cloth; None: the rules.
        loose: Which samples of the skin's colour hang off the body and are no skin, bool, shape [n], or None.
    """
    features = describe_points(points, fit)
    tone = None if points.lab is None else skin_evidence(points.lab, features.place, fit.body)
    if tone is not None and loose is not None:
        tone = np.where(loose, SKIN_COLOUR_EVIDENCE[0], tone)
    if committee is None:
        posterior = predict_by_rules(points, features, fit, tone)
    else:
        posterior = predict_by_networks(points, features, fit, tone, committee)
    return smooth_parts(posterior, points, features, links, tone), features


def smooth_parts(
    posterior: np.ndarray, points: PersonPoints, features: Features, links: Links, tone: np.ndarray | None
) -> np.ndarray:
    """Smooth a posterior of the samples, shape [n, part_count], and combine it with the evidence of the scan's colours.

    Args:
        posterior: By geometry alone, or by anything that was learnt, shape [n, part_count].
        points: The samples.
        features: Their features.
        links: Their neighbours, as `link_alike` gives them where there are colours.
        tone: Evidence for skin by its colour, shape [n], or None.
    """
    posterior = diffuse(posterior, links)
    return posterior if points.lab is None else use_colours(posterior, points.lab, features.place, links, tone)


def _hinted_garments(hints: Hints) -> tuple[Part, ...] | None:
    """Return the garments that the user gave by name or by labels, or None."""
    if hints.wearing is not None or hints.label is None:
        return hints.wearing
    return tuple(part for part in PARTS if part in CLOTH and part is not Part.OTHER and (hints.label == part).any())


def _sample_labels(raw: RawScan, points: PersonPoints, label: np.ndarray) -> np.ndarray:
    """Return given labels of the raw points as a posterior of the samples, shape [n, part_count]."""
    nearest = label[cKDTree(raw.points).query(points.positions)[1]]
    posterior = np.full((len(nearest), len(PARTS)), (1.0 - USER_LABEL_PROBABILITY) / (len(PARTS) - 1))
    posterior[np.arange(len(nearest)), np.searchsorted(PART_NUMBERS, nearest)] = USER_LABEL_PROBABILITY
    return posterior


def _swap_probabilities(posterior: np.ndarray, first: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Return the posterior with the first and the chosen part's probabilities exchanged, shape [n, part_count]."""
    rows = np.arange(len(column))
    changed = posterior.copy()
    changed[rows, column], changed[rows, first] = posterior[rows, first], posterior[rows, column]
    return changed
