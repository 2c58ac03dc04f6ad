"""Meshes for other programs, read back by trimesh and Khronos' validator."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.sewn_files import write_sewn_glb, write_sewn_obj
from garmentq.core.deliver.export.sewn_mesh import SewnMesh, sanitise_names, seams_of_uv
from garmentq.core.garment.templates import load_draped_template
from gltf_validator import validate_glb
from PIL import Image

FABRIC = get_fabric("cotton_poplin")


IMAGE = io.BytesIO()
Image.fromarray(np.full((8, 8, 3), [200, 100, 50], np.uint8)).save(IMAGE, format="PNG")


@pytest.fixture(scope="module")
def mesh() -> SewnMesh:
    """Return a T-shirt as it hangs on the built-in body: six panels, twelve seams, darts of none."""
    garment = load_draped_template("tshirt")
    if garment is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    return SewnMesh("simulation", garment, garment.nodes, FABRIC)


def areas(flat: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return signed areas of flat triangles."""
    a, b, c = (flat[faces[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def panel_areas(mesh: SewnMesh) -> np.ndarray:
    """Return the area of each panel as it was meshed [m2]."""
    garment = mesh.garment
    return np.bincount(garment.panel_of_face, areas(garment.uv, garment.uv_faces))


def read_chunks(path: Path) -> dict:
    """Return the JSON of a GLB."""
    content = path.read_bytes()
    return json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])


def test_glb_holds_panels_seams_rest_and_fabric(mesh: SewnMesh, tmp_path: Path) -> None:
    """Fails if a face lost its panel, uv its metres, or a seam one of its sides."""
    path = write_sewn_glb(mesh, tmp_path / "a.glb")
    parts = list(trimesh.load_scene(path, process=False).geometry.values())
    garment, count = mesh.garment, len(mesh.garment.pattern.panels)
    assert len(parts) == count
    joined = np.full((len(mesh.nodes), 3), np.nan)
    sides = {n: set() for n in range(len(garment.pattern.seams))}
    for index, (part, area) in enumerate(zip(parts, panel_areas(mesh), strict=True)):
        assert areas(np.asarray(part.visual.uv), part.faces).sum() == pytest.approx(area, rel=1e-4)
        assert (part.vertex_attributes["_PANEL"] == index).all()
        nodes = part.vertex_attributes["_NODE"].astype(int).ravel()
        joined[nodes] = part.vertices
        lies_on = np.concatenate([part.vertex_attributes[name].astype(int).ravel() for name in ("_SEAM_A", "_SEAM_B")])
        for seam in np.unique(lies_on):
            if seam >= 0:
                sides[seam].add(garment.pattern.panels[index].name)
    assert sum(len(part.faces) for part in parts) == len(garment.faces)
    assert joined == pytest.approx(mesh.nodes, abs=1e-6)
    assert sides == {n: {seam.a.panel, seam.b.panel} for n, seam in enumerate(garment.pattern.seams)}
    told = read_chunks(path)["meshes"][0]["extras"]["garmentq"]
    assert told["fabric"]["H00"] == FABRIC.H00 and told["fabric"]["density"] == FABRIC.density
    assert [panel["name"] for panel in told["panels"]] == [panel.name for panel in garment.pattern.panels]


def test_second_uv_is_within_one_at_one_scale(mesh: SewnMesh, tmp_path: Path) -> None:
    """Fails if a panel left 0..1, was stretched, or lies on another one."""
    chunks = read_chunks(write_sewn_glb(mesh, tmp_path / "a.glb"))
    flat, side = mesh.unit_uv
    assert flat.min() >= 0.0 and flat.max() <= 1.0
    scaled = side**2 * areas(flat, mesh.garment.uv_faces)
    assert scaled == pytest.approx(areas(mesh.garment.uv, mesh.garment.uv_faces), rel=1e-9, abs=1e-12)
    boxes = [
        (flat[own].min(axis=0), flat[own].max(axis=0)) for own in (mesh.garment.panel_of_uv == n for n in range(6))
    ]
    for n, (low, high) in enumerate(boxes):
        for other_low, other_high in boxes[n + 1 :]:
            assert ((low > other_high) | (other_low > high)).any()
    primitives = chunks["meshes"][0]["primitives"]
    assert all("TEXCOORD_1" in each["attributes"] for each in primitives)
    assert sorted(each["material"] for each in primitives) == list(range(len(chunks["materials"])))
    assert chunks["meshes"][0]["extras"]["garmentq"]["metres_per_unit_of_uv"] == pytest.approx([1.0, side])


@pytest.mark.parametrize("image", [None, IMAGE.getvalue()], ids=["plain", "textured"])
def test_glb_has_no_fault_by_khronos(image: bytes | None, mesh: SewnMesh, tmp_path: Path) -> None:
    """Fails if an accessor is misaligned, out of bounds, or of a type that glTF forbids."""
    found = validate_glb(write_sewn_glb(mesh, tmp_path / "a.glb", image))
    assert (found["numErrors"], found["numWarnings"]) == (0, 0), found["messages"]


def test_obj_has_a_group_and_material_for_each_panel(mesh: SewnMesh, tmp_path: Path) -> None:
    """Fails if a face is in no panel's group, uv are not metres, or the sidecar's seams are not the mesh's."""
    files = write_sewn_obj(mesh, tmp_path / "a.obj")
    assert [file.name for file in files] == ["a.obj", "a.mtl", "a.json"]
    garment = mesh.garment
    parts = trimesh.load_scene(files[0], process=False, group_material=False, split_object=False).geometry
    assert sum(len(part.faces) for part in parts.values()) == len(garment.faces)
    names = sanitise_names([panel.name for panel in garment.pattern.panels])
    found = {}
    for part in parts.values():
        name = part.visual.material.name
        found[name] = found.get(name, 0.0) + float(areas(np.asarray(part.visual.uv), part.faces).sum())
    assert found == pytest.approx(dict(zip(names, panel_areas(mesh), strict=True)), rel=1e-4)
    lines = files[0].read_text().splitlines()
    assert sum(line.startswith("v ") for line in lines) == len(garment.nodes)  # welded
    told = json.loads(files[2].read_text())
    for seam, kept in zip(garment.pattern.seams, told["seams"], strict=True):
        mine = set(garment.uv_node[garment.edge_uv[seam.b]] + 1)
        assert set(kept["vertices"]) == mine
    assert set(told["contours"]) == {contour.name for contour in garment.contours}


def test_every_edge_vertex_names_its_seams(mesh: SewnMesh) -> None:
    """Fails if a corner between two seams knew only one, or a vertex inside a panel any."""
    garment = mesh.garment
    found = seams_of_uv(garment)
    on_edge = np.zeros(len(garment.uv), dtype=bool)
    for index, seam in enumerate(garment.pattern.seams):
        for side in (seam.a, seam.b):
            assert (found[garment.edge_uv[side]] == index).any(axis=1).all()
            on_edge[garment.edge_uv[side]] = True
    assert (found[~on_edge] == -1).all()


def test_names_from_a_file_are_made_plain() -> None:
    """Fails if a panel's name could add a line to an OBJ, or two panels share a group."""
    assert sanitise_names(("back\nf 1 1 1", "Back/f 1 1 1", "", "é")) == [
        "back_f_1_1_1",
        "Back_f_1_1_1_1",
        "panel_2",
        "panel_3",
    ]


def test_same_mesh_same_bytes(mesh: SewnMesh, tmp_path: Path) -> None:
    """Fails if a file held a time, a random id or the order of a set."""
    first = write_sewn_glb(mesh, tmp_path / "a.glb").read_bytes()
    assert write_sewn_glb(mesh, tmp_path / "b.glb").read_bytes() == first


def test_a_texture_is_read_by_the_first_uv(mesh: SewnMesh, tmp_path: Path) -> None:
    """Fails if a viewer that knows one uv set would lay the texture on in metres, or does not find the image."""
    scene = trimesh.load_scene(write_sewn_glb(mesh, tmp_path / "a.glb", IMAGE.getvalue()), process=False)
    for part in scene.geometry.values():
        assert part.visual.uv.min() >= 0.0 and part.visual.uv.max() <= 1.0
        assert part.visual.material.baseColorTexture.size == (8, 8)
    (tmp_path / "texture.png").write_bytes(IMAGE.getvalue())
    obj = write_sewn_obj(mesh, tmp_path / "a.obj", tmp_path / "texture.png")[0]
    part = trimesh.load(obj, process=False, force="mesh")
    assert part.visual.material.image.size == (8, 8)
    assert part.visual.uv.min() >= 0.0 and part.visual.uv.max() <= 1.0
