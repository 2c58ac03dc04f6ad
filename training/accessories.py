"""Hair, shoes, hats, bags and scarves: the CC0 assets, and shells and blobs of our own, on any wearer in any pose."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import igl
import numpy as np
import trimesh
from scipy.spatial import ConvexHull

from ..core.body.body import JOINTS, Body
from ..core.body.skinning import skin
from ..core.body.template import Template
from ..core.geometry.geometry import vertex_normals
from ..core.people.part import Part
from .base_mesh import surface_values
from .build_accessories import ASSET, STEP
from .cloth import Mesh, clip, even_out, refine, thicken, tuck_under, wave_field
from .wardrobe import Layer
from .wearer import size_of

TAKEN_IN = 0.008
"""How far the skin inside shoes is drawn in [m]: toes are thicker in one shape than in another."""

TRUNK = ("pelvis", "spine1", "spine2", "spine3", "left_collar", "right_collar", "neck")
"""Joints of what a strap goes around."""

SOCKS = 0.3
"""Share of persons whose socks show: without shoes, or above them."""

TILT = np.deg2rad(35.0)
"""Angle by which the hairline is lower behind than in front."""


@cache
def load_accessories() -> dict[str, Mesh]:
    """Return the CC0 accessories around the mean body's T-pose by name, `hair.bob01`."""
    with np.load(ASSET) as kept:
        names = sorted({key.rsplit(".", 1)[0] for key in kept.files})
        return {
            name: (STEP * kept[f"{name}.vertices"].astype(np.float64), kept[f"{name}.faces"].astype(np.int64))
            for name in names
        }


def draw_accessories(template: Template, body: Body, cloth: list[Layer], rng: np.random.Generator) -> list[Layer]:
    """Draw what a person wears beside garments, in the pose.

    Args:
        template: The built-in body, around whose mean the assets lie.
        body: The wearer in the pose.
        cloth: The garments, which bags and scarves lie on, and whose hoods hair is below and hats are not worn with.
        rng: The generator.
    """
    layers = []
    assets = load_accessories()
    hair, shoes = ([name for name in assets if name.startswith(kind)] for kind in ("hair.", "shoes."))
    drawn = rng.random()
    if drawn < 0.55:
        chosen, bulk = assets[str(rng.choice(hair))], float(rng.uniform(0.7, 1.4))
        layers.append(Layer(Part.HAIR, worn_asset(template, body, chosen, bulk)))
    elif drawn < 0.9:
        layers.append(Layer(Part.HAIR, hair_shell(body, rng)))
        if rng.random() < 0.25:
            layers.append(Layer(Part.HAIR, tied_hair(body, rng)))
    hoods = [garment for garment in cloth if garment.is_on_head]
    for hood in hoods:
        layers = [replace(hair, mesh=tuck_under(hair.mesh, hood.mesh)) for hair in layers]
    if rng.random() < SOCKS:
        layers.append(Layer(Part.SHOES, sock_shell(body, rng)))
    drawn = rng.random()
    if drawn < 0.4:
        chosen, bulk = assets[str(rng.choice(shoes))], float(rng.uniform(0.8, 1.3))
        layers.append(Layer(Part.SHOES, worn_asset(template, body, chosen, bulk)))
    elif drawn < 0.78:
        layers.append(Layer(Part.SHOES, shoe_shell(body, rng)))
    drawn = 1.0 if hoods else rng.random()
    if drawn < 0.05:
        hat = str(rng.choice(["hat.fedora", "hat.fedora_cocked"]))
        layers.append(Layer(Part.OTHER, worn_asset(template, body, assets[hat], 1.05)))
    elif drawn < 0.08:
        layers.append(Layer(Part.OTHER, hair_shell(body, rng)))
    elif drawn < 0.11:
        layers.append(Layer(Part.OTHER, head_scarf(body, rng)))
    if rng.random() < 0.12:
        layers.append(Layer(Part.OTHER, glasses(body, rng)))
    if rng.random() < 0.12:
        layers += draw_bag(body, cloth, rng)
    if rng.random() < 0.04:
        layers.append(Layer(Part.OTHER, scarf(body, rng)))
    return layers


