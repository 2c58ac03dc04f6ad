"""A pattern maker's story: a hem is lowered by a typed distance, a dart turned, a hem spread, a drape begun."""

from __future__ import annotations

import numpy as np
import pytest
from editor_page import Editor
from garmentq.core.garment.pieces.edge_names import name_edges
from garmentq.core.garment.pieces.seam_names import is_dart
from garmentq.core.garment.seams import seam_mismatch


@pytest.fixture(scope="module")
def opened(open_window, shirt):
    """Open the editor on a small screen of a laptop."""
    with open_window(viewport={"width": 1280, "height": 800}) as context:
        page = context.new_page()
        page.goto(f"/results/{shirt}/edit")
        page.locator("#said", has_text="Ready.").wait_for()
        yield page


def select(page, *items: dict) -> None:
    """Select as the board does."""
    page.evaluate("(items) => document.querySelector('#editor').session.select(items)", list(items))


def test_a_hem_is_lowered_a_dart_turned_and_a_hem_spread(opened):
    """Broken where a typed distance moves by another length, a step is not undone as one, a tool leaves sides of a seam
    that differ, or the button that drapes is out of view."""
    editor, page = Editor(opened), opened
    before, text = editor.pattern(), editor.text()
    names = name_edges(before)["front"]
    hem = names.lines.index("hem")
    ends = [hem, (hem + 1) % len(names.lines)]
    page.select_option("#line", label="front hem")
    page.locator("#selection", has_text="Whole hem, on front, back").wait_for()
    page.fill("#amount", "3 cm")
    page.select_option("#direction", "down")
    page.press("#amount", "Enter")
    assert page.inner_text("#said") == "front hem lowered by 30.0 mm."
    lowered = editor.pattern()
    moved = lowered.panel("front").points[ends] - before.panel("front").points[ends]
    np.testing.assert_allclose(moved, [[0.0, -0.03]] * 2, atol=1e-9)
    assert seam_mismatch(lowered) < 1e-6
    overlaps = "overlaps(session.pattern, (name) => session.placeOf(name), session.pieces)"
    assert not editor.module("layout", overlaps)
    page.click("[data-command=undo]")
    assert editor.text() == text
    page.click("[data-command=redo]")

    side = names.lines.index("side seam")
    select(page, {"panel": "front", "edge": side})
    page.fill("#amount", "20")
    page.fill("#depth", "120")
    page.click("[data-sized=dart]")
    darted = editor.pattern()
    assert sum(is_dart(darted, seam) for seam in darted.seams) == 2
    assert seam_mismatch(darted) < 1e-6
    (apex, *_) = editor.module("darts", "listDarts(session.present)")
    count = len(darted.panel("front").points)
    reach = darted.panel("front").points - darted.panel("front").points[(apex["first"] + 1) % count]
    own = {(apex["first"] + k) % count for k in range(3)}
    inner = [k for k in np.argsort(np.linalg.norm(reach, axis=1)) if int(k) not in own]
    said = ""
    for target in inner:  # the nearest point that a straight line inside the panel reaches
        select(page, {"panel": "front", "point": (apex["first"] + 1) % count}, {"panel": "front", "point": int(target)})
        page.click("[data-command=pivot]")
        said = page.inner_text("#said")
        if said.startswith("The dart is turned"):
            break
    assert said == "The dart is turned about its apex; its angle is kept."
    assert seam_mismatch(editor.pattern()) < 1e-6
    page.click("[data-command=undo]")

    select(page, {"panel": "front", "edge": editor.module("names", LAST_HEM)})
    page.click("[data-command=add]")
    point = page.evaluate("document.querySelector('#editor').session.selection[0].point")
    select(page, {"panel": "front", "point": point}, {"panel": "front", "point": editor.module("names", NECK)})
    page.fill("#amount", "4 cm")
    page.click("[data-sized=spread]")
    assert page.inner_text("#said") == "Opened by 4 cm at the first point; the second is the hinge."
    assert seam_mismatch(editor.pattern()) < 1e-6
    drape = page.locator("#drape").bounding_box()
    page.evaluate("scrollTo(0, 0)")
    assert drape["y"] + drape["height"] < 800.0
    page.fill("#version-name", "longer, with darts")
    page.click("#drape")
    page.locator("#draping progress").wait_for()
    page.click("#cancel-drape")
    page.locator("#draping .error", has_text="cancelled").wait_for()


LAST_HEM = "listLines(session.present).find(({ words }) => words === 'front hem').edges[0].edge"
"""The number of the edge of the front hem."""

NECK = """listLines && (() => {
    const { edges } = session.present.panels.find(({ name }) => name === 'front');
    return edges.findIndex((edge) => edge.title?.corner === 'CF of the neckline');
})()"""
"""The number of the front neckline's middle point."""
