"""Measure how soon pages are there, with WebGL and drawing by software: a result's first view, and the list of jobs.

    python benchmarks/pages.py            # both; or one of view, list
    python benchmarks/pages.py view --cores 2

Server, browser and this program share as many cores as are named (1). A home of its own is made: a T-shirt with four
meshes of 4 000 vertices, body, scan and pattern, and for the list 10 000 ended jobs. `view` opens the result, each time
in a window that has never seen it; it is the time from the request until the page is at rest: the first mesh and the
pattern are drawn, and everything else is there. `list` goes from one page of 50 families to the next in one window; it
is the time from the request until the page is painted. Printed are medians of the wall clock, the milestones on the
way, and the CPU seconds of server, browser and this program.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "standin"))

from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.result import write_recovery
from garmentq.core.garment.meshes import Meshes
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.recover.drape.stage import remesh
from garmentq.core.recover.recovery import Recovery
from garmentq.core.run.report import ResultReport
from garmentq.core.scan.contours.target import Target
from garmentq.core.scan.scan import Scan
from garmentq.service.jobs import claim
from garmentq.service.kinds.recover import Recover
from garmentq.service.local_token import make_local_token
from garmentq.service.results import store_result
from garmentq.service.services import open_services
from garmentq.service.settings import ServiceSettings
from garmentq.service.submission import Order, submit
from playwright.sync_api import Browser, Page, sync_playwright
from service_load import fill, serving

FLAGS = ("--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-background-networking")
VERTICES = 4000
JOBS = 10_000

WATCH = """
window.milestones = {};
const note = (name, at = performance.now()) => {
    window.milestones[name] ??= at;
    document.documentElement.setAttribute(`data-at-${name.replaceAll(' ', '-')}`, '');
};
const painted = (name) => requestAnimationFrame(() => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => note(name);
    port2.postMessage(0);
});
new MutationObserver(() => {
    const place = document.querySelector('#result');
    if (place?.dataset.shown) painted('first mesh');
    if (place?.dataset.ready) painted('at rest');
}).observe(document, { subtree: true, attributes: true, attributeFilter: ['data-shown', 'data-ready'] });
new PerformanceObserver((list) => {
    const [first] = list.getEntriesByName('first-contentful-paint');
    if (first) note('painted', first.startTime);
}).observe({ type: 'paint', buffered: true });
"""
"""Notes when a page is where, in ms after its request began."""


def keep_result(settings: ServiceSettings) -> str:
    """Store the result of a T-shirt that hangs on the built-in body, and return the job's id."""
    draped = load_draped_template("tshirt")
    if draped is None:
        raise SystemExit("no drape is shipped for this machine's triangulation")
    garment, body = remesh(draped, VERTICES), builtin_body("builtin:female,height=1.70")
    nodes, contours = garment.nodes, draped.contours
    scan, target = Scan(nodes, garment.faces, name="shirt"), Target(nodes, garment.faces, nodes, contours, (), "tshirt")
    meshes = Meshes(nodes * 1.001, nodes, nodes * 1.002, nodes * 1.003)
    fabric = get_fabric("single_jersey")
    recovery = Recovery(
        scan, body, target, "tshirt", garment.pattern, fabric, garment, meshes, ResultReport(manifest={"seed": 0})
    )
    services = open_services(settings)
    with tempfile.TemporaryDirectory() as folder:
        given, out = Path(folder) / "given", Path(folder) / "out"
        given.write_bytes(b"ply")
        job = submit(
            services.database,
            services.store,
            Order(given.rename(given.with_suffix(".ply")), BuiltinWearer("builtin:female")),
        ).job
        write_recovery(recovery, out)
        held = claim(services.database, job, "benchmark", 600.0)
        store_result(services.database, services.store, held, Recover(), recovery, out)
    services.database.dispose()
    return job


def used(pid: int) -> float:
    """Return the CPU seconds of a process and of all below it that live."""
    parents, seconds = {}, {}
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            try:
                words = (folder / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            parents[int(folder.name)] = int(words[1])
            seconds[int(folder.name)] = (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")
    chosen = {pid}
    while more := {one for one, parent in parents.items() if parent in chosen} - chosen:
        chosen |= more
    return sum(seconds.get(one, 0.0) for one in chosen)


@contextmanager
def opened(browser: Browser, url: str, token: str) -> Iterator[Page]:
    """Open a window that has seen nothing, signed in, for the block."""
    context = browser.new_context(base_url=url, viewport={"width": 1280, "height": 900})
    context.add_init_script(WATCH)
    context.request.post("/signin", form={"token": token})
    yield context.new_page()
    context.close()


def read(page: Page, last: str) -> dict[str, float]:
    """Return when the page was where [s], once it is at its last milestone."""
    page.locator(f"html[data-at-{last.replace(' ', '-')}]").wait_for(state="attached", timeout=120_000)
    return {name: at / 1000 for name, at in page.evaluate("window.milestones").items()}


def show(what: str, found: list[dict[str, float]], last: str) -> None:
    """Print the medians; the first, which compiles, does not count."""
    told = {name: statistics.median(one[name] for one in found[1:]) for name in found[0]}
    worst = max(one[last] for one in found[1:])
    text = ", ".join(f"{name} {value:.3f} s" for name, value in sorted(told.items(), key=lambda one: one[1]))
    print(f"{what}: {text}; the slowest of {len(found) - 1} {worst:.3f} s", flush=True)


def measure_view(browser: Browser, home: tuple[str, str], job: str, count: int) -> None:
    """Open a result, each time in a window that has seen nothing."""
    found = []
    for _ in range(count + 1):
        with opened(browser, *home) as page:
            before = used(os.getpid())
            page.goto(f"/results/{job}")
            found.append(read(page, "at rest") | {"CPU": used(os.getpid()) - before})
    show("view", found, "at rest")


def measure_list(browser: Browser, home: tuple[str, str], count: int) -> None:
    """Go from page to page of the list in one window, from its first to older jobs."""
    found = []
    with opened(browser, *home) as page:
        page.goto("/")
        for _ in range(count + 1):
            page.wait_for_load_state("networkidle")
            before = used(os.getpid())
            url = page.locator("a[rel=next]").get_attribute("href") or ""
            page.goto(url, wait_until="commit")
            found.append(read(page, "painted") | {"CPU": used(os.getpid()) - before})
    show("list", found, "painted")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", default=["view", "list"], help="some of view, list")
    parser.add_argument("--cores", type=int, default=1, help="cores for all of it [1]")
    parser.add_argument("--count", type=int, default=5, help="times that each page is opened [5]")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        settings = ServiceSettings(home=Path(folder))
        job = keep_result(settings) if "view" in given.parts else ""
        if "list" in given.parts:
            services = open_services(settings)
            fill(services.database, JOBS, "succeeded")
            services.database.dispose()
        token = make_local_token(settings.home)
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: given.cores])
        with serving(settings) as (_, url), sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
            if "view" in given.parts:
                measure_view(browser, (url, token), job, given.count)
            if "list" in given.parts:
                measure_list(browser, (url, token), given.count)
            browser.close()


if __name__ == "__main__":
    main()
