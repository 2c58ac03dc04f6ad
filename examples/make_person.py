"""Make the demo's scan: a person in T-shirt and trousers, fused into one surface with a label per vertex.

Run it as `python examples/make_person.py` (two minutes on one core) after `make_example.py`, whose T-shirt and wearer
it takes from `examples/data`; the demo itself does not need it. It writes `person.ply` into the same folder.

What it does: draft trousers by other measures than the shipped template's, dress the wearer in them, shorten both
garments so that they are seen whole, look from 60 sides, fuse the depth images in a signed distance field (Curless and
Levoy 1996), and take the surface out of it, with noise, the holes where nothing looked, and one more.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import igl
import numpy as np
import open3d
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.templates import draft_template
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from scipy.ndimage import binary_dilation, generate_binary_structure

DATA = Path(__file__).parent / "data"

BODY = "builtin:female,height=1.66,pose=A"
"""The wearer of `make_example.py`."""

Mesh = tuple[np.ndarray, np.ndarray]

NODES = 3000
"""Nodes of the trousers: edges of 2 cm."""
HEM, CUFF = 1.02, 0.18
"""Heights at which T-shirt and trousers are cut off [m]: 3 cm above the trousers, and above the feet, where they would
lie in folds."""

VOXEL = 4.0e-3
"""Size of the distance field's cells [m]: half a scanner's point distance on a person."""
TRUNCATION = 3 * VOXEL
"""Distance [m] up to which a depth image says something about a cell behind the surface that it saw."""
PIXEL = 2.0e-3
"""Size of a depth image's pixels [m]."""
HEADINGS, ELEVATIONS = 20, (-0.35, 0.1, 0.6)
"""Directions that the scanner looks from: so many around, from below, the side and above [rad]."""
GRAZING = 0.2
"""Rays that meet the surface at less than this cosine are not believed."""

NOISE = 1.0e-3
"""Noise of the vertices [m per coordinate]: a hand-held scanner's."""
FACES = 60000
"""Faces in the file: about 1.5 MB."""
HOLE = (0.09, 1.18, -1.0, 0.035)
"""A hole at the back of the T-shirt: x, y [m], the sign of z, and its radius [m]."""

FACING = 0.3
"""Cosine between the normals of scan and garment below which the scan shows a garment's inside or its edge."""

COLOURS = np.array([[205, 170, 145], [70, 95, 170], [60, 60, 66], [110, 100, 100]], np.uint8)
"""Of skin, T-shirt, trousers, and the insides of both, which have the labels 0, 1, 2 and 3."""


def drape_trousers() -> Mesh:
    """Dress the wearer in trousers that are cut by a smaller woman's measures than the template's."""
    measures = BodyMeasures(waist=0.73, hip=1.00, waist_height=1.045, crotch_height=0.765)
    pattern = draft_template("trousers", measures)
    worn = drape_template(pattern, WearerGeometry(builtin_body(BODY)), settings=DrapeSettings(template_vertices=NODES))
    return shorten((worn.nodes, worn.faces), CUFF)


def shorten(garment: Mesh, height: float) -> Mesh:
    """Cut a garment off at a height [m]."""
    vertices, faces = garment
    above = faces[(vertices[faces, 1] > height).any(axis=1)]
    return np.maximum(vertices, (-np.inf, height, -np.inf)), above  # the last row's lower corners move up to the line


def read(path: Path) -> Mesh:
    """Read one of the example's meshes."""
    mesh = trimesh.load(path, process=False)
    return np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)


def fuse(meshes: list[Mesh]) -> Mesh:
    """Return what a scanner sees of some meshes, as one surface with holes where it saw nothing."""
    scene = open3d.t.geometry.RaycastingScene()
    for vertices, faces in meshes:
        scene.add_triangles(
            open3d.core.Tensor(vertices.astype(np.float32)), open3d.core.Tensor(faces.astype(np.uint32))
        )
    everything = np.concatenate([vertices for vertices, _ in meshes])
    low, high = everything.min(axis=0) - 5 * VOXEL, everything.max(axis=0) + 5 * VOXEL
    counts = np.ceil((high - low) / VOXEL).astype(int)
    axes = [low[a] + VOXEL * np.arange(counts[a]) for a in range(3)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3).astype(np.float32)
    near = np.flatnonzero(_around(meshes, low, counts))
    total, weight = np.zeros(len(near)), np.zeros(len(near))
    for elevation in ELEVATIONS:
        for heading in 2 * np.pi * np.arange(HEADINGS) / HEADINGS:
            _look(scene, grid[near].astype(np.float64), heading, elevation, total, weight)
    field = np.full(len(grid), 1.0)
    field[near] = np.where(weight > 0, total / np.maximum(weight, 1e-9), 1.0)
    known = np.zeros(len(grid), bool)
    known[near] = weight > 0
    return _extract(field.reshape(counts), known.reshape(counts), low)


