"""Rings on unrolled limbs, and what the rules make of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS, Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.people.evidence import WAIST_BEND_COST, WARMTH, find_rings, find_spans
from garmentq.core.people.features import describe_points
from garmentq.core.people.limbs import Limb
from garmentq.core.people.part import PARTS, Part
from garmentq.core.people.points import PersonPoints, sample_person
from garmentq.core.people.prior import below_hair
from garmentq.core.people.rings import (
    BEND_COST,
    MIN_RING_DISTANCE,
    STEP_ROW_COUNT,
    colour_contrasts,
    edge_evidence,
    find_ring,
    ridge_strengths,
    score_ring,
    step_heights,
)
from garmentq.core.people.rules import predict_by_rules
from garmentq.core.people.tone import skin_evidence
from garmentq.core.people.unrolled import LIMB_COLUMN_COUNT, NECK_RADIUS, STATION_STEP, unroll
from garmentq.core.scan.raw import RawScan
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

NECKLINE_AT = 0.05
"""Station of a neckline [m]."""


@dataclass(frozen=True)
class Fit:
    """Stand for a fit: the body is known."""

    body: Body


def sleeve(end: np.ndarray, rows: int = 60, height: float = 0.004, noise: float = 0.001) -> np.ndarray:
    """Return offsets on a limb's grid [m]: a sleeve that widens, up to a row for each column, then bare skin."""
    row = np.arange(rows)[:, None]
    rng = np.random.default_rng(0)
    cloth = height + 0.0002 * (row - end)
    return np.where(row < end, cloth, 0.0) + noise * rng.normal(size=(rows, LIMB_COLUMN_COUNT))


def test_the_step_of_a_known_height_is_read_where_it_is():
    """Broken where a step is read a row off, or a slope counts as a step."""
    offset = sleeve(np.full(LIMB_COLUMN_COUNT, 30), noise=0.0)
    steps = step_heights(offset)
    assert (steps.argmax(axis=0) == 30).all()
    # The line through the sleeve meets its end half a row beyond its last row's middle.
    assert steps[30] == pytest.approx(0.0039, abs=1e-5)
    slope = step_heights(np.repeat(0.01 * np.arange(60.0)[:, None], LIMB_COLUMN_COUNT, axis=1))
    assert np.abs(slope[STEP_ROW_COUNT:-STEP_ROW_COUNT]).max() < 1e-9


@pytest.mark.parametrize("tilt", [0, 4])
def test_a_sleeves_end_is_found_within_one_station(tilt):
    """Broken where a ring, level or tilted, is found elsewhere than where the cloth ends."""
    end = np.round(30 + tilt * np.sin(2 * np.pi * np.arange(LIMB_COLUMN_COUNT) / LIMB_COLUMN_COUNT))
    step = step_heights(sleeve(end))
    edge = edge_evidence(step, np.zeros_like(step))
    ring = find_ring(edge)
    assert np.abs(ring.rows - end).max() <= 1
    assert score_ring(edge, ring.rows) == pytest.approx(ring.score)
    assert score_ring(edge, ring.rows + 5) < ring.score
    assert ring.confidence > 0.75
    beyond = ring.probability_beyond(60)
    assert beyond[:20].max() < 0.05
    assert beyond[40:].min() > 0.95
    assert np.abs(np.diff(np.append(ring.rows, ring.rows[0]))).max() <= 3


def test_nothing_there_is_not_sure():
    """Broken where noise alone is taken for a ring as surely as a hem."""
    step = step_heights(sleeve(np.full(LIMB_COLUMN_COUNT, 30), height=0.0))
    quiet = find_ring(edge_evidence(step, np.zeros_like(step)))
    hem = step_heights(sleeve(np.full(LIMB_COLUMN_COUNT, 30)))
    clear = find_ring(edge_evidence(hem, np.zeros_like(hem)))
    assert clear.score - clear.second > 3 * (quiet.score - quiet.second)
    assert clear.score > quiet.score + 10


def test_two_rings_the_second_is_the_other_one():
    """Broken where the second best ring is the best one's neighbour, or none at all."""
    first, second = sleeve(np.full(LIMB_COLUMN_COUNT, 20)), sleeve(np.full(LIMB_COLUMN_COUNT, 45), height=0.003)
    step = step_heights(first + second)
    edge = edge_evidence(step, np.zeros_like(step))
    ring = find_ring(edge)
    other = edge.copy()
    other[: 45 - int(MIN_RING_DISTANCE / STATION_STEP)] = -50.0
    assert np.median(ring.rows) == 20
    assert ring.second == pytest.approx(find_ring(other).score, abs=1.0)


