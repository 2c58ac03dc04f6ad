"""Files of an animation: read back by readers that share no code with the writers."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.animation import write_animation
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.reuse.animate.animate_garment import AnimatedGarment
from garmentq.core.reuse.animate.animation import Animation, FrameVerdict
from garmentq.core.reuse.wear.worn import WornGarment
from garmentq.core.run.report import ResultReport
from PIL import Image

FRAMES = 5


@pytest.fixture(scope="module")
def animation() -> Animation:
    """Return a skirt that is moved aside and waves, without a simulation."""
    garment, body = load_draped_template("skirt"), builtin_body("builtin:female,height=1.70")
    worn = WornGarment(garment, get_fabric("cotton_poplin"), body, None, None, "skirt", "skirt")
    share = np.linspace(0.0, 1.0, FRAMES)[:, None, None]
    wave = 0.02 * np.sin(20.0 * garment.nodes[:, [1, 2, 0]])
    frames = garment.nodes + share * (wave + [0.1, 0.0, 0.05])
    verdicts = tuple(FrameVerdict(True, 1e-4 * n, n, 1, 4, 0.5) for n in range(FRAMES))
    transforms = np.tile(body.transforms, (FRAMES, 1, 1, 1))
    return Animation(worn, 25.0, np.arange(FRAMES) / 25.0, frames, transforms, verdicts)


@pytest.fixture(scope="module")
def folder(animation, tmp_path_factory):
    """Return the folder of the written files."""
    folder = tmp_path_factory.mktemp("animation")
    files = write_animation(animation, folder)
    assert sorted(path.name for path in files) == sorted(path.name for path in folder.iterdir())
    return folder


def test_pc2_holds_every_frame(animation, folder):
    """Broken where the header or the order of frames, points and axes is another than players expect."""
    content = (folder / "garment.pc2").read_bytes()
    magic, version, points, start, rate, samples = struct.unpack_from("<12siiffi", content)
    assert (magic, version, start, rate, samples) == (b"POINTCACHE2\0", 1, 0.0, 1.0, FRAMES)
    read = np.frombuffer(content, "<f4", offset=32).reshape(samples, points, 3)
    np.testing.assert_array_equal(read, animation.frames.astype(np.float32))


def test_mdd_holds_every_frame_and_its_time(animation, folder):
    """Broken where it is not big endian, or the times are frames and not seconds."""
    content = (folder / "garment.mdd").read_bytes()
    frames, points = struct.unpack_from(">ii", content)
    times = np.frombuffer(content, ">f4", count=frames, offset=8)
    np.testing.assert_allclose(times, np.arange(FRAMES) / 25.0, rtol=1e-6)
    read = np.frombuffer(content, ">f4", offset=8 + 4 * frames).reshape(frames, points, 3)
    np.testing.assert_array_equal(read, animation.frames.astype(np.float32))


def test_the_mesh_has_the_caches_order(animation, folder):
    """Broken where the mesh that a cache is played on is reordered or merged."""
    mesh = trimesh.load(folder / "garment.ply", process=False)
    np.testing.assert_array_equal(mesh.vertices, animation.frames[0])


def test_morphs_give_every_frame(animation, folder):
    """Broken where trimesh refuses the file, a target is another frame's, or a weight does not pick it at its time."""
    content = (folder / "garment.glb").read_bytes()
    mesh = next(iter(trimesh.load(folder / "garment.glb", process=False).geometry.values()))
    split = animation.worn.garment.uv_node
    np.testing.assert_allclose(mesh.vertices, animation.frames[0][split], atol=1e-6)
    length = struct.unpack_from("<I", content, 12)[0]
    scene, binary = json.loads(content[20 : 20 + length]), content[28 + length :]

    def read(index):
        accessor = scene["accessors"][index]
        view = scene["bufferViews"][accessor["bufferView"]]
        values = np.frombuffer(binary, "<f4", offset=view["byteOffset"], count=view["byteLength"] // 4)
        return values.reshape(accessor["count"], -1)

    targets = [read(target["POSITION"]) for target in scene["meshes"][0]["primitives"][0]["targets"]]
    sampler = scene["animations"][0]["samplers"][0]
    times, weights = read(sampler["input"])[:, 0], read(sampler["output"]).reshape(FRAMES, len(targets))
    np.testing.assert_allclose(times, animation.times, atol=1e-6)
    for frame in range(FRAMES):
        shown = mesh.vertices + np.einsum("t,tnd->nd", weights[frame], targets)
        np.testing.assert_allclose(shown, animation.frames[frame][split], atol=1e-6)
    for accessor in scene["accessors"]:
        assert scene["bufferViews"][accessor["bufferView"]]["byteOffset"] % 4 == 0


def test_usd_holds_every_frame(animation, folder):
    """Broken where Pixar's own library finds a fault, a frame is another's, or texture is another than the OBJ's."""
    from pxr import Usd, UsdGeom, UsdValidation

    stage = Usd.Stage.Open(str(folder / "garment.usdc"))
    everything = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert UsdValidation.ValidationContext(everything).Validate(stage) == []
    assert (stage.GetTimeCodesPerSecond(), stage.GetFramesPerSecond()) == (25.0, 25.0)
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0.0, FRAMES - 1.0)
    assert (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)) == ("Y", 1.0)
    mesh, garment = UsdGeom.Mesh(stage.GetPrimAtPath("/garment/cloth")), animation.worn.garment
    read = np.stack([np.array(mesh.GetPointsAttr().Get(code)) for code in mesh.GetPointsAttr().GetTimeSamples()])
    np.testing.assert_array_equal(read, animation.frames.astype(np.float32))
    np.testing.assert_array_equal(np.reshape(mesh.GetFaceVertexIndicesAttr().Get(), (-1, 3)), garment.faces)
    uv = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").ComputeFlattened())
    rows = (folder / "garment.obj").read_text().splitlines()
    texture = np.array([row.split()[1:] for row in rows if row.startswith("vt ")], dtype=float)
    corners = np.concatenate(
        [[int(corner.split("/")[1]) - 1 for corner in row.split()[1:]] for row in rows if row.startswith("f ")]
    )
    np.testing.assert_allclose(uv[: len(corners)], texture[corners], atol=1e-6)
    panels = UsdGeom.Subset.GetGeomSubsets(mesh, UsdGeom.Tokens.face, "panel")
    kept = [panels[p].GetIndicesAttr().Get() for p in range(len(panels))]
    np.testing.assert_array_equal(np.sort(np.concatenate(kept)), np.arange(len(garment.faces)))


