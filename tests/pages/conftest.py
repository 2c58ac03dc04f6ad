"""Pages in a real browser, of a real service, of a home with a real stored result."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "api"))

from api_client import address, serving  # noqa: F401
from garmentq.core.body.builtin import builtin_body
from garmentq.core.deliver.export.result import write_recovery
from garmentq.core.garment.meshes import Meshes
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.recover.recovery import Recovery
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.scan.contours.target import Target
from garmentq.core.scan.scan import Scan
from garmentq.service.api.limits import ApiLimits
from garmentq.service.jobs import claim
from garmentq.service.kinds.recover import Recover
from garmentq.service.local_token import make_local_token
from garmentq.service.results import store_result
from garmentq.service.services import Services, open_services
from garmentq.service.settings import ServiceSettings
from garmentq.service.submission import Order, submit
from garmentq.service.terms import JobTerms
from garmentq_home import (  # noqa: F401
    blank_database,
    database,
    database_kind,
    database_url,
    make_settings,
    settings,
    store,
)

CHROMIUM = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
"""WebGL by software, and no request of the browser's own."""

WAIT_MS = 60_000
"""A deadline that only a hang reaches, however loaded the machine is [ms]."""


@dataclass(frozen=True)
class Site:
    """Describe a served home.

    Attributes:
        url: Where it is, `http://127.0.0.1:PORT`.
        services: The open home, for what a worker would do.
        token: What signs the local user in.
        result: Id of a job with a real result: a tube of two panels, four meshes, on a post.
        queue: Queue the scan of a tube under a name; gives the job's id.
        keep: Submit a recovery under a name and store it as a worker would; gives the job's id.
    """

    url: str
    services: Services
    token: str
    result: str
    queue: Callable[[str], str]
    keep: Callable[..., str]

    @property
    def settings(self) -> ServiceSettings:
        """Return the home's settings."""
        return self.services.settings


def find_chromium() -> str | None:
    """Return the browser: GARMENTQ_CHROMIUM, else what the system has."""
    chosen = os.environ.get("GARMENTQ_CHROMIUM") or next(filter(shutil.which, CHROMIUM), None)
    return shutil.which(chosen) if chosen else None


@pytest.fixture(scope="module")
def chromium():
    """Start the browser for a module: while it runs an event loop does too, which other tests must not have."""
    path = find_chromium()
    if path is None:
        pytest.skip("no chromium found: `apt-get install chromium`, or set GARMENTQ_CHROMIUM to its path")
    sync_api = pytest.importorskip("playwright.sync_api")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def site(tmp_path_factory, blank_database, whole_tube, write_once) -> Iterator[Site]:  # noqa: F811
    """Serve a home with one result and no key; tests that change it add jobs of their own."""
    with open_site(tmp_path_factory.mktemp("site"), blank_database, whole_tube, write_once) as opened:
        yield opened


@pytest.fixture
def own_site(tmp_path, blank_database, whole_tube, write_once) -> Iterator[Site]:  # noqa: F811
    """Serve such a home for one test alone, which may make keys."""
    with open_site(tmp_path, blank_database, whole_tube, write_once) as opened:
        yield opened


@contextmanager
def open_site(folder: Path, blank_database: Path, make_recovery, write_once) -> Iterator[Site]:  # noqa: F811
    """Serve a home with one result for the block."""
    home = folder / "home"
    home.mkdir(mode=0o700)
    shutil.copy(blank_database, home / "garmentq.db")
    services = open_services(make_settings(home, writer="garmentq.core.deliver.export.result:write_recovery"))

    def keep(name: str, recovery=None, chosen: RecoverySettings | None = None) -> str:
        recovery = recovery or make_recovery()
        job = queue_scan(services, folder, name, recovery, chosen)
        held = claim(services.database, job, "test", 600.0)
        store_result(services.database, services.store, held, Recover(), recovery, write_once(recovery))
        return job

    with serving(services.settings, ApiLimits()) as url:
        queue = lambda name: queue_scan(services, folder, name, make_recovery())  # noqa: E731
        yield Site(url, services, make_local_token(home), keep("tube"), queue, keep)
    services.database.dispose()