def test_the_best_ring_is_the_best_of_all():
    """Broken where dynamic programming misses a closed ring that trying all would find."""
    rng = np.random.default_rng(3)
    edge = np.full((4, LIMB_COLUMN_COUNT), -50.0)
    edge[:, :4] = rng.normal(size=(4, 4))
    edge[1, 4:] = 0.0
    ring = find_ring(edge)
    every = np.stack(np.meshgrid(*[np.arange(4)] * 4, indexing="ij"), axis=-1).reshape(-1, 4)
    paths = np.concatenate([every, np.ones((len(every), LIMB_COLUMN_COUNT - 4), dtype=int)], axis=1)
    turns = np.abs(np.diff(paths, axis=1, append=paths[:, :1])).sum(axis=1)
    scores = (edge[paths, np.arange(LIMB_COLUMN_COUNT)].sum(axis=1) - BEND_COST * turns) / 4.0
    assert ring.score == pytest.approx(scores.max())


def test_a_waist_is_level_where_folds_drown_it():
    """Broken where the folds of a half that shows no hem draw the ring aslant by more than 2 cm."""
    row, columns = np.arange(80)[:, None], np.arange(LIMB_COLUMN_COUNT)
    seen = columns < LIMB_COLUMN_COUNT // 2
    errors = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        folds = gaussian_filter(rng.normal(size=(80, LIMB_COLUMN_COUNT)), 2.5, mode=("nearest", "wrap"))
        offset = np.where((row < 40) & seen, 0.008, 0.0) + 0.002 * folds / folds.std()
        edge = edge_evidence(step_heights(offset), ridge_strengths(rng.normal(size=(80, LIMB_COLUMN_COUNT))))
        rings = (find_ring(edge, None, WARMTH, cost) for cost in (WAIST_BEND_COST, BEND_COST))
        errors.append([np.abs(ring.rows[~seen] - 40).mean() for ring in rings])
    waist, loose = np.median(errors, axis=0) * STATION_STEP
    assert waist < 0.02 < loose


@pytest.fixture(scope="module")
def dressed() -> tuple[Fit, RawScan, np.ndarray]:
    """Return a person in a top with short sleeves over trousers to the shins, shod, and the true parts."""
    body = builtin_body("builtin:female,pose=A")
    x, y = np.abs(body.rest_vertices[:, 0]), body.rest_vertices[:, 1]
    joint = dict(zip(("hip", "knee", "neck", "shoulder", "ankle"), body.rest_joints[[1, 4, 12, 16, 7]], strict=True))
    arm = body.weights[:, 16:24].sum(axis=1) > 0.5
    leg = ~arm & (y < joint["hip"][1])
    shin = 0.5 * (joint["knee"][1] + joint["ankle"][1])
    top = ~leg & (y < joint["neck"][1] - 0.03) & (x < joint["shoulder"][0] + 0.15)
    bottom = leg & (y > shin)
    shoe = leg & (y < joint["ankle"][1] + 0.01)
    part = np.select([top, bottom, shoe], [Part.UPPER, Part.LOWER, Part.SHOES], Part.SKIN)
    height = np.select([top, bottom, shoe], [0.016, 0.010, 0.012], 0.0)
    count = np.arange(len(y))
    raw = RawScan(body.raised(height).vertices, body.faces, None, False, None, None, count, count)
    return Fit(body), raw, part


def test_the_rules_take_a_plain_person_apart(dressed):
    """Broken where offsets and rings no longer give garments, shoes and hair of a scan with clear edges."""
    fit, raw, part = dressed
    rest, neck = fit.body.rest_vertices, fit.body.rest_joints[JOINTS.index("neck")]
    hair = (part == Part.SKIN) & (rest[:, 1] > neck[1] + 0.04) & (rest[:, 2] < neck[2] + 0.05)
    part = np.where(hair, Part.HAIR, part)
    haired = raw.points + fit.body.raised(np.where(hair, 0.02, 0.0)).vertices - fit.body.vertices
    points = sample_person(replace(raw, points=haired), fit)
    posterior = predict_by_rules(points, describe_points(points, fit), fit)
    assert posterior.shape == (len(points.positions), len(PARTS))
    assert np.abs(posterior.sum(axis=1) - 1).max() < 1e-9
    found = np.array(PARTS)[points.carry(posterior).argmax(axis=1)]
    limits = {Part.UPPER: 0.98, Part.LOWER: 0.98, Part.SHOES: 0.99, Part.HAIR: 0.7, Part.SKIN: 0.93}
    for each, least in limits.items():
        assert ((found == each) & (part == each)).sum() > least * ((found == each) | (part == each)).sum()


