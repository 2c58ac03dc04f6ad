"""Exports for other programs as jobs: from a stored result and its scan to files, by the service."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.meshes import write_ply
from garmentq.core.deliver.export.program_formats import read_colours
from garmentq.core.deliver.formats.registry import FORMATS
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.reading import Reading, save_reading
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.recover.recovery import Request
from garmentq.core.reuse.wear.worn import WornGarment, save_worn
from garmentq.core.run.errors import GarmentqError
from garmentq.core.scan.pieces import ScanInput
from garmentq.core.scan.scan import Scan
from garmentq.service.derived import DerivedOrder
from garmentq.service.jobs import claim
from garmentq.service.kinds.export_request import find_scan
from garmentq.service.kinds.recover import Recover
from garmentq.service.local import LocalBackend
from garmentq.service.models import ArtifactRow, JobInputRow, JobRow
from garmentq.service.results import store_result
from garmentq.service.submission import Order, submit
from garmentq_family_home import work_off
from garmentq_standin import make_recovery
from PIL import Image


@pytest.fixture(scope="session")
def database_kind():
    """Ask of SQLite only: exports are made by the same functions as all jobs."""
    return "sqlite"


@pytest.fixture(scope="module")
def worn() -> WornGarment:
    """Return a skirt as it hangs on the built-in body."""
    garment, body = load_draped_template("skirt"), builtin_body("builtin:female,height=1.70")
    return WornGarment(garment, get_fabric("denim"), body, None, None, "skirt", "skirt")


def keep(home: tuple, worn: WornGarment, folder, colours: np.ndarray | None) -> str:
    """Store a recovery of the garment in centimetres, z up, whose scan has colours; return the job."""
    _, database, store = home
    nodes, faces = worn.garment.nodes, worn.garment.faces
    turned = 100.0 * nodes[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    folder.mkdir()
    trimesh.Trimesh(turned, faces, vertex_colors=colours, process=False).export(folder / "My Skirt.ply")
    job = submit(database, store, Order(folder / "My Skirt.ply", "builtin:female,height=1.70")).job
    out = folder / "made"
    out.mkdir()
    save_worn(worn, out)
    for name in ("graded", "detail"):
        write_ply(nodes, faces, out / f"{name}.ply")
    told = {"scan": {"name": "My Skirt", "units": "cm", "up": "z"}}
    (out / "manifest.json").write_text(json.dumps(told))
    held = claim(database, job, "test", 60.0)
    store_result(database, store, held, Recover(), make_recovery(Request(out / "x.ply"), 3.0), out)
    return job


def export(home: tuple, job: str, form: str, folder) -> dict:
    """Export a job, and return its files by name."""
    backend = LocalBackend(home[0])
    made = backend.submit_derived(DerivedOrder("export", job, {"format": form}))
    work_off(home[0], home[1])
    report = backend.find_job(made.job)
    assert (report.state, report.error) == ("succeeded", None)
    files = {path.name: path for path in backend.export_files(made.job, folder / form)}
    backend.close()
    return files


@pytest.fixture
def home(settings, database, store) -> tuple:
    """Return where jobs are."""
    return settings, database, store


def test_every_format_is_made_of_a_stored_result(home, worn, tmp_path):
    """Broken where a format lacks a file of the result, files of two garments have one name, or colours are lost."""
    height = np.clip(255.0 * (worn.garment.nodes[:, 1] - 0.3), 0, 255).astype(np.uint8)
    job = keep(home, worn, tmp_path / "scan", np.column_stack([height, 255 - height, height]))
    stem = "my_skirt"
    named = {
        "clo": {f"{stem}.clo.json", f"{stem}_clo.py"},
        "blender": {f"{stem}_{part}" for part in ("sewing.obj", "worn.obj", "body.obj", "blender.py")},
        "obj": {f"{stem}_{mesh}.{end}" for mesh in ("graded", "detail") for end in ("obj", "mtl", "json")},
        "glb": {f"{stem}_graded.glb", f"{stem}_detail.glb"},
    }
    for form, names in named.items():
        assert set(export(home, job, form, tmp_path)) == names
    files = export(home, job, "texture", tmp_path)
    assert {f"{stem}_textured.glb", f"{stem}_texture.png"} <= set(files)
    assert sum("_print_" in name for name in files) == 2
    mask = np.asarray(Image.open(files[f"{stem}_texture_mask.png"]))
    assert (mask == 255).sum() > 0.98 * (mask > 0).sum()  # the scan was put where the garment is
    mesh = trimesh.load(files[f"{stem}_textured.glb"], process=False, force="mesh")
    image = np.asarray(mesh.visual.material.baseColorTexture)[..., 0]
    u, v = np.clip(mesh.visual.uv, 0.0, 1.0 - 1e-9).T * len(image)
    shown = image[(len(image) - 1 - v.astype(int)), u.astype(int)]
    assert np.abs(shown - np.clip(255.0 * (mesh.vertices[:, 1] - 0.3), 0, 255)).mean() < 2.0


def test_usd_is_made_of_a_stored_result(home, worn, tmp_path):
    """Broken where the format is not known, or needs more than the result holds."""
    pytest.importorskip("pxr", reason="usd-core is not installed: pip install garmentq[usd]")
    job = keep(home, worn, tmp_path / "scan", None)
    assert set(export(home, job, "usd", tmp_path)) == {"my_skirt_graded.usd", "my_skirt_detail.usd"}


def test_what_cannot_be_written_ends_with_a_code(home, worn, tmp_path):
    """Broken where a scan without colours, or a garment without its detail mesh, ends in a traceback."""
    backend = LocalBackend(home[0])
    job = keep(home, worn, tmp_path / "scan", None)
    done = backend.submit_derived(DerivedOrder("export", job, {"format": "texture"}))
    work_off(home[0], home[1])
    assert backend.find_job(done.job).error.code == "scan.colours_missing"
    with pytest.raises(GarmentqError) as caught:  # whoever knows a hash has not handed the file in
        scan = {"sha256": "0" * 64, "name": "x.ply"}
        backend.submit_derived(DerivedOrder("export", job, {"format": "texture", "scan": scan}))
    assert caught.value.code == "job.request_bad"
    backend.close()


def test_a_hostile_pattern_ends_with_a_code(home, tmp_path):
    """Broken where a seam of 2 mm reaches a file that drops every seam then."""
    corners = np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 0.002], [0.3, 0.3], [0.0, 0.3]])
    panels = tuple(Panel(name, corners, (Edge(),) * 5) for name in ("a\n<b>", "../b"))
    seams = tuple(Seam(EdgeRef(panels[0].name, n), EdgeRef(panels[1].name, n)) for n in (1, 2))
    garment = mesh_pattern(Pattern("x", panels, seams), edge_length=0.05)
    body = builtin_body("builtin:female,height=1.70")
    job = keep(home, WornGarment(garment, get_fabric("denim"), body, None, None, "x", "skirt"), tmp_path / "scan", None)
    backend = LocalBackend(home[0])
    done = backend.submit_derived(DerivedOrder("export", job, {"format": "clo"}))
    work_off(home[0], home[1])
    assert backend.find_job(done.job).error.code == "export.seam_unsewable"
    backend.close()
    files = export(home, job, "glb", tmp_path)
    assert len(files) == 2


def test_a_garment_of_a_person_has_the_person_s_reading_for_its_scan(home, worn, tmp_path):
    """Broken where the colours of a raw scan's garments cannot be had, for they have no file of their own."""
    _, database, store = home
    parent = keep(home, worn, tmp_path / "scan", None)
    colours = np.full((len(worn.garment.nodes), 3), 0.5)
    scan = Scan(worn.garment.nodes, worn.garment.faces, colours=colours)
    save_reading(Reading(ScanInput(scan, None)), tmp_path / "reading.npz")
    kept = store.put(tmp_path / "reading.npz")
    with database.write() as session:
        row = session.get(JobRow, parent)
        session.add(ArtifactRow(job=parent, kind="result", name="lower/reading.npz", sha256=kept.sha256,
                                size=kept.size, created=row.created))  # fmt: skip
        session.add(JobInputRow(job=parent, name="person", input=parent))
        row.request = {**{key: value for key, value in row.request.items() if key != "scan"}, "part": "lower"}
    with database.read() as session:
        found = find_scan(session, session.get(JobRow, parent))
    assert found == {"sha256": kept.sha256, "name": "reading.npz"}
    assert read_colours(store.copy(kept.sha256, tmp_path / "again" / "reading.npz"), tmp_path).is_coloured.all()


def test_formats_are_those_that_the_documentation_names():
    """Broken where a format is added or renamed and no page says so."""
    assert {"clo", "blender", "obj", "glb", "usd", "texture"} <= set(FORMATS)