def bare_skin(body: Body, layers: list[Layer]) -> Mesh:
    """Return the wearer's skin, drawn in inside shoes."""
    if not any(layer.part is Part.SHOES for layer in layers):
        return body.vertices, body.faces
    foot = body.weights[:, [JOINTS.index(f"{side}_{name}") for side in ("left", "right") for name in ("ankle", "foot")]]
    inward = TAKEN_IN * np.clip(2 * foot.sum(axis=1) - 0.8, 0.0, 1.0)
    return body.vertices - inward[:, None] * vertex_normals(body.vertices, body.faces), body.faces


def worn_asset(template: Template, body: Body, asset: Mesh, bulk: float) -> Mesh:
    """Return an asset on a wearer: it goes with the mean body's nearest skin, its height scaled by bulk."""
    points, faces = asset
    values = np.hstack([body.rest_vertices - template.vertices, template.weights, template.vertices])
    near = surface_values(template.vertices, template.faces, values, points)
    moved, weights, foot = near[:, :3], near[:, 3:-3], near[:, -3:]
    rest = foot + moved + bulk * size_of(body) * (points - foot)
    return skin(rest, weights / weights.sum(axis=1, keepdims=True), body.transforms), faces


def hair_shell(body: Body, rng: np.random.Generator) -> Mesh:
    """Return a cap of drawn extent and thickness on the head: short hair, or a close hat."""
    head = body.rest_joints[JOINTS.index("head")]
    top = body.rest_vertices[:, 1].max()
    centre = np.array([head[0], 0.45 * head[1] + 0.55 * top, head[2]])
    toward = body.rest_vertices - centre
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    line = rng.uniform(-0.05, 0.3)
    tilt = TILT + rng.normal(0.0, 0.12)
    keep = np.cos(tilt) * toward[:, 1] - np.sin(tilt) * toward[:, 2] - line
    keep = np.where(body.rest_vertices[:, 1] > head[1] - 0.02, keep, -1.0)
    thickness = rng.uniform(0.003, 0.03)
    height = thickness * np.clip(keep / 0.25, 0.05, 1.0) * (1 + 0.25 * wave_field(body.rest_vertices, (0.02, 0.1), rng))
    return refine(*clip(thicken((body.vertices, body.faces), np.maximum(height, 0.001)), keep))


def tied_hair(body: Body, rng: np.random.Generator) -> Mesh:
    """Return a bun or a tail behind the head."""
    head, top = body.rest_joints[JOINTS.index("head")], body.rest_vertices[:, 1].max()
    behind = body.rest_vertices[body.rest_vertices[:, 1] > head[1]][:, 2].min()
    bun = rng.random() < 0.5
    size = rng.uniform(0.025, 0.045) * np.ones(3) if bun else rng.uniform([0.02, 0.08, 0.02], [0.04, 0.2, 0.04])
    high = rng.uniform(0.2, 1.0)
    place = np.array(
        [head[0], head[1] + high * (top - head[1]) - (0.0 if bun else 0.8 * size[1]), behind - 0.6 * size[2]]
    )
    ball = trimesh.creation.icosphere(subdivisions=3)
    return turn_with_head(body, place + size * ball.vertices), np.asarray(ball.faces, np.int64)


def turn_with_head(body: Body, rest: np.ndarray) -> np.ndarray:
    """Return points about the T-pose's head [m], shape [n, 3], where they are in the pose."""
    weights = np.zeros((len(rest), len(JOINTS)))
    weights[:, JOINTS.index("head")] = 1.0
    return skin(rest, weights, body.transforms)


