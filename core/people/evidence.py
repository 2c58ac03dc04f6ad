"""Find the rings of a dressed person: where sleeves, legs, neckline and waist end, and how sure each is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.spatial import cKDTree

from ..body.body import JOINTS
from ..geometry.geometry import unit
from .colour import CONTRAST
from .features import FEATURE_LENGTH_SCALE, Features
from .limbs import Limb
from .points import FittedPerson, PersonPoints
from .prior import below_hair
from .rings import (
    Ring,
    colour_contrasts,
    edge_evidence,
    find_ring,
    measure_noise,
    ridge_strengths,
    score_ring,
    step_heights,
)
from .unrolled import UnrolledGrid, unroll

COUPLING = 0.5
"""Share of the other limb's evidence that counts: sleeves and legs end alike, but not on everybody."""
COUPLED_ROWS = 5
"""Rows within which the other limb's end lies [8 mm each]: poses and fits move a cuff by 2 cm."""
BARE_OFFSETS = {Limb.NECK: (0.003, 0.005), Limb.LEFT_LEG: (0.008, 0.006), Limb.RIGHT_LEG: (0.008, 0.006)}
"""Offset [m] that skin and cloth have alike often, and the offset beyond it that says one unit more; of other limbs
`ARM_OFFSETS`. Of simulated persons' bare legs nine tenths lie within 4 mm of a fit below what is cloth, and half within
7 mm of one that took them for cloth; of the cloth on legs half lies further off than 9 mm."""
ARM_OFFSETS = (0.003, 0.005)
"""The same of arms."""
OFFSET_SAYS = (-0.6, 2.0)
"""Units at most that it says either way: cloth touches the body often, skin is seldom far from the fit."""
ARMS, LEGS = (Limb.LEFT_ARM, Limb.RIGHT_ARM), (Limb.LEFT_LEG, Limb.RIGHT_LEG)
"""The limbs that come in pairs."""
FOLD_SHARE = 0.8
"""Share of a slice of an arm's offsets below its folds: a sleeve lies on the arm above and hangs below."""
FOLD = 0.006
"""Offset of that share [m] from which on a slice has folds: bare arms are rounder than that."""
CREASE = (-0.04, 0.08)
"""Stations of an arm [m] between which edges begin to count: creases around the shoulder look like armholes."""
LEAST_CREASE = 0.2
"""Share of an edge's evidence that is left at the shoulder."""
REGION_WEIGHT = 0.012
"""Log-probability of one cell's unit of offset: a limb's slice of 1 cm of clear cloth says as much as one column's
clear edge, as the fit is off over lengths of 10 cm."""
TONE_WEIGHT = 0.02
"""Log-probability of one cell's unit of evidence for skin by its colour: a row around a limb in another colour than the
skin's says 2.9, as much as one that is told to be cloth with odds of 500."""
BOOTED = 0.3
"""Probability that what lies beyond a garment's end, below the knee, is a boot or a sock and not skin."""
SURE = 0.04
"""Log-probability of a cell where anatomy knows: the trunk is clothed; head, hands and feet are not."""
WARMTH = 3.0
"""What rings' scores are divided by: their cues are not independent."""


@dataclass(frozen=True)
class Waist:
    """The ring between an upper and a lower garment.

    Attributes:
        limbs: The limbs it lies on: the trunk, or both legs where a long top ends there.
        rings: One for each.
        is_upper_over: Whether the upper garment hangs over the lower one; else it is tucked in.
        score: Log-probability against one garment over all.
        by_shape: What of it is the shape's, at this very place: of the trunk by sharp or broad edges, the larger.
    """

    limbs: tuple[Limb, ...]
    rings: tuple[Ring, ...]
    is_upper_over: bool
    score: float
    by_shape: float


