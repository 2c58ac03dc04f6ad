"""Every shipped garment in every format for other programs, read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.blender import write_blender
from garmentq.core.deliver.export.sewn_files import write_sewn_glb, write_sewn_obj
from garmentq.core.deliver.export.sewn_mesh import SewnMesh
from garmentq.core.deliver.export.sewn_usd import write_sewn_usd
from garmentq.core.deliver.export.textured import write_textured
from garmentq.core.garment.templates import list_templates, load_draped_template
from garmentq.core.scan.coloured import ColouredScan
from gltf_validator import find_validator, validate_glb

pytestmark = pytest.mark.nightly
NAMES = [info.name for info in list_templates()]


def flat_area(flat: np.ndarray) -> float:
    """Return the area of flat triangles, shape [n, 3, 2]; turned ones count as negative."""
    one, two = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    return float(0.5 * (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]).sum())


@pytest.mark.parametrize("name", NAMES)
def test_every_template_in_every_format(name: str, tmp_path: Path) -> None:
    """Fails if a category of garment breaks a writer: uv areas to 1e-4, panel ids on all faces, no fault found."""
    pytest.importorskip("pxr", reason="usd-core is not installed: pip install garmentq[usd]")
    from pxr import Usd, UsdGeom, UsdValidation

    garment = load_draped_template(name)
    if garment is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    mesh = SewnMesh("simulation", garment, garment.nodes, get_fabric("denim"))
    area = flat_area(garment.rest)
    glb = write_sewn_glb(mesh, tmp_path / "a.glb")
    parts = list(trimesh.load_scene(glb, process=False).geometry.values())
    assert sum(flat_area(part.visual.uv[part.faces]) for part in parts) == pytest.approx(area, rel=1e-4)
    panels = [part.vertex_attributes["_PANEL"] for part in parts]
    assert [set(np.unique(each)) for each in panels] == [{n} for n in range(len(garment.pattern.panels))]
    obj = write_sewn_obj(mesh, tmp_path / "a.obj")[0]
    groups = trimesh.load_scene(obj, process=False, group_material=False, split_object=False).geometry.values()
    assert sum(flat_area(part.visual.uv[part.faces]) for part in groups) == pytest.approx(area, rel=1e-4)
    stage = Usd.Stage.Open(str(write_sewn_usd(mesh, tmp_path / "a.usd")))
    cloth = UsdGeom.Mesh(stage.GetPrimAtPath("/garment/cloth"))
    flat = np.array(UsdGeom.PrimvarsAPI(cloth).GetPrimvar("st").ComputeFlattened(), float).reshape(-1, 3, 2)
    assert flat_area(flat) == pytest.approx(area, rel=1e-4)
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert not UsdValidation.ValidationContext(validators).Validate(stage)
    assert len(write_blender(mesh, builtin_body("builtin:female"), tmp_path, "a")) == 4
    colours = np.tile(np.array([[200, 100, 50]], np.uint8), (len(garment.nodes), 1))
    count = len(garment.faces)
    scan = ColouredScan(garment.nodes, garment.faces, colours, np.zeros((count, 3, 2)), np.full(count, -1))
    written = write_textured(mesh, scan, tmp_path, "a", 2.0)
    assert written.coverage > 0.98
    if find_validator() is not None:
        for path in (glb, tmp_path / "a_textured.glb"):
            found = validate_glb(path)
            assert (found["numErrors"], found["numWarnings"]) == (0, 0), found["messages"]
