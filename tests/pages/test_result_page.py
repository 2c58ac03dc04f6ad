"""The page of a result, in a real browser: what it shows is compared with the files that were stored."""

from __future__ import annotations

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.deliver.export.meshes import write_ply
from garmentq.core.deliver.export.point_caches import write_pc2
from garmentq.core.deliver.ply import read_ply
from garmentq.core.reuse.wear.worn import load_worn
from garmentq.service.jobs import claim
from garmentq.service.kinds.recover import Recover
from garmentq.service.kinds.recover_request import PERSON
from garmentq.service.models import JobInputRow
from garmentq.service.pages.stored_files import find_file, read_bytes
from garmentq.service.results import store_result
from person_jobs import keep_person
from PIL import Image
from shells import dress_in_shells


@pytest.fixture(scope="module")
def shown(open_window, site):
    """Open the page of the tube for the tests of this file, and wait until all of it is there."""
    with open_window() as opened:
        page = opened.new_page()
        page.goto(f"/results/{site.result}")
        page.locator("#result[data-ready]").wait_for()
        yield page


@pytest.fixture(scope="module")
def worn(site, tmp_path_factory):
    """Read what the page reads, by the program's own reader."""
    folder = tmp_path_factory.mktemp("worn")
    (folder / "worn.npz").write_bytes(read_bytes(site.services, find_file(site.services, site.result, "worn.npz")))
    return load_worn(folder)


def middle_of(page, selector: str, share: float = 0.5) -> tuple[float, float]:
    """Return the point of the screen at a share of a path's length."""
    script = """(path, share) => { const at = path.getPointAtLength(share * path.getTotalLength())
        .matrixTransform(path.getScreenCTM()); return [at.x, at.y]; }"""
    return tuple(page.locator(selector).evaluate(script, share))


def test_readers_agree_with_python(shown, site, worn, whole_tube):
    """Broken where the page reads other arrays than were written, or computes other lengths and stretches."""
    script = """async (job) => {
      const take = (name) => import(`/static/${name}.js`);
      const [api, garments, packed] = await Promise.all(['api', 'garment', 'shown'].map(take));
      const { garment, meshes } = packed.readShown(await api.getBytes(`/results/${job}/view.bin`));
      const scan = packed.readShown(await api.getBytes(`/results/${job}/scan.bin`)).meshes.get('scan');
      const mesh = meshes.get('simulation');
      const nodes = mesh.positions, strain = [...garments.computeStrain(garment, nodes)];
      const measure = (edge) => garments.measureEdge(garment, edge, 0, edge.uv.length - 1, nodes);
      const seams = garment.seams.map((pair) => pair.map((edge) => [edge.panel, edge.index]));
      return { uv: [...garment.uv], faces: [...mesh.faces], seams, nodes: [...nodes], strain, names: [...meshes.keys()],
        colours: [...meshes.get('detail').colours], scanned: [...scan.colours],
        distance: [...mesh.values.distance], lengths: garment.panels[0].edges.map(measure) };
    }"""
    found, garment = shown.evaluate(script, site.result), worn.garment
    assert found["names"] == ["detail", "simulation", "redrape", "graded", "body"]
    assert np.allclose(np.reshape(found["uv"], (-1, 2)), garment.uv, atol=1e-7)
    assert np.array_equal(np.reshape(found["faces"], (-1, 3)), garment.faces)
    assert np.allclose(np.reshape(found["nodes"], (-1, 3)), garment.nodes, atol=1e-7)  # worn.npz holds the simulation
    stored = read_ply(read_bytes(site.services, find_file(site.services, site.result, "simulation.ply")))
    assert np.allclose(found["distance"], stored.values["distance"], atol=1e-7)
    stored = read_ply(read_bytes(site.services, find_file(site.services, site.result, "detail.ply")))
    assert np.array_equal(np.reshape(found["colours"], (-1, 3)), stored.colours)
    assert np.array_equal(np.reshape(found["scanned"], (-1, 3)), np.round(255 * whole_tube().scan.colours))
    assert found["seams"] == [[[s.a.panel, s.a.edge], [s.b.panel, s.b.edge]] for s in garment.pattern.seams]
    for edge, told in enumerate(found["lengths"]):
        own = next(uv for ref, uv in garment.edge_uv.items() if (ref.panel, ref.edge) == ("front", edge))
        flat = np.linalg.norm(np.diff(garment.uv[own], axis=0), axis=1).sum()
        lifted = np.linalg.norm(np.diff(garment.nodes[garment.uv_node[own]], axis=0), axis=1).sum()
        assert np.allclose([told["flat"], told["worn"]], [flat, lifted], atol=1e-6)
    rest, space = garment.uv[garment.uv_faces], garment.nodes[garment.uv_node[garment.uv_faces]]
    rest, space = (np.swapaxes(points[:, 1:] - points[:, :1], 1, 2) for points in (rest, space))
    gradient = space @ np.linalg.inv(rest)
    stretch = np.linalg.svd(gradient, compute_uv=False)[:, 0] - 1.0
    assert np.allclose(found["strain"], stretch, atol=1e-5)