@dataclass(frozen=True)
class PersonRings:
    """What the rings of a person say.

    Attributes:
        grids: Each limb rolled out.
        sleeves: The ends of the sleeves, left and right: the armhole where there are none.
        hems: The lower ends on the legs, left and right.
        ankles: The upper ends of the shoes, left and right, if there are shoes.
        neckline: The neck's opening.
        waists: Rings between upper and lower, the best first.
        waists_by_shape: The same without colours, on the trunk by broad edges: of one cloth above and below, they alone
            show where it ends.
        tube: Share of the height below the crotch where cloth spans from leg to leg: near 1 for skirts.
        is_coloured: Whether colours counted for the waists.
        roughness: Noise of the ridges around the trunk, differences of curvature times 2 cm: what is lower is lost.
    """

    grids: dict[Limb, UnrolledGrid]
    sleeves: tuple[Ring, Ring]
    hems: tuple[Ring, Ring]
    ankles: tuple[Ring, Ring]
    neckline: Ring
    waists: tuple[Waist, ...]
    waists_by_shape: tuple[Waist, ...]
    tube: float
    is_coloured: bool
    roughness: float


@dataclass(frozen=True)
class _Cells:
    """What is measured on a limb's cells: step [m], ridge within 12 mm and within 4 cm, contrast, offset [m], evidence
    for skin by its colour.
    """

    step: np.ndarray
    ridge: np.ndarray
    broad_ridge: np.ndarray
    contrast: np.ndarray | None
    offset: np.ndarray
    is_near: np.ndarray
    tone: np.ndarray | None

    def edge(self, sign: float, use_colours: bool = False) -> np.ndarray:
        """Return the evidence for a garment's end whose side before (+1) or beyond (-1) is the higher."""
        contrast = self.contrast if use_colours else None
        return np.where(self.is_near, edge_evidence(sign * self.step, sign * self.ridge, contrast), 0.0)

    def broad_edge(self, sign: float) -> np.ndarray:
        """Return the same by shape, of ridges within 4 cm: placed less well, and not lost in noise and folds."""
        return np.where(self.is_near, edge_evidence(sign * self.step, sign * self.broad_ridge), 0.0)

    def seen_share(self, ring: Ring) -> float:
        """Return the share of a ring's cells of which something is known: below a skirt, not those between the legs."""
        return float(self.is_near[ring.rows, np.arange(len(ring.rows))].mean())

    def region(self, limb: Limb, worn: np.ndarray | float = 0.0) -> np.ndarray:
        """Return the log-probability of cloth against skin, or what else is worn, by the offset and the skin's colour.

        Args:
            limb: Whose cells these are.
            worn: Probability w that what is beyond the garment's end is no skin either, shape [rows, 1]: it is then as
                far off and as coloured as cloth, so that of a cue's log-odds x of cloth -log((1 - w) exp(-x) + w) are
                left.
        """
        bare, scale = BARE_OFFSETS.get(limb, ARM_OFFSETS)
        units = np.clip((self.offset - bare) / scale, *OFFSET_SAYS)
        if limb in ARMS:
            folds = np.quantile(np.where(self.is_near, self.offset, 0.0), FOLD_SHARE, axis=1, keepdims=True)
            units = 0.5 * (units + np.clip((folds - FOLD) / scale, -1.0, 2.0))
        told = REGION_WEIGHT * _unless_worn(units, worn)
        if self.tone is not None:
            told += TONE_WEIGHT * _unless_worn(-self.tone, worn)
        return np.where(self.is_near, told, 0.0)


def _unless_worn(odds: np.ndarray, worn: np.ndarray | float) -> np.ndarray:
    """Return log-odds of cloth against what is skin but for a share `worn` that looks like cloth."""
    return np.asarray(-np.log((1.0 - worn) * np.exp(-odds) + worn))


