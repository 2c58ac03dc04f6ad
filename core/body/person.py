"""Fit the body under the clothes: first as if bare, then below whatever may be cloth."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.geometry import vertex_normals
from ..geometry.point_normals import smooth_normals
from ..run.hooks import SILENT_HOOKS, Hooks
from .body import JOINTS, Body
from .competing_starts import SearchSettings, spread_subset
from .fit import FitStage, FitState, Fitter, OrientedPoints, find_forearms
from .person_search import find_start
from .presence import (
    MIN_SCAN_CELL_COUNT,
    MIN_WHOLE_PERSON_HEIGHT,
    SeveralPersons,
    TooSparse,
    find_hair_vertices,
    find_presence_error,
    measure_presence,
    split_in_two,
)
from .registration import NotHuman, body_of_state, pose_model
from .template import Template, load_template
from .thinning import average_points

INWARD_CLOTH_COSINE = -0.2
"""Cosine between the normals of cloth and body below which the cloth is seen from inside; folds reach 0."""

STAGE = "body"
"""Name under which progress is reported."""

IGNORED_POINT_WEIGHT = 0.1
"""Weight of a point that is surely hair, shoe or thing, relative to 1; above 0, so that a head stays below its hair."""

BARE_PARTS = ("head", "left_wrist", "right_wrist", "left_hand", "right_hand")
"""Joints whose surface is assumed to be bare: face and hands."""
SHOD_PARTS = ("left_ankle", "right_ankle", "left_foot", "right_foot")
"""Joints whose surface may be shoes."""

SUPPORT_JOINTS = (("spine3", "left_collar", "right_collar"), ("pelvis", "spine1"))
"""Joints of the skin that supports clothes: shoulders and upper back, waist and hips."""
MAX_CONTACT_OFFSET = 0.008
"""Offset [m] up to which the lowest tenth of cloth touches the body: its thickness, and a fit's error of 5 mm."""

MAX_SLEEVE_DISTANCE = 0.06
"""Largest distance of a sleeve from the forearm inside it [m]."""

MAX_BARE_SKIN_DISTANCE = 0.04
"""Largest distance [m] of a point of a hand or face from it; folds of a skirt beside a hand are further."""


@dataclass(frozen=True)
class PersonSettings:
    """Describe how a person is fitted.

    Attributes:
        search: The search of the start, as if bare.
        surface_count: Number of points of the scan in the last stages: one every 2 cm.
        fine_count: Number of template points in the last stages: one every 3 cm.
        stages: Stages that continue a fit, from 6 cm: by so much a body fitted to the clothes as if bare may be too
            thick.
        pull: Weight of cloth outside the body in these stages, relative to skin: about the share of the cloth that
            touches the body. With 0.03 bodies are too thin where all but head and hands is cloth (1.7 mm more error).
        gap: Ratio of the scale of the distance of cloth outside the body to that of skin.
        contact_refits: Largest number of refits of a body that does not reach its clothes; each counts a fifth more of
            them as skin.
        refuses: Whether scans that are not one whole person are refused.
        stray: Share of the scan's points far from the body above which there may be a second person: the widest skirt
            had 0.12.
        seed: Number that seeds the choice of points.
    """

    search: SearchSettings = field(default_factory=SearchSettings)
    surface_count: int = 5000
    fine_count: int = 1800
    stages: tuple[FitStage, ...] = (
        FitStage(6, 0.06, 0.10, True, 15),
        FitStage(8, 0.05, 0.10, True, 20),
        FitStage(8, 0.025, 0.06, True, 40),
        FitStage(10, 0.012, 0.04, True, 60),
    )
    pull: float = 0.1
    gap: float = 2.0
    contact_refits: int = 2
    refuses: bool = True
    stray: float = 0.15
    seed: int = 0