def test_rings_lie_where_the_garments_end(dressed):
    """Broken where sleeves, legs or the waist end elsewhere than the cloth does."""
    fit, raw, _ = dressed
    points = sample_person(raw, fit)
    rings = find_rings(points, describe_points(points, fit), fit)
    for limb, ring in zip((Limb.LEFT_ARM, Limb.RIGHT_ARM), rings.sleeves, strict=True):
        assert np.median(rings.grids[limb].stations[ring.rows]) == pytest.approx(0.15, abs=0.02)
    body = fit.body
    shin = body.rest_joints[1, 1] - 0.5 * (body.rest_joints[4, 1] + body.rest_joints[7, 1])
    for limb, ring in zip((Limb.LEFT_LEG, Limb.RIGHT_LEG), rings.hems, strict=True):
        assert np.median(rings.grids[limb].stations[ring.rows]) == pytest.approx(shin, abs=0.02)
    best = rings.waists[0]
    assert best.score > 0
    assert best.is_upper_over
    assert rings.tube < 0.5


def test_shorts_over_boots_end_where_the_skin_begins(dressed):
    """Broken where high boots, no skin either and as far off as cloth, draw the legs of shorts down to them."""
    fit, raw, _ = dressed
    body, weights = fit.body, fit.body.weights[:, 16:24].sum(axis=1)
    station, end = body.rest_joints[1, 1] - body.rest_vertices[:, 1], 0.30
    is_low, boot = (weights < 0.5) & (station > 0.0), body.rest_joints[1, 1] - body.rest_joints[4, 1] + 0.09
    shorts, boots = is_low & (station < end), is_low & (station > boot)
    colours = np.select([shorts[:, None], boots[:, None]], [[0.3, 0.3, 0.3], [0.1, 0.1, 0.12]], [0.8, 0.6, 0.5])
    worn = body.raised(np.select([shorts, boots], [0.010, 0.012], 0.0)).vertices
    points = sample_person(replace(raw, points=worn, colours=colours), fit)
    features = describe_points(points, fit)
    rings = find_rings(points, features, fit, skin_evidence(points.lab, features.place, body))
    for limb, ring in zip((Limb.LEFT_LEG, Limb.RIGHT_LEG), rings.hems, strict=True):
        assert np.median(rings.grids[limb].stations[ring.rows]) == pytest.approx(end, abs=0.02)


@pytest.mark.parametrize("is_tube", [True, False])
def test_a_long_top_is_a_tube_between_the_legs(dressed, is_tube, monkeypatch):
    """Broken where what ends on two legs passes for a top over trousers, or the hem of a tunic is not found."""
    fit, raw, part = dressed
    rest, hip = fit.body.rest_vertices, fit.body.rest_joints[1, 1]
    cloth = np.isin(part, (Part.UPPER, Part.LOWER))
    top = cloth & (rest[:, 1] > hip - 0.28)
    colours = np.select([top[:, None], cloth[:, None]], [[0.16, 0.24, 0.78], [0.75, 0.7, 0.3]], [0.8, 0.6, 0.5])
    even = fit.body.raised(np.where(cloth, 0.012, 0.0)).vertices
    points = sample_person(replace(raw, points=even, colours=colours), fit)
    features = describe_points(points, fit)
    assert not find_spans(points, features).any()  # trousers
    monkeypatch.setattr("garmentq.core.people.evidence.find_spans", lambda *_: np.full(20, is_tube))
    rings = find_rings(points, features, fit)
    long = [waist for waist in rings.waists if len(waist.limbs) == 2]
    assert len(long) == is_tube
    for waist in long:
        for limb, ring in zip(waist.limbs, waist.rings, strict=True):
            assert np.median(rings.grids[limb].stations[ring.rows]) == pytest.approx(0.28, abs=0.08)  # means of 10 cm


def test_a_waist_counts_by_what_is_seen_of_it(dressed, monkeypatch):
    """Broken where a waist of which half is seen has to show as much there as one that is seen all around."""
    fit, raw, _ = dressed
    points = sample_person(raw, fit)
    features = describe_points(points, fit)
    scores = []
    for hidden in (np.zeros(len(points.positions), dtype=bool), features.place.rest[:, 0] > 0.0):
        seen = lambda *given, gone=hidden: unroll(*given).without(gone)  # noqa: E731
        monkeypatch.setattr("garmentq.core.people.evidence.unroll", seen)
        best = find_rings(points, features, fit).waists_by_shape[0]
        assert best.limbs == (Limb.TRUNK,) and best.is_upper_over
        scores.append(best.score)
    assert scores[0] > 5.0
    assert 0.4 * scores[0] < scores[1] < 0.7 * scores[0]


def scanned(fit: Fit, height: np.ndarray, noise: float, raw: RawScan) -> PersonPoints:
    """Return samples of a cloud of 60 000 points on a person raised by heights [m], with noise [m] and no colours."""
    rng = np.random.default_rng(0)
    points = TriangleSurface(fit.body.raised(height).vertices, raw.faces).sample(60_000, rng)[0]
    points = points + noise * rng.normal(size=points.shape)
    count = np.arange(len(points))
    return sample_person(replace(raw, points=points, faces=raw.faces[:0], origin=count, place=count), fit)


