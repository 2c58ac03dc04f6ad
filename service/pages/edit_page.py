"""`/results/ID/edit` and `/templates/NAME/edit`: change a pattern and see it draped."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from fastapi import Response

from ..api.access import AppStateDependency, find_own
from ..templates import read_template
from .markup import Html, html, join
from .page_route import make_router
from .pattern_names import describe_names
from .session import VisitorOf
from .shell import Visitor, draw_shell
from .stored_files import find_file, read_bytes

router = make_router()

TOOLS = (("select", "Select"), ("pan", "Pan"), ("cut", "Cut line"), ("ruler", "Ruler"))
"""Tools for dragging on an empty place: name and title."""

CHECKS = (
    ("symmetric", "Keep symmetry", "a change applies to the mirror image too"),
    ("sewn", "Keep seams", "points sewn to a moved point follow, so that both sides of a seam keep equal lengths"),
    ("align", "Snap to points", "a dragged point aligns with others; Alt suspends this"),
    ("handles", "Handles", "of the selected curves"),
    ("possible", "Possible points", "possible places for control points; click one to add it"),
    ("between", "Mirrored panels", "panels that are mirror images have one colour"),
    ("within", "Symmetry within panels", "axes; mirrored points have one colour"),
    ("difference", "Difference", "the recovered pattern, or the template, dashed"),
)
"""Options that are on or off: name, title, effect. The first two apply to every change."""

NUMBERS = (
    ("step", "Step of arrow keys [mm]", 1, 0.1),
    ("grid", "Grid [mm], 0: none", 0, 0.5),
    ("allowance", "Allowance shown [mm]", 0, 1),
)
"""Options that are numbers: name, title, minimum, step."""

DIRECTIONS = (
    ("down", "down, along the grain"), ("up", "up, along the grain"), ("out", "outward, square to the edge"),
    ("in", "inward, square to the edge"), ("along", "along the edge"),
)  # fmt: skip
"""Directions of a typed distance: name and title."""

DEFAULT_CHECKS = ("symmetric", "sewn", "align", "handles")
"""Options that are on when the page opens."""


@router.get("/results/{job}/edit")
def edit_result(job: str, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the editor with the pattern of a result."""
    row = find_own(rooms, visitor.caller, job)
    file = find_file(rooms, row.id, "pattern.json")
    names = describe_names(read_bytes(rooms, file)) if file is not None else {}
    return _draw_editor(row.name, visitor, names, job=row.id)


