"""The garments of a person, each with its picture, verdict and link."""

from __future__ import annotations

from collections.abc import Sequence

from ..records import JobReport
from ..states import State
from .garment_words import title_garment
from .markup import Html, html, join
from .words import draw_state, draw_verdict

RECOVER_KIND = "recover"
"""Kind of the jobs that recover a garment."""


def draw_garments(garments: Sequence[JobReport]) -> Html:
    """Return the card with the garments of a person; empty if there are none."""
    if not garments:
        return Html()
    return html(CARD, items=join(map(_draw_garment, garments)))


def _draw_garment(job: JobReport) -> Html:
    """Return one garment: its verdict once it is done, else its state."""
    is_done = job.state == State.SUCCEEDED
    picture = html('<img src="/jobs/{}/thumbnail" alt="" loading="lazy">', job.id) if is_done else Html()
    url, title = f"/{'results' if is_done else 'jobs'}/{job.id}", title_garment(job.garment or job.name)
    return html(
        ITEM, url=url, picture=picture, title=title,
        part=job.name if job.garment else "", state=draw_verdict(job.verdict) if is_done else draw_state(job),
    )  # fmt: skip


CARD = """<section class="card" id="garments"><h2>Garments</h2><ul class="result-garments">{items}</ul></section>"""

ITEM = """<li><a href="{url}"><span class="picture">{picture}</span><b>{title}</b></a>
<span class="soft">{part}</span> {state}</li>"""