def test_pointing_goes_both_ways(shown, worn):
    """Broken where the mark stands further than one edge from the true place (E2), either way."""
    garment, edge_length = worn.garment, 0.03
    box = shown.locator("#flat .panel").first.bounding_box()
    for across, up in ((0.5, 0.5), (0.3, 0.7), (0.8, 0.2)):
        shown.mouse.move(box["x"] + across * box["width"], box["y"] + (1.0 - up) * box["height"])
        marked = json.loads(shown.locator("#result").get_attribute("data-marked"))
        own = garment.panel_of_uv == 0
        low, high = garment.uv[own].min(axis=0), garment.uv[own].max(axis=0)
        true = np.argmin(np.linalg.norm(garment.uv - (low + [across, up] * (high - low)), axis=1) + 9.0 * ~own)
        detail = garment.nodes[garment.uv_node[true]] / 1.02 * np.ones(3)
        swell = 1.0 + 0.02 * np.sin(8.0 * np.arctan2(detail[0], detail[2]))
        assert np.linalg.norm(detail * [swell, 1.0, swell] - marked) < edge_length
    canvas = shown.locator("#space canvas").bounding_box()
    shown.mouse.move(canvas["x"] + canvas["width"] / 2, canvas["y"] + canvas["height"] / 2)
    panel, x, y = json.loads(shown.locator("#result").get_attribute("data-flat"))
    assert panel == 0 and abs(x - np.pi * 0.15 / 2) < edge_length and abs(y - 0.15) < edge_length
    assert shown.locator("#flat .mark").get_attribute("visibility") == "visible"


def test_edges_are_measured_and_seams_lit(shown):
    """Broken where an edge is measured wrongly, in whole or in part, or its other side is not lit."""
    hem = '[data-edge="front.0"]'
    shown.mouse.click(*middle_of(shown, hem))
    row = shown.locator("#measured tr").nth(1).inner_text().split("\t")
    assert row[0] == "front, edge 0" and abs(float(row[1]) - 471.2) < 0.2
    shown.mouse.move(*middle_of(shown, hem, 0.25))
    shown.mouse.down()
    shown.mouse.move(*middle_of(shown, hem, 0.75), steps=3)
    shown.mouse.up()
    row = shown.locator("#measured tr").nth(1).inner_text().split("\t")
    assert row[0] == "front, edge 0, a part" and abs(float(row[1]) - 471.2 / 2) < 25.0
    shown.locator('[data-edge="front.1"]').focus()
    shown.keyboard.press("Enter")
    assert shown.locator("#flat .lit").count() == 2
    assert "sewn to back" not in shown.locator("#pointed").inner_text()
    shown.mouse.move(*middle_of(shown, '[data-edge="front.1"]'))
    assert "sewn to back, edge 3" in shown.locator("#pointed").inner_text()