@dataclass(frozen=True)
class PointWeights:
    """Describe what is known of the points to which a body is fitted.

    Attributes:
        cloth: Probability that each is cloth, 0 to 1, shape [n].
        ignore: Probability that each is hair, shoe or thing, 0 to 1, shape [n]; None: 0.
        inside: Expected depth of the body's surface below the point [m], shape [n], NaN where unknown; or None.
        spread: Standard deviation of `inside` [m], shape [n]; None: 1 cm.
    """

    cloth: np.ndarray
    ignore: np.ndarray | None = None
    inside: np.ndarray | None = None
    spread: np.ndarray | None = None

    def take(self, index: np.ndarray) -> PointWeights:
        """Return the entries of some of the points."""
        ignore, inside, spread = (None if v is None else v[index] for v in (self.ignore, self.inside, self.spread))
        return PointWeights(np.asarray(self.cloth)[index], ignore, inside, spread)


@dataclass(frozen=True)
class PersonFit:
    """Describe a body fitted to a dressed person.

    Attributes:
        body: The wearer; its vertices are the fitted model's [m].
        state: The fit, from which a refit continues.
        skin_rms: RMS distance of points taken for skin to the body [m].
        bare_residual: Robust two-way misfit of the fit as if bare [m].
        coverage: Share of the body's vertices with scan on or over them.
        margin: Excess misfit of the next best other fit, relative to this one's.
    """

    body: Body
    state: FitState
    skin_rms: float
    bare_residual: float
    coverage: float
    margin: float


def fit_person(
    points: np.ndarray,
    normals: np.ndarray | None,
    oriented: bool = True,
    hooks: Hooks = SILENT_HOOKS,
    settings: PersonSettings | None = None,
) -> PersonFit:
    """Fit the wearer of a scan without labels: as if bare, then below all but head, hands and feet.

    Args:
        points: Positions [m], y up, any place and heading, shape [n, 3]; of a mesh its vertices.
        normals: Unit normals, shape [n, 3], or None: from neighbours.
        oriented: Whether the normals are known to point outward.
        hooks: For progress and cancelling.
        settings: How to fit, or None for the defaults.

    Raises:
        NotHuman: where no start converges to the points.
        ScanPartial: where much of the body has nothing of the scan over it.
        SeveralPersons: where there are two.
        TooSparse: where the points are too few.
    """
    settings = settings or PersonSettings()
    template = load_template()
    surface = average_points(points, normals, oriented, settings.surface_count, settings.seed)
    extent = np.zeros(3) if surface is None else np.ptp(surface.points, axis=0)
    if surface is None or not (0.7 <= extent.max() and extent[1] <= 2.8):
        raise NotHuman(f"The scan is {extent[1]:.2f} m high. {NotHuman().message}")
    if settings.refuses and surface.total < MIN_SCAN_CELL_COUNT:
        raise TooSparse()
    found = find_start(template, surface, settings.search, settings.seed, hooks)
    presence = measure_presence(template, surface, found.state)
    if settings.refuses and presence.stray > settings.stray and _shows_two_persons(template, surface, settings, hooks):
        raise SeveralPersons()
    problem = find_presence_error(presence) if settings.refuses else None
    if problem is not None and not presence.may_be_whole:
        raise problem
    turned = orient_by_body(template, surface, found.state)
    weights = guess_weights(template, turned, found.state)
    hooks.progress(STAGE, 0.6, "fitting the body below the clothes")
    fit = PersonFit(body_of_state(template, found.state, 0.0), found.state, 0.0, found.residual, 0.0, found.margin)
    fit = refit_person(fit, turned.points, turned.normals, weights, hooks, settings)
    # In the fit as if bare, hands and feet of small people extend beyond the scan and count as unseen.
    if problem is not None and find_presence_error(measure_presence(template, surface, fit.state)) is not None:
        raise problem
    return fit


def _shows_two_persons(template: Template, surface: OrientedPoints, settings: PersonSettings, hooks: Hooks) -> bool:
    """Check whether a scan is of two persons beside each other: whether each half of the points is a person."""
    second = split_in_two(surface.points)
    for half in (surface.take(~second), surface.take(second)):
        if np.ptp(half.points[:, 1]) < MIN_WHOLE_PERSON_HEIGHT:
            return False
        found = find_start(template, half, settings.search, settings.seed, hooks)
        if not measure_presence(template, half, found.state).is_person:
            return False
    return True


