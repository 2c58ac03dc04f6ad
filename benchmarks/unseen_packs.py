"""Make what was drawn: drafts, drapes moved into the pose, scans with their faults, and packs of the bench's kinds."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import foreign_newton
import numpy as np
import trimesh
from foreign_body import measure_for_garmentcode
from foreign_drapes import Cloth, Track, describe, simulate, weld
from foreign_own import draw_cut, draw_measures
from foreign_start import settle
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.template import load_template
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.garmentcode import load_pattern
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.templates import draft_template, find_cut
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.people.part import Part
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.core.recover.drape.stage import drape_template, remesh
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.reuse.wear.raised_skin import raise_skin_over
from garmentq.core.scan.contours.contours import name_contours
from garmentq.core.scan.open3d_library import load_open3d
from garmentq.training.accessories import bare_skin, draw_accessories
from garmentq.training.cloth import tuck_under, wave_field
from garmentq.training.colours import paint
from garmentq.training.designs import name_finished, widen_for_layers
from garmentq.training.persons import name_material
from garmentq.training.scanner import Scanner, scan_person
from garmentq.training.shards import Shard
from garmentq.training.wardrobe import Layer, heights_above
from scipy.spatial import cKDTree
from unseen_draw import Draft, Target
from unseen_wearer import draw_wearer, pose_by_steps

VERTICES = 3000
"""Of a drape: edges of 1.7 cm on a T-shirt, as fine as a recovery's."""

MOST_CROSSING = 0.03
"""Share of faces that may cross others: more is crumpled cloth, another seed's work; other packs have 0.5 %."""

SEEN = 0.008
"""A vertex of the true garment is seen where a point of the scan with its label lies within this [m]."""

MEAN_WEARER = "builtin:female"
"""For whom our own base patterns are drafted; GarmentCode's are for its own woman of mean measures."""

PARTS = {"upper": Part.UPPER, "lower": Part.LOWER, "onepiece": Part.ONE_PIECE, "outer": Part.OUTER}


class Unusable(Exception):
    """What was drawn cannot be made: no draft, or cloth that does not come to rest; why is its text."""


@dataclass(frozen=True)
class Tools:
    """Name what is no dependency of the project.

    Attributes:
        blender: Python that has the module `bpy`.
        newton: Python that has Newton, or None.
        garmentcode: Checkout of GarmentCode, or None.
        garmentcode_python: Python that has what GarmentCode asks for.
    """

    blender: str
    newton: str | None = None
    garmentcode: Path | None = None
    garmentcode_python: str = sys.executable


@dataclass(frozen=True)
class Drape:
    """Choose who drapes a garment.

    Attributes:
        solver: `blender` or `newton`.
        cloth: What it is made of.
        tools: Where the solvers are.
    """

    solver: str
    cloth: Cloth
    tools: Tools

    def run(
        self, garment: Garment, held: np.ndarray, skins: Sequence[trimesh.Trimesh], worn: Sequence[Track] = ()
    ) -> np.ndarray:
        """Return a dressed garment's nodes as it comes to rest on the last of some skins [m], the last ones at rest.

        Args:
            garment: As dressed, on the first skin.
            held: Nodes that stay where they are.
            skins: The wearer's, on the way into the pose.
            worn: Layers below it; Blender's cloth collides with them.

        Returns:
            Shape [frame_count, node_count, 3]; Newton's is one frame.
        """
        if self.solver == "blender":
            return weld(garment, simulate(garment, held, skins, self.tools.blender, self.cloth, worn))
        own, usual = self.cloth, Cloth()
        ratios = (own.mass / usual.mass, own.stiffness / usual.stiffness, own.bending / usual.bending)
        assert self.tools.newton is not None
        return foreign_newton.drape(garment, held, skins, self.tools.newton, ratios)[None]


@dataclass(frozen=True)
class Hung:
    """A draft on its wearer in the pose of the scan.

    Attributes:
        draft: What was drawn.
        garment: Its mesh in the pose [m].
        folder: Of the draft: `specification.json` and `design.json`.
        crossing: Faces that cross others, of the garment's own and of layers below it.
        frames: Nodes on the way into the pose [m], shape [frame_count, node_count, 3].
    """

    draft: Draft
    garment: Garment
    folder: Path
    crossing: int
    frames: np.ndarray

    @property
    def track(self) -> Track:
        """Return how the garment moves into the pose."""
        return Track(self.frames, self.garment.faces)


