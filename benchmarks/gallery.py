"""Measure how soon the gallery is there: 500 persons of a key in a real browser that has seen nothing, cache off.

    python benchmarks/gallery.py              # 500 persons, 5 times
    python benchmarks/gallery.py --keep DIR   # keep the home, to look at it

Each person is a job with a contact sheet as `person` draws it, and two garments with reports as `recover` writes them;
the first 60 persons have files of their own, so that no picture is cut twice. Server, browser and this program share as
many cores as are named (1). Measured is the first page: the time from the request until it is painted, until every
picture in the window is decoded, and the CPU seconds of the server for the page alone and with its pictures. The
service is started anew for each visit: nothing is cached in it either.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import sys
import tempfile
import time
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import httpx

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "standin"))

import numpy as np
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.person import draw_person
from garmentq.core.deliver.export.result import write_recovery
from garmentq.core.garment.meshes import Meshes
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.people.part import Part
from garmentq.core.recover.recovery import Recovery
from garmentq.core.run.report import ResultReport
from garmentq.core.scan.contours.target import Target
from garmentq.core.scan.scan import Scan
from garmentq.service.keys import create_key
from garmentq.service.models import ArtifactRow, JobInputRow, JobRow, JobTagRow, OwnerRow, ScanRow
from garmentq.service.services import Services, open_services
from garmentq.service.settings import ServiceSettings
from pages import FLAGS, used
from playwright.sync_api import sync_playwright
from service_load import serving
from sqlalchemy import insert

OUTFITS = (("tshirt", "trousers"), ("long_sleeve_tshirt", "skirt"), ("tank", "shorts"), ("dress",))
COLOURS = ((0.75, 0.28, 0.25), (0.25, 0.42, 0.68), (0.32, 0.52, 0.36), (0.86, 0.76, 0.55), (0.35, 0.32, 0.38))
NAMES = ("Anna", "Björn", "Chiara", "Dmitri", "Élodie", "Fatima", "Goran", "Hana", "Ines", "Jo")
OWN_FILES = 60

DECODED = """() => Promise.all([...document.images]
    .filter((one) => one.getBoundingClientRect().top < innerHeight && one.getBoundingClientRect().bottom > 0)
    .map((one) => one.decode())).then((all) => [performance.now() / 1000, all.length])"""


def make_sheet(outfit: tuple[str, ...], colours: list[np.ndarray]) -> bytes | None:
    """Draw the contact sheet of the built-in body in draped templates; None if one is not shipped."""
    body = builtin_body("builtin:female,height=1.70")
    garments = [load_draped_template(name) for name in outfit]
    if any(one is None for one in garments):
        return None
    points, faces = [body.vertices], [body.faces]
    shades = [np.tile([0.8, 0.62, 0.52], (len(body.vertices), 1))]
    for garment, colour in zip(garments, colours, strict=False):
        faces.append(garment.faces + sum(map(len, points)))
        points.append(garment.nodes)
        shades.append(np.tile(colour, (len(garment.nodes), 1)))
    count = sum(map(len, points))
    label = np.full(count, Part.UPPER, np.uint8)
    label[: len(body.vertices)] = Part.SKIN
    raw = SimpleNamespace(points=np.concatenate(points), faces=np.concatenate(faces), colours=np.concatenate(shades),
                          is_cloud=False, origin=np.arange(count))  # fmt: skip
    return draw_person(raw, SimpleNamespace(label=label, confidence=np.full(count, 0.97), body=body))  # type: ignore[arg-type]


def make_report(name: str) -> bytes | None:
    """Write the report of a draped template's recovery; None if it is not shipped."""
    garment, body = load_draped_template(name), builtin_body("builtin:female,height=1.70")
    if garment is None:
        return None
    nodes = garment.nodes
    target = Target(nodes, garment.faces, nodes, garment.contours, (), name)
    meshes = Meshes(nodes, nodes * 1.001, simulation=nodes, redraped=nodes)
    recovery = Recovery(Scan(nodes, garment.faces, name=name), body, target, name, garment.pattern,
                        get_fabric("single_jersey"), garment, meshes, ResultReport(manifest={"seed": 0}))  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        write_recovery(recovery, Path(folder))
        return (Path(folder) / "report.html").read_bytes()


