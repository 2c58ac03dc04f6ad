"""Draw what a person wears, and dress the wearer in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import igl
import numpy as np
from scipy.spatial import cKDTree

from ..core.body.body import Body
from ..core.body.distance import DistanceGrid
from ..core.body.skinning import skin, weights_at
from ..core.garment.garment import Garment
from ..core.garment.measures import BodyMeasures
from ..core.garment.sewing import mesh_pattern
from ..core.garment.templates import draft_template
from ..core.people.part import Part
from ..core.recover.drape.dress import DressSettings, dress
from ..core.recover.drape.pbd import DistanceConstraints, PbdState, build_distance_constraints, simulate_pbd
from ..core.recover.drape.sizing import measure_wearer
from ..core.recover.drape.waist import waist_loop
from ..core.run.errors import GarmentqError
from .cloth import COVER, Mesh, clear, clip, even_out, hem_height, refine, thicken, tuck_under, wave_field

NODES = 1000
"""Nodes of a garment while it is draped: edges of 3 cm, 0.7 s a garment; refined once before it is scanned."""

FALL = 45
"""Steps of gravity in the pose: 0.75 s, in which cloth that was skinned finds its folds."""

SETTLED = 0.004
"""Distance [m] from the skin that the drape leaves; what a drawn thickness is less than that is taken off again."""

UPPERS = ("long_sleeve_tshirt", "tshirt", "tank")
LOWERS = ("trousers", "shorts", "skirt", "four_panel_skirt")
DRESSES = ("dress", "sleeved_dress")
JUMPSUITS = ("jumpsuit", "sleeved_jumpsuit")
HELD_OUT = "pencil_skirt"
"""Design that is kept for measuring when a set is drawn without it."""

OVER = 0.12
"""Share of persons in an outer layer."""

Cut = Callable[[np.ndarray], np.ndarray]
"""From points around the T-pose [m], [n, 3], to a field [n] that is positive where cloth stays."""


@dataclass(frozen=True)
class Piece:
    """Describe one garment before it is draped.

    Attributes:
        template: Which of the shipped ones.
        part: What it is labelled as.
        measures: What it is drafted to.
        wide: Whether it lies over what was put on before.
        tucked: Whether it is tucked into what is put on next.
    """

    template: str
    part: Part
    measures: BodyMeasures
    wide: bool = False
    tucked: bool = False


@dataclass(frozen=True)
class Worn:
    """A garment that hangs on the wearer in the T-pose.

    Attributes:
        piece: What it is.
        garment: Its mesh.
        threads: Its constraints.
        nodes: Positions [m], shape [node_count, 3].
        heights: Height of what lies below it over each vertex of the skin [m], shape [vertex_count].
    """

    piece: Piece
    garment: Garment
    threads: DistanceConstraints
    nodes: np.ndarray
    heights: np.ndarray


@dataclass(frozen=True)
class Layer:
    """One surface of a dressed person in its pose.

    Attributes:
        part: What it is.
        mesh: The surface.
        is_cloth: Whether it is dyed: underwear counts as skin and is none.
    """

    part: Part
    mesh: Mesh = field(repr=False)
    is_cloth: bool = True


GRID = 0.013
"""Spacing of the distance grids [m]: coarser than a recovery's, in half the time; cloth is cleared by millimetres."""


