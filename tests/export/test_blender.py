"""Files for Blender: panels and threads read back, and the script run in Blender's own module where it is installed."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.blender import sewing_threads, write_blender
from garmentq.core.deliver.export.sewn_mesh import SewnMesh
from garmentq.core.garment.templates import load_draped_template

RUN = """
import json, sys, runpy
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
garment = runpy.run_path(sys.argv[1])["set_up"]()
mesh, cloth = garment.data, garment.modifiers["Cloth"]
faces = {tuple(sorted(key)) for polygon in mesh.polygons for key in polygon.edge_keys}
loose = [tuple(edge.vertices) for edge in mesh.edges if tuple(sorted(edge.vertices)) not in faces]
keys = {block.name: [tuple(point.co) for point in block.data] for block in mesh.shape_keys.key_blocks}
scene = bpy.context.scene
scene.frame_set(1)
for point in garment.data.shape_keys.key_blocks["worn"].data:
    point.co = point.co * 1.05
for frame in range(1, 16):
    scene.frame_set(frame)
moved = garment.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
places = [tuple(vertex.co) for vertex in moved.vertices]
print("FOUND" + json.dumps({
    "faces": len(mesh.polygons), "loose": loose, "keys": keys, "places": places, "mass": cloth.settings.mass,
    "sewing": cloth.settings.use_sewing_springs,
    "world": [list(row) for row in garment.matrix_world],
}))
"""


@pytest.fixture(scope="module")
def mesh() -> SewnMesh:
    """Return a skirt as it hangs on the built-in body."""
    garment = load_draped_template("skirt")
    if garment is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    return SewnMesh("simulation", garment, garment.nodes, get_fabric("denim"))


@pytest.fixture(scope="module")
def written(mesh: SewnMesh, tmp_path_factory) -> list[Path]:
    """Return the files."""
    return write_blender(mesh, builtin_body("builtin:female"), tmp_path_factory.mktemp("blender"), "skirt")


def read_rows(path: Path, word: str) -> np.ndarray:
    """Return the numbers of the lines of an OBJ that begin with a word."""
    rows = [line.split()[1:] for line in path.read_text().splitlines() if line.startswith(word + " ")]
    return np.array([[float(each.split("/")[0]) for each in row] for row in rows])


def test_threads_join_what_seams_join_and_panels_are_flat(mesh: SewnMesh, written: list[Path]) -> None:
    """Fails if a thread joins other vertices, a rest triangle is stretched, or the two meshes differ in order."""
    garment = mesh.garment
    flat, worn = read_rows(written[0], "v"), read_rows(written[1], "v")
    threads = read_rows(written[0], "l").astype(int) - 1
    faces = read_rows(written[0], "f").astype(int) - 1
    assert np.array_equal(faces, read_rows(written[1], "f").astype(int) - 1)
    assert len(read_rows(written[1], "l")) == 0
    assert np.array_equal(threads, sewing_threads(mesh))
    assert np.array_equal(garment.uv_node[threads[:, 0]], garment.uv_node[threads[:, 1]])
    assert np.abs(worn[threads[:, 0]] - worn[threads[:, 1]]).max() < 1e-6
    order = np.argsort(garment.panel_of_face, kind="stable")
    assert np.array_equal(faces, garment.uv_faces[order])
    corners = flat[faces]
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    rest = garment.uv[garment.uv_faces[order]]
    one, two = rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]
    assert areas == pytest.approx(0.5 * np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]), rel=1e-3)
    joined = {frozenset(pair) for pair in threads.tolist()}
    wanted = sum(len(garment.edge_uv[seam.a]) for seam in garment.pattern.seams)
    assert wanted - 2 * len(garment.pattern.seams) <= len(joined) <= wanted


def test_the_script_is_of_this_garment(mesh: SewnMesh, written: list[Path]) -> None:
    """Fails if the script would load another garment's files, or weighs vertices wrongly."""
    scope: dict = {}
    text = written[3].read_text()
    assigned = "\n".join(line for line in text.splitlines() if line.startswith(("STEM =", "VERTEX_MASS =")))
    exec(assigned, scope)
    assert scope["STEM"] == "skirt"
    rest = mesh.garment.rest
    one, two = rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]
    area = 0.5 * np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]).sum()
    assert scope["VERTEX_MASS"] * len(mesh.garment.uv) == pytest.approx(area * mesh.fabric.density)


@pytest.mark.nightly
def test_blender_sews_it(mesh: SewnMesh, written: list[Path], tmp_path: Path) -> None:
    """Fails if Blender loses a thread or a shape key, or cloth that starts 5 % too large does not become as the panels.

    A key that is named as the rest shape does nothing in Blender 5.0: lengths at rest stayed those of the first frame.
    """
    python = os.environ.get("GARMENTQ_BPY_PYTHON")
    if python is None:
        pytest.skip("GARMENTQ_BPY_PYTHON names no Python with the module bpy (an environment of its own, numpy < 2)")
    (tmp_path / "run.py").write_text(RUN)
    command = [python, str(tmp_path / "run.py"), str(written[3])]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout[done.stdout.index("FOUND") + 5 :].splitlines()[0])
    assert found["faces"] == len(mesh.garment.faces)
    threads, garment_faces = sewing_threads(mesh), mesh.garment.uv_faces
    assert {frozenset(pair) for pair in found["loose"]} == {frozenset(pair) for pair in threads.tolist()}
    assert found["sewing"]
    assert np.array(found["keys"]["worn"]) == pytest.approx(mesh.nodes[mesh.garment.uv_node], abs=1e-5)
    turned = np.array(found["world"])[:3, :3]
    assert turned @ [0.0, 1.0, 0.0] == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)  # our y is up in Blender
    places = np.array(found["places"])
    flat = read_rows(written[0], "v")
    sides = np.concatenate([garment_faces[:, [0, 1]], garment_faces[:, [1, 2]]])
    longer = np.linalg.norm(np.diff(places[sides], axis=1), axis=2) / np.linalg.norm(
        np.diff(flat[sides], axis=1), axis=2
    )
    assert np.median(longer) == pytest.approx(1.0, abs=0.015)
    gaps = np.linalg.norm(places[threads[:, 0]] - places[threads[:, 1]], axis=1)
    assert np.quantile(gaps, 0.99) < 5e-3
    assert np.abs(places - mesh.nodes[mesh.garment.uv_node]).max() < 0.1
