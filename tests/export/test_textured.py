"""Textured files of a stored result: read back, at true scale, the same each time."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.meshes import write_ply
from garmentq.core.deliver.export.prints import PRINT_BLEED_WIDTH, PrintPlace, draw_print, list_prints
from garmentq.core.deliver.export.sewn_mesh import SewnMesh
from garmentq.core.deliver.export.stored import garment_stem, read_nodes
from garmentq.core.deliver.export.textured import write_textured
from garmentq.core.deliver.texture.bake import BakedTexture
from garmentq.core.garment.templates import load_template
from garmentq.core.run.errors import BadInput
from garmentq.core.scan.coloured import ColoursMissing, to_coloured_scan
from garmentq.core.scan.scan import Scan
from gltf_validator import validate_glb
from PIL import Image


@pytest.fixture(scope="module")
def mesh(tube, tube_pattern) -> SewnMesh:
    """Return a tube of two panels, 47 by 30 cm, one of which has a name that no file may hold."""
    garment = tube(tube_pattern(names=("front", "../back\n")))
    return SewnMesh("detail", garment, garment.nodes, get_fabric("denim"))


@pytest.fixture(scope="module")
def written(mesh: SewnMesh, tmp_path_factory) -> dict[str, Path]:
    """Return the files of a scan that is red by height, 2 mm a texel."""
    nodes = mesh.nodes
    height = (nodes[:, 1] - nodes[:, 1].min()) / np.ptp(nodes[:, 1])
    scan = Scan(nodes, mesh.garment.faces, colours=np.column_stack([height, 1.0 - height, np.full(len(nodes), 0.5)]))
    folder = tmp_path_factory.mktemp("textured")
    found = write_textured(mesh, to_coloured_scan(scan), folder, "tube", 2.0)
    assert found.coverage > 0.99
    assert sorted(found.files) == sorted(folder.iterdir())
    return {file.name: file for file in found.files}


def test_every_file_is_there_and_names_are_plain(written: dict[str, Path]) -> None:
    """Fails if a panel's name left the folder."""
    wanted = {"tube_texture.png", "tube_texture_mask.png", "tube_textured.glb", "tube_textured.obj",
              "tube_textured.mtl", "tube_textured.json", "tube_print_FRONT.png", "tube_print_BACK.png"}  # fmt: skip
    assert wanted <= set(written) <= wanted | {"tube_textured.usd", "tube_textured.usdz"}


@pytest.mark.parametrize("name", ["tube_textured.glb", "tube_textured.obj"])
def test_readers_see_the_scan_s_colours_at_their_height(name: str, written: dict[str, Path]) -> None:
    """Fails if v is turned in one of the formats, or the image is another one's."""
    mesh = trimesh.load(written[name], process=False, force="mesh")
    material = mesh.visual.material
    image = np.asarray(material.baseColorTexture if name.endswith("glb") else material.image)[..., :3]
    size = len(image)
    u, v = mesh.visual.uv.T
    row, column = np.clip((1.0 - v) * size, 0, size - 1).astype(int), np.clip(u * size, 0, size - 1).astype(int)
    height = (mesh.vertices[:, 1] - mesh.vertices[:, 1].min()) / np.ptp(mesh.vertices[:, 1])
    assert np.abs(image[row, column, 0] / 255.0 - height).max() < 0.02
    assert np.abs(image[row, column, 1] / 255.0 - 1.0 + height).max() < 0.02


def test_glb_has_no_fault_by_khronos(written: dict[str, Path]) -> None:
    """Fails if the image's part of the buffer is misaligned."""
    found = validate_glb(written["tube_textured.glb"])
    assert (found["numErrors"], found["numWarnings"]) == (0, 0), found["messages"]