@pytest.fixture(scope="session")
def shirt(site, tube_recovery) -> str:
    """Store the result of a T-shirt as it hangs on the body that it was drafted for; gives the job's id."""
    garment = load_draped_template("tshirt")
    nodes, body = garment.nodes, builtin_body("builtin:female,height=1.70")
    meshes = Meshes(nodes, nodes * 1.001, simulation=nodes, redraped=nodes)
    changes = {"pattern": garment.pattern, "garment": garment, "meshes": meshes, "body": body, "template": "tshirt"}
    target = Target(nodes, garment.faces, nodes, garment.contours, (), "tshirt")
    scan = Scan(nodes, garment.faces, name="shirt")
    return site.keep("shirt", tube_recovery(**changes, target=target, scan=scan))


@pytest.fixture(scope="session")
def whole_tube(tube_recovery) -> Callable[[], Recovery]:
    """Return the maker of a recovery with all four meshes, told apart by size, of a scan that is red above blue."""
    found = tube_recovery()
    nodes = found.garment.nodes
    four = Meshes(found.meshes.graded, found.meshes.detail, nodes * 1.02, nodes * 1.03)
    height = nodes[:, 1] - nodes[:, 1].min()
    above = (height > 0.5 * height.max())[:, None]
    scan = replace(found.scan, colours=np.where(above, [0.8, 0.2, 0.2], [0.2, 0.2, 0.8]))
    return lambda: tube_recovery(meshes=four, scan=scan)


@pytest.fixture(scope="session")
def write_once(tmp_path_factory) -> Callable[[Recovery], Path]:
    """Return the writer of a recovery's files, which writes equal meshes once."""
    written: dict[int, tuple[Path, Recovery]] = {}  # a recovery that is kept leaves its meshes' id to no other

    def write(recovery: Recovery) -> Path:
        key = id(recovery.meshes)
        if key not in written:
            written[key] = tmp_path_factory.mktemp("written"), recovery
            write_recovery(recovery, written[key][0])
        return written[key][0]

    return write


def queue_scan(services: Services, folder: Path, name: str, recovery, chosen: RecoverySettings | None = None) -> str:
    """Submit the scan of a recovery as a file of its own."""
    import trimesh

    own = Path(tempfile.mkdtemp(dir=folder))
    scan, body = own / "scan.ply", own / "body.ply"
    trimesh.Trimesh(recovery.scan.vertices, recovery.scan.faces, process=False).export(scan)
    trimesh.Trimesh(recovery.body.vertices, recovery.body.faces, process=False).export(body)
    order = Order(scan, body, settings=chosen or RecoverySettings(), terms=JobTerms(name, force=True))
    return submit(services.database, services.store, order).job


@pytest.fixture
def faults() -> list[str]:
    """Return the list of what no page may do; a test that expects a refusal takes it from there."""
    return []


@contextmanager
def open_context(chromium, site, faults: list[str], token: str = "", **options) -> Iterator:
    """Open a browser window of its own for the block, signed in with a key or as the local user; `options` are those
    of the browser's `new_context`. Fails where `faults` are left."""
    opened = chromium.new_context(base_url=site.url, **{"viewport": {"width": 1280, "height": 900}} | options)
    opened.set_default_timeout(WAIT_MS)
    host = urlsplit(site.url).netloc

    def watch(page) -> None:
        page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
        page.on("pageerror", lambda error: faults.append(str(error)))

    def look(request) -> None:
        if urlsplit(request.url).scheme in ("http", "https", "ws", "wss") and urlsplit(request.url).netloc != host:
            faults.append(f"a request to {request.url}")

    opened.on("page", watch)
    opened.on("request", look)
    answer = opened.request.post("/signin", form={"token": token or site.token})
    assert answer.ok
    opened.faults = faults
    yield opened
    opened.close()
    assert faults == []


@pytest.fixture(scope="module")
def open_window(chromium, site) -> Callable:
    """Return `open_context` for windows that several tests share, of another key or size, or of another home."""
    return lambda at=site, **options: open_context(chromium, at, [], **options)


@pytest.fixture(scope="session")
def find_barriers() -> Callable:
    """Return a function that lists what axe-core finds serious on a page, in light and in dark."""
    reason = "pip install axe-playwright-python"
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason=reason).Axe()

    def find(page) -> list[tuple[str, str, str, str]]:
        found = []
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
            for one in axe.run(page).response["violations"]:
                if one["impact"] in ("serious", "critical"):
                    found.append((scheme, one["id"], one["impact"], one["nodes"][0]["html"]))
        page.emulate_media(color_scheme="light")
        return found

    return find


@pytest.fixture
def context(chromium, site, faults) -> Iterator:
    """Open a browser window of its own for one test."""
    with open_context(chromium, site, faults) as opened:
        yield opened


@pytest.fixture
def page(context):
    """Open one page of it."""
    return context.new_page()