def make_pack(target: Target, out: Path, tools: Tools) -> dict[str, object]:
    """Draft, drape and scan a target, write its pack, and return what is told of it.

    Args:
        target: What was drawn.
        out: Folder of packs.
        tools: Who drafts and drapes.

    Raises:
        Unusable: where it cannot be made.
    """
    rest = draw_wearer(target.seed)
    poses = pose_by_steps(rest, target.pose)
    work = out.parent / "drafts" / target.name
    hung: list[Hung] = []
    for draft, cloth in zip(target.drafts, target.cloth, strict=True):
        folder = draft_garment(draft, rest, work, tools)
        is_tucking = draft.role == "lower"  # a waistband presses a tucked top to the body
        one = hang(draft, folder, poses, Drape(target.solver, cloth, tools), [] if is_tucking else hung)
        hung = [*(tuck(top, one) if is_tucking else top for top in hung), one]
    told = {
        "name": target.name, "pose": target.pose, "simulator": target.solver, "units": "m", "up": "y",
        "licence": "CC0-1.0; drafts of GarmentCode MIT", "drawn": asdict(target),
        "crossing": [one.crossing for one in hung],
    }  # fmt: skip
    folder = out / target.name
    building = out / f".{target.name}"
    shutil.rmtree(building, ignore_errors=True)
    building.mkdir(parents=True)
    (write_person if target.is_person else write_garment)(target, poses[-1], hung, building, told)
    building.rename(folder)
    return told


def draft_garment(draft: Draft, rest: Body, out: Path, tools: Tools) -> Path:
    """Draft a garment for a wearer, and its maker's base pattern, the same design for a woman of mean measures.

    Returns:
        The folder of `specification.json`, `base.json` and `design.json`.

    Raises:
        Unusable: where the program that was drawn does not draft it.
    """
    folder = out / f"{draft.category}_{draft.seed}"
    if (folder / "design.json").exists() and (folder / "base.json").exists():
        return folder
    folder.mkdir(parents=True, exist_ok=True)
    if draft.program == "own":
        rng = np.random.default_rng(draft.seed)
        name = name_finished(draft.category, draft.parts) if draft.parts else draw_cut(draft.category, rng)
        hangs_from_waist = str(find_cut(name).bodice) == "none"
        for body, file in ((rest, "specification.json"), (builtin_body(MEAN_WEARER), "base.json")):
            measures = draw_measures(
                measure_wearer(body), np.random.default_rng(draft.seed), hangs_from_waist=hangs_from_waist
            )
            if draft.role == "outer":
                measures = widen_for_layers(measures, np.random.default_rng(draft.seed))
            save_pattern(draft_template(name, measures), folder / file)
        told = {"category": draft.category, "cut": name, "source": "own parts", "seed": draft.seed}
        (folder / "design.json").write_text(json.dumps(told, indent=1))
        return folder
    body_file = folder / "body.yaml"
    body_file.write_text(json.dumps({"body": measure_for_garmentcode(rest)}, indent=1))  # YAML reads JSON
    _run_garmentcode(draft, out, tools, "--body", str(body_file))
    _run_garmentcode(draft, out / "base", tools)
    shutil.copy(out / "base" / folder.name / "specification.json", folder / "base.json")
    return folder


def _run_garmentcode(draft: Draft, out: Path, tools: Tools, *options: str) -> None:
    script = Path(__file__).with_name("foreign_draft.py")
    line = [tools.garmentcode_python, script, tools.garmentcode, out, "--seed", draft.seed, "--draft", draft.category]
    line += ["--parts", draft.parts] if draft.parts else []
    environment = {"PYTHONPATH": str(tools.garmentcode), "PATH": "/usr/bin:/bin"}
    ran = subprocess.run([*map(str, line), *options], env=environment, capture_output=True, text=True, check=False)
    if ran.returncode:
        raise Unusable(f"GarmentCode does not draft {draft.category}: {''.join(ran.stderr.strip().splitlines()[-1:])}")


def raise_over(poses: tuple[Body, ...], worn: list[Hung]) -> tuple[Body, ...]:
    """Return the wearer's poses with the skin raised by what is worn already, as it lies in the last one."""
    heights = np.zeros(len(poses[-1].vertices))
    for one in worn:
        heights = np.maximum(heights, heights_above(poses[-1], (one.garment.nodes, one.garment.faces)))
    return tuple(pose.raised(heights) for pose in poses) if worn else poses