def head_scarf(body: Body, rng: np.random.Generator) -> Mesh:
    """Return a cloth around head, neck and shoulders that leaves the face open."""
    head, neck = (body.rest_joints[JOINTS.index(name)] for name in ("head", "neck"))
    rest = body.rest_vertices
    top = rest[:, 1].max()
    face = np.array([head[0], 0.55 * head[1] + 0.45 * top, rest[rest[:, 1] > head[1]][:, 2].max()])
    opening = np.linalg.norm((rest - face) / [0.07, 0.1, 0.09], axis=1) - 1.0
    low = rest[:, 1] - (neck[1] - rng.uniform(-0.02, 0.12))
    keep = np.minimum(np.minimum(0.08 * opening, low), 0.14 - np.abs(rest[:, 0]))
    waves = wave_field(rest, (0.03, 0.12), rng)
    height = rng.uniform(0.004, 0.02) * (1 + 0.3 * np.clip(waves, -2, 2))
    return refine(*clip(thicken((body.vertices, body.faces), height), keep))


def glasses(body: Body, rng: np.random.Generator) -> Mesh:
    """Return two rims and a bridge before the eyes."""
    head = body.rest_joints[JOINTS.index("head")]
    rest = body.rest_vertices
    own = rest[rest[:, 1] > head[1]]
    eyes = head[1] + 0.5 * (own[:, 1].max() - head[1])
    ahead = own[np.abs(own[:, 1] - eyes) < 0.02][:, 2].max() + 0.01
    rims = []
    for side in (-1.0, 1.0):
        rim = trimesh.creation.torus(rng.uniform(0.02, 0.03), rng.uniform(0.002, 0.004), 32, 8)
        rim.apply_translation([head[0] + side * 0.033, eyes, ahead])
        rims.append(rim)
    bridge = trimesh.creation.box([0.02, 0.005, 0.004])
    bridge.apply_translation([head[0], eyes, ahead])
    whole = trimesh.util.concatenate([*rims, bridge])
    return turn_with_head(body, np.asarray(whole.vertices)), np.asarray(whole.faces, np.int64)


def sock_shell(body: Body, rng: np.random.Generator) -> Mesh:
    """Return socks up to a drawn height."""
    rest = body.rest_vertices
    rim = rng.uniform(0.06, 0.42) * size_of(body) - rest[:, 1]
    shell = body.vertices + rng.uniform(0.001, 0.003) * vertex_normals(body.vertices, body.faces)
    return refine(*clip((shell, body.faces), rim))


def shoe_shell(body: Body, rng: np.random.Generator) -> Mesh:
    """Return shoes or boots: a smoothed shell around the feet up to a drawn height, with a sole."""
    height = float(rng.choice([rng.uniform(0.05, 0.12), rng.uniform(0.12, 0.4)], p=[0.75, 0.25])) * size_of(body)
    rest = body.rest_vertices
    low = rest[:, 1] < height + 0.05
    smooth = rest + rng.uniform(0.004, 0.01) * vertex_normals(rest, body.faces)
    smooth = even_out(smooth, body.faces, 12, low[:, None])
    smooth += rng.uniform(0.003, 0.007) * vertex_normals(smooth, body.faces)
    sole = rng.uniform(0.005, 0.03)
    smooth[:, 1] -= sole * np.clip((0.03 - rest[:, 1]) / 0.02, 0.0, 1.0)
    # Lower over the instep than behind, as a shoe's opening is.
    ahead = rest[:, 2] - body.rest_joints[JOINTS.index("left_ankle")][2]
    rim = height - (0.35 * np.clip(ahead, 0.0, 0.12) if height < 0.12 else 0.0) - rest[:, 1]
    return refine(*clip((skin(smooth, body.weights, body.transforms), body.faces), rim))