def find_rings(
    points: PersonPoints,
    features: Features,
    fit: FittedPerson,
    tone: np.ndarray | None = None,
) -> PersonRings:
    """Find all rings; where there are colours, the skin's own says where it is seen, and means of cloth where two meet.

    Args:
        points: The samples.
        features: Their description.
        fit: The body fitted to them.
        tone: Evidence for skin by its colour, shape [n], or None.
    """
    body = fit.body
    grids = {limb: unroll(features.place, body, limb) for limb in Limb}
    colours = None if points.lab is None else points.lab * CONTRAST
    # Where hair ends over the neck the surface steps down by 1 to 4 cm: beside it no neckline shows.
    open_grids = grids | {Limb.NECK: grids[Limb.NECK].without(below_hair(points, features, body, tone))}
    cells = {limb: _measure(grid, features, colours, tone) for limb, grid in open_grids.items()}
    joints = dict(zip(JOINTS, body.rest_joints, strict=True))
    wrist = float(np.abs(joints["left_wrist"] - joints["left_shoulder"])[0])
    knee, ankle = (float((joints["left_hip"] - joints[name])[1]) for name in ("left_knee", "left_ankle"))
    sleeves = _find_pair(grids, cells, ARMS, (0.0, wrist, np.inf))
    hems = _find_pair(grids, cells, LEGS, (0.05, ankle - 0.02, knee))
    ankles = _find_ankles(grids, cells, LEGS, ankle)
    hem = float(np.mean([grids[limb].stations[ring.rows].mean() for limb, ring in zip(LEGS, hems, strict=True)]))
    lowest = max(min(hem - SHOWN_BELOW[0], knee), hem - SHOWN_BELOW[1])
    spans = find_spans(points, features, lowest)
    waists = tuple(_find_waists(grids, cells, (lowest, spans), use_colours) for use_colours in (True, False))
    return PersonRings(
        grids=grids,
        sleeves=sleeves,
        hems=hems,
        ankles=ankles,
        neckline=_find_neckline(grids[Limb.NECK], cells[Limb.NECK]),
        waists=waists[0],
        waists_by_shape=waists[1],
        tube=measure_tube(spans),
        is_coloured=colours is not None,
        roughness=measure_noise(cells[Limb.TRUNK].ridge, 0.0),
    )


def _measure(grid: UnrolledGrid, features: Features, colours: np.ndarray | None, tone: np.ndarray | None) -> _Cells:
    offset = grid.spread(features.column("offset") * FEATURE_LENGTH_SCALE)
    contrast = None
    if colours is not None:
        contrast = colour_contrasts(np.stack([grid.spread(channel) for channel in colours.T], axis=2))
    ridge = ridge_strengths(grid.spread(features.column("curvature_12")))
    broad_ridge = ridge_strengths(grid.spread(features.column("curvature_40")), BROAD_ROWS)
    spread = None if tone is None else grid.spread(tone)
    return _Cells(step_heights(offset), ridge, broad_ridge, contrast, offset, grid.is_near, spread)


def _find_pair(
    grids: dict[Limb, UnrolledGrid],
    cells: dict[Limb, _Cells],
    pair: tuple[Limb, Limb],
    known: tuple[float, float, float],
) -> tuple[Ring, Ring]:
    """Find the ends of cloth on a pair of limbs.

    `known` are the stations [m] up to which it surely is, from which on it surely is not, and from which on what is not
    skin may be a boot or a sock.
    """
    edges = _couple(*((grids[limb], cells[limb].edge(1.0)) for limb in pair))
    rings = []
    for limb, edge in zip(pair, edges, strict=True):
        stations = grids[limb].stations
        region = cells[limb].region(limb, np.where(stations > known[2], BOOTED, 0.0)[:, None])
        region[stations < known[0]] = SURE
        region[stations > known[1]] = -SURE
        edge[stations > known[1]] = 0.0
        if limb in ARMS:
            edge *= np.clip((stations - CREASE[0]) / (CREASE[1] - CREASE[0]), LEAST_CREASE, 1.0)[:, None]
        rings.append(find_ring(edge, region, WARMTH))
    return rings[0], rings[1]