@dataclass(frozen=True)
class Over:
    """Measure the distance to a body with cloth on it: that to the body less the cloth's height over the nearest skin.

    Attributes:
        grid: Distance to the body.
        tree: The skin's vertices.
        heights: Of what lies on them [m], shape [vertex_count].
    """

    grid: DistanceGrid
    tree: cKDTree
    heights: np.ndarray

    @classmethod
    def of(cls, body: Body, grid: DistanceGrid, heights: np.ndarray) -> Over:
        """Return the distance to what lies on a body."""
        return cls(grid, cKDTree(body.vertices), heights)

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return distances [m] and gradients."""
        distance, gradient = self.grid.measure(points)
        if not self.heights.any():
            return distance, gradient
        height = self.heights[self.tree.query(points)[1]]
        return distance - np.resize(height, distance.shape), gradient


def grid_of(body: Body) -> DistanceGrid:
    """Return the distance to a body."""
    return DistanceGrid.from_mesh(body.vertices, body.faces, GRID)


def draw_outfit(body: Body, rng: np.random.Generator, held_out: bool) -> list[Piece]:
    """Draw the garments of a person, the innermost first.

    Args:
        body: The wearer, whose measures they are drafted to with drawn ease.
        rng: The generator.
        held_out: Draw a jumpsuit, or a top over `HELD_OUT`.
    """
    m = measure_wearer(body)
    ease = float(rng.uniform(0.97, 1.2))
    m = replace(
        m,
        bust=m.bust * ease,
        waist=m.waist * float(rng.uniform(0.98, 1.12)),
        hip=m.hip * float(rng.uniform(0.98, 1.14)),
        hip_height=m.hip_height - float(rng.uniform(-0.06, 0.05)),
    )
    kind = rng.random()
    if kind < (0.5 if held_out else 0.1):
        pieces = [Piece(str(rng.choice(JUMPSUITS)), Part.ONE_PIECE, m)]
    elif not held_out and kind < 0.27:
        pieces = [Piece(str(rng.choice(DRESSES)), Part.ONE_PIECE, m)]
    elif not held_out and kind < 0.35:
        pieces = [_lower(m, rng, False) if rng.random() < 0.8 else _upper(m, rng)]
    else:
        upper, lower = _upper(m, rng), _lower(m, rng, held_out)
        pieces = [replace(upper, tucked=True), lower] if rng.random() < 0.35 else [lower, upper]
        pieces[1] = replace(pieces[1], wide=True)
    if rng.random() < OVER:
        length = float(rng.uniform(-0.05, 0.25))
        roomy = replace(m, bust=m.bust * 1.14 + 0.06, hip=m.hip * 1.12, hip_height=m.hip_height - length)
        pieces.append(Piece("long_sleeve_tshirt", Part.OUTER, roomy, wide=True))
    return pieces


def _upper(m: BodyMeasures, rng: np.random.Generator) -> Piece:
    long = replace(m, hip_height=m.hip_height - float(rng.choice([0.0, 0.0, rng.uniform(0.0, 0.22)])))
    return Piece(str(rng.choice(UPPERS, p=(0.6, 0.2, 0.2))), Part.UPPER, long)


def _lower(m: BodyMeasures, rng: np.random.Generator, held_out: bool) -> Piece:
    slim = replace(m, waist=min(m.waist, 0.5 * (m.waist + m.hip)), hip_height=m.hip_height)
    name = HELD_OUT if held_out else str(rng.choice(LOWERS, p=(0.5, 0.15, 0.2, 0.15)))
    return Piece(name, Part.LOWER, slim)


def put_on(pieces: list[Piece], rest: Body) -> list[Worn]:
    """Dress the T-pose, each garment over those before it; one that cannot be put on is left out."""
    heights = np.zeros(len(rest.vertices))
    grid = grid_of(rest)
    worn: list[Worn] = []
    for piece in pieces:
        over = heights if piece.wide else np.zeros_like(heights)
        try:
            garment = mesh_pattern(draft_template(piece.template, piece.measures), NODES)
            threads = build_distance_constraints(garment)
            nodes = dress(
                garment, rest, Over.of(rest, grid, over), settings=DressSettings(unfold=False), threads=threads
            )
        except (GarmentqError, RuntimeError, ValueError):
            continue
        if not np.isfinite(nodes).all():
            continue
        worn.append(Worn(piece, garment, threads, nodes, over))
        heights = np.maximum(heights, heights_above(rest, (nodes, garment.faces)))
    return worn


def heights_above(body: Body, cloth: Mesh) -> np.ndarray:
    """Return how high cloth lies over each vertex of the skin [m], 0 where there is none within reach, evened out."""
    square, _, nearest = igl.point_mesh_squared_distance(body.vertices, *cloth)
    distance = np.sqrt(square)
    normals = igl.per_vertex_normals(body.vertices, body.faces)
    upright = np.einsum("na,na->n", nearest - body.vertices, normals) > 0.7 * distance
    height = np.where(upright & (distance < 0.5 * COVER), distance, 0.0)
    return even_out(height, body.faces, 4)


def draw_cuts(piece: Piece, rest: Body, rng: np.random.Generator) -> list[Cut]:
    """Draw where a garment is cut shorter than its draft: sleeves, legs, hem, neckline, an open front."""
    cuts: list[Cut] = []
    shoulder, wrist = rest.joint("left_shoulder"), rest.joint("left_wrist")
    neck, knee, ankle, pelvis = (rest.joint(name) for name in ("neck", "left_knee", "left_ankle", "pelvis"))
    tilt = rng.normal(0.0, 0.06, 3)
    if piece.template in ("long_sleeve_tshirt", "sleeved_dress", "sleeved_jumpsuit") and rng.random() < 0.6:
        reach = shoulder[0] + rng.uniform(0.08, 1.0) * (wrist[0] - shoulder[0])
        slant = rng.normal(0.0, 0.12)
        cuts.append(lambda p: reach - np.abs(p[:, 0]) + slant * (p[:, 1] - shoulder[1]))
    if piece.template in UPPERS and piece.part is Part.UPPER and rng.random() < 0.35:
        hem = pelvis[1] + rng.uniform(-0.12, 0.12)
        wave = rng.normal(0.0, 0.1)
        cuts.append(lambda p: p[:, 1] - hem - wave * np.abs(p[:, 0]) + tilt[0] * p[:, 2])
    if piece.tucked:
        end = pelvis[1] + rng.uniform(-0.03, 0.03)
        cuts.append(lambda p: p[:, 1] - end)
    if piece.template in ("trousers", *JUMPSUITS) and rng.random() < 0.55:
        leg = ankle[1] + rng.uniform(-0.02, 0.75) * (pelvis[1] - ankle[1])
        cuts.append(lambda p: p[:, 1] - leg + tilt[1] * p[:, 2])
    if piece.template in (*DRESSES, "skirt", "four_panel_skirt", HELD_OUT) and rng.random() < 0.4:
        low = knee[1] + rng.uniform(-0.05, 0.25) * (pelvis[1] - knee[1]) * 2
        cuts.append(lambda p: p[:, 1] - low + tilt[2] * p[:, 2])
    if piece.part is not Part.LOWER and rng.random() < 0.5:
        depth, width = rng.uniform(0.04, 0.2), rng.uniform(0.06, 0.12)
        front = rng.random() < 0.8
        # A V or a U: what lies above the line through the lowest point, on one side of the neck.
        power = rng.uniform(1.0, 2.5)

        def neckline(p: np.ndarray) -> np.ndarray:
            side = (p[:, 2] - neck[2]) * (1.0 if front else -1.0)
            line = neck[1] - depth * (1 - (np.abs(p[:, 0]) / width) ** power)
            return np.maximum(line + 0.02 - p[:, 1], np.maximum(np.abs(p[:, 0]) - width, -side - 0.01))

        cuts.append(neckline)
    if piece.part is Part.OUTER and rng.random() < 0.8:
        gap, flare = rng.uniform(0.01, 0.08), rng.uniform(0.0, 0.12)
        cuts.append(
            lambda p: np.maximum(
                np.abs(p[:, 0]) - gap - flare * np.clip(neck[1] - p[:, 1], 0, None), rest.joint("spine3")[2] - p[:, 2]
            )
        )
    return cuts


def take_pose(worn: list[Worn], body: Body, grid: DistanceGrid, rng: np.random.Generator) -> list[Layer]:
    """Carry what is worn into a pose, cut it to drawn lengths and wrinkle it.

    Args:
        worn: What hangs on the T-pose, the innermost first.
        body: The wearer in the pose.
        grid: Distance to the body.
        rng: The generator.
    """
    layers: list[Layer] = []
    for one in worn:
        around = Over.of(body, grid, one.heights)
        nodes = skin(one.nodes, weights_at(body, one.nodes, rest=True), body.transforms)
        start = PbdState.at_rest(nodes)
        nodes = simulate_pbd(one.threads, start, around, FALL, gravity=9.81, pins=waist_loop(one.garment)).nodes
        if not np.isfinite(nodes).all():
            continue
        layers.append(Layer(one.piece.part, _finish(one, nodes, around, body, rng)))
    return layers


def cover(layers: list[Layer]) -> list[Layer]:
    """Put what a layer covers of those before it below it; one of which nothing is left is dropped."""
    for outer in range(len(layers) - 1, 0, -1):
        for inner in range(outer):
            layers[inner] = replace(layers[inner], mesh=tuck_under(layers[inner].mesh, layers[outer].mesh))
    return [layer for layer in layers if len(layer.mesh[1])]


def _finish(one: Worn, nodes: np.ndarray, around: Over, body: Body, rng: np.random.Generator) -> Mesh:
    """Refine a posed garment, cut, wrinkle and hem it, and clear it from what it lies on."""
    flat, _ = refine(one.nodes, one.garment.faces)
    mesh = refine(nodes, one.garment.faces)
    stays = np.ones(len(flat))
    for cut in draw_cuts(one.piece, body_at_rest(body), rng):
        stays = np.minimum(stays, cut(flat))
    amount = rng.choice([0.0, rng.uniform(0.0005, 0.004)])
    folds = amount * np.maximum(wave_field(flat, (0.04, 0.16), rng), -0.3)
    thickness = rng.uniform(0.0005, 0.004) - SETTLED + 0.001
    mesh = clip(thicken(mesh, folds + thickness), stays)
    if not len(mesh[1]):
        return mesh
    if rng.random() < 0.45:
        mesh = thicken(mesh, hem_height(mesh, rng.uniform(0.015, 0.04), rng.uniform(0.0007, 0.0025)))
    return clear(mesh, around, rng.uniform(0.001, 0.003))


def body_at_rest(body: Body) -> Body:
    """Return the wearer's joints and skin in the T-pose."""
    return replace(body, vertices=body.rest_vertices, joints=body.rest_joints)