@router.get("/templates/{name}/edit")
def edit_template(name: str, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the editor with a template, which has no drape."""
    return _draw_editor(name, visitor, describe_names(read_template(rooms, name)), template=name)


def _draw_editor(name: str, visitor: Visitor, names: Mapping[str, Any], job: str = "", template: str = "") -> Response:
    back = html('<a href="/results/{}">Result</a>', job) if job else Html()
    content = html(
        EDITOR, name=name, job=job, base=template, back=back, names=json.dumps(names),
        tools=join(
            html('<button type="button" data-tool="{}" aria-pressed="{}">{}</button>', tool, pressed, words)
            for pressed, (tool, words) in zip(("true", "false", "false", "false"), TOOLS, strict=True)
        ),
        checks=join(
            html('<label title="{}"><input type="checkbox" data-option="{}"{}> {}</label>', title, option,
                 Html(" checked") if option in DEFAULT_CHECKS else Html(), words)
            for option, words, title in CHECKS
        ),
        numbers=join(
            html('<label>{} <input type="number" data-option="{}" value="{}" min="0" max="1000" step="{}"></label>',
                 words, option, value, step)
            for option, words, value, step in NUMBERS
        ),
        directions=join(html('<option value="{}">{}</option>', *one) for one in DIRECTIONS),
        drape=html(DRAPE) if job else Html(), start=html(START) if job else Html(),
        compared="recovered pattern" if job else "template",
    )  # fmt: skip
    return draw_shell(f"Edit {name}", content, visitor, ["edit/editor.js"])


EDITOR = """<link rel="stylesheet" href="/static/edit/edit.css">
<div id="editor" data-job="{job}" data-template="{base}" data-names="{names}">
<div class="row head"><h1>Edit {name}</h1>{back}{start}</div>
<div class="toolbar" id="commands"><div class="group" role="group" aria-label="Tool">{tools}</div></div>
<form class="toolbar" id="distance" aria-label="Distance">
<label>Line <select id="line"></select></label>
<label>Distance <input id="amount" size="8" value="10 mm" autocomplete="off"
 title="a number with mm, cm or inch; without a unit: mm"></label>
<label>Direction <select id="direction">{directions}</select></label>
<button type="submit">Move</button>
<button type="button" data-sized="spread" title="cut from the first selected point to the second and open the cut by the
 distance, or by an angle as in 5°; the second point is the hinge">Slash and spread</button>
<label>Dart's length <input id="depth" size="8" value="100 mm" autocomplete="off"></label>
<button type="button" data-sized="dart" title="add a dart in the middle of the selected edge; the distance is its
 width">Add dart</button>
</form>
<p id="said" role="status" aria-live="polite">Loading the pattern.</p>
<p id="board-help" class="hushed">
Arrow keys move the selection, or the view if nothing is selected. N and P select the next and
the previous control point. The list of shortcuts has the others.</p>
<div class="boards">
<svg id="board" class="board" tabindex="0" role="application" aria-label="Pattern"
 aria-describedby="board-help"></svg>
<div id="draped" class="draped" hidden></div>
<div class="beside">
<section class="card" aria-labelledby="options-title"><h2 id="options-title">Options</h2>
<div class="choices">{checks}{numbers}</div></section>
<section class="card" aria-labelledby="selection-title"><h2 id="selection-title">Selection</h2>
<div id="selection"></div></section>
</div>
</div>
<div class="asides">
<section class="card" aria-labelledby="file-title"><h2 id="file-title">File</h2>
<div class="row"><button type="button" id="download">Download JSON</button>
<label class="row">Template's name
<input id="template-name" maxlength="64" autocomplete="off"></label>
<button type="button" id="save-template">Save as template</button></div>
<div id="saved" role="status"></div></section>
{drape}
<section class="card" aria-labelledby="seams-title"><h2 id="seams-title">Seams</h2><p id="seams-summary"></p>
<p class="soft">Lengths of both sides in mm; ×: a gathered seam's ratio.</p>
<div class="wide" tabindex="0" role="region" aria-label="Lengths of seams"><table><thead><tr><th scope="col">Sides</th>
<th scope="col" class="number">mm</th><th scope="col" class="number">mm</th>
<th scope="col" class="number">difference</th></tr></thead><tbody id="seams"></tbody></table></div>
</section>
<section class="card" aria-labelledby="difference-title"><h2 id="difference-title">Difference to the {compared}</h2>
<ul id="differences"></ul></section>
<details class="card"><summary>Shortcuts</summary><dl id="shortcuts" class="keys"></dl></details>
</div>
</div>"""
"""The page; its script fills in buttons, tables and drawings."""

DRAPE = """<section class="card" aria-labelledby="drape-title"><h2 id="drape-title">Drape</h2>
<div id="findings"></div><div id="verdicts"></div>
<h3>Versions</h3><ul id="versions"><li>None yet.</li></ul></section>"""
"""Section for a result's pattern, not for a template: the drape and the versions."""

START = """<div class="row start"><label>Version's name <input id="version-name" maxlength="80"
 autocomplete="off"></label>
<button type="button" id="drape" class="primary">Drape and save the version</button>
<button type="button" id="cancel-drape" hidden>Cancel</button><div id="draping" role="status"></div></div>"""
"""What starts a drape, in view above the board."""
