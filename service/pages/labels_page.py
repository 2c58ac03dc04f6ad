"""`/results/ID/labels`: view and correct the labels of a person's scan."""

from __future__ import annotations

import json

import numpy as np
from fastapi import Response

from ...core.people.colours import COLOURS, SURE, UNSURE
from ...core.people.part import PARTS
from ..api.access import AppState, AppStateDependency, find_own
from ..derived import InputWrong
from ..models import BodyRow
from ..submission import PERSON_KIND
from .markup import Html, html, join
from .page_route import make_router
from .session import VisitorOf
from .shell import draw_shell

router = make_router()


@router.get("/results/{job}/labels")
def show_labels(job: str, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the page of one person's labels."""
    row = find_own(rooms, visitor.caller, job)
    if row.kind != PERSON_KIND:
        raise InputWrong(f"job {row.id} is a job '{row.kind}'; only a job '{PERSON_KIND}' has labels.")
    data = {
        "parts": [{"value": int(part), "word": part.word, "colour": COLOURS[part]} for part in PARTS],
        "unsure": UNSURE.tolist(), "sure": SURE.tolist(), "plane": _find_sagittal_plane(rooms, row.id),
    }  # fmt: skip
    parts = join(
        html(PART, value=int(part), word=part.word, checked=Html(" checked" if n == 0 else ""), key=n + 1)
        for n, part in enumerate(PARTS)
    )
    content = html(CONTENT, name=row.name, job=row.id, told=json.dumps(data), parts=parts)
    return draw_shell(f"Labels of {row.name}", content, visitor, ["labels/main.js"])


def _find_sagittal_plane(rooms: AppState, job: str) -> dict[str, list[float]] | None:
    """Return a point [m] between a person's hips and shoulders, and the unit vector to their left; None if unknown."""
    with rooms.database.read() as session:
        body = session.get(BodyRow, job)
    joints = body.joints if body else {}
    sides = [[f"{side}_{joint}" for joint in TRUNK] for side in ("left", "right")]
    if not all(name in joints for side in sides for name in side):
        return None
    left, right = (np.mean([joints[name] for name in side], axis=0) for side in sides)
    width = float(np.linalg.norm(left - right))
    if not width > 0.0:
        return None
    return {"point": ((left + right) / 2.0).tolist(), "normal": ((left - right) / width).tolist()}


TRUNK = ("hip", "shoulder")
"""Joints between whose left and right ones the sagittal plane lies."""

PART = """<label><input type="radio" name="part" value="{value}"{checked}>
<span class="swatch" data-part="{value}"></span> {word} <kbd>{key}</kbd>
<span class="counts soft"><span data-unsure="{value}"></span> <span data-count="{value}"></span></span></label>"""

CONTENT = """<link rel="stylesheet" href="/static/labels/labels.css">
<h1>Labels of {name}</h1>
<p class="soft">The part of each point of the scan, and its confidence. Corrected labels start a new job for the
same scan; <a href="/results/{job}">job {job}</a> does not change.</p>
<div id="problem"></div>
<div id="labels" data-job="{job}" data-told="{told}">
<div class="view"><div id="scene"></div><svg id="outline" aria-hidden="true"><polygon/><polygon/></svg>
<div id="aim" aria-hidden="true"></div>
<p id="said" role="status" class="soft">Loading the scan.</p></div>
<div class="tools">
<fieldset><legend>Colours</legend>
<label><input type="radio" name="colours" value="parts" checked> parts</label>
<label><input type="radio" name="colours" value="confidence"> confidence</label>
<span class="scale" hidden><span>0.5 or less</span> <span class="bar"></span> <span>1</span></span></fieldset>
<p id="unsure" class="soft"></p>
<div class="row" role="group" aria-label="View from">
<button type="button" data-view="0">Front</button> <button type="button" data-view="180">Back</button>
<button type="button" data-view="90">Left</button> <button type="button" data-view="-90">Right</button></div>
<fieldset id="tool"><legend>Tool</legend>
<label><input type="radio" name="tool" value="look" checked> look <kbd>L</kbd></label>
<label><input type="radio" name="tool" value="brush"> brush <kbd>B</kbd></label>
<label><input type="radio" name="tool" value="lasso"> lasso <kbd>O</kbd></label>
<label><input type="radio" name="tool" value="fill"> fill <kbd>F</kbd></label>
<label><input type="radio" name="tool" value="ring"> ring <kbd>R</kbd></label>
<label class="own" data-tool="brush">radius <input id="radius" type="range" min="5" max="120" value="25">
<output id="radius-mm" for="radius">25 mm</output></label>
<div class="row own" data-tool="ring"><button type="button" id="up">Up 5 mm</button>
<button type="button" id="down">Down 5 mm</button></div></fieldset>
<fieldset id="part"><legend>Part to paint</legend>{parts}</fieldset>
<fieldset id="mirror"><legend>Copy to the wearer's other side</legend><div class="row">
<button type="button" id="mirror-last">Last change</button>
<button type="button" id="mirror-left">Left side</button>
<button type="button" id="mirror-right">Right side</button></div></fieldset>
<div class="row"><button type="button" id="undo">Undo</button> <button type="button" id="redo">Redo</button></div>
<p id="changed">Nothing is changed.</p>
<div class="row"><button type="button" id="again" class="primary">Run again with these labels</button></div>
<div id="made" role="status"></div>
<details><summary>Mouse and keyboard</summary>
<p>Look: drag turns the view, the wheel zooms. Other tools work where you press; the right button turns the view.
Letters, digits and Ctrl keys work on the whole page. With the view focused arrows turn it, plus and minus zoom, Space
works at the cross in the middle,
page up and page down move the ring, [ and ] change the brush, 1 to 8 choose the part, Ctrl+Z and Ctrl+Y undo and redo.
</p>
<p>Lasso: draw an outline around points; those that are visible get the part. Fill: paints all connected points that
have the part of the place you press. Ring: press near the border of two parts; then move that border.</p></details>
</div></div>"""
