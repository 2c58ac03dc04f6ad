"""A simulated scanner: what is seen of layered surfaces, fused or not, with its faults, and the truth at each point."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
from scipy.spatial import cKDTree

from ..core.body.body import Body
from ..core.geometry.geometry import face_areas, face_normals
from ..core.people.part import Part
from ..core.scan.open3d_library import load_open3d
from .cloth import even_out, wave_field
from .shards import Shard
from .wardrobe import Layer

SPACING = 5.0e-3
"""Distance of the points that are looked for on the surfaces [m]: finer than the 7 mm that labelling works on."""

VIEWS = 30
"""Directions that the scanner looks from: a hand-held scanner or a rig of cameras sees nearly all of a person."""

GRAZING = 0.25
"""Cosine of the angle of view below which a scanner gives no depth."""

SEEN_FROM = 2
"""Views that a point must be seen from: depth from stereo needs two."""

LIFTED = 5.0e-4
"""How far a ray starts above the surface it leaves [m]."""

CELL = 1.9
"""Edge [m] of the cells in which a surface's vertices are merged, times the root of the number of faces wanted: a
person has about 2 m2, and a cell on a surface has about one vertex and two faces."""

FAR_BORDER = 0.1
"""Distances to a border are kept up to this [m]."""


NO_SURFACE = 255
"""Number of the surface of the remains of a floor."""

STRAY_SHARE, STRAY_REACH = 0.01, 0.05
"""Share of the points of splats that float about the surface, and how far [m]."""

BACK_ROUNDS = 30
"""Times that what an image does not show is smoothed: 3 cm of what is guessed behind."""

Seen = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Points [m], shape [n, 3], unit normals, shape [n, 3], and surfaces, shape [n], or faces, shape [f, 3]."""


KINDS = {"cloud": 0.16, "fused": 0.38, "watertight": 0.16, "depth": 0.1, "image": 0.12, "splats": 0.08}
"""Kinds of scanners and how often each is drawn."""

POINTS = ("cloud", "splats")
"""Kinds that give no surface."""


@dataclass(frozen=True)
class Scanner:
    """Describe a scanner and its faults.

    Attributes:
        kind: `cloud`: points as seen; `fused`: a surface, trimmed where nothing was seen (structured light,
            photogrammetry); `watertight`: all of it (booths); `depth`: fused depth images, a surface from cells of 1 to
            2 cm; `image`: made of one image, bloated, gaps closed, its back smooth and painted like its front;
            `splats`: points about the surface.
        noise: Standard deviation [m].
        bumps: RMS of errors of low frequency, of registering the views [m].
        holes: Radii [m] of round holes.
        soles: Whether the soles are seen.
        depth: Depth of the octree of a fused surface.
        snap: Share by which a fused surface is drawn to the points that were seen.
        faces: Faces that a fused surface is thinned to.
        thinning: Share of the points that an uneven density leaves out at its worst.
        floor: Whether some of the floor about the feet is in the scan.
        bloat: How far a surface made of an image lies outside [m].
    """

    kind: str
    noise: float
    bumps: float
    holes: tuple[float, ...]
    soles: bool
    depth: int
    snap: float
    faces: int
    thinning: float
    floor: bool
    bloat: float = 0.0


def draw_scanner(rng: np.random.Generator) -> Scanner:
    """Draw a scanner."""
    kind = str(rng.choice(list(KINDS), p=list(KINDS.values())))
    coarse = kind in ("depth", "image")
    return Scanner(
        kind=kind,
        noise=float(np.exp(rng.uniform(*np.log([0.002, 0.006] if kind == "splats" else [0.0004, 0.004])))),
        bumps=float(rng.choice([0.0, rng.uniform(0.0, 0.004)])),
        holes=tuple(rng.uniform(0.01, 0.06, rng.integers(0, 6))),
        soles=bool(rng.random() < 0.5),
        depth=int(rng.choice([7, 8] if coarse else [8, 9], p=[0.7, 0.3] if coarse else [0.9, 0.1])),
        snap=float(rng.uniform(0.3, 1.0)),
        faces=int(np.exp(rng.uniform(*np.log([16000, 60000])))),
        thinning=float(rng.choice([0.0, rng.uniform(0.2, 0.7)])),
        floor=bool(rng.random() < 0.08),
        bloat=float(rng.uniform(0.0, 0.006)) if kind == "image" else 0.0,
    )