def test_without_the_extra_there_is_no_usd_and_that_is_told(animation, tmp_path, monkeypatch):
    """Broken where an animation fails, or silently lacks a file, where the library is not installed."""
    from garmentq.core.deliver.export import animation as room

    monkeypatch.setattr(room, "can_write_usd", lambda: False)
    moved = AnimatedGarment(animation, "walk", ResultReport())
    assert any("garmentq[usd]" in warning for warning in room.add_omission_warnings(moved).report.warnings)
    assert not any(path.suffix == ".usdc" for path in write_animation(animation, tmp_path / "plain"))
    monkeypatch.undo()
    assert room.add_omission_warnings(moved).report.warnings == ()


def test_pictures_show_motion(folder):
    """Broken where a picture is empty, every frame is the first, or the preview does not loop."""
    sheet = np.asarray(Image.open(folder / "sheet.png").convert("L"), dtype=float)
    assert sheet.std() > 10.0
    with Image.open(folder / "preview.gif") as preview:
        assert (preview.n_frames, preview.info["loop"], preview.info["duration"]) == (FRAMES, 0, 40)
        shown = []
        for frame in (0, FRAMES - 1):
            preview.seek(frame)
            shown.append(np.asarray(preview.convert("L"), dtype=float))
    assert np.abs(shown[1] - shown[0]).mean() > 0.5


def test_verdicts_are_told(folder):
    """Broken where a frame's verdict is lost or in another unit."""
    told = json.loads((folder / "frames.json").read_text())
    assert [frame["depth_mm"] for frame in told["frames"]] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert told["frames"][2] == {
        "t": 0.08, "converged": True, "depth_mm": 0.2, "pinched_mm": 0.0, "crossings": 2, "steps": 1,
        "cpu_seconds": 0.5,
    }  # fmt: skip