def refit_person(
    fit: PersonFit,
    points: np.ndarray,
    normals: np.ndarray,
    weights: PointWeights,
    hooks: Hooks = SILENT_HOOKS,
    settings: PersonSettings | None = None,
) -> PersonFit:
    """Fit the body of a person again from the last fit, with what is known of each point.

    Args:
        fit: The last fit.
        points: Positions [m], shape [n, 3], evenly spread.
        normals: Outward unit normals, shape [n, 3].
        weights: What is known of each point.
        hooks: For progress and cancelling.
        settings: How to fit, or None for the defaults.
    """
    settings = settings or PersonSettings()
    outer = find_outer_points(fit.body, points, normals, weights.cloth)
    points, normals, weights = points[outer], normals[outer], weights.take(outer)
    template = load_template()
    rng = np.random.default_rng(settings.seed)
    drawn = np.sort(rng.choice(len(points), min(settings.surface_count, len(points)), replace=False))
    surface = apply_point_weights(points, normals, weights).take(drawn)
    surface = replace(surface, normals=smooth_normals(points, normals, drawn))
    surface = replace(surface, limb=_find_limbs(template, surface, fit.state))
    subset = spread_subset(template, settings.fine_count, rng)
    state = _run_stages(Fitter(template, subset, surface), fit.state, settings.stages, settings, hooks)
    for _ in range(settings.contact_refits):
        touching = strengthen_contact(template, surface, state)
        if touching is None:
            break
        surface = touching
        state = _run_stages(Fitter(template, subset, surface), state, settings.stages[1:], settings, hooks)
    model, _ = pose_model(template, state)
    rms = _skin_rms(model, template.faces, surface)
    coverage = 1.0 - measure_presence(template, surface, state).unseen
    return replace(fit, body=body_of_state(template, state, rms), state=state, skin_rms=rms, coverage=coverage)


def _find_limbs(template: Template, surface: OrientedPoints, state: FitState) -> np.ndarray:
    """Label the points within `MAX_SLEEVE_DISTANCE` of a fit's forearm: numbers of `find_forearms`, shape [n]."""
    model, normals = pose_model(template, state)
    _, nearest = cKDTree(np.hstack([model, 0.05 * normals])).query(np.hstack([surface.points, 0.05 * surface.normals]))
    close = ((surface.points - model[nearest]) ** 2).sum(axis=1) < MAX_SLEEVE_DISTANCE**2
    return np.where(close, find_forearms(template.weights)[nearest], 0)


def _run_stages(
    fitter: Fitter, state: FitState, stages: tuple[FitStage, ...], settings: PersonSettings, hooks: Hooks
) -> FitState:
    """Improve a state by stages; shape coefficients that are free stay free."""
    for i, stage in enumerate(stages):
        hooks.progress(STAGE, 1.0 - 0.1 * (len(stages) - i), "fitting the body below the clothes")
        free = max(stage.shape_count, len(state.shape))
        state = fitter.fit(state, replace(stage, cloth_pull=settings.pull, cloth_gap=settings.gap, shape_count=free))
    return state


def strengthen_contact(template: Template, surface: OrientedPoints, state: FitState) -> OrientedPoints | None:
    """Weight the cloth over shoulders or hips more where the body does not reach it; return None where it does. Clothes
    rest on shoulders and upper back, or on waist and hips: in each the lowest tenth of the cloth touches the body."""
    if surface.cloth is None:
        return None
    model, normals = pose_model(template, state)
    tree = cKDTree(np.hstack([model, 0.05 * normals]))
    _, nearest = tree.query(np.hstack([surface.points, 0.05 * surface.normals]))
    offset = np.einsum("na,na->n", surface.points - model[nearest], normals[nearest])
    cloth = np.asarray(surface.cloth, dtype=np.float64).copy()
    for names in SUPPORT_JOINTS:
        part = template.weights[:, [JOINTS.index(name) for name in names]].sum(axis=1) > 0.5
        in_contact = part[nearest] & (cloth > 0)
        if in_contact.sum() >= 50 and np.quantile(offset[in_contact], 0.1) > MAX_CONTACT_OFFSET:
            cloth[in_contact] *= 0.8
    return None if np.array_equal(cloth, surface.cloth) else replace(surface, cloth=cloth)