def scan_person(layers: list[Layer], body: Body, scanner: Scanner, rng: np.random.Generator) -> Shard:
    """Scan a dressed person.

    Args:
        layers: All surfaces, the skin among them.
        body: The wearer in the pose, for the truth.
        scanner: How it is scanned.
        rng: The generator.
    """
    points, normals, surface = see(layers, rng)
    if not scanner.soles:
        kept = (points[:, 1] > points[:, 1].min() + 0.012) | (normals[:, 1] > -0.5)
        points, normals, surface = points[kept], normals[kept], surface[kept]
    points = points + scanner.bumps * wave_field(points, (0.15, 0.5), rng)[:, None] * normals
    if scanner.floor:
        ground = _floor(points, rng)
        points, surface = np.concatenate([points, ground]), np.append(surface, np.full(len(ground), NO_SURFACE))
        normals = np.concatenate([normals, np.tile([0.0, 1.0, 0.0], (len(ground), 1))])
    seen = (points, normals, surface)
    faces = np.zeros((0, 3), np.int64)
    if scanner.kind in POINTS:
        wave = np.clip(wave_field(points, (0.3, 1.0), rng), -1, 1)
        kept = rng.random(len(points)) > scanner.thinning * 0.5 * (1 + wave)
        points, normals, surface = points[kept], normals[kept], surface[kept]
        if scanner.kind == "splats":
            points = _float(points, rng)
    else:
        points, normals, faces = fuse(seen, scanner)
        surface = _carry(seen, points, normals)
        if scanner.kind == "image":
            points = _smooth_back(points, faces) + scanner.bloat * normals
    gone = np.zeros(len(points), bool)
    for radius in scanner.holes if scanner.kind not in ("watertight", "image") else ():
        gone |= ((points - points[rng.integers(len(points))]) ** 2).sum(axis=1) < radius**2
    points, normals, surface, faces = _drop(points, normals, surface, faces, gone)
    part_of = np.full(NO_SURFACE + 1, Part.OTHER.value, np.uint8)
    part_of[: len(layers)] = [layer.part.value for layer in layers]
    label = part_of[surface]
    square, _, _ = igl.point_mesh_squared_distance(points, body.vertices, body.faces)
    border = border_distance(points, label)
    points = points + scanner.noise * _grain(points, rng)[:, None] * normals
    normals = igl.per_vertex_normals(points, faces) if len(faces) else _shake(normals, scanner.noise, rng)
    normals = np.where(np.isfinite(normals), normals, 0.0)
    surface = surface.astype(np.uint8)
    return Shard(points, normals, faces, label, surface, np.sqrt(square), border, body.vertices, dict(body.parameters))


def see(layers: list[Layer], rng: np.random.Generator) -> Seen:
    """Return the points of some surfaces that are seen from enough views, their normals towards these, and surfaces."""
    open3d = load_open3d()
    scene = open3d.t.geometry.RaycastingScene(nthreads=1)
    every = []
    for number, layer in enumerate(layers):
        vertices, faces = layer.mesh
        scene.add_triangles(
            open3d.core.Tensor(vertices.astype(np.float32)), open3d.core.Tensor(faces.astype(np.uint32))
        )
        points, normals = _sample(vertices, faces, rng)
        every.append((points, normals, np.full(len(points), number, np.uint8)))
    points, normals, surface = (np.concatenate(parts) for parts in zip(*every, strict=True))
    front, back = np.zeros(len(points), np.int64), np.zeros(len(points), np.int64)
    for direction in _directions(rng):
        cosine = normals @ direction
        ahead = np.flatnonzero(np.abs(cosine) > GRAZING)
        start = points[ahead] + LIFTED * np.sign(cosine[ahead])[:, None] * normals[ahead]
        rays = np.hstack([start, np.broadcast_to(direction, start.shape)]).astype(np.float32)
        free = ~scene.test_occlusions(open3d.core.Tensor(rays), nthreads=1).numpy()
        front[ahead[free & (cosine[ahead] > 0)]] += 1
        back[ahead[free & (cosine[ahead] < 0)]] += 1
    seen = np.maximum(front, back) >= SEEN_FROM
    normals = np.where((front >= back)[:, None], normals, -normals)
    return points[seen], normals[seen], surface[seen]


def _directions(rng: np.random.Generator) -> np.ndarray:
    """Return unit directions towards the cameras, around and from a little below to above, shape [VIEWS, 3]."""
    step = np.arange(VIEWS)
    turn = step * np.pi * (3 - np.sqrt(5)) + rng.uniform(0, 2 * np.pi)
    height = -0.35 + 1.2 * (step + 0.5) / VIEWS
    flat = np.sqrt(1 - np.minimum(height, 0.95) ** 2)
    return np.stack([flat * np.cos(turn), np.minimum(height, 0.95), flat * np.sin(turn)], axis=1)