def fill_gallery(services: Services, key: str, count: int) -> None:
    """Add persons with their garments, the newest with files of their own."""
    rng = np.random.default_rng(0)
    outfits = [one for one in OUTFITS if all(load_draped_template(name) is not None for name in one)]
    sheets = [(one, make_sheet(one, [np.array(COLOURS[(n + k) % len(COLOURS)]) for k in range(2)]))
              for n, one in enumerate(outfits * 3)]  # fmt: skip
    reports = {name: make_report(name) for one in outfits for name in one}
    rows: dict[type, list[dict[str, Any]]] = {
        one: [] for one in (JobRow, OwnerRow, JobTagRow, ArtifactRow, JobInputRow)
    }

    def add(job: str, created: float, **values: Any) -> None:
        rows[JobRow].append({
            "id": job, "dedup": job, "scan": "0" * 64, "request": {}, "version": "0", "priority": 0,
            "cancel": False, "attempts": 1, "fence": 1, "touched": 0.0, "created": created, "stage": "measure",
            "progress": 1.0, "overall": 1.0, "bad_input": False, "finished": created, "parent": None, "garment": None,
            "error_code": None, "error_message": None} | values)  # fmt: skip
        rows[OwnerRow].append({"key": key, "job": job})
        rows[JobTagRow].append({"job": job, "tag": f"studio {int(values['family'], 16) // 40}"})

    def keep(job: str, name: str, content: bytes) -> None:
        kept = services.store.put_bytes(content)
        rows[ArtifactRow].append({"job": job, "kind": "result", "name": name, "sha256": kept.sha256, "size": kept.size,
                                  "created": 0.0})  # fmt: skip

    now = time.time()
    for n in range(count):
        family, created = f"{16 * n:012x}", now - 600.0 * (count - n)
        own = b"%d" % n if n >= count - OWN_FILES else b""
        outfit, sheet = sheets[n % len(sheets)]
        add(family, created, family=family, kind="person", state="succeeded", name=f"{NAMES[n % 10]} {n}", verdict=None)
        keep(family, "picture.png", sheet + own)
        for k, garment in enumerate(outfit):
            job = f"{16 * n + k + 1:012x}"
            verdict = str(rng.choice(["pass", "doubtful", "fail"], p=[0.7, 0.2, 0.1]))
            word = "one-piece" if garment == "dress" else ("upper", "lower")[k]
            add(job, created + 60, family=family, parent=family, kind="recover", state="succeeded", name=word,
                garment=garment, verdict=verdict)  # fmt: skip
            rows[JobInputRow].append({"job": job, "name": "person", "input": family})
            keep(job, "report.html", reports[garment] + b"<!-- %s -->" % own)
    with services.database.write() as session:
        session.execute(
            insert(ScanRow), [{"sha256": "0" * 64, "name": "s.ply", "size": 1, "created": 0.0, "details": {}}]
        )
        for table, values in rows.items():
            session.execute(insert(table), values)


def measure_page(url: str, token: str, server: int) -> float:
    """Return the CPU seconds of the server for the page alone, a mean of ten after the first."""
    with httpx.Client(base_url=url) as client:
        client.post("/signin", data={"token": token})
        client.get("/")
        before = used(server)
        for _ in range(10):
            assert client.get("/").status_code == 200
        return (used(server) - before) / 10


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--persons", type=int, default=500, help="persons of the key [500]")
    parser.add_argument("--cores", type=int, default=1, help="cores for all of it [1]")
    parser.add_argument("--count", type=int, default=5, help="visits [5]")
    parser.add_argument("--keep", type=Path, help="folder of the home, which is kept")
    chosen = parser.parse_args()
    with nullcontext(chosen.keep) if chosen.keep else tempfile.TemporaryDirectory() as folder:
        settings = ServiceSettings(home=Path(folder))
        services = open_services(settings)
        key, token = create_key(services.database, "studio", ("read", "submit"))
        fill_gallery(services, key.id, chosen.persons)
        services.database.dispose()
        print(f"a key's token: {token}" if chosen.keep else "", flush=True)
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: chosen.cores])
        found = []
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
            for _ in range(chosen.count):
                with serving(settings) as (process, url):
                    context = browser.new_context(base_url=url, viewport={"width": 1280, "height": 900})
                    context.request.post("/signin", form={"token": token})
                    page, before = context.new_page(), used(process.pid)
                    page.goto("/", wait_until="commit")
                    page.wait_for_load_state("domcontentloaded")
                    shown, pictures = page.evaluate(DECODED)
                    painted = page.evaluate(
                        "performance.getEntriesByName('first-contentful-paint')[0].startTime / 1000"
                    )
                    page.wait_for_load_state("networkidle")
                    loaded = page.evaluate("[...document.images].filter((one) => one.naturalWidth > 1).length")
                    found.append((painted, shown, pictures, loaded, used(process.pid) - before))
                    context.close()
                    alone = measure_page(url, token, process.pid)
            browser.close()
        painted, shown, pictures, loaded, cpu = (statistics.median(values) for values in zip(*found, strict=True))
        print(f"{chosen.persons} persons: painted {painted:.2f} s, {pictures:.0f} pictures in the window decoded "
              f"{shown:.2f} s; slowest {max(one[1] for one in found):.2f} s; server CPU {cpu:.2f} s with {loaded:.0f} "
              f"pictures, {alone:.3f} s for a page alone", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