def _around(meshes: list[Mesh], low: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Mark the cells within `TRUNCATION` of a surface, shape [cell_count]."""
    marked = np.zeros(counts, bool)
    for vertices, faces in meshes:
        surface = trimesh.Trimesh(vertices, faces, process=False)
        points, _ = trimesh.sample.sample_surface(surface, int(surface.area / (0.5 * VOXEL) ** 2), seed=0)
        marked[tuple(np.rint((points - low) / VOXEL).astype(int).T)] = True
    return binary_dilation(marked, generate_binary_structure(3, 3), round(TRUNCATION / VOXEL)).ravel()


def _look(
    scene: open3d.t.geometry.RaycastingScene,
    points: np.ndarray,
    heading: float,
    elevation: float,
    total: np.ndarray,
    weight: np.ndarray,
) -> None:
    """Add one depth image, seen in parallel from far away, to the sums of distances and weights at the points."""
    across = np.array([np.cos(heading), 0.0, -np.sin(heading)])
    toward = np.array([np.sin(heading) * np.cos(elevation), np.sin(elevation), np.cos(heading) * np.cos(elevation)])
    frame = np.stack([across, np.cross(toward, across), toward])
    local = points @ frame.T
    low = local.min(axis=0)
    pixel = ((local[:, :2] - low[:2]) / PIXEL).astype(np.int64)
    used, place = np.unique(pixel[:, 0] * (pixel[:, 1].max() + 1) + pixel[:, 1], return_inverse=True)
    column, row = np.divmod(used, pixel[:, 1].max() + 1)
    top = local[:, 2].max() + 1.0
    centre = np.stack([low[0] + (column + 0.5) * PIXEL, low[1] + (row + 0.5) * PIXEL, np.full(len(used), top)], axis=1)
    rays = np.concatenate([centre @ frame, np.tile(-toward, (len(used), 1))], axis=1).astype(np.float32)
    hit = scene.cast_rays(open3d.core.Tensor(rays))
    depth, normal = hit["t_hit"].numpy(), hit["primitive_normals"].numpy()
    cosine = np.abs(normal @ toward)[place]
    height = local[:, 2] - (top - depth[place])
    # Along a slanted ray the way to the surface is longer than the distance to it.
    height = np.where(np.isfinite(height), height * np.maximum(cosine, GRAZING), np.inf)
    seen = (height > -TRUNCATION) & np.isfinite(height) & (cosine > GRAZING)
    total[seen] += cosine[seen] * np.minimum(height[seen], TRUNCATION)
    weight[seen] += cosine[seen]


def _extract(field: np.ndarray, known: np.ndarray, low: np.ndarray) -> Mesh:
    """Take the zero level out of a distance field, where both sides of it are known; the largest piece of it."""
    index = np.stack(np.meshgrid(*(np.arange(n) for n in field.shape), indexing="ij"), axis=-1).astype(np.float64)
    order = (2, 1, 0)  # igl runs through x first
    vertices, faces = igl.marching_cubes(
        np.ascontiguousarray(field.transpose(order)).ravel(),
        np.ascontiguousarray(index.transpose(2, 1, 0, 3)).reshape(-1, 3),
        *field.shape,
        0.0,
    )[:2]
    ends = [np.floor(vertices + 1e-9).astype(int), np.ceil(vertices - 1e-9).astype(int)]
    sure = np.all([known[tuple(np.minimum(end, np.array(field.shape) - 1).T)] for end in ends], axis=0)
    mesh = trimesh.Trimesh(low + VOXEL * vertices, faces[sure[faces].all(axis=1)], process=True)
    piece = max(mesh.split(only_watertight=False), key=lambda part: part.area)
    if np.median(np.einsum("ij,ij->i", piece.vertex_normals, piece.vertices - piece.centroid)) < 0:
        piece.invert()
    return np.asarray(piece.vertices), np.asarray(piece.faces)


def write_scan(surface: Mesh, meshes: list[Mesh], path: Path) -> None:
    """Thin the surface out, add noise, a hole, labels and colours, and write it as PLY."""
    thin = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(surface[0]), open3d.utility.Vector3iVector(surface[1].astype(np.int32))
    ).simplify_quadric_decimation(FACES)
    vertices, faces = np.asarray(thin.vertices), np.asarray(thin.triangles).astype(np.int64)
    x, y, side, radius = HOLE
    gone = (np.linalg.norm(vertices[:, :2] - (x, y), axis=1) < radius) & (side * vertices[:, 2] > 0)
    faces = faces[~gone[faces].any(axis=1)]
    used, index = np.unique(faces, return_inverse=True)
    vertices, faces = vertices[used], index.reshape(-1, 3)
    label = _label(vertices, faces, meshes)
    rng = np.random.default_rng(0)
    mesh = trimesh.Trimesh(vertices + rng.normal(0.0, NOISE, vertices.shape), faces, process=False)
    shade = COLOURS[label] + rng.normal(0.0, 6.0, (len(label), 3))
    mesh.visual.vertex_colors = np.clip(shade, 0, 255).astype(np.uint8)
    mesh.vertex_attributes["label"] = label.astype(np.uint8)
    mesh.export(path)
    print(f"{len(vertices)} vertices, {len(faces)} faces in {path}")


def _label(vertices: np.ndarray, faces: np.ndarray, meshes: list[Mesh]) -> np.ndarray:
    """Return each vertex the nearest mesh's number, or one more where it does not look the way that mesh does.

    From below a scanner looks into sleeves and hems, and edges are rounded: that is neither skin nor the garment.
    """
    normals = trimesh.Trimesh(vertices, faces, process=False).vertex_normals
    distance, facing = [], []
    for mesh in meshes:
        squared, face, _ = igl.point_mesh_squared_distance(vertices, *mesh)
        outward = trimesh.Trimesh(*mesh, process=False).face_normals[face]
        distance.append(squared)
        facing.append(np.einsum("ij,ij->i", outward, normals))
    label = np.argmin(distance, axis=0)
    towards = np.take_along_axis(np.array(facing), label[None], axis=0)[0]
    return np.where(towards > FACING, label, len(meshes))


def main() -> None:
    """Write the dressed person."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=DATA, help="folder for the file")
    options = parser.parse_args()
    body, trousers = read(DATA / "body.ply"), drape_trousers()
    shirt = shorten(read(DATA / "garment.ply"), HEM)
    meshes = [body, shirt, trousers]
    write_scan(fuse(meshes), meshes, options.out / "person.ply")


if __name__ == "__main__":
    main()
