"""What each kind of job leaves is shown on its page: the files are written as its worker writes them."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.outcome import Outcome
from garmentq.core.cloth.statics import Drape
from garmentq.core.deliver.export.animation import write_animation_result
from garmentq.core.deliver.export.dressed import write_dressed
from garmentq.core.deliver.export.edited import write_edited
from garmentq.core.deliver.export.meshes import write_ply
from garmentq.core.deliver.export.outfit import write_outfit
from garmentq.core.deliver.export.stored_result import load_result
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.reuse.animate.animate_garment import AnimatedGarment
from garmentq.core.reuse.animate.animation import Animation, FrameVerdict
from garmentq.core.reuse.edit.redraping import drape_edit
from garmentq.core.reuse.wear.dressing import DressedGarment, measure_worn
from garmentq.core.reuse.wear.ease import measure_ease
from garmentq.core.reuse.wear.outfit import DressedOutfit
from garmentq.core.reuse.wear.verdicts import judge_wear
from garmentq.core.reuse.wear.worn import WornGarment
from garmentq.core.run.clock import Clock
from garmentq.core.run.hooks import SILENT_HOOKS
from garmentq.core.run.report import ResultReport
from garmentq.service.jobs import claim
from garmentq.service.kinds import KINDS
from garmentq.service.kinds.recover import Recover
from garmentq.service.results import store_result
from PIL import Image
from quick_edit import drape_at_once


@pytest.fixture(scope="module")
def worn() -> WornGarment:
    """Return a skirt as it hangs on the body that it was drafted for."""
    garment, body = load_draped_template("skirt"), builtin_body("builtin:female,height=1.70")
    if garment is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    return WornGarment(garment, get_fabric("cotton_poplin"), body, None, None, "skirt", "skirt")


@pytest.fixture(scope="module")
def keep(site, whole_tube) -> Callable[[Path], str]:
    """Return a function that stores a folder as a job's result, as a worker would; it gives the job's id."""

    def store(folder: Path) -> str:
        job = site.queue(folder.name)
        held = claim(site.services.database, job, "test", 600.0)
        store_result(site.services.database, site.services.store, held, Recover(), whole_tube(), folder)
        return job

    return store


@pytest.fixture(scope="module")
def window(open_window):
    """Open one page for the tests of this file."""
    with open_window() as opened:
        yield opened.new_page()


def dress(worn: WornGarment) -> DressedGarment:
    """Return the garment where it is, as if a body had been dressed in it."""
    drape = Drape(worn.garment.nodes, 0.1, 3, 1.0, Outcome.CONVERGED, worn.garment.nodes)
    metrics, loads = measure_worn(worn, WearerGeometry(worn.body), drape), np.zeros((2, len(worn.garment.nodes)))
    ease = measure_ease(worn.garment, worn.body)
    return DressedGarment(worn, worn, drape, ease, *loads, ResultReport(metrics, judge_wear(metrics)))


def write_dress(worn: WornGarment, folder: Path) -> None:
    """Write a garment over another one."""
    write_dressed(replace(dress(worn), inner=worn), folder)


def write_outfits(worn: WornGarment, folder: Path) -> None:
    """Write an outfit of every garment that a person can wear."""
    one = dress(worn)
    garments = dict.fromkeys(("lower", "upper", "one-piece", "outer"), one)
    write_outfit(DressedOutfit(garments, worn.body, one.drape, one.report), folder)


def write_motion(worn: WornGarment, folder: Path) -> None:
    """Write two frames."""
    frames, turned = np.stack([worn.garment.nodes] * 2), np.tile(worn.body.transforms, (2, 1, 1, 1))
    verdicts = (FrameVerdict(True, 1e-4, 1, 1, 4, 0.5),) * 2
    write_animation_result(
        AnimatedGarment(Animation(worn, 25.0, np.arange(2) / 25.0, frames, turned, verdicts), "walk", ResultReport()),
        folder,
    )


def write_edit(worn: WornGarment, folder: Path) -> None:
    """Write a version; the drape took no time."""
    with pytest.MonkeyPatch.context() as patch:
        drape_at_once(patch)
        write_edited(drape_edit(worn, worn.pattern, worn.pattern, Clock(SILENT_HOOKS)), folder)


def write_sizes(worn: WornGarment, folder: Path) -> None:
    """Write the meshes of two draped sizes, by the names that the export of sizes gives them."""
    folder.mkdir()
    for name in ("36", "38"):
        write_ply(worn.garment.nodes, worn.garment.faces, folder / f"draped_{name}.ply")
        write_ply(worn.body.vertices, worn.body.faces, folder / f"body_{name}.ply")


WRITERS = {"dress": write_dress, "refit": write_dress, "outfit": write_outfits, "edit": write_edit,
           "animate": write_motion, "export": write_sizes}  # fmt: skip


def test_every_kind_is_asked_here():
    """Broken where a kind of job is new and nobody looks whether its page shows what it made."""
    # the first two have tests of their own beside this; a re-drape is shown with its recovery
    assert set(KINDS) == {*WRITERS, "recover", "person", "redrape"}


@pytest.mark.parametrize("kind", [name for name in WRITERS if name != "refit"])
def test_the_cloth_of_every_kind_is_shown(kind, worn, keep, window, tmp_path):
    """Broken where a mesh of cloth among a result's files is not offered on its page, or none is seen at first."""
    folder = tmp_path / kind
    WRITERS[kind](worn, folder)
    there = {str(path.relative_to(folder))[:-4] for path in folder.rglob("*.ply")}
    assert any(not name.startswith("body") for name in there)
    page = window
    page.goto(f"/results/{keep(folder)}")
    page.locator("#result[data-ready]").wait_for()
    assert {box.get_attribute("data-mesh") for box in page.locator("[data-mesh]").all()} == there
    beside = {box.get_attribute("data-mesh") for box in page.locator("[data-mesh][data-beside]").all()}
    assert beside == {name for name in there if name == "under" or name.startswith("body")}
    dressed = take_picture(page)
    for name in there:
        if not name.startswith("body"):
            page.locator(f"[data-mesh='{name}']").uncheck()
    assert (np.abs(dressed - take_picture(page)).max(axis=2) > 10).mean() > 0.02


def test_a_stored_version_is_read_with_its_mesh(worn, tmp_path):
    """Broken where programs and exports find no mesh in the result of an edit."""
    write_edit(worn, tmp_path / "edit")
    found = load_result(tmp_path / "edit")
    assert found.meshes == ("edited",) and np.array_equal(found.mesh("edited").nodes, worn.garment.nodes)


def take_picture(page) -> np.ndarray:
    """Return what the view shows, RGB, shape [height, width, 3]."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return np.asarray(Image.open(io.BytesIO(page.locator("#space canvas").screenshot())).convert("RGB"), np.int64)
