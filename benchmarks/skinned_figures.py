"""Find the wearers of clothed figures that others modelled, and what they wear.

OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/skinned_figures.py DIR [--whole]

DIR holds skinned GLB files without compression (`gltf-transform` writes them from others), whose skeletons have the
names of Mixamo's. Each figure is posed twice, with arms stretched out as it was modelled and with arms down and a leg
ahead; what no scanner around it would see is left out (`--whole` leaves it in); colours are its textures'. One line for
each: the largest distance [mm] of a knee, an ankle, an elbow and a wrist of the fitted body from the skeleton's, as the
body is first found and as it is fitted below what is told to be cloth; then what it wears, or a code.
"""

from __future__ import annotations

import argparse
import io
import json
import struct
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import trimesh
from garmentq.cli.bench.raw_file import RawFile, write_raw_file
from garmentq.core.body.body import Body
from garmentq.core.body.person import fit_person
from garmentq.core.people.colour import link_alike
from garmentq.core.people.diffusion import link_points
from garmentq.core.people.points import sample_person
from garmentq.core.people.separate import fit_below_clothes, label_person
from garmentq.core.run.errors import GarmentqError
from garmentq.core.scan.load_raw import load_raw
from garmentq.core.scan.open3d_library import load_open3d
from PIL import Image
from trimesh.transformations import quaternion_matrix, rotation_matrix

NAMES = {"knee": "Leg", "ankle": "Foot", "elbow": "ForeArm", "wrist": "Hand"}
"""The skeleton's names of our joints, without their side."""
SIDES = ("Left", "Right")
TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32, 5120: np.int8, 5122: np.int16}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
INNER = ("gland", "teeth")
"""Parts of a head that no scanner sees."""