def _sample(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return points spread over a surface, one in `SPACING` squared, and its normals there."""
    area = face_areas(vertices, faces)
    count = int(area.sum() / SPACING**2) + 1
    face = np.searchsorted(np.cumsum(area), (np.arange(count) + rng.random(count)) / count * area.sum())
    face = np.minimum(face, len(faces) - 1)
    a, b = rng.random(count), rng.random(count)
    over = a + b > 1
    a[over], b[over] = 1 - a[over], 1 - b[over]
    share = np.stack([1 - a - b, a, b], axis=1)
    corner = faces[face]
    smooth = igl.per_vertex_normals(vertices, faces)
    smooth = np.where(np.isfinite(smooth), smooth, 0.0)
    normals = np.einsum("nk,nka->na", share, smooth[corner])
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    flat = face_normals(vertices, faces)[0][face]
    normals = np.where(size > 0.3, normals / np.maximum(size, 1e-9), flat)
    return np.einsum("nk,nka->na", share, vertices[corner]), normals


def fuse(seen: Seen, scanner: Scanner) -> Seen:
    """Return a surface through what was seen (screened Poisson, Kazhdan and Hoppe 2013): vertices, normals, faces."""
    points, normals, _ = seen
    open3d = load_open3d()
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    cloud.normals = open3d.utility.Vector3dVector(normals)
    mesh, _ = open3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=scanner.depth, n_threads=1)
    tree = cKDTree(points)
    if scanner.kind in ("fused", "depth"):
        far = tree.query(np.asarray(mesh.vertices))[0] > 0.015
        mesh.remove_vertices_by_mask(far)
    if len(mesh.triangles) > 1.5 * scanner.faces:
        mesh = mesh.simplify_vertex_clustering(CELL * np.sqrt(1 / scanner.faces))
    mesh.remove_duplicated_triangles()
    mesh.remove_non_manifold_edges()
    mesh.remove_degenerate_triangles()
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.triangles).astype(np.int64)
    label, count, _ = (np.asarray(a) for a in mesh.cluster_connected_triangles())
    faces = faces[count[label] > 0.01 * len(faces)]
    used, index = np.unique(faces, return_inverse=True)
    vertices, faces = vertices[used], index.reshape(-1, 3)
    outward = igl.per_vertex_normals(vertices, faces)
    distance, near = tree.query(vertices, k=4)
    agree = np.einsum("nka,na->nk", normals[near], outward) > 0.5
    weight = agree / (distance + 1e-3)
    height = np.einsum("nka,na->nk", points[near] - vertices[:, None], outward)
    move = (weight * height).sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-9)
    move = np.where((np.abs(move) < 0.008) & (distance[:, 0] < 0.01), move, 0.0)
    if scanner.kind not in ("depth", "image"):
        vertices = vertices + scanner.snap * move[:, None] * outward
    return vertices, np.nan_to_num(igl.per_vertex_normals(vertices, faces)), faces


def _carry(seen: Seen, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the surface of the nearest point that was seen, one that faces alike before one that does not."""
    length = 0.01  # a unit of difference in normals counts as 1 cm
    tree = cKDTree(np.hstack([seen[0], length * seen[1]]))
    return seen[2][tree.query(np.hstack([points, length * normals]))[1]]


def border_distance(points: np.ndarray, label: np.ndarray) -> np.ndarray:
    """Return the distance of each point to the nearest with another label [m], at most `FAR_BORDER`, shape [n]."""
    border = np.full(len(points), FAR_BORDER)
    for part in np.unique(label):
        own = label == part
        if own.all():
            break
        distance, _ = cKDTree(points[~own]).query(points[own], distance_upper_bound=FAR_BORDER)
        border[own] = np.minimum(distance, FAR_BORDER)
    return border


def _drop(
    points: np.ndarray, normals: np.ndarray, surface: np.ndarray, faces: np.ndarray, gone: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Drop points, and the faces at them."""
    place = np.cumsum(~gone) - 1
    faces = place[faces[~gone[faces].any(axis=1)]] if len(faces) else faces
    return points[~gone], normals[~gone], surface[~gone], faces


def _float(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return points [m], shape [n, 3], some of which float about the others."""
    stray = rng.random(len(points)) < STRAY_SHARE
    return points + stray[:, None] * rng.normal(0.0, STRAY_REACH, points.shape)


def _smooth_back(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return a surface's vertices [m], shape [n, 3], smooth where they face away from a camera in front."""
    return even_out(points, faces, BACK_ROUNDS, igl.per_vertex_normals(points, faces)[:, 2:] < 0.0)


def _grain(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return noise of unit variance, half of it alike over about 1 cm, shape [n]."""
    white = rng.normal(size=len(points))
    return np.sqrt(0.5) * (white + wave_field(points, (0.01, 0.04), rng))


def _shake(normals: np.ndarray, noise: float, rng: np.random.Generator) -> np.ndarray:
    """Return normals as they come from noisy points: off by the noise over about 15 mm."""
    shaken = normals + rng.normal(0.0, min(noise / 0.015, 0.3), normals.shape)
    return shaken / np.linalg.norm(shaken, axis=1, keepdims=True)


def _floor(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return points of the floor about the feet [m], shape [n, 3]."""
    low = points[:, 1].min()
    feet = points[points[:, 1] < low + 0.05][:, [0, 2]].mean(axis=0)
    flat = feet + rng.uniform(-0.3, 0.3, (4000, 2))
    return np.column_stack([flat[:, 0], np.full(len(flat), low), flat[:, 1]])
