"""Pages lead where they say, exist where the code names them, and stay short enough to be read."""

from __future__ import annotations

import re
from pathlib import Path

import garmentq
import pytest

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted([*DOCS.rglob("*.md"), ROOT / "README.md", ROOT / "CHANGELOG.md", ROOT / "SECURITY.md"])
SOURCES = (".py", ".yml", ".toml", ".js", ".html", ".sh", ".md")

WORDS = 30_000
"""Of all pages but decisions and measurements: what a newcomer can read in two hours."""


def anchors_of(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub makes them."""
    titles = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    kept = (re.sub(r"[^\w\- ]", "", re.sub(r"\]\([^)]*\)", "]", title).lower()) for title in titles)
    return {title.strip().replace(" ", "-") for title in kept}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_to_pages_and_headings(page):
    """Broken where a page or a heading was renamed, and a link to it was not."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        linked = (page.parent / path).resolve() if path else page
        assert linked.exists(), target
        if anchor and linked.suffix == ".md":
            assert anchor in anchors_of(linked), target


def test_pages_that_the_code_names_exist():
    """Broken where a message or a help text sends its reader to a page that is gone."""
    folders = (
        "core",
        "service",
        "workers",
        "cli",
        "migrations",
        "tests",
        "benchmarks",
        "training",
        "examples",
        "deploy",
    )
    loose = [ROOT / name for name in ("Makefile", "Dockerfile", "docker-compose.yml", "pyproject.toml", "README.md")]
    found = [path for folder in folders for path in (ROOT / folder).rglob("*") if path.suffix in SOURCES]
    missing = []
    for path in [*loose, *found]:
        named = re.findall(r"\bdocs/[a-z0-9_/-]+\.md\b", path.read_text(encoding="utf-8"))
        missing += [f"{path.relative_to(ROOT)}: {page}" for page in named if not (ROOT / page).exists()]
    assert missing == []


def test_pages_are_short_enough():
    """Broken where a page grows again into what nobody reads."""
    read = [page for page in PAGES if not {"adr", "lab"} & set(page.relative_to(ROOT).parts)]
    assert sum(len(page.read_text(encoding="utf-8").split()) for page in read) <= WORDS


MAX_PICTURE_SIZE = 150_000
"""Of a tutorial's picture [B]: all of them stay in a clone for ever."""


@pytest.mark.parametrize("page", sorted((DOCS / "tutorials").glob("*.md")), ids=lambda page: page.name)
def test_each_tutorial_has_small_pictures_that_can_be_made_again(page):
    """Broken where a tutorial shows nothing, or a picture that is heavy or that no script makes."""
    shown = re.findall(r"!\[[^\]]+\]\((\S+\.png)\)", page.read_text(encoding="utf-8"))
    script = (ROOT / "examples" / "make_pictures.py").read_text(encoding="utf-8")
    assert shown
    for name in shown:
        assert (page.parent / name).stat().st_size <= MAX_PICTURE_SIZE, name
        assert f'"{name}"' in script, name


RELEASE_LINES = 50
"""Of one release in the changelog: a screen."""


def test_the_changelog_has_a_screen_for_each_release():
    """Broken where a version is released without its changes, or where its changes become too many to be read."""
    _, *releases = re.split(r"^## ", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert releases[0].split()[0] == garmentq.__version__
    assert all(len(release.splitlines()) <= RELEASE_LINES for release in releases)


def test_each_study_is_dated_and_listed():
    """Broken where a figure's day is not told, or its study cannot be found."""
    listed = (DOCS / "lab" / "README.md").read_text(encoding="utf-8")
    for study in sorted((DOCS / "lab").glob("*.md")):
        if study.name != "README.md":
            assert re.search(r"20\d\d-\d\d", study.read_text(encoding="utf-8")), study.name
            assert f"({study.name})" in listed, study.name