class Figure:
    """A skinned GLB file."""

    def __init__(self, path: Path) -> None:
        """Read the file."""
        data = path.read_bytes()
        length = struct.unpack("<I", data[12:16])[0]
        self.tree: dict[str, Any] = json.loads(data[20 : 20 + length])
        self.binary = data[28 + length :]
        self.nodes = self.tree["nodes"]
        self.parents = {child: i for i, node in enumerate(self.nodes) for child in node.get("children", [])}
        self.index = {node.get("name"): i for i, node in enumerate(self.nodes)}
        self.turns: dict[int, np.ndarray] = {}

    def read(self, accessor: int) -> np.ndarray:
        """Return the values of an accessor, shape [count, width]."""
        entry = self.tree["accessors"][accessor]
        view = self.tree["bufferViews"][entry["bufferView"]]
        width, kind = WIDTHS[entry["type"]], TYPES[entry["componentType"]]
        size = width * np.dtype(kind).itemsize
        held = np.frombuffer(self.binary, np.uint8, offset=view.get("byteOffset", 0) + entry.get("byteOffset", 0))
        raw = np.lib.stride_tricks.as_strided(held, (entry["count"], size), (view.get("byteStride", size), 1))
        values = np.ascontiguousarray(raw).view(kind).reshape(entry["count"], width).astype(np.float64)
        return values / np.iinfo(kind).max if entry.get("normalized") else values

    def texture(self, material: int) -> np.ndarray:
        """Return the colours of a material, uint8, shape [height, width, 3]."""
        chosen = self.tree["materials"][material]["pbrMetallicRoughness"]["baseColorTexture"]["index"]
        entry = self.tree["textures"][chosen]
        source = entry.get("source", entry.get("extensions", {}).get("EXT_texture_webp", {}).get("source"))
        view = self.tree["bufferViews"][self.tree["images"][source]["bufferView"]]
        start = view.get("byteOffset", 0)
        return np.asarray(Image.open(io.BytesIO(self.binary[start : start + view["byteLength"]])).convert("RGB"))

    def place(self, node: int) -> np.ndarray:
        """Return where a node stands, shape [4, 4]."""
        entry = self.nodes[node]
        x, y, z, w = entry.get("rotation", (0.0, 0.0, 0.0, 1.0))
        local = quaternion_matrix([w, x, y, z])
        local[:3, :3] *= np.array(entry.get("scale", (1.0, 1.0, 1.0)))
        local[:3, 3] = entry.get("translation", (0.0, 0.0, 0.0))
        local = local @ self.turns.get(node, np.eye(4))
        return self.place(self.parents[node]) @ local if node in self.parents else local

    def turn(self, name: str, axis: tuple[float, float, float], degrees: float) -> None:
        """Turn a joint about an axis of the world."""
        node = self.index[name]
        axes = self.place(node)[:3, :3]
        axes = axes / np.linalg.norm(axes, axis=0)
        turned = np.eye(4)
        turned[:3, :3] = axes.T @ rotation_matrix(np.radians(degrees), axis)[:3, :3] @ axes
        self.turns[node] = self.turns.get(node, np.eye(4)) @ turned

    def surface(self) -> trimesh.Trimesh:
        """Return the figure as it is posed, each triangle divided in four, with colours."""
        parts = []
        for node in self.nodes:
            mesh = self.tree["meshes"][node["mesh"]] if "mesh" in node else None
            if mesh is None or any(word in mesh["name"].lower() for word in INNER):
                continue
            skin = self.tree["skins"][node["skin"]]
            inverse = self.read(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
            moved = np.stack([self.place(joint) for joint in skin["joints"]]) @ inverse
            parts += [self._primitive(primitive, moved) for primitive in mesh["primitives"]]
        return trimesh.util.concatenate(parts)

    def _primitive(self, primitive: dict[str, Any], moved: np.ndarray) -> trimesh.Trimesh:
        named = {name: self.read(accessor) for name, accessor in primitive["attributes"].items()}
        weights = named["WEIGHTS_0"] / named["WEIGHTS_0"].sum(axis=1, keepdims=True)
        blend = np.einsum("vk,vkab->vab", weights, moved[named["JOINTS_0"].astype(np.int64)])
        points = np.einsum("vab,vb->va", blend, np.c_[named["POSITION"], np.ones(len(blend))])[:, :3]
        faces = self.read(primitive["indices"]).astype(np.int64).reshape(-1, 3)
        finer, faces = trimesh.remesh.subdivide(np.c_[points, named["TEXCOORD_0"]], faces)
        image = self.texture(primitive["material"])
        size = np.array(image.shape[1::-1])
        column, row = np.clip((finer[:, 3:] % 1.0 * size).astype(np.int64), 0, size - 1).T
        return trimesh.Trimesh(finer[:, :3], faces, vertex_colors=image[row, column], process=False)


def keep_seen(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return the faces that are seen from one of 96 directions, from 20 degrees below to 55 above."""
    open3d = load_open3d()
    scene = open3d.t.geometry.RaycastingScene(nthreads=1)
    corners, faces = mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)
    scene.add_triangles(open3d.core.Tensor(corners), open3d.core.Tensor(faces))
    normals, seen = np.asarray(mesh.vertex_normals), np.zeros(len(mesh.vertices), bool)
    start = mesh.vertices + 0.002 * normals
    for rise in np.radians([-20, 0, 25, 55]):
        for turn in np.radians(np.arange(0, 360, 15)):
            way = np.array([np.cos(rise) * np.sin(turn), np.sin(rise), np.cos(rise) * np.cos(turn)])
            asked = np.flatnonzero(~seen & (normals @ way > 0.1))
            rays = np.c_[start[asked], np.tile(way, (len(asked), 1))].astype(np.float32)
            seen[asked] = ~scene.test_occlusions(open3d.core.Tensor(rays), nthreads=1).numpy()
    kept = mesh.copy()
    kept.update_faces(seen[mesh.faces].all(axis=1))
    kept.remove_unreferenced_vertices()
    return kept


def stretch_out(figure: Figure) -> None:
    """Leave the figure as it was modelled."""


def stand(figure: Figure) -> None:
    """Put arms down, forearms a little ahead, and one leg before the other."""
    for side in SIDES:
        sign = float(np.sign(figure.place(figure.index[f"{side}Arm"])[0, 3]))
        figure.turn(f"{side}Shoulder", (0.0, 0.0, 1.0), -8.0 * sign)
        figure.turn(f"{side}Arm", (0.0, 0.0, 1.0), -58.0 * sign)
        figure.turn(f"{side}ForeArm", (1.0, 0.0, 0.0), -22.0)
        figure.turn(f"{side}UpLeg", (1.0, 0.0, 0.0), -9.0 * sign)


POSES: dict[str, Callable[[Figure], None]] = {"stretched out": stretch_out, "standing": stand}


def compare(body: Body, figure: Figure) -> str:
    """Return the larger distance of the two sides' knees, ankles, elbows and wrists [mm]."""
    found = []
    for ours, theirs in NAMES.items():
        far = [
            np.linalg.norm(body.joint(f"{side.lower()}_{ours}") - figure.place(figure.index[side + theirs])[:3, 3])
            for side in SIDES
        ]
        found.append(f"{1e3 * max(far):.0f}")
    return " / ".join(found)


def run(path: Path, pose: str, whole: bool) -> str:
    """Return what is found of one figure in one pose."""
    figure = Figure(path)
    POSES[pose](figure)
    mesh = figure.surface() if whole else keep_seen(figure.surface())
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"{path.stem}.ply"
        colours = np.asarray(mesh.visual.vertex_colors)[:, :3]
        write_raw_file(RawFile(np.asarray(mesh.vertices), np.asarray(mesh.faces), None, colours), file)
        raw = load_raw(file)
    try:
        first = fit_person(raw.points, raw.normals, raw.is_oriented)
        points = sample_person(raw, first)
        links = link_alike(link_points(points.positions, points.normals), points.lab)
        below = fit_below_clothes(first, points, links)
        found = label_person(raw)
    except GarmentqError as error:
        return error.code
    worn = ", ".join(f"{garment.part.word} ({garment.category or '?'})" for garment in found.garments)
    code = "" if found.problem is None else f" {found.problem.code}"
    return f"{compare(first.body, figure)} | {compare(below.body, figure)} | {worn}{code}"


def main() -> None:
    """Run all figures of a folder."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path, help="folder of skinned GLB files")
    parser.add_argument("--whole", action="store_true", help="keep what no scanner would see")
    options = parser.parse_args()
    for path in sorted(options.folder.glob("*.glb")):
        for pose in POSES:
            print(f"{path.stem} | {pose} | {run(path, pose, options.whole)}", flush=True)


if __name__ == "__main__":
    main()