def draw_bag(body: Body, cloth: list[Layer], rng: np.random.Generator) -> list[Layer]:
    """Return a bag at a hip with its strap, a backpack, or something held in a hand."""
    side = str(rng.choice(["left", "right"]))
    box = trimesh.creation.icosphere(subdivisions=4)
    power = rng.uniform(0.35, 1.0)
    shape = np.sign(box.vertices) * np.abs(box.vertices) ** power
    kind = rng.choice(["hip", "back", "hand"])
    sign = 1.0 if side == "left" else -1.0
    if kind == "hand":
        phone = rng.random() < 0.4
        size = np.array([0.006, 0.075, 0.037]) if phone else rng.uniform(0.02, 0.12, 3)
        place = body.joint(f"{side}_hand") + [0.0, -0.05, 0.0]
    elif kind == "back":
        size = rng.uniform([0.11, 0.15, 0.05], [0.17, 0.24, 0.10])
        place = body.joint("spine3") + [0.0, -0.05, -0.13 - size[2]]
    else:
        size = rng.uniform([0.03, 0.08, 0.08], [0.07, 0.15, 0.16])
        place = body.joint(f"{side}_hip") + [sign * (0.13 + size[0]), 0.0, 0.0]
    layers = [Layer(Part.OTHER, (place + size * shape, np.asarray(box.faces, np.int64)))]
    if kind == "hip":
        other = "right" if side == "left" else "left"
        far = body.joint(f"{other}_collar") + [-sign * 0.06, 0.0, 0.0]
        strap = ribbon(body, cloth, place, far, rng.uniform(0.01, 0.03))
        layers += [] if strap is None else [Layer(Part.OTHER, strap)]
    return layers


def ribbon(body: Body, cloth: list[Layer], low: np.ndarray, high: np.ndarray, half: float) -> Mesh | None:
    """Return a strap around trunk and clothes through two places, in the plane that is upright from front to back."""
    along = (high - low) / np.linalg.norm(high - low)
    depth = np.array([0.0, 0.0, 1.0])
    normal = np.cross(along, depth)
    normal /= np.linalg.norm(normal)
    trunk = body.weights[:, [JOINTS.index(name) for name in TRUNK]]
    points = body.vertices[trunk.sum(axis=1) > 0.5]
    near = points[np.abs((points - low) @ normal) < 0.02]
    if len(near) < 10:
        return None
    flat = np.column_stack([(near - low) @ along, (near - low) @ depth])
    corners = flat[ConvexHull(flat).vertices]
    middle = corners.mean(axis=0)
    ring = middle + (corners - middle) * (1 + 0.012 / np.linalg.norm(corners - middle, axis=1, keepdims=True))
    ends = np.roll(ring, -1, axis=0)
    ring = np.linspace(ring, ends, 8, endpoint=False, axis=1).reshape(-1, 2)
    centre = low + ring[:, :1] * along + ring[:, 1:] * depth
    count = len(centre)
    vertices = np.concatenate([centre - half * normal, centre, centre + half * normal])
    i, j = np.arange(count), np.roll(np.arange(count), -1)
    strips = [((i + row, j + row, i + row + count), (j + row, j + row + count, i + row + count)) for row in (0, count)]
    faces = np.concatenate([np.stack(corner, axis=1) for strip in strips for corner in strip])
    return _outermost(vertices, cloth), faces


def _outermost(points: np.ndarray, cloth: list[Layer]) -> np.ndarray:
    """Push points that are below cloth to 4 mm above it."""
    points = points.copy()
    for layer in cloth:
        square, face, nearest = igl.point_mesh_squared_distance(points, *layer.mesh)
        normal = vertex_normals(*layer.mesh)[layer.mesh[1][face]].mean(axis=1)
        above = np.einsum("na,na->n", points - nearest, normal)
        low = (above < 0.004) & (square < 0.05**2)
        points[low] = nearest[low] + 0.004 * normal[low]
    return points


def scarf(body: Body, rng: np.random.Generator) -> Mesh:
    """Return a torus around the neck."""
    size = size_of(body)
    ring = trimesh.creation.torus(size * rng.uniform(0.08, 0.1), size * rng.uniform(0.02, 0.04), 48, 24)
    turn = trimesh.transformations.rotation_matrix(np.pi / 2 + rng.normal(0.25, 0.1), [1, 0, 0])
    ring.apply_transform(turn)
    return np.asarray(ring.vertices) + body.joint("neck") + [0.0, 0.02, 0.02], np.asarray(ring.faces, np.int64)
