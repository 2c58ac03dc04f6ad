"""Meshes as USD, read back and judged by its own library."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export import sewn_usd
from garmentq.core.deliver.export.sewn_mesh import SewnMesh
from garmentq.core.deliver.export.sewn_usd import UsdMissing, write_sewn_usd, write_usdz
from garmentq.core.garment.templates import load_draped_template
from PIL import Image

pxr = pytest.importorskip("pxr", reason="usd-core is not installed: pip install garmentq[usd]")


@pytest.fixture(scope="module")
def mesh() -> SewnMesh:
    """Return trousers as they hang on the built-in body."""
    garment = load_draped_template("trousers")
    if garment is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    return SewnMesh("simulation", garment, garment.nodes, get_fabric("denim"))


def find_faults(path: Path) -> list[str]:
    """Return what all of USD's validators say of a file."""
    from pxr import Usd, UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 20
    stage = Usd.Stage.Open(str(path))
    return [each.GetErrorAsString() for each in UsdValidation.ValidationContext(validators).Validate(stage)]


def read_flat(cloth, name: str) -> np.ndarray:
    """Return the coordinates of a primvar at each corner of each face, shape [face_count, 3, 2]."""
    from pxr import UsdGeom

    primvar = UsdGeom.PrimvarsAPI(cloth).GetPrimvar(name)
    return np.array(primvar.ComputeFlattened(), dtype=float).reshape(-1, 3, 2)


def areas(flat: np.ndarray) -> np.ndarray:
    """Return signed areas of flat triangles, shape [n, 3, 2]."""
    a, b, c = flat[:, 0], flat[:, 1], flat[:, 2]
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def test_usd_holds_panels_seams_rest_and_fabric(mesh: SewnMesh, tmp_path: Path) -> None:
    """Fails if a face is in no panel's subset, uv are not metres, a seam is missing, or a validator objects."""
    from pxr import Usd, UsdGeom, UsdShade

    path = write_sewn_usd(mesh, tmp_path / "a.usd")
    assert find_faults(path) == []
    stage = Usd.Stage.Open(str(path))
    cloth = UsdGeom.Mesh(stage.GetPrimAtPath("/garment/cloth"))
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0 and UsdGeom.GetStageUpAxis(stage) == "Y"
    assert np.array(cloth.GetPointsAttr().Get()) == pytest.approx(mesh.nodes, abs=1e-6)
    garment = mesh.garment
    rest = areas(read_flat(cloth, "st"))
    subsets = {each.GetPrim().GetName(): each for each in UsdGeom.Subset.GetAllGeomSubsets(cloth)}
    panels = [each for each in subsets.values() if each.GetElementTypeAttr().Get() == "face"]
    held = np.concatenate([np.array(each.GetIndicesAttr().Get()) for each in panels])
    assert sorted(held) == list(range(len(garment.faces)))
    assert UsdGeom.Subset.ValidateFamily(cloth, "face", UsdShade.Tokens.materialBind)[0]
    for index, each in enumerate(panels):
        own = np.array(each.GetIndicesAttr().Get())
        assert (garment.panel_of_face[own] == index).all()
        mine = areas(garment.uv[garment.uv_faces[own]]).sum()
        assert rest[own].sum() == pytest.approx(mine, rel=1e-4)
        material, _ = UsdShade.MaterialBindingAPI(each.GetPrim()).ComputeBoundMaterial()
        assert material.GetPrim().GetName() == f"panel_{index}"
        assert each.GetPrim().GetCustomDataByKey("panel") == garment.pattern.panels[index].name
    seams = [subsets[f"seam_{n}"] for n in range(len(garment.pattern.seams))]
    for seam, each in zip(garment.pattern.seams, seams, strict=True):
        assert set(each.GetIndicesAttr().Get()) == set(garment.uv_node[garment.edge_uv[seam.b]])
    unit = areas(read_flat(cloth, "st1")).sum() * mesh.unit_uv[1] ** 2
    assert unit == pytest.approx(rest.sum(), rel=1e-4)
    prim = cloth.GetPrim()
    assert prim.GetAttribute("garmentq:fabric:H11").Get() == mesh.fabric.H11
    assert json.loads(prim.GetCustomDataByKey("garmentq"))["fabric"]["name"] == "denim"


def test_a_texture_is_on_st_within_one(mesh: SewnMesh, tmp_path: Path) -> None:
    """Fails if the image is not found, or a viewer would lay it on in metres."""
    from pxr import Usd, UsdGeom, UsdShade

    Image.fromarray(np.full((8, 8, 3), 128, np.uint8)).save(tmp_path / "texture.png")
    path = write_sewn_usd(mesh, tmp_path / "a.usd", tmp_path / "texture.png")
    assert find_faults(path) == []
    stage = Usd.Stage.Open(str(path))
    flat = read_flat(UsdGeom.Mesh(stage.GetPrimAtPath("/garment/cloth")), "st")
    assert flat.min() >= 0.0 and flat.max() <= 1.0
    shader = UsdShade.Shader(stage.GetPrimAtPath("/garment/materials/panel_0/texture"))
    assert Path(shader.GetInput("file").Get().resolvedPath).name == "texture.png"


def test_a_package_holds_mesh_and_texture(mesh: SewnMesh, tmp_path: Path) -> None:
    """Fails if a phone gets a mesh without its texture, or other bytes for the same mesh."""
    Image.fromarray(np.full((8, 8, 3), 128, np.uint8)).save(tmp_path / "texture.png")
    usd = write_sewn_usd(mesh, tmp_path / "a.usd", tmp_path / "texture.png")
    first = write_usdz(usd).read_bytes()
    assert find_faults(tmp_path / "a.usdz") == []
    with zipfile.ZipFile(tmp_path / "a.usdz") as package:
        assert {Path(name).suffix for name in package.namelist()} == {".usd", ".png"}
    assert write_usdz(usd).read_bytes() == first


def test_same_mesh_same_bytes(mesh: SewnMesh, tmp_path: Path) -> None:
    """Fails if a file held a time or the order of a set."""
    first = write_sewn_usd(mesh, tmp_path / "a.usd").read_bytes()
    assert write_sewn_usd(mesh, tmp_path / "b.usd").read_bytes() == first


def test_without_the_extra_the_answer_says_what_to_install(mesh: SewnMesh, tmp_path: Path, monkeypatch) -> None:
    """Fails if a missing library is a traceback."""
    monkeypatch.setattr(sewn_usd, "can_write_usd", lambda: False)
    with pytest.raises(UsdMissing, match=r"garmentq\[usd\]") as caught:
        write_sewn_usd(mesh, tmp_path / "a.usd")
    assert caught.value.code == "export.usd_missing"
