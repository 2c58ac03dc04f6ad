"""Dress a wearer in drawn garments, and carry these into a pose."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import igl
import numpy as np
from scipy.spatial import cKDTree

from ..core.body.body import Body
from ..core.body.distance import DistanceGrid
from ..core.body.skinning import skin, weights_at
from ..core.garment.creases import mark_turned_faces
from ..core.garment.garment import Garment
from ..core.garment.parts.cut import Front, Hood, HoodWorn
from ..core.garment.sewing import mesh_pattern
from ..core.garment.templates import draft_template
from ..core.people.part import Part
from ..core.recover.drape.dress import DressSettings, dress
from ..core.recover.drape.layer_contact import LayerContact
from ..core.recover.drape.pbd import DistanceConstraints, PbdState, build_distance_constraints, simulate_pbd
from ..core.recover.drape.waist import waist_loop
from ..core.run.errors import GarmentqError
from .cloth import COVER, Mesh, clear, clip, even_out, hem_height, refine, thicken, tuck_under, wave_field
from .designs import Piece, draw_trims

NODES = 1000
"""Nodes of a garment while it is draped: edges of 3 cm, 0.7 s a garment, 2 to 5 s with a collar or a hood; refined once
before it is scanned."""

FALL = 45
"""Steps of gravity in the pose: 0.75 s, in which cloth that was skinned finds its folds."""

SETTLED = 0.004
"""Distance [m] from the skin that the drape leaves; what a drawn thickness is less than that is taken off again."""


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

    @property
    def layers(self) -> LayerContact | None:
        """Return how its layers are kept apart: where cloth is turned over, wrapped, or a hood, it lies on its own."""
        cut = self.piece.cut
        is_layered = self.threads.is_creased or cut.hood is not Hood.NONE or cut.front is Front.WRAP
        return LayerContact() if is_layered else None


@dataclass(frozen=True)
class Layer:
    """One surface of a dressed person in its pose.

    Attributes:
        part: What it is.
        mesh: The surface.
        is_cloth: Whether it is dyed: underwear counts as skin and is none.
        is_on_head: Whether it is a garment whose hood is worn on the head.
    """

    part: Part
    mesh: Mesh = field(repr=False)
    is_cloth: bool = True
    is_on_head: bool = False


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
        if not np.isfinite(nodes).all() or not goes_around_arms(garment.at(nodes), rest):
            continue
        worn.append(Worn(piece, garment, threads, nodes, over))
        heights = np.maximum(heights, heights_above(rest, (nodes, garment.faces)))
    return worn


def goes_around_arms(garment: Garment, rest: Body) -> bool:
    """Check that every cuff of a garment that hangs on the T-pose goes around an arm.

    A ring of a girth that hangs on the arm's axis, however flat, has its middle within a quarter of the girth from it.
    """
    cuffs: dict[str, list[np.ndarray]] = {}
    for ref, line in garment.edge_uv.items():
        contour = garment.pattern.panel(ref.panel).edges[ref.edge].contour
        if contour.startswith("cuff"):
            cuffs.setdefault(contour, []).append(line)
    for name, lines in cuffs.items():
        side = name.partition(".")[2]
        axis = np.array([rest.joint(f"{side}_{joint}") for joint in ("shoulder", "elbow", "wrist", "hand")])
        axis = axis[np.argsort(axis[:, 0])]
        girth = sum(float(np.linalg.norm(np.diff(garment.uv[line], axis=0), axis=1).sum()) for line in lines)
        x, *across = np.mean([garment.nodes[garment.uv_node[line]].mean(axis=0) for line in lines], axis=0)
        if np.hypot(*(value - np.interp(x, axis[:, 0], axis[:, k]) for k, value in enumerate(across, 1))) > girth / 4:
            return False
    return True


def heights_above(body: Body, cloth: Mesh) -> np.ndarray:
    """Return how high cloth lies over each vertex of the skin [m], 0 where there is none within reach, evened out."""
    square, _, nearest = igl.point_mesh_squared_distance(body.vertices, *cloth)
    distance = np.sqrt(square)
    normals = igl.per_vertex_normals(body.vertices, body.faces)
    upright = np.einsum("na,na->n", nearest - body.vertices, normals) > 0.7 * distance
    height = np.where(upright & (distance < 0.5 * COVER), distance, 0.0)
    return even_out(height, body.faces, 4)


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
        nodes = simulate_pbd(
            one.threads, start, around, FALL, gravity=9.81, pins=waist_loop(one.garment), layers=one.layers
        ).nodes
        if not np.isfinite(nodes).all():
            continue
        is_on_head = one.piece.cut.hood is not Hood.NONE and one.piece.cut.hood_worn is HoodWorn.UP
        layers.append(Layer(one.piece.part, _finish(one, nodes, around, body, rng), is_on_head=is_on_head))
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
    vertices, faces = refine(nodes, one.garment.faces)
    # Each face is four now, one after the other. The side that is seen faces outwards.
    mesh = vertices, np.where(np.repeat(mark_turned_faces(one.garment), 4)[:, None], faces[:, ::-1], faces)
    stays = np.ones(len(flat))
    for trim in draw_trims(one.piece, body_at_rest(body), rng):
        stays = np.minimum(stays, trim(flat))
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
