"""Make target packs of what `foreign_draft.py` and `foreign_own.py` draft, draped by Blender's cloth.

Nothing of `core.cloth` runs.

    python benchmarks/foreign_drapes.py DRAFTS BODY.ply OUT --blender PYTHON [--only NAME]... [--vertices 4000]

PYTHON is one that has the module `bpy` (development only). A body is dressed in the panels by position-based dynamics,
since Blender's threads lose a shirt's shoulders on the way, and cloth is brought to its lengths (`foreign_start.py`);
from there on Blender's cloth finds where it hangs, sewn by its threads, from the flat panels as rest shape. OUT is a
folder of packs that `garmentq bench OUT --library --json` reads; without `--library` the draft is the base pattern.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from foreign_start import settle
from garmentq.core.body.registration import register_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.blender import sewing_threads
from garmentq.core.deliver.export.sewn_mesh import SewnMesh
from garmentq.core.garment.curves import edge_points
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.garmentcode import load_pattern
from garmentq.core.garment.orientation import place_points
from garmentq.core.garment.pattern import Pattern
from garmentq.core.geometry.geometry import face_areas
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.drape.stage import drape_template, remesh
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.scan.contours.contours import name_contours
from scipy.sparse import csr_matrix

VERTICES = 4000
"""Of a drape: that of the other packs."""

MOST_CROSSING = 0.02
"""Share of faces that may cross others: more is crumpled cloth, which is told and left out. Other packs have 0.5 %."""

UNSOUND = "unsound"
"""Folder of what is left out, to look at: it is no pack, so the bench passes it over."""

SIMULATE = """
import sys
import bpy
import numpy as np

given = np.load(sys.argv[1])
bodies, hang, rest, fabric = given["bodies"], int(given["hang"]), int(given["rest"]), given["fabric"]
FRAMES = hang + int(given["move"]) + rest if len(bodies) > 1 else hang + rest
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def add(name, vertices, faces, edges=()):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices.tolist(), [tuple(edge) for edge in edges], faces.tolist())
    mesh.update()
    made = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(made)
    return made


body = add("body", bodies[0], given["body_faces"])
if len(bodies) > 1:
    body.shape_key_add(name="start", from_mix=False)
    keys = [body.shape_key_add(name=f"pose {n}", from_mix=False) for n in range(1, len(bodies))]
    for key, points in zip(keys, bodies[1:]):
        key.data.foreach_set("co", points.ravel())
    for frame in range(hang, hang + int(given["move"]) + 1):
        # Between two poses the skin goes straight; a key is given at each frame, so no curve is drawn between them.
        at = (frame - hang) / int(given["move"]) * len(keys)
        for n, key in enumerate(keys, 1):
            key.value = max(0.0, 1.0 - abs(at - n))
            key.keyframe_insert("value", frame=frame)
body.modifiers.new("Collision", "COLLISION")
body.collision.thickness_outer = 0.002
body.collision.cloth_friction = 0.5
for layer in range(int(given["layers"])):
    # What is worn below, as it was draped: one key for each frame.
    tracks = given[f"track_{layer}"]
    below = add(f"layer {layer}", tracks[0], given[f"track_faces_{layer}"])
    below.shape_key_add(name="first", from_mix=False)
    for frame, points in enumerate(tracks, 1):
        key = below.shape_key_add(name=f"frame {frame}", from_mix=False)
        key.data.foreach_set("co", points.ravel())
        for near, value in ((frame - 1, 0.0), (frame, 1.0), (frame + 1, 0.0)):
            key.value = value
            key.keyframe_insert("value", frame=near)
    below.modifiers.new("Collision", "COLLISION")
    below.collision.thickness_outer = 0.001
    below.collision.cloth_friction = 0.5
cloth = add("cloth", given["flat"], given["faces"], given["threads"])
cloth.shape_key_add(name="flat", from_mix=False)
worn = cloth.shape_key_add(name="worn", from_mix=False)
worn.data.foreach_set("co", given["nodes"].ravel())
# Of a dynamic mesh the lengths at rest are those that it has now. Between the keys it would be shorter than either: of
# two edges that point apart the mean is short. So one follows the other at once.
for frame, value in ((1, 1.0), (2, 0.0)):
    worn.value = value
    worn.keyframe_insert("value", frame=frame)
