"""Own attributes of every GLB that is written, as programs read them that take only some of glTF."""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.animation import write_animation
from garmentq.core.deliver.export.meshes import write_meshes
from garmentq.core.deliver.export.sewn_files import write_sewn_glb
from garmentq.core.deliver.export.sewn_mesh import SewnMesh, seams_of_uv
from garmentq.core.deliver.export.textured import write_textured
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.reuse.animate.animation import Animation, FrameVerdict
from garmentq.core.reuse.wear.worn import WornGarment
from garmentq.core.scan.coloured import to_coloured_scan
from garmentq.core.scan.scan import Scan

IMPORT = """
import json, sys
import bpy
found = {}
for path in sys.argv[1:]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)
    (mesh,) = {each.data for each in bpy.data.objects if each.type == "MESH"}
    own = {each.name: [point.value for point in each.data] for each in mesh.attributes if each.name.startswith("_")}
    found[path] = {"faces": len(mesh.polygons), "own": own}
print("FOUND" + json.dumps(found))
"""

STARTS = range(10)
"""Values of PYTHONHASHSEED: Blender's reader walks sets, whose order changes with it."""


@pytest.fixture(scope="module")
def mesh() -> SewnMesh:
    """Return a T-shirt as it hangs on the built-in body: six panels, corners on two seams."""
    garment = load_draped_template("tshirt")
    if garment is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    return SewnMesh("simulation", garment, garment.nodes, get_fabric("denim"))


@pytest.fixture(scope="module")
def files(mesh: SewnMesh, tmp_path_factory) -> dict[str, Path]:
    """Write a GLB by each of the writers."""
    folder, garment = tmp_path_factory.mktemp("glb"), mesh.garment
    write_sewn_glb(mesh, folder / "simulation.glb")
    write_meshes(garment, garment.nodes, folder, "detail", ("glb",))
    colours = np.full((len(garment.nodes), 3), 0.5)
    scan = to_coloured_scan(Scan(garment.nodes, garment.faces, colours=colours))
    write_textured(replace(mesh, name="detail"), scan, folder, "tshirt", 2.0)
    body = builtin_body("builtin:female,height=1.70")
    worn = WornGarment(garment, mesh.fabric, body, None, None, "tshirt", "tshirt")
    frames = garment.nodes + np.linspace(0.0, 0.1, 3)[:, None, None]
    verdicts = (FrameVerdict(True, 1e-4, 1, 1, 4, 0.5),) * 3
    turned = np.tile(body.transforms, (3, 1, 1, 1))
    write_animation(Animation(worn, 25.0, np.arange(3) / 25.0, frames, turned, verdicts), folder)
    found = {path.name: path for path in folder.glob("*.glb")}
    assert sorted(found) == ["detail.glb", "garment.glb", "simulation.glb", "tshirt_textured.glb"]
    return found


def test_own_attributes_have_one_width(files: dict[str, Path]) -> None:
    """Fails if a GLB has own attributes of several widths or kinds, which Blender 4.5 and 5.0 cannot read."""
    with_some = set()
    for name, path in files.items():
        content = path.read_bytes()
        told = json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])
        own = [
            told["accessors"][index]
            for each in told["meshes"]
            for primitive in each["primitives"]
            for attribute, index in primitive["attributes"].items()
            if attribute.startswith("_")
        ]
        with_some |= {name} if own else set()
        assert len({(each["type"], each["componentType"]) for each in own}) <= 1, name
    assert with_some == {"simulation.glb", "tshirt_textured.glb"}


@pytest.mark.nightly
@pytest.mark.parametrize("start", STARTS)
def test_blender_imports_it_at_every_start(start: int, mesh: SewnMesh, files: dict[str, Path], tmp_path: Path) -> None:
    """Fails if Blender refuses one of the files at some starts, or gives an attribute another one's numbers."""
    python = os.environ.get("GARMENTQ_BPY_PYTHON")
    if python is None:
        pytest.skip("GARMENTQ_BPY_PYTHON names no Python with the module bpy (an environment of its own, numpy < 2)")
    (tmp_path / "run.py").write_text(IMPORT)
    command = [python, str(tmp_path / "run.py"), *map(str, files.values())]
    environment = os.environ | {"PYTHONHASHSEED": str(start)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout[done.stdout.index("FOUND") + 5 :].splitlines()[0])
    garment = mesh.garment
    order = np.argsort(garment.panel_of_uv, kind="stable")
    seams = seams_of_uv(garment)
    wanted = {"_NODE": garment.uv_node, "_PANEL": garment.panel_of_uv, "_SEAM_A": seams[:, 0], "_SEAM_B": seams[:, 1]}
    for name, path in files.items():
        told = found[str(path)]
        assert told["faces"] == len(garment.faces), name
        if name in ("simulation.glb", "tshirt_textured.glb"):
            assert told["own"] == {key: values[order].tolist() for key, values in wanted.items()}, name