def find_outer_points(body: Body, points: np.ndarray, normals: np.ndarray, cloth: np.ndarray) -> np.ndarray:
    """Find the points that do not face the body, bool, shape [n]: all but the inner side of cloth.

    A scanner sees into hems and sleeves. Inward points are paired with the far side of the body, which then seems to be
    outside the cloth: 8 % of them under a wide shirt made the fit of the torso diverge.

    Args:
        body: The last fit.
        points: Positions [m], shape [n, 3].
        normals: Outward unit normals, shape [n, 3].
        cloth: Probability of cloth of each point, shape [n].
    """
    _, nearest = cKDTree(body.vertices).query(points)
    facing = np.einsum("na,na->n", vertex_normals(body.vertices, body.faces)[nearest], normals)
    return np.asarray((facing > INWARD_CLOTH_COSINE) | (np.asarray(cloth) < 0.5))


def apply_point_weights(points: np.ndarray, normals: np.ndarray, weights: PointWeights) -> OrientedPoints:
    """Combine points with what is known of them; points with a predicted depth are moved inward by it."""
    cloth = np.asarray(weights.cloth, dtype=np.float64)
    weight = np.ones(len(points))
    spread = None
    if weights.ignore is not None:
        weight = 1.0 - (1.0 - IGNORED_POINT_WEIGHT) * weights.ignore
        cloth = np.maximum(cloth, weights.ignore)
    if weights.inside is not None:
        known = np.isfinite(weights.inside)
        points = points - np.where(known, weights.inside, 0.0)[:, None] * normals
        cloth = np.where(known, 0.0, cloth)
        spread = np.where(known, 0.01 if weights.spread is None else weights.spread, 0.0)
    return OrientedPoints(points, normals, cloth, weight, spread)


def guess_weights(template: Template, surface: OrientedPoints, state: FitState) -> PointWeights:
    """Estimate weights from a fit: all is cloth but face, hands and feet; crown and feet have low weight. Hair hides
    the crown and the back of the head, shoes hide the feet."""
    model, normals = pose_model(template, state)
    _, nearest = cKDTree(np.hstack([model, 0.05 * normals])).query(np.hstack([surface.points, 0.05 * surface.normals]))
    bare = template.weights[:, [JOINTS.index(name) for name in BARE_PARTS]].sum(axis=1)
    shoe_weight = template.weights[:, [JOINTS.index(name) for name in SHOD_PARTS]].sum(axis=1)
    hair = find_hair_vertices(template)
    cloth = np.where(hair, 1.0, 1.0 - np.clip(bare + shoe_weight, 0.0, 1.0))[nearest]
    is_far = ((surface.points - model[nearest]) ** 2).sum(axis=1) > MAX_BARE_SKIN_DISTANCE**2
    return PointWeights(np.where(is_far, 1.0, cloth), np.maximum(0.7 * hair, 0.7 * (shoe_weight > 0.5))[nearest])


def orient_by_body(template: Template, surface: OrientedPoints, state: FitState) -> OrientedPoints:
    """Orient normals of unknown sign like those of the fitted body's nearest vertices."""
    if surface.oriented:
        return surface
    model, normals = pose_model(template, state)
    _, nearest = cKDTree(model).query(surface.points)
    sign = np.where(np.einsum("na,na->n", normals[nearest], surface.normals) < 0, -1.0, 1.0)
    return replace(surface, normals=sign[:, None] * surface.normals, oriented=True)


def _skin_rms(model: np.ndarray, faces: np.ndarray, surface: OrientedPoints) -> float:
    """Compute the RMS distance [m] to the model of the points that are more likely skin than cloth."""
    from ..geometry.surface import TriangleSurface

    skin = np.ones(len(surface.points), bool) if surface.cloth is None else surface.cloth < 0.5
    if not skin.any():
        return 0.0
    distance = np.sort(TriangleSurface(model, faces).distance(surface.points[skin]))
    return float(np.sqrt((distance[: max(int(0.9 * len(distance)), 1)] ** 2).mean()))