held = cloth.vertex_groups.new(name="held")
held.add(given["held"].tolist(), 1.0, "REPLACE")
modifier = cloth.modifiers.new("Cloth", "CLOTH")
settings, touching = modifier.settings, modifier.collision_settings
settings.use_sewing_springs = True
settings.use_dynamic_mesh = True
settings.vertex_group_mass = "held"
settings.mass, stiffness, settings.bending_stiffness = (float(value) for value in fabric)
settings.tension_stiffness = settings.compression_stiffness = stiffness
settings.shear_stiffness = 0.5 * stiffness
settings.air_damping = 5.0
settings.quality = 10
touching.distance_min = 0.003
touching.use_self_collision = True
touching.self_distance_min = 0.001
touching.self_friction = 1.0
touching.collision_quality = 3
scene.frame_end = modifier.point_cache.frame_end = FRAMES
moved = []
for frame in range(1, FRAMES + 1):
    scene.frame_set(frame)
    if given["every"] or frame in (FRAMES - 10, FRAMES):
        mesh = cloth.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        moved.append([tuple(vertex.co) for vertex in mesh.vertices])
np.save(sys.argv[2], np.array(moved))
"""


HANG, MOVE, REST = 25, 25, 45
"""Frames in which cloth falls, is moved with its wearer into the pose, and comes to rest."""


@dataclass(frozen=True)
class Cloth:
    """What Blender's cloth is made of, in its own units.

    Attributes:
        mass: Of a vertex [kg].
        stiffness: Of springs along the edges.
        bending: Of springs across them.
    """

    mass: float = 0.3
    stiffness: float = 160.0
    bending: float = 0.5


def to_blender(points: np.ndarray) -> np.ndarray:
    """Turn y up into z up, shape [..., 3]."""
    return points[..., [0, 2, 1]] * [1.0, -1.0, 1.0]


def from_blender(points: np.ndarray) -> np.ndarray:
    """Turn z up into y up."""
    return points[:, [0, 2, 1]] * [1.0, 1.0, -1.0]


@dataclass(frozen=True)
class Track:
    """A layer of cloth that moves with its wearer: what Blender makes of another garment.

    Attributes:
        frames: Nodes at each frame [m], shape [frame_count, node_count, 3].
        faces: Shape [face_count, 3].
    """

    frames: np.ndarray
    faces: np.ndarray

    @property
    def hung(self) -> np.ndarray:
        """Return the nodes as they hang on the wearer in the first pose [m], shape [node_count, 3]."""
        return self.frames[HANG - 1]

    def begun_at_rest(self) -> np.ndarray:
        """Return the frames [m], those in which the cloth falls replaced by where it hangs then."""
        return np.concatenate([np.repeat(self.hung[None], HANG - 1, axis=0), self.frames[HANG - 1 :]])


def simulate(
    garment: Garment,
    held: np.ndarray,
    poses: Sequence[trimesh.Trimesh],
    python: str,
    cloth: Cloth | None = None,
    worn: Sequence[Track] | None = None,
) -> np.ndarray:
    """Return the cut panels' vertices ten frames before the end and at the end, shape [2, uv_count, 3].

    Args:
        garment: As dressed, in the first pose.
        held: Nodes that stay where they are.
        poses: The wearer's skin on the way from the pose that the garment is dressed in to the one it is scanned in.
        python: One that has Blender's module.
        cloth: What it is made of.
        worn: Layers below it, which it collides with, the innermost first; where given, all frames are returned.
    """
    mesh = SewnMesh("drape", garment, garment.nodes, get_fabric("cotton_poplin"))
    flat = np.zeros((len(garment.uv), 3))
    for index, panel in enumerate(garment.pattern.panels):
        own = garment.panel_of_uv == index
        flat[own] = place_points(panel, garment.uv[own])
    start, threads = garment.nodes[garment.uv_node], sewing_threads(mesh)
    waist = np.flatnonzero(np.isin(garment.uv_node, held))
    anchors = len(start) + np.arange(len(waist))  # vertices that stay: what is pinned itself would follow the shape key
    threads = np.concatenate([threads, np.stack([waist, anchors], axis=1)])
    flat, start = (np.concatenate([points, start[waist]]) for points in (flat, start))
    skins = np.stack([to_blender(np.asarray(pose.vertices)) for pose in poses])
    made_of = cloth or Cloth()
    with tempfile.TemporaryDirectory() as folder:
        given, found, script = (Path(folder) / name for name in ("given.npz", "found.npy", "simulate.py"))
        script.write_text(SIMULATE)
        np.savez(
            given, bodies=skins, body_faces=poses[0].faces, flat=to_blender(flat), nodes=to_blender(start),
            faces=garment.uv_faces, threads=threads, held=anchors, hang=HANG, move=MOVE, rest=REST,
            fabric=[made_of.mass, made_of.stiffness, made_of.bending], layers=len(worn or ()), every=worn is not None,
            **{f"track_{n}": to_blender(track.begun_at_rest()) for n, track in enumerate(worn or ())},
            **{f"track_faces_{n}": track.faces for n, track in enumerate(worn or ())},
        )  # fmt: skip
        subprocess.run([python, str(script), str(given), str(found)], check=True, stdout=subprocess.DEVNULL)
        return np.array([from_blender(points[: len(garment.uv)]) for points in np.load(found)])


def weld(garment: Garment, cut: np.ndarray) -> np.ndarray:
    """Return the nodes at the mean of the panels' vertices that were sewn to them, shape [..., node_count, 3]."""
    sewn = csr_matrix(
        (np.ones(len(garment.uv)), (garment.uv_node, np.arange(len(garment.uv)))), (len(garment.nodes), len(garment.uv))
    )
    share = sewn.multiply(1.0 / sewn.sum(axis=1)).tocsr()
    flat = np.moveaxis(cut, -2, 0).reshape(len(garment.uv), -1)
    return np.moveaxis((share @ flat).reshape(-1, *cut.shape[:-2], 3), 0, -2)


