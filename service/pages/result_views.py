"""The 3D view of a result beside its flat pattern."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from ..records import JobReport
from .help_note import draw_heading
from .markup import Html, html, join
from .shown_meshes import BODY, SCANS, WORN, WORN_TOGETHER, is_companion_mesh, list_shown

STYLES = {
    "cloth": "Cloth",
    "texture": "Texture",
    "normals": "Fold normals",
    "distance": "Distance from the scan",
    "inferred": "Inferred, not scanned",
    "strain": "Stretch",
    "pressure": "Pressure",
}
"""Colourings of the cloth."""

PERSON_SCAN = "person"
"""Name of the person's scan on the page."""

VIEW_FILES = {WORN, "garment.pc2", "body.pc2", "frames.json"}
"""Files whose presence the page's script checks."""


@dataclass(frozen=True)
class Addresses:
    """Describe where the views read.

    Attributes:
        base: Address of the result's page; `/view.bin` and `/scan.bin` lie below it.
        job: The job whose files are read, for animations and exports; empty: none.
        person: The job whose scan is offered beside the garment; empty: none.
    """

    base: str
    job: str = ""
    person: str = ""


def has_view(names: Collection[str]) -> bool:
    """Return whether `view.bin` of a result with some files has any content."""
    return bool(set(list_shown(names)) - set(SCANS)) or WORN in names


def has_cloth(names: Collection[str]) -> bool:
    """Return whether a result with some files has cloth to show in 3D."""
    return any(not is_companion_mesh(name) for name in list_shown(names))


def draw_views(job: JobReport, names: Collection[str], at: Addresses, pictures: Html) -> Html:
    """Return the views of a result, and its pictures, which a browser without WebGL shows.

    Args:
        job: The result.
        names: Its files.
        at: Where the views read.
        pictures: The card with its pictures.
    """
    there = list_shown(names)
    cloth = [name for name in there if not is_companion_mesh(name)]
    titles = there | ({PERSON_SCAN: "The person's scan"} if at.person else {})
    shown = {*cloth[:1], *WORN_TOGETHER, *_find_wearer(cloth)} if cloth else {"scan"} if "scan" in there else {BODY}
    boxes = join(
        html('<label><input type="checkbox" data-mesh="{}"{}{}> {}</label>', name,
             Html("" if name in cloth else " data-beside"), Html(" checked" if name in shown else ""), title)
        for name, title in titles.items()
    )  # fmt: skip
    styles = join(html('<option value="{}">{}</option>', name, title) for name, title in STYLES.items())
    solid = html(
        SOLID, boxes=boxes, styles=styles, uncoloured=_explain_missing_colours(job), cloth=_hide(not cloth),
        player=_hide("garment.pc2" not in names or not at.job), heading=draw_heading("3D", ABOUT_SOLID),
    ) if there else Html()  # fmt: skip
    flat = html(FLAT, heading=draw_heading("Pattern", ABOUT_FLAT)) if WORN in names else Html()
    return html(
        VIEWS, job=at.job, base=at.base, person=at.person, files=" ".join(sorted(set(names) & VIEW_FILES)), solid=solid,
        packed=Html(" data-packed") if has_view(names) else Html(), beside=flat or pictures,
        below=pictures if flat else Html(),
    )  # fmt: skip


def _hide(is_hidden: bool) -> Html:
    return Html(" hidden") if is_hidden else Html()


def _find_wearer(cloth: Sequence[str]) -> tuple[str, ...]:
    """Return the possible names of the wearer of the first shown mesh: of one size, or the only one."""
    return BODY, f"{BODY}_{cloth[0].partition('_')[2]}"


def _explain_missing_colours(job: JobReport) -> str:
    """Return why a result has no colours."""
    checked = job.details.get("checked") or {}
    scan = checked.get("scan") if isinstance(checked, Mapping) else None
    if isinstance(scan, Mapping) and scan.get("has_colours"):
        return "No texture: the result was stored by a version without colours; submit its scan again."
    return f"No texture: {'the scan has no colours' if job.kind == 'recover' else 'only a recovery has one'}."


ABOUT_SOLID = (
    "Drag turns, the wheel or two fingers zoom, the right button moves. By keyboard: Tab to the picture, arrows turn, "
    "+ and - zoom."
)

ABOUT_FLAT = (
    "The net pieces, without seam allowance. Point at a piece to find the place on the garment. Edges of one colour "
    "are sewn together. Click an edge to measure it, Shift and click for several, drag along it for a part."
)

VIEWS = """<div id="result" data-job="{job}" data-base="{base}" data-person="{person}" data-files="{files}"{packed}>
<div class="views">{solid}{beside}</div>
<div id="problem"></div>{below}</div>"""

SOLID = """<section class="card view" aria-label="3D">{heading}<div class="row tools">
<fieldset class="row"><legend>Shown</legend>{boxes}</fieldset>
<label{cloth}>Colour <select id="style">{styles}</select></label>
<label><input type="checkbox" id="wireframe"> Wireframe</label></div>
<div id="space"></div>
<div class="row sides" role="group" aria-label="Look from"><button type="button" data-side="front">Front</button>
<button type="button" data-side="back">Back</button><button type="button" data-side="left">Left</button>
<button type="button" data-side="right">Right</button>
<button type="button" id="turntable" aria-pressed="false">Turntable</button></div>
<p class="row"><span id="colours" hidden><canvas id="bar" width="200" height="12"
 role="img" aria-label="Colours from none to the largest value"></canvas> <span id="end"></span></span>
<span id="loading" class="soft" role="status">Loading…</span>
<span id="unseen" class="soft" hidden>The scan's colours; grey where the scan has none.</span>
<span id="uncoloured" class="soft" hidden>{uncoloured}</span></p>
<p class="row" id="player"{player}><button type="button" id="play" aria-pressed="false">Play</button>
<input type="range" id="frame" min="0" max="0" value="0" aria-label="Frame"><output id="time"></output></p></section>"""

FLAT = """<section class="card view" aria-label="Pattern">{heading}
<p class="soft" id="pointed" role="status">Point at a panel or an edge.</p><div id="flat"></div>
<div id="measured" role="status"></div></section>"""
