"""Write a garment's mesh as USD with its flat rest shape, panels, seams, fabric and, if there is one, its texture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ...run.errors import BadInput
from .sewn_mesh import FABRIC_UNITS, SewnMesh, describe_cloth, panel_colour, sanitise_names
from .usd_mesh import can_write_usd, make_stage


class UsdMissing(BadInput):
    """USD is written by the extra `usd`, which is not installed; `pip install garmentq[usd]` adds it."""

    code = "export.usd_missing"


def write_usdz(usd: Path) -> Path:
    """Pack a USD file with its texture into one `.usdz` beside it, and return that.

    Raises:
        UsdMissing: where the extra `usd` is not installed.
    """
    if not can_write_usd():
        raise UsdMissing()
    from pxr import UsdUtils

    path = usd.with_suffix(".usdz")
    UsdUtils.CreateNewUsdzPackage(str(usd), str(path))
    return path


def write_sewn_usd(mesh: SewnMesh, path: Path, image: Path | None = None) -> Path:
    """Write a binary USD file of one welded mesh [m], y up.

    `/garment/cloth` has `st`, the flat position [m] of each corner, `st1`, the same panels within 0..1, a subset of the
    faces and a material for each panel, a subset of the points for each seam, attributes `garmentq:fabric:*`, and in
    `customData` under `garmentq` the JSON of `describe_cloth`. With a texture `st`, which every program reads, is
    within 0..1, and `st1` in metres; the friction of the cloth is that of UsdPhysics' material.

    Args:
        mesh: The mesh.
        path: The file, `.usd` or `.usdc`.
        image: A texture in the folder of `path`, for `st` within 0..1; None: a plain colour for each panel.

    Raises:
        UsdMissing: where the extra `usd` is not installed.
    """
    if not can_write_usd():
        raise UsdMissing()
    from pxr import Sdf, UsdGeom, UsdPhysics, UsdShade, Vt

    garment, unit = mesh.garment, mesh.unit_uv[0]
    uv = {"st": mesh.metre_uv, "st1": unit} if image is None else {"st": unit, "st1": mesh.metre_uv}
    stage, cloth = make_stage(garment, mesh.nodes[None], uv=uv)
    names = sanitise_names([panel.name for panel in garment.pattern.panels])
    UsdGeom.Scope.Define(stage, "/garment/materials")
    subsets = {int(subset.GetPrim().GetName().split("_")[1]): subset for subset in UsdGeom.Subset.GetGeomSubsets(cloth)}
    for index, subset in subsets.items():
        subset.GetFamilyNameAttr().Set(UsdShade.Tokens.materialBind)
        material = _make_material(stage, f"panel_{index}", panel_colour(index, len(names)), image)
        friction = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
        friction.CreateStaticFrictionAttr(mesh.fabric.friction)
        friction.CreateDynamicFrictionAttr(mesh.fabric.friction)
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
        subset.GetPrim().SetCustomDataByKey("panel", garment.pattern.panels[index].name)
    UsdGeom.Subset.SetFamilyType(cloth, UsdShade.Tokens.materialBind, UsdGeom.Tokens.partition)
    for index, seam in enumerate(garment.pattern.seams):
        nodes = garment.uv_node[garment.edge_uv[seam.a]].astype(np.int32)
        UsdGeom.Subset.CreateGeomSubset(
            cloth, f"seam_{index}", UsdGeom.Tokens.point, Vt.IntArray.FromNumpy(np.unique(nodes)), "seam"
        )
    UsdGeom.Subset.SetFamilyType(cloth, "seam", UsdGeom.Tokens.unrestricted)
    prim = cloth.GetPrim()
    for name in FABRIC_UNITS:
        attribute = prim.CreateAttribute(f"garmentq:fabric:{name}", Sdf.ValueTypeNames.Double, custom=True)
        attribute.Set(float(getattr(mesh.fabric, name)))
        attribute.SetCustomDataByKey("unit", FABRIC_UNITS[name])
    prim.SetCustomDataByKey("garmentq", json.dumps(describe_cloth(mesh, image is not None), ensure_ascii=True))
    stage.GetRootLayer().Export(str(path))
    return path


def _make_material(stage: Any, name: str, colour: list[float], image: Path | None) -> Any:
    """Add a material of a plain colour, or of an image beside the file."""
    from pxr import Gf, Sdf, UsdShade

    place = f"/garment/materials/{name}"
    material = UsdShade.Material.Define(stage, place)
    shader = UsdShade.Shader.Define(stage, f"{place}/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.9)
    shader.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(0.0)
    diffuse = shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    if image is None:
        diffuse.Set(Gf.Vec3f(*colour))
    else:
        reader = UsdShade.Shader.Define(stage, f"{place}/uv")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
        texture = UsdShade.Shader.Define(stage, f"{place}/texture")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(f"./{image.name}"))
        texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("sRGB")
        flat = reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(flat)
        diffuse.ConnectToSource(texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3))
    material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", Sdf.ValueTypeNames.Token))
    return material
