"""Make the pictures of the tutorials from what their commands leave.

Follow `docs/tutorials/scan-to-pattern.md` up to step 3 and `docs/tutorials/edit-a-pattern.md` up to step 1, leave its
server running, and run (JOB is the T-shirt's job)

    pip install -e '.[test]'
    python examples/make_pictures.py --parts parts --result result/upper --job JOB

It needs Debian's `chromium` and takes half a minute. It writes PNG files of at most 256 colours into `docs/tutorials`.
"""

from __future__ import annotations

import argparse
import io
import shutil
from pathlib import Path

import garmentq
import numpy as np
import trimesh
from garmentq.core.body.body import Body
from garmentq.core.deliver.export.person import composite_on_white
from garmentq.core.deliver.export.picture import ColouredMesh, aim_camera, render_meshes
from garmentq.service.settings import read_settings
from PIL import Image, ImageDraw
from playwright.sync_api import BrowserContext, sync_playwright

FOLDER = Path(__file__).parents[1] / "docs" / "tutorials"
FLAGS = ("--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader")

SKIN, CLOTH = np.array([0.80, 0.76, 0.70]), np.array([0.27, 0.51, 0.71])
"""Colours of body and cloth, RGB in 0..1."""
PERSON_TILE = (240, 340)
"""Width and height of a picture of the whole person [px]."""
MESH_TILE = (300, 240)
"""Width and height of a picture of a garment's mesh [px]."""
PATTERN_WIDTH = 760
"""Of the picture of the pattern [px]."""
WINDOW = {"width": 1280, "height": 750}
"""Size of the editor's picture [px]."""
CAPTION_HEIGHT = 20
"""Of the line above a tile [px]."""
PRESSES = 10
"""Steps of the arrow key that the lesson takes."""


def main() -> None:
    """Make all pictures."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--parts", type=Path, required=True, help="folder that `garmentq segment` wrote")
    parser.add_argument("--result", type=Path, required=True, help="folder of the upper garment of `garmentq run`")
    parser.add_argument("--job", required=True, help="the T-shirt's job, which the editor shows")
    parser.add_argument("--url", default="http://127.0.0.1:8080", help="where `garmentq up --serve` listens")
    parser.add_argument("--out", type=Path, default=FOLDER)
    options = parser.parse_args()
    draw_person(options.parts, options.out / "person.png")
    draw_meshes(options.result, options.out / "meshes.png")
    result = garmentq.open_result(options.result)
    write_picture(Image.open(io.BytesIO(result.plot().png)), options.out / "notebook.png")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
        context = browser.new_context(base_url=options.url, viewport=WINDOW)
        take_pattern(context, options.result / "pattern.svg", options.out / "pattern.png")
        take_editor(context, options.job, options.out / "editor.png")
        browser.close()


def draw_person(parts: Path, path: Path) -> None:
    """Draw scan, labels and wearer side by side, from the front."""
    tiles = {"scan": read_coloured(parts / "scan.ply"), "labels": read_coloured(parts / "segmented.ply")}
    body = trimesh.load(parts / "body.ply", process=False)
    tiles["wearer"] = ColouredMesh(body.vertices, body.faces, SKIN)
    everything = np.concatenate([tile.vertices for tile in tiles.values()])
    camera = aim_camera(everything, np.eye(3), *PERSON_TILE)
    join_tiles({name: composite_on_white(render_meshes([tile], camera)) for name, tile in tiles.items()}, path)


def draw_meshes(folder: Path, path: Path) -> None:
    """Draw the four meshes of a garment on its wearer, from the front."""
    result = garmentq.open_result(folder)
    body: Body = result.body
    skin = ColouredMesh(body.vertices, body.faces, SKIN)
    meshes = {name: result.mesh(name) for name in result.meshes}
    camera = aim_camera(np.concatenate([mesh.vertices for mesh in meshes.values()]), body.heading, *MESH_TILE)
    tiles = {
        f"{name}.ply": composite_on_white(render_meshes([skin, ColouredMesh(mesh.vertices, mesh.faces, CLOTH)], camera))
        for name, mesh in meshes.items()
    }
    join_tiles(tiles, path)


def take_pattern(context: BrowserContext, drawing: Path, path: Path) -> None:
    """Show the pattern's drawing in the browser, and keep what it shows."""
    page = context.new_page()
    text = drawing.read_text(encoding="utf-8")
    page.set_content(
        f"<style>body {{margin: 0}} svg {{width: {PATTERN_WIDTH}px; height: auto}}</style>{text[text.index('<svg') :]}"
    )
    write_picture(Image.open(io.BytesIO(page.locator("svg").screenshot())), path)
    page.close()


def take_editor(context: BrowserContext, job: str, path: Path) -> None:
    """Widen the T-shirt's hem in the editor as the lesson does, and keep what it shows."""
    token = (read_settings().home / "api.token").read_text(encoding="utf-8").strip()
    if not context.request.post("/signin", form={"token": token}).ok:
        raise SystemExit("the server takes no token of this home; set GARMENTQ_HOME to the home that it serves")
    page = context.new_page()
    page.goto(f"/results/{job}/edit")
    page.locator("#said", has_text="Ready.").wait_for()
    boxes = [dot.bounding_box() for dot in page.locator('[data-panel="front"] [data-point]').all()]
    corner = max(boxes, key=lambda box: box["x"] + box["y"])
    page.mouse.click(corner["x"] + 0.5 * corner["width"], corner["y"] + 0.5 * corner["height"])
    for _ in range(PRESSES):
        page.keyboard.press("ArrowRight")
    page.wait_for_load_state("networkidle")
    write_picture(Image.open(io.BytesIO(page.screenshot())), path)
    print(f"the editor says: {page.locator('#said').inner_text()}")


def read_coloured(path: Path) -> ColouredMesh:
    """Read a mesh with a colour for each vertex."""
    mesh = trimesh.load(path, process=False)
    return ColouredMesh(mesh.vertices, mesh.faces, mesh.visual.vertex_colors[:, :3] / 255.0)


def join_tiles(tiles: dict[str, np.ndarray], path: Path) -> None:
    """Write pictures, RGB in 0..255, side by side, each below its name."""
    row = Image.fromarray(np.concatenate(list(tiles.values()), axis=1))
    sheet = Image.new("RGB", (row.width, row.height + CAPTION_HEIGHT), "white")
    sheet.paste(row, (0, CAPTION_HEIGHT))
    pen, width = ImageDraw.Draw(sheet), row.width / len(tiles)
    for number, name in enumerate(tiles):
        pen.text(((number + 0.5) * width, CAPTION_HEIGHT / 2), name, fill="black", anchor="mm")
    write_picture(sheet, path)


def write_picture(picture: Image.Image, path: Path) -> None:
    """Write a picture as a small PNG file."""
    picture.convert("RGB").quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path}: {picture.width} x {picture.height}, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