def test_a_waist_is_shown_through_noise_by_its_broad_ridge(dressed):
    """Broken where the shape of a hem over trousers is lost in 2 mm of a scanner's noise, or a jumpsuit shows one."""
    fit, raw, part = dressed
    hem = np.select([part == Part.UPPER, part == Part.LOWER, part == Part.SHOES], [0.016, 0.010, 0.012], 0.0)
    scores = []
    for height in (hem, np.where(np.isin(part, (Part.UPPER, Part.LOWER)), 0.010, 0.0)):
        samples = scanned(fit, height, 0.002, raw)
        scores.append(find_rings(samples, describe_points(samples, fit), fit).waists_by_shape[0].score)
    assert scores[0] > 12.0 > 0.0 > scores[1]  # sharp ridges alone give 6


def test_a_tuck_of_two_cloths_is_shown_by_its_sharp_edge(dressed):
    """Broken where the low step of a top tucked into trousers is asked of the broad ridge alone, which gives -16."""
    fit, raw, part = dressed
    samples = scanned(fit, np.select([part == Part.UPPER, part == Part.LOWER], [0.006, 0.009], 0.0), 0.0, raw)
    low = part[points_near(raw, samples.positions)] == Part.LOWER
    coloured = replace(samples, colours=np.where(low[:, None], [0.2, 0.2, 0.3], [0.8, 0.7, 0.6]))
    best = find_rings(coloured, describe_points(coloured, fit), fit).waists[0]
    assert best.limbs == (Limb.TRUNK,) and not best.is_upper_over
    assert best.by_shape > 0.0


def points_near(raw: RawScan, positions: np.ndarray) -> np.ndarray:
    """Return the raw point nearest to each position."""
    return np.asarray(cKDTree(raw.points).query(positions)[1])


def test_two_colours_are_an_edge_and_stripes_are_none():
    """Broken where stripes or a print pass for the border of two garments, or two fabrics for one."""
    row = np.arange(80)[:, None, None]
    red, cream = np.array([20.0, 50.0, 30.0]), np.array([36.0, 2.0, 8.0])
    two = np.where(row < 40, red, cream) * np.ones((80, LIMB_COLUMN_COUNT, 1))
    found = colour_contrasts(two)
    assert (found.argmax(axis=0) == 40).all()
    assert found.max() == pytest.approx(np.linalg.norm(red - cream))
    stripes = np.where(row // 3 % 2 == 0, red, cream) * np.ones((80, LIMB_COLUMN_COUNT, 1))
    assert colour_contrasts(stripes)[15:-15].max() < 0.1 * found.max()
    blobs = np.random.default_rng(0).random((8, 8)).repeat(10, axis=0).repeat(LIMB_COLUMN_COUNT // 8, axis=1) > 0.5
    assert np.median(colour_contrasts(np.where(blobs[:, :, None], red, cream))) < 0.4 * found.max()


def test_the_end_of_hair_is_no_neckline():
    """Broken where the step at the lower end of a bob hides the small one of the neckline below it."""
    body = builtin_body("builtin:female,pose=A")
    rest, neck = body.rest_vertices, body.rest_joints[JOINTS.index("neck")]
    arm = body.weights[:, 16:24].sum(axis=1) > 0.5
    # The neckline's station is its distance from the neck's axis beyond 6 cm, plus its depth below the neck's joint.
    station = np.hypot(rest[:, 0], rest[:, 2] - neck[2]) - NECK_RADIUS + neck[1] - rest[:, 1]
    cloth = ~arm & (station > NECKLINE_AT) & (rest[:, 1] > 0.8)
    head = body.weights[:, [JOINTS.index("neck"), JOINTS.index("head")]].sum(axis=1) > 0.5
    hair = head & (rest[:, 1] > neck[1] + 0.01) & (rest[:, 2] < neck[2] + 0.06)
    height = np.select([hair, cloth], [0.035, 0.004], 0.0)
    count = np.arange(len(rest))
    raw = RawScan(body.raised(height).vertices, body.faces, None, False, None, None, count, count)
    fit = Fit(body)
    points = sample_person(raw, fit)
    features = describe_points(points, fit)
    covered = below_hair(points, features, body)
    near = points_near(raw, points.positions)
    assert covered[hair[near]].mean() > 0.9
    assert covered[~head[near]].mean() < 0.05
    rings = find_rings(points, features, fit)
    grid = rings.grids[Limb.NECK]
    off = np.abs(grid.stations[rings.neckline.rows] - NECKLINE_AT)
    assert np.quantile(off, 0.8) < 0.012  # over the shoulders, where arms begin, the cloth has no end