def hang(draft: Draft, folder: Path, poses: tuple[Body, ...], drape: Drape, worn: Sequence[Hung] = ()) -> Hung:
    """Drape a draft on a wearer in T-pose and move both into the pose.

    Args:
        draft: What was drawn.
        folder: Of the draft.
        poses: The wearer's, from the T-pose on.
        drape: Who drapes it.
        worn: What lies below it, the innermost first. Newton drapes over the skin raised by it, Blender over its cloth.

    Raises:
        Unusable: where it crumples, a limb slips out of it, or it crosses what is worn below it.
    """
    tracks = [one.track for one in worn] if drape.solver == "blender" else []
    poses = poses if tracks else raise_over(poses, list(worn))
    below = WearerGeometry(poses[0])
    for one, track in zip(worn, tracks, strict=False):
        below = raise_skin_over(below, one.garment.at(track.hung))
    garment, held = dress(load_pattern(folder / "specification.json"), below)
    frames = drape.run(
        garment, held, [trimesh.Trimesh(pose.vertices, pose.faces, process=False) for pose in poses], tracks
    )
    nodes = frames[-1]
    crossing = count_crossing(nodes, garment.faces, worn)
    if not np.isfinite(nodes).all() or crossing > MOST_CROSSING * len(garment.faces):
        raise Unusable(f"{folder.name} crumples: {crossing} of {len(garment.faces)} faces cross others")
    require_worn((garment.nodes, poses[0]), (nodes, poses[-1]), garment.faces)
    return Hung(draft, garment.at(nodes), folder, crossing, frames)


def count_crossing(nodes: np.ndarray, faces: np.ndarray, worn: Sequence[Hung]) -> int:
    """Return the number of a garment's faces that cross its own or those of layers below it."""
    meshes = [(nodes, faces), *((one.garment.nodes, one.garment.faces) for one in worn)]
    starts = np.cumsum([0, *(len(points) for points, _ in meshes)])
    joined = np.concatenate([one[1] + start for one, start in zip(meshes, starts, strict=False)])
    crossed = self_intersections(np.concatenate([points for points, _ in meshes]), joined)
    return int((crossed < len(faces)).sum())


def tuck(top: Hung, lower: Hung) -> Hung:
    """Return a top below the lower garment that it is tucked into, in each frame."""
    frames = np.stack(
        [
            tuck_under((nodes, top.garment.faces), (over, lower.garment.faces))[0]
            for nodes, over in zip(top.frames, lower.frames, strict=True)
        ]
    )
    return replace(top, garment=top.garment.at(frames[-1]), frames=frames)


def require_worn(before: tuple[np.ndarray, Body], after: tuple[np.ndarray, Body], faces: np.ndarray) -> None:
    """Check that a garment goes round the limbs that it was put on.

    Args:
        before: Nodes as dressed [m] and the wearer.
        after: Nodes in the pose [m] and the wearer in it.
        faces: Of the garment.

    Raises:
        Unusable: where an end of it goes round another part of the body, or none.
    """
    names = [sorted(one.name for one in name_contours(nodes, faces, body)[0]) for nodes, body in (before, after)]
    if names[0] != names[1]:
        raise Unusable(f"it was put on as {', '.join(names[0])} and hangs as {', '.join(names[1])}")


def dress(pattern: Pattern, wearer: WearerGeometry) -> tuple[Garment, np.ndarray]:
    """Return a garment at the lengths of its panels on the T-pose, and the nodes of the waist by which it hangs."""
    garment = remesh(drape_template(pattern, wearer), VERTICES)
    contours, _ = name_contours(garment.nodes, garment.faces, wearer.body)
    waists = [contour.vertices for contour in contours if contour.name == "waist"]
    held = np.concatenate([np.zeros(0, np.int64), *waists])
    return settle(garment, held, wearer), held


def write_garment(target: Target, body: Body, hung: list[Hung], folder: Path, told: dict[str, object]) -> None:
    """Write a garment's scan with noise and holes, its wearer, and the drape as it hangs."""
    one, rng = hung[0], np.random.default_rng([target.seed, 1])
    points, faces = one.garment.nodes, one.garment.faces
    normals = vertex_normals(points, faces)
    white, smooth = rng.normal(size=len(points)), wave_field(points, (0.01, 0.04), rng)
    scanned = points + target.noise * np.sqrt(0.5) * (white + smooth)[:, None] * normals
    gone = np.zeros(len(points), bool)
    for radius in target.holes:
        gone |= np.linalg.norm(points - points[rng.integers(len(points))], axis=1) < radius
    scan = trimesh.Trimesh(scanned, faces[~gone[faces].any(axis=1)], process=False)
    scan = max(scan.split(only_watertight=False), key=lambda part: len(part.faces))
    scan.export(folder / "garment.ply")
    trimesh.Trimesh(points, faces, process=False).export(folder / "truth.ply")
    trimesh.Trimesh(body.vertices, body.faces, process=False).export(folder / "body.ply")
    _write_pattern(one, folder / "pattern.json", folder / "template.json")
    (folder / "meta.json").write_text(json.dumps({"category": one.draft.category, **told}, indent=1))


