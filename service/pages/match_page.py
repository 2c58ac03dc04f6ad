"""`/match?a=JOB&b=JOB`: two patterns in two rows, their panels paired and compared."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query, Response

from .markup import html
from .page_route import make_router
from .session import VisitorOf
from .shell import draw_shell

router = make_router()

Word = Annotated[str, Query(max_length=64)]
"""A job, a template's name, or the sha256 of an uploaded pattern."""


@router.get("/match")
def show_match(visitor: VisitorOf, a: Word = "", b: Word = "") -> Response:
    """Return the matcher; its script requests `/v1/match`, with the pairs in the page's address."""
    return draw_shell("Match", html(CONTENT, a=a, b=b), visitor, ["match/main.js"], place="/match")


CONTENT = """<link rel="stylesheet" href="/static/match/match.css">
<h1>Compare two patterns</h1>
<form id="choose" class="card" method="get" action="/match" data-a="{a}" data-b="{b}">
<fieldset><legend>First pattern</legend>
<label for="a">Job or template</label> <select id="a" name="a"></select>
<label for="a-file">or a file</label> <input id="a-file" type="file" accept=".json"></fieldset>
<fieldset><legend>Second pattern</legend>
<label for="b">Job or template</label> <select id="b" name="b"></select>
<label for="b-file">or a file</label> <input id="b-file" type="file" accept=".json"></fieldset>
<button type="submit" class="primary">Compare</button>
</form>
<div id="problem"></div>
<p id="working" role="status" hidden><progress aria-label="Comparing"></progress> Comparing the patterns.</p>
<div id="match" hidden>
<section class="card" aria-labelledby="pieces-title">
<h2 id="pieces-title">Pieces</h2>
<p class="soft" id="how">Choose a piece of each row and pair them. Drag moves a piece, the round handle turns it.
By keyboard: Enter chooses, arrows move by 10 mm (Shift: 1 mm), comma and full stop turn by 5° (Shift: 1°), P pairs, U
unpairs, Escape chooses none.</p>
<div class="row" role="toolbar" aria-label="Chosen pieces">
<button type="button" id="pair">Pair</button> <button type="button" id="part">Unpair</button>
<button type="button" id="left">Turn left</button> <button type="button" id="right">Turn right</button>
<button type="button" id="reset">Put back</button> <button type="button" id="propose">Propose pairs</button>
</div>
<div id="rows"></div>
</section>
<div class="beside">
<section class="card" aria-labelledby="pairs-title"><h2 id="pairs-title">Pairs</h2>
<div class="wide" tabindex="0" role="region" aria-labelledby="pairs-title"><table id="pairs"></table></div>
<p id="summary" role="status"></p>
<div class="row"><button type="button" id="save-csv">Save as CSV</button>
<button type="button" id="save-json">Save as JSON</button>
<button type="button" id="save-pairs">Save only the pairs</button></div></section>
<section class="card" aria-labelledby="overlay-title"><h2 id="overlay-title">Overlay</h2>
<div id="overlay"></div></section>
</div>
</div>"""