def test_a_print_is_the_panel_at_true_scale_with_bleed(written: dict[str, Path]) -> None:
    """Fails if a print comes out of a printer at another size, or stops at the sew line."""
    image = Image.open(written["tube_print_FRONT.png"])
    assert image.mode == "RGBA"
    assert image.info["dpi"][0] == pytest.approx(12.7, abs=0.01)  # 2 mm a pixel
    wide, high = (0.0254 * pixels / image.info["dpi"][0] for pixels in image.size)
    assert wide == pytest.approx(np.pi * 0.15 + 2 * PRINT_BLEED_WIDTH, abs=0.003)
    assert high == pytest.approx(0.30 + 2 * PRINT_BLEED_WIDTH, abs=0.003)
    pixels = np.asarray(image)
    middle = pixels[:, pixels.shape[1] // 2]
    assert (middle[:, 3] == 255).all() and pixels[0, 0, 3] == 0
    assert middle[21, 0] > 240 and middle[-22, 0] < 15  # the waist is up
    assert (middle[:20, :3] == middle[20, :3]).all()  # the bleed goes on in the colour of the sew line


def test_a_print_of_two_panels_turns_each_into_its_place(mesh: SewnMesh) -> None:
    """Fails if a mirrored or turned panel is drawn with its colours where they were."""
    size = round(mesh.unit_uv[1] / 2e-3)
    ramp = np.tile(np.linspace(0, 255, size)[None, :, None], (size, 1, 3)).astype(np.uint8)  # by u
    everywhere = np.ones((size, size), dtype=bool)
    baked = BakedTexture(ramp, everywhere, everywhere, 2e-3)
    one = draw_print(mesh, baked, [PrintPlace(0, np.eye(2), np.zeros(2))], 2e-3)
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    two = draw_print(
        mesh, baked, [PrintPlace(0, np.eye(2), np.zeros(2)), PrintPlace(1, quarter, np.array([-0.01, 0.0]))], 2e-3
    )
    assert two.shape[1] - one.shape[1] == pytest.approx(0.31 / 2e-3, abs=2)
    left = two[:, 30:150]
    inner = left[left[..., 3] == 255]
    assert np.ptp(inner[:, 0]) > 50
    middle = two[two.shape[0] // 2, 40:140, 0]
    assert np.ptp(middle.astype(int)) <= 2  # what was across is up now


def test_a_scan_without_colours_has_a_code() -> None:
    """Fails if a grey texture is made of nothing."""
    with pytest.raises(ColoursMissing):
        to_coloured_scan(Scan(np.zeros((3, 3)), np.zeros((1, 3), int)))


def test_stored_nodes_come_back_bit_by_bit(mesh: SewnMesh, tmp_path: Path) -> None:
    """Fails if further properties shift the columns, or a cut file is read."""
    path = write_ply(mesh.nodes, mesh.garment.faces, tmp_path / "a.ply", {"strain": mesh.nodes[:, 0]})
    assert np.array_equal(read_nodes(path), mesh.nodes)
    path.write_bytes(path.read_bytes()[:400])
    with pytest.raises(BadInput):
        read_nodes(path)


def test_files_are_called_after_the_scan(tmp_path: Path) -> None:
    """Fails if a scan's name could leave the folder, or a result without one has no name."""
    assert garment_stem(tmp_path) == "garment"
    (tmp_path / "manifest.json").write_text(json.dumps({"scan": {"name": "../My Shirt (1)"}}))
    assert garment_stem(tmp_path) == "my_shirt_1"


@pytest.mark.parametrize("name", ["tshirt", "trousers", "pencil_skirt", "sleeved_jumpsuit"])
def test_every_panel_is_printed_once_and_as_it_is_cut(name: str) -> None:
    """Fails if the colours of a pair's copy are lost, or a print is mirrored."""
    pattern = load_template(name)
    prints = list_prints(pattern)
    assert sorted(place.panel for _, places in prints for place in places) == list(range(len(pattern.panels)))
    assert all(np.linalg.det(place.rotation) == pytest.approx(1.0) for _, places in prints for place in places)
    assert len({each for each, _ in prints}) == len(prints)
