"""What a person was found to wear, and why."""

from __future__ import annotations

from ..records import JobReport
from ..submission import PERSON_KIND
from .markup import Html, html, join
from .words import describe_worn, list_offered


def draw_worn(job: JobReport, may_change: bool) -> Html:
    """Return the card with what a person wears, and a button for each other likely reading of the outfit.

    Args:
        job: The job of the person.
        may_change: Whether the visitor may take the outfit for another one.
    """
    outfits = job.details.get("outfits") if job.kind == PERSON_KIND else None
    if not outfits:
        return Html()
    first, *others = list_offered(outfits)
    rows = join(
        html("<tr><th scope=row>{}</th><td>{}</td></tr>", name, text)
        for name, text in describe_worn(job.details.get("garments") or [])
    )
    button = '<button type="button" data-wearing="{}">Take it for {} ({})</button>'
    buttons = join((html(button, one.wearing, one.words, one.percent) for one in others), " ")
    offered = html(OFFERED, buttons=buttons) if may_change and others else Html()
    return html(WORN, words=first.words, share=first.percent, rows=rows, offered=offered)


WORN = """<section class="card" id="worn"><h2>Worn</h2>
<p>{words} <span class="soft">({share})</span></p><div class="wide"><table>{rows}</table></div>{offered}</section>"""

OFFERED = """<p class="row">{buttons}</p><div id="worn-problem"></div>"""
