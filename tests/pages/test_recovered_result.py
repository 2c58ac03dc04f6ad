"""The page of a result that was really recovered: a skirt of another shape than its template, scanned in colours."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.deliver.ply import read_ply
from garmentq.core.deliver.texture.lookup import UNSEEN_COLOUR
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.reuse.wear.worn import load_worn

pytestmark = pytest.mark.nightly  # the recovery takes 5 to 10 s of CPU time, and 25 s where nothing is compiled yet


def colour_of(height: np.ndarray) -> np.ndarray:
    """Return the colours of the scan at heights [m], RGB in 0..255, shape [n, 3]: red at the waist, blue at the hem."""
    share = np.clip((height - 0.4) / 0.8, 0.0, 1.0)
    return 255.0 * np.stack([share, np.full_like(share, 0.3), 1.0 - share], axis=1)


@pytest.fixture(scope="module")
def recovery(tmp_path_factory):
    """Recover the skirt from its file."""
    from garmentq.core.recover.pipeline import recover
    from garmentq.core.recover.recovery import Request
    from garmentq.core.recover.settings import RecoverySettings

    garment = load_draped_template("skirt")
    if garment is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    turn = np.arctan2(garment.nodes[:, 0], garment.nodes[:, 2])
    swell = 1.0 + 0.02 * np.sin(6.0 * turn)
    nodes = garment.nodes * np.stack([swell, np.ones_like(swell), swell], axis=1)
    scan = tmp_path_factory.mktemp("scan") / "skirt.ply"
    colours = colour_of(nodes[:, 1]).astype(np.uint8)
    trimesh.Trimesh(nodes, garment.faces, vertex_colors=colours, process=False).export(scan)
    settings = RecoverySettings(method="deform", vertex_count=500, up="y", template="skirt")
    return recover(Request(scan, BuiltinWearer("builtin:female,height=1.70"), settings=settings))


@pytest.fixture(scope="module")
def shown(site, recovery, open_window, write_once):
    """Open its page; gives the page and the folder of its files."""
    job = site.keep("recovered", recovery)
    with open_window() as opened:
        page = opened.new_page()
        page.goto(f"/results/{job}")
        page.locator("#result[data-ready]").wait_for()
        yield page, write_once(recovery)


def test_the_cloth_has_the_colours_of_its_scan(shown):
    """Broken where a vertex has the colour of another place, or most of the cloth none."""
    page, folder = shown
    mesh = read_ply((Path(folder) / "detail.ply").read_bytes())
    seen = (mesh.colours != UNSEEN_COLOUR).any(axis=1)
    assert seen.mean() > 0.9
    off = np.abs(mesh.colours[seen] - colour_of(mesh.vertices[seen, 1])).max(axis=1)
    assert np.quantile(off, 0.99) < 6.0  # 20 mm of height
    styles = page.locator("#style option").all_inner_texts()
    assert {"Cloth", "Texture", "Distance from the scan", "Stretch"} <= set(styles)
    page.select_option("#style", "texture")
    assert page.locator("#unseen").is_visible() and not page.locator("#uncoloured").is_visible()


def test_pattern_and_cloth_point_at_each_other(shown):
    """Broken where the mark is further than an edge from the true place, or an edge is measured wrongly."""
    page, folder = shown
    garment = load_worn(Path(folder)).garment
    nodes = read_ply((Path(folder) / "detail.ply").read_bytes()).vertices
    panel = page.locator("#flat [data-panel] .panel").first
    at = int(panel.get_attribute("data-n"))
    box = panel.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    marked = json.loads(page.locator("#result").get_attribute("data-marked"))
    own = np.flatnonzero(garment.panel_of_uv == at)
    low, high = garment.uv[own].min(axis=0), garment.uv[own].max(axis=0)
    nearest = own[np.argmin(np.linalg.norm(garment.uv[own] - (low + high) / 2, axis=1))]
    assert np.linalg.norm(nodes[garment.uv_node[nearest]] - marked) < 0.06
    edge = page.locator("#flat .hold").first
    edge.focus()
    page.keyboard.press("Enter")
    _, flat, lifted = page.locator("#measured tr").nth(1).inner_text().split("\t")
    name, _, index = edge.get_attribute("data-edge").rpartition(".")
    uv = next(uv for ref, uv in garment.edge_uv.items() if (ref.panel, ref.edge) == (name, int(index)))
    lengths = [
        np.linalg.norm(np.diff(points, axis=0), axis=1).sum() for points in (garment.uv[uv], nodes[garment.uv_node[uv]])
    ]
    assert np.allclose([float(flat), float(lifted)], 1e3 * np.array(lengths), atol=0.06)