def _write_pattern(one: Hung, outlines: Path, base: Path) -> None:
    outlines.write_text(json.dumps(describe(load_pattern(one.folder / "specification.json"))))
    shutil.copy(one.folder / "base.json", base)
    shutil.copy(
        one.folder / "specification.json", outlines.with_name(outlines.stem.replace("pattern", "drafted") + ".json")
    )


def write_person(target: Target, body: Body, hung: list[Hung], folder: Path, told: dict[str, object]) -> None:
    """Write a person's scan without labels, and the truth beside it."""
    rng = np.random.default_rng([target.seed, 2])
    meshes = {one.draft.role: (one.garment.nodes, one.garment.faces) for one in hung}
    worn = list(meshes)
    for outer in range(len(worn) - 1, 0, -1):
        for inner in range(outer):
            meshes[worn[inner]] = tuck_under(meshes[worn[inner]], meshes[worn[outer]])
    layers = [Layer(PARTS[role], mesh) for role, mesh in meshes.items()]
    layers += [each for each in draw_accessories(load_template(), body, layers, rng) if each.part is not Part.OTHER]
    layers.append(Layer(Part.SKIN, bare_skin(body, layers), is_cloth=False))
    scanner = Scanner(
        kind=str(rng.choice(["cloud", "fused"], p=[0.2, 0.8])), noise=target.noise, bumps=float(rng.uniform(0, 2e-3)),
        holes=target.holes, soles=bool(rng.random() < 0.5), depth=9, snap=float(rng.uniform(0.5, 1.0)), faces=60000,
        thinning=0.2, floor=False,
    )  # fmt: skip
    shard = scan_person(layers, body, scanner, rng)
    materials = [name_material(layer) for layer in layers]
    about = {"seed": target.seed, "scan": 0, "materials": materials, "scanner": asdict(scanner)}
    shard = replace(shard, about=about)
    truth = folder / "truth"
    truth.mkdir()
    _write_scan(shard, folder / "scan.ply")
    np.savez_compressed(truth / "labels.npz", label=shard.label)
    trimesh.Trimesh(body.vertices, body.faces, process=False).export(truth / "body.ply")
    np.savez_compressed(truth / "body_cover.npz", cover=_cover(body, layers))
    for one in hung:
        mesh, part = one.garment, PARTS[one.draft.role]
        trimesh.Trimesh(mesh.nodes, mesh.faces, process=False).export(truth / f"garment_{one.draft.role}.ply")
        near = cKDTree(shard.points[shard.label == part]).query(mesh.nodes)[0]
        np.savez_compressed(truth / f"garment_{one.draft.role}_aux.npz", visible=near < SEEN)
        _write_pattern(one, truth / f"pattern_{one.draft.role}.json", truth / f"base_{one.draft.role}.json")
    garments = [{"role": one.draft.role, "category": one.draft.category, "parts": one.draft.parts} for one in hung]
    (truth / "garments.json").write_text(json.dumps(garments, indent=1))
    told |= {"kind": "raw scan", "scan_to_truth": np.eye(4).tolist(), "scanner": asdict(scanner)}
    (folder / "meta.json").write_text(json.dumps(told, indent=1))


def _write_scan(shard: Shard, path: Path) -> None:
    """Write a surface or a cloud, with colours where the scanner gave them."""
    rgb = paint(shard)
    colours = None if rgb is None else (255 * rgb).round().astype(np.uint8)
    if len(shard.faces):
        trimesh.Trimesh(shard.points, shard.faces, vertex_colors=colours, process=False).export(path)
        return
    open3d = load_open3d()
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(shard.points))
    cloud.normals = open3d.utility.Vector3dVector(shard.normals)
    if rgb is not None:
        cloud.colors = open3d.utility.Vector3dVector(rgb)
    open3d.io.write_point_cloud(str(path), cloud)


def _cover(body: Body, layers: list[Layer]) -> np.ndarray:
    """Return which part lies over each vertex of the body, 0 where it is bare; garments before hair and shoes."""
    cover = np.zeros(len(body.vertices), np.uint8)
    for layer in reversed(layers):
        if layer.part is not Part.SKIN:
            cover[heights_above(body, layer.mesh) > 0.0] = layer.part.value
    return cover
