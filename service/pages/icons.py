"""Icons of states and verdicts: each has a shape and a colour of its own, and its word for screen readers."""

from __future__ import annotations

from ..gallery import GalleryJob
from ..records import JobReport
from ..states import State
from .markup import Html, html
from .words import STATE_CLASSES, VERDICTS

DISC = "M8 1a7 7 0 1 0 0 14A7 7 0 0 0 8 1Z"
RING = f"{DISC}M8 2.6a5.4 5.4 0 1 1 0 10.8A5.4 5.4 0 0 1 8 2.6Z"
CROSS = "M5.2 6.3 6.3 5.2 8 6.9l1.7-1.7 1.1 1.1L9.1 8l1.7 1.7-1.1 1.1L8 9.1l-1.7 1.7-1.1-1.1L6.9 8Z"

SHAPES = {
    "pass": f"{DISC}M6.9 11.2 3.8 8.1 5 6.9l1.9 1.9 4.1-4.1 1.2 1.2Z",
    "doubtful": "M8 1 15.6 14.6H.4ZM7.2 5.6h1.6v4.2H7.2ZM7.2 11h1.6v1.7H7.2Z",
    "fail": f"M5.1 1h5.8L15 5.1v5.8L10.9 15H5.1L1 10.9V5.1Z{CROSS}",
    State.WAITING: f"{RING}M4.4 7.2H6v1.6H4.4ZM7.2 7.2h1.6v1.6H7.2ZM10 7.2h1.6v1.6H10Z",
    State.QUEUED: f"{RING}M7.3 4.4h1.4v3.2l2.2 1.3-.7 1.2-2.9-1.8Z",
    State.RUNNING: "M3.5 1.8v12.4L13.8 8Z",
    State.SUCCEEDED: "M6.4 13.2 1.6 8.4 3.2 6.8l3.2 3.2 6.4-6.4 1.6 1.6Z",
    State.FAILED: f"M5.1 1h5.8L15 5.1v5.8L10.9 15H5.1L1 10.9V5.1Z{CROSS}",
    State.DEAD: f"M5.1 1h5.8L15 5.1v5.8L10.9 15H5.1L1 10.9V5.1Z{CROSS}",
    State.CANCELLED: f"{RING}M4.6 7.2h6.8v1.6H4.6Z",
}
"""Outline of each icon in a square of 16 units; where outlines overlap, it is open."""

ICON = """<svg class="icon {look}" viewBox="0 0 16 16" aria-hidden="true">
<path fill-rule="evenodd" d="{shape}"/></svg>"""


def draw_icon(job: GalleryJob | JobReport, is_named: bool = False) -> Html:
    """Return the icon of a job's verdict, or of its state if it has none, with the word; `is_named`: it is visible."""
    word = job.verdict if job.state == State.SUCCEEDED and job.verdict in VERDICTS else str(job.state)
    look = VERDICTS.get(word or "", STATE_CLASSES.get(job.state, ""))
    name = html('<span class="{}">{}</span>', "" if is_named else "hushed", word)
    return html("{}{}", html(ICON, look=look, shape=SHAPES[word or job.state]), name)