def test_meshes_and_colours_are_chosen(shown):
    """Broken where a mesh cannot be shown, or a colouring that the result has is not offered or has no end."""
    assert shown.locator("#style option").all_inner_texts() == [
        "Cloth", "Texture", "Fold normals", "Distance from the scan", "Stretch",
    ]  # fmt: skip
    pictures = set()

    def look() -> None:
        shown.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        pictures.add(shown.locator("#space canvas").screenshot())

    look()
    for name in ("Simulation", "Re-draped", "Scan"):
        shown.get_by_label("Detail").uncheck()
        shown.get_by_role("checkbox", name=name).check()
        look()
        shown.get_by_role("checkbox", name=name).uncheck()
        shown.get_by_label("Detail").check()
    for style in ("texture", "normals", "distance", "strain"):
        shown.select_option("#style", style)
        look()
        assert shown.locator("#colours").is_visible() == (style in ("distance", "strain"))
        assert shown.locator("#unseen").is_visible() == (style == "texture")
    assert not shown.locator("#uncoloured").is_visible()
    shown.get_by_label("Wireframe").check()
    look()
    shown.locator("#space canvas").focus()
    shown.keyboard.press("ArrowLeft")
    look()
    assert len(pictures) == 10  # each choice shows something else


def count_blue(page) -> int:
    """Return how many pixels of the 3D view are as blue as the person's clothes."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    shown = Image.open(io.BytesIO(page.locator("#space canvas").screenshot())).convert("RGB")
    red, green, blue = np.moveaxis(np.asarray(shown, int), 2, 0)
    return int(((blue > 90) & (red < 30) & (green < 30)).sum())


def test_a_garment_shows_its_person_by_touch(open_window, site, whole_tube, tmp_path_factory):
    """Broken where a person's scan is not offered, is grey, or is out of reach of a finger; or where a result whose
    scan has no colours keeps silent about it."""
    person = keep_person(site.services, tmp_path_factory.mktemp("person") / "anna", dress_in_shells(1))
    tube = whole_tube()
    bare = replace(tube, scan=replace(tube.scan, colours=None), meshes=replace(tube.meshes))  # written anew
    job = site.keep("her skirt", bare)
    with site.services.database.write() as session:
        session.add(JobInputRow(job=job, name=PERSON, input=person))
    with open_window(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True) as opened:
        page = opened.new_page()
        page.goto(f"/results/{job}")
        page.locator("#result[data-ready]").wait_for()
        assert page.locator("#uncoloured").inner_text() == "No texture: the scan has no colours."
        assert "Texture" not in page.locator("#style option").all_inner_texts()
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        assert count_blue(page) == 0
        page.get_by_label("The person's scan").tap()
        page.locator("#loading", has_text="Loading").wait_for(state="detached")
        seen = count_blue(page)
        assert seen > 500
        page.locator("#space canvas").scroll_into_view_if_needed()
        box = page.locator("#space canvas").bounding_box()
        y, finger = box["y"] + box["height"] / 2, opened.new_cdp_session(page)
        for kind, x in (("touchStart", 0.3), ("touchMove", 0.5), ("touchMove", 0.7), ("touchEnd", None)):
            points = [] if x is None else [{"x": box["x"] + x * box["width"], "y": y}]
            finger.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        assert count_blue(page) != seen  # the view has turned
        page.goto(f"/results/{person}")
        page.locator("#result[data-ready]").wait_for()
        assert page.get_by_label("Scan", exact=True).is_checked() and count_blue(page) > 500


def test_an_animation_plays(page, site, whole_tube, tmp_path):
    """Broken where the point cache is read wrongly, or the frames do not follow each other."""
    recovery = whole_tube()
    nodes, faces = recovery.garment.nodes, recovery.garment.faces
    frames = np.stack([nodes + [0.0, 0.1 * n, 0.0] for n in range(4)])
    write_pc2(frames, tmp_path / "garment.pc2")
    write_ply(nodes, faces, tmp_path / "garment.ply")
    (tmp_path / "frames.json").write_text('{"fps": 8, "frames": []}')
    job = site.queue("moving")
    held = claim(site.services.database, job, "test", 600.0)
    store_result(site.services.database, site.services.store, held, Recover(), recovery, tmp_path)
    page.goto(f"/results/{job}")
    page.locator("#result[data-ready]").wait_for()
    assert page.locator("#frame").get_attribute("max") == "3"
    page.locator("#frame").focus()
    page.keyboard.press("End")
    assert page.locator("#time").inner_text() == "0.38 s"
    page.keyboard.press("Home")
    page.get_by_role("button", name="Play").click()
    page.locator("#time", has_text="0.25 s").wait_for()
    page.get_by_role("button", name="Pause").click()
    script = """(job) => Promise.all([import('/static/frames.js'), import('/static/api.js')]).then(async ([own, api]) =>
        own.readFrames(await api.getBytes(`/v1/jobs/${job}/artifacts/garment.pc2`)).map((frame) => [...frame]))"""
    assert np.allclose(np.reshape(page.evaluate(script, job), frames.shape), frames, atol=1e-6)


def test_all_garments_of_an_outfit_are_shown(page, site, whole_tube, tmp_path):
    """Broken where a garment of an outfit is missing in 3D or hidden at first, or the body is."""
    recovery = whole_tube()
    nodes, faces = recovery.garment.nodes, recovery.garment.faces
    for name, way in (("lower/dressed", 0.0), ("upper/dressed", 0.3), ("body", 0.1)):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        write_ply(nodes + [0.0, way, 0.0], faces, tmp_path / f"{name}.ply")
    job = site.queue("outfit")
    held = claim(site.services.database, job, "test", 600.0)
    store_result(site.services.database, site.services.store, held, Recover(), recovery, tmp_path)
    page.goto(f"/results/{job}")
    page.locator("#result[data-ready]").wait_for()
    boxes = page.locator("input[data-mesh]")
    shown = {boxes.nth(n).get_attribute("data-mesh"): boxes.nth(n).is_checked() for n in range(boxes.count())}
    assert shown == {"lower/dressed": True, "upper/dressed": True, "body": True}
    page.get_by_label("Upper").uncheck()
    assert page.locator("#loading").inner_text() == "" and not page.locator("#pictures").is_visible()


def test_without_webgl_there_are_pictures(chromium, site):
    """Broken where a machine without WebGL sees nothing, or the pattern cannot be measured there."""
    with chromium.new_context(base_url=site.url) as opened:
        opened.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
        assert opened.request.post("/signin", form={"token": site.token}).ok
        page = opened.new_page()
        page.goto(f"/results/{site.result}")
        page.locator("#pictures img").first.wait_for()
        first = page.locator("#pictures img").first
        assert first.evaluate("(image) => image.decode().then(() => image.naturalWidth)") == 480
        assert not page.locator("#space").is_visible()
        page.locator('[data-edge="front.0"]').wait_for(state="attached")


def test_files_and_report_are_offered(shown, site):
    """Broken where a file cannot be had, or the report could run something."""
    shown.get_by_text("Files", exact=True).click()
    names = shown.locator("table a[download]").all_inner_texts()
    assert {"pattern.svg", "worn.npz", "scan.ply", "report.html", "metrics.json"} <= set(names)
    with shown.expect_download() as started:
        shown.get_by_role("link", name="pattern.svg").click()
    assert b"<svg" in started.value.path().read_bytes()[:200]
    report = shown.context.request.get(f"/results/{site.result}/report")
    assert report.headers["content-security-policy"].endswith("sandbox") and "<h1" in report.text()
    shown.get_by_role("button", name="PDF").click()
    shown.get_by_text("pdf: queued").wait_for()