def _couple(
    left: tuple[UnrolledGrid, np.ndarray], right: tuple[UnrolledGrid, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Add to each limb's evidence a share of the other's best nearby."""
    coupled = []
    for (grid, edge), (other, far) in ((left, right), (right, left)):
        shift = round((grid.first - other.first) / (grid.stations[1] - grid.stations[0])) if len(edge) > 1 else 0
        row = np.arange(len(edge)) + shift
        near = maximum_filter1d(far, COUPLED_ROWS, axis=0, mode="nearest")
        there = np.where(((row >= 0) & (row < len(far)))[:, None], near[np.clip(row, 0, len(far) - 1)], 0.0)
        coupled.append(edge + COUPLING * there)
    return coupled[0], coupled[1]


SHOE_TOP = (-0.035, 0.12)
"""Range of a shoe's upper end over the ankle joint [m]: loafers to high sneakers. Lower, soles make larger steps."""
SHOE_USUAL = (0.0, 0.03)
"""Mean and spread of a shoe's upper end over the ankle joint [m]."""


def _find_ankles(
    grids: dict[Limb, UnrolledGrid], cells: dict[Limb, _Cells], legs: tuple[Limb, Limb], ankle: float
) -> tuple[Ring, Ring]:
    """Find where shoes end if there are any: the higher side is the one beyond."""
    edges = list(_couple(*((grids[limb], cells[limb].edge(-1.0)) for limb in legs)))
    for limb, edge in zip(legs, edges, strict=True):
        stations = grids[limb].stations
        edge -= 0.5 * (((ankle - stations - SHOE_USUAL[0]) / SHOE_USUAL[1]) ** 2)[:, None]
        edge[(stations < ankle - SHOE_TOP[1]) | (stations > ankle - SHOE_TOP[0])] = -50.0
    return find_ring(edges[0], None, WARMTH), find_ring(edges[1], None, WARMTH)


NECKLINE = (0.06, 0.05)
"""Mean and spread of the station [m] where necklines of the usual garments lie on the neck's chart."""


def _find_neckline(grid: UnrolledGrid, cells: _Cells) -> Ring:
    """Find the neck's opening: skin before it, cloth beyond."""
    stations = grid.stations
    region = -cells.region(Limb.NECK)
    region[stations < -0.06] = SURE
    region[stations > NECKLINE[0] + 4 * NECKLINE[1]] = -SURE
    prior = -0.5 * ((stations - NECKLINE[0]) / NECKLINE[1]) ** 2
    return find_ring(cells.edge(-1.0) + prior[:, None], region, WARMTH)


WAIST_FROM = 0.22
"""Station on the trunk [m below the neck joint] where waists begin: below the bust's middle."""
WAIST_BEND_COST = 1.6
"""What a waist's ring, or the hem of a top over it, costs by each row up or down: a hem hangs level, and where half
of it is not seen at all, twice `BEND_COST` keeps folds from drawing it aslant."""
BROAD_ROWS = 3
"""Rows that the ridge of a waist by shape is compared over on either side, 2.4 cm, of curvature within 4 cm."""
WAIST_PRIOR = -22.0
"""Log-probability of a ring against none that the best one of noise and folds gains by itself, seen all around."""
SHOWN_BELOW = (0.08, 0.2)
"""Least length of a leg's garment that shows below a long top [m], for tops that end above the knee and below it: what
is shorter there is the shaft of a boot, and the ring the end of all that is worn above."""
SPANNED = 0.5
"""Least share of the height between crotch and a long top's end in which cloth spans from leg to leg: a top is a tube
there; what ends on two legs is trousers, or a jumpsuit."""


def _find_waists(
    grids: dict[Limb, UnrolledGrid], cells: dict[Limb, _Cells], legs: tuple[float, np.ndarray], use_colours: bool
) -> tuple[Waist, ...]:
    """Find rings between upper and lower: on the trunk with either side higher, on the legs with the upper over.

    By shape, those of the trunk are looked for by their broad edges; with colours by sharp ones, which place them.
    `legs` are the station beyond which no long top ends [m], and where cloth spans between them (`find_spans`).
    """
    lowest, spans = legs
    found = []
    trunk = grids[Limb.TRUNK]
    crotch = trunk.stations[-1] - np.ptp(grids[LEGS[0]].stations) + 0.10
    outside = (trunk.stations < WAIST_FROM) | (trunk.stations > crotch)
    for sign in (1.0, -1.0):
        broad = cells[Limb.TRUNK].broad_edge(sign)
        edge = cells[Limb.TRUNK].edge(sign, True) if use_colours else broad.copy()
        edge[outside] = -50.0
        ring = find_ring(edge, None, WARMTH, WAIST_BEND_COST)
        shape = max(score_ring(e, ring.rows, WAIST_BEND_COST) for e in (broad, cells[Limb.TRUNK].edge(sign)))
        prior = WAIST_PRIOR * cells[Limb.TRUNK].seen_share(ring)
        found.append(Waist((Limb.TRUNK,), (ring,), sign > 0, ring.score + prior, shape + prior))
    edges, shown = (
        _couple(*((grids[limb], cells[limb].edge(1.0, colours)) for limb in LEGS)) for colours in (use_colours, False)
    )
    rings, shapes = [], []
    for limb, edge, plain in zip(LEGS, edges, shown, strict=True):
        stations = grids[limb].stations
        edge[(stations < 0.05) | (stations > lowest)] = -50.0
        rings.append(find_ring(edge, None, WARMTH, WAIST_BEND_COST))
        shapes.append(score_ring(plain, rings[-1].rows, WAIST_BEND_COST))
    end = float(np.mean([grids[limb].stations[ring.rows].mean() for limb, ring in zip(LEGS, rings, strict=True)]))
    above = spans[: max(int((end - TUBE_FROM) / TUBE_STEP), 0)]
    if not len(above) or above.mean() >= SPANNED:
        prior = 0.5 * WAIST_PRIOR * sum(cells[limb].seen_share(ring) for limb, ring in zip(LEGS, rings, strict=True))
        score, by_shape = (
            0.5 * (left + right) / (1 + COUPLING) + prior for left, right in ((ring.score for ring in rings), shapes)
        )
        found.append(Waist(LEGS, (rings[0], rings[1]), True, score, by_shape))
    return tuple(sorted(found, key=lambda waist: -waist.score))


TUBE_FROM, TUBE_TO = 0.14, 0.34
"""Stations of the legs [m] between which a skirt spans from leg to leg: from 5 cm below the crotch."""
TUBE_STEP = 0.02
"""Step of stations at which cloth is looked for between the legs [m]."""


NORMALS_AROUND = 16
"""Samples whose normals are averaged: a disk of 1.5 cm radius."""


def find_spans(points: PersonPoints, features: Features, end: float = TUBE_TO) -> np.ndarray:
    """Find where cloth goes from leg to leg, in front and behind: every `TUBE_STEP` from `TUBE_FROM` on, bool.

    A sample spans where it is nearer to the middle between the legs than to either, and faces forward or backward.

    Args:
        points: The samples.
        features: Their description.
        end: Station of the legs to which it is asked at least [m].
    """
    place = features.place
    leg = np.isin(place.limb, (Limb.LEFT_LEG, Limb.RIGHT_LEG))
    gap = points.positions - place.foot
    side = np.cross(place.along, place.front)
    inward = np.einsum("na,na->n", gap, side) * np.where(place.limb == Limb.LEFT_LEG, 1.0, -1.0)
    _, near = cKDTree(points.positions).query(points.positions, k=NORMALS_AROUND)
    normals = unit(points.normals[near].sum(axis=1))  # noise must not turn an inner thigh's normal to the front
    across = np.abs(np.einsum("na,na->n", normals, side))
    spans = leg & (inward > 0.015) & (across < 0.6)
    ahead = np.einsum("na,na->n", normals, place.front) > 0
    rows = np.arange(TUBE_FROM, max(TUBE_TO, end), TUBE_STEP)
    close = (np.abs(place.station - row) < 0.5 * TUBE_STEP for row in rows)
    return np.array([min((spans & ahead & near).sum(), (spans & ~ahead & near).sum()) >= 2 for near in close])


def measure_tube(spans: np.ndarray) -> float:
    """Return the share of the height below the crotch, to `TUBE_TO`, in which cloth spans from leg to leg."""
    return float(spans[: round((TUBE_TO - TUBE_FROM) / TUBE_STEP)].mean())


def spread_over(rings: PersonRings, limb: Limb, ring: Ring, count: int) -> np.ndarray:
    """Compute the probability that each sample lies beyond a ring of a limb, 0 where it is not on it, shape [count]."""
    grid = rings.grids[limb]
    return grid.at_samples(ring.probability_beyond(len(grid.counts)), count, 0.0)
