"""Write a garment as USD, at rest or with a time sample for each frame of a motion; needs the extra `usd`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ...garment.garment import Garment
from .meshes import uv_layout

USD_MISSING_WARNING = "no USD file: `pip install garmentq[usd]` adds it."
"""Warning where the library that writes USD is not installed."""


def can_write_usd() -> bool:
    """Return whether the library that writes USD is installed."""
    return find_spec("pxr") is not None


def write_usd(garment: Garment, frames: np.ndarray, path: Path, fps: float | None = None) -> Path:
    """Write states of a garment as one welded mesh in a binary USD file [m], y up.

    `/garment/cloth` has the points (float32; one time sample a frame, from time code 0, where `fps` is given), faces, a
    subset of the faces for each panel, and `st`: the uv of `uv_layout` for each corner, so that texture is split along
    the seams and the cloth is not. The same input gives the same bytes.

    Args:
        garment: Topology, uv and panels.
        frames: Positions [m], shape [frame_count, node_count, 3].
        path: The file; `.usdc` or `.usd` for binary, `.usda` for text.
        fps: Frames a second [1/s]; None for a garment at rest, of which the first frame is written.

    Raises:
        ImportError: where the extra `usd` is not installed; `can_write_usd` checks it.
    """
    stage, _ = make_stage(garment, frames, fps)
    stage.GetRootLayer().Export(str(path))
    return path


def make_stage(
    garment: Garment, frames: np.ndarray, fps: float | None = None, uv: Mapping[str, np.ndarray] | None = None
) -> tuple[Any, Any]:
    """Return a stage in memory with the mesh that `write_usd` describes, and the mesh.

    Args:
        garment, frames, fps: As there.
        uv: Coordinates of the uv vertices by the name of their primvar, shape [uv_count, 2] each; None: `st` alone.

    Raises:
        ImportError: where the extra `usd` is not installed.
    """
    from pxr import Sdf, Tf, Usd, UsdGeom, Vt

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/garment")
    stage.SetDefaultPrim(root.GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/garment/cloth")
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(garment.faces), 3, dtype=np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(garment.faces.astype(np.int32).ravel()))
    kind = Sdf.ValueTypeNames.TexCoord2fArray
    for name, flat in ({"st": uv_layout(garment)} if uv is None else uv).items():
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(name, kind, UsdGeom.Tokens.faceVarying)
        primvar.Set(Vt.Vec2fArray.FromNumpy(flat.astype(np.float32)))
        primvar.SetIndices(Vt.IntArray.FromNumpy(garment.uv_faces.astype(np.int32).ravel()))
    for index, panel in enumerate(garment.pattern.panels):
        panel_faces = np.flatnonzero(garment.panel_of_face == index)
        # Panel names are the file author's: only plain characters are written, and the number makes them unique.
        name = Tf.MakeValidIdentifier(f"panel_{index}_" + re.sub(r"[^A-Za-z0-9]+", "_", panel.name))
        if len(panel_faces):
            UsdGeom.Subset.CreateGeomSubset(
                mesh, name, UsdGeom.Tokens.face, Vt.IntArray.FromNumpy(panel_faces.astype(np.int32)), "panel"
            )
    points, extent = mesh.CreatePointsAttr(), mesh.CreateExtentAttr()
    if fps is not None:
        stage.SetTimeCodesPerSecond(fps)
        stage.SetFramesPerSecond(fps)
        stage.SetStartTimeCode(0.0)
        stage.SetEndTimeCode(float(len(frames) - 1))
    for n, frame in enumerate(frames if fps is not None else frames[:1]):
        code = Usd.TimeCode(n) if fps is not None else Usd.TimeCode.Default()
        nodes = np.ascontiguousarray(frame, dtype=np.float32)
        points.Set(Vt.Vec3fArray.FromNumpy(nodes), code)
        extent.Set(Vt.Vec3fArray.FromNumpy(np.stack([nodes.min(axis=0), nodes.max(axis=0)])), code)
    return stage, mesh