def describe(pattern: Pattern) -> dict[str, object]:
    """Return the outlines of a pattern as packs have them."""
    outlines = {}
    for panel in pattern.panels:
        points = [edge_points(panel, n, 20)[:-1] for n in range(len(panel.edges))]
        outlines[panel.name] = {"outline": np.concatenate(points).round(6).tolist()}
    return {"unit": "m", "panels": outlines}


def make_pack(drafts: Path, wearer: WearerGeometry, out: Path, python: str, vertices: int) -> dict[str, object]:
    """Drape one draft, write its pack, and return what is told of it."""
    design = json.loads((drafts / "design.json").read_text())
    pattern = load_pattern(drafts / "specification.json")
    body = trimesh.Trimesh(wearer.body.vertices, wearer.body.faces, process=False)
    garment = remesh(drape_template(pattern, wearer), vertices)
    contours, _ = name_contours(garment.nodes, garment.faces, wearer.body)
    waists = [contour.vertices for contour in contours if contour.name == "waist"]
    held = np.concatenate([np.zeros(0, np.int64), *waists])
    garment = settle(garment, held, wearer)
    before, after = simulate(garment, held, [body], python)
    nodes = weld(garment, after)
    moved = np.linalg.norm(after - before, axis=1)
    gaps = np.linalg.norm(after - nodes[garment.uv_node], axis=1)
    flat = face_areas(np.pad(garment.uv, ((0, 0), (0, 1))), garment.uv_faces).sum()
    crossing = len(self_intersections(nodes, garment.faces))
    told = {
        "name": drafts.name, "pose": "T", "simulator": "Blender cloth (bpy)", "fabric": None, "units": "m, y up",
        "source": {"kind": "GarmentCode program", "licence": "MIT"}, "licence": "MIT", "panels": len(pattern.panels),
        **design, "is_target": crossing <= MOST_CROSSING * len(garment.faces),
        "area_drape_over_pattern": round(float(face_areas(nodes, garment.faces).sum() / flat), 3),
        "gap_p99_mm": round(1000.0 * float(np.quantile(gaps, 0.99)), 2),
        "motion_p95_mm_last_10_frames": round(1000.0 * float(np.quantile(moved, 0.95)), 2),
        "self_intersecting_faces": crossing,
    }  # fmt: skip
    folder = (out if told["is_target"] else out / UNSOUND) / drafts.name
    folder.mkdir(parents=True, exist_ok=True)
    trimesh.Trimesh(nodes, garment.faces, process=False).export(folder / "garment.ply")
    body.export(folder / "body.ply")
    (folder / "pattern.json").write_text(json.dumps(describe(pattern)))
    (folder / "meta.json").write_text(json.dumps(told, indent=1))
    shutil.copy(drafts / "specification.json", folder / "template.json")
    return told


def main() -> None:
    """Drape all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("drafts", type=Path)
    parser.add_argument("body", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--blender", required=True)
    parser.add_argument("--only", action="append", help="a draft's name; may be repeated")
    parser.add_argument("--vertices", type=int, default=VERTICES, help="of a drape")
    given = parser.parse_args()
    mesh = trimesh.load(given.body, process=False)
    wearer = WearerGeometry(register_body(np.asarray(mesh.vertices), np.asarray(mesh.faces), name="body"))
    for folder in sorted(path.parent for path in given.drafts.glob("*/design.json")):
        if given.only is None or folder.name in given.only:
            print(json.dumps(make_pack(folder, wearer, given.out, given.blender, given.vertices)), flush=True)


if __name__ == "__main__":
    main()
