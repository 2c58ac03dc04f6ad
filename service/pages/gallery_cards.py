"""The gallery: a card for each person or single garment, with its garments, their verdicts and its progress."""

from __future__ import annotations

from collections.abc import Sequence
from urllib.parse import urlencode

from ..gallery import GalleryFamily, GalleryJob
from ..kinds.redrape_request import REDRAPE
from ..states import UNSUCCESSFUL, State
from ..submission import PERSON_KIND
from .control_words import speak_of_controls
from .garment_words import title_garment
from .icons import draw_icon
from .markup import Html, html, join
from .words import draw_state, draw_time

MAX_CARD_GARMENT_COUNT = 6
"""Largest number of garments with a picture on a card; an outfit rarely has more."""


def draw_cards(families: Sequence[GalleryFamily], has_bodies: bool) -> Html:
    """Return the cards of some families.

    Args:
        families: The families.
        has_bodies: Whether a person of whom no garment was found is shown, too.
    """
    return html('<ol class="gallery" id="jobs">{}</ol>', join(_draw_card(one, has_bodies) for one in families))


def is_undressed(family: GalleryFamily) -> bool:
    """Return whether a family is a person of whom no garment was found, so that its picture may show bare skin."""
    root = family.root
    return root.kind == PERSON_KIND and not family.garments and not root.is_open


def find_page(job: GalleryJob) -> str:
    """Return the address of a job's page: of its result if it has one."""
    return f"/{'results' if job.state == State.SUCCEEDED and job.kind != REDRAPE else 'jobs'}/{job.id}"


def _draw_card(family: GalleryFamily, has_bodies: bool) -> Html:
    root = family.root
    picture = _draw_picture(root, is_undressed(family) and not has_bodies)
    shown = family.garments[:MAX_CARD_GARMENT_COUNT]
    rest = [*family.garments[MAX_CARD_GARMENT_COUNT:], *family.others]
    tags = join((html('<a class="tag" href="/?{}">{}</a>', urlencode({"tag": tag}), tag) for tag in family.tags), " ")
    garments = html('<ul class="garments">{}</ul>', join(map(_draw_garment, shown))) if shown else Html()
    return html(
        CARD, job=root.id, name=root.name, url=find_page(root), picture=picture, garments=garments, tags=tags,
        state=_draw_progress(family), created=draw_time(root.created), error=_draw_error(family),
        others=_draw_others(rest), what=title_garment(root.garment or root.kind),
    )  # fmt: skip


def _draw_garment(job: GalleryJob) -> Html:
    name, picture = title_garment(job.garment or job.name), _draw_picture(job)
    return html(GARMENT, url=find_page(job), picture=picture, name=name, icon=draw_icon(job), live=_live(job))


def _draw_picture(job: GalleryJob, is_hidden: bool = False) -> Html:
    """Return the figure of a job; an outline while it has none, or where it is hidden."""
    if job.state != State.SUCCEEDED or is_hidden:
        return html(PLACEHOLDER)
    return html('<img src="/jobs/{}/thumbnail" alt="" loading="lazy" decoding="async">', job.id)


def _draw_progress(family: GalleryFamily) -> Html:
    """Return state and progress of a family: those of its first job while that is open, then those of the garments."""
    root, progress = family.root, family.progress
    if progress is None:
        return html('<p class="state-line">{}</p>', draw_icon(root, is_named=True))
    main = family.main_jobs
    live = draw_state(root)
    if not root.is_open:
        ended = sum(not job.is_open for job in family.garments)
        live = html("{} of {} garments done", ended, len(family.garments))
    opened = next((job for job in main if job.is_open), root)
    return html(PROGRESS, icon=draw_icon(opened), live=live, root=_live(root), jobs=" ".join(job.id for job in main),
                progress=f"{progress:.4f}", name=root.name)  # fmt: skip


def _draw_error(family: GalleryFamily) -> Html:
    failed = [job for job in family.main_jobs if job.state in UNSUCCESSFUL and job.error_message]
    one = '<p class="error">{}{} <code>{}</code></p>'
    return join(
        html(one, "" if job is family.root else f"{job.name}: ", speak_of_controls(job.error_message or ""),
             job.error_code) for job in failed[:2]
    )  # fmt: skip


def _draw_others(jobs: Sequence[GalleryJob]) -> Html:
    if not jobs:
        return Html()
    rows = join(
        html('<li{}>{} <a href="{}">{}</a> <span class="soft">{}</span></li>', _live(job), draw_icon(job),
             find_page(job), job.name, job.kind) for job in jobs
    )  # fmt: skip
    left = sum(job.is_open for job in jobs)
    note = f"{len(jobs)} more, {left} open" if left else f"{len(jobs)} more"
    return html('<details class="others"><summary>{}</summary><ul>{}</ul></details>', note, rows)


def _live(job: GalleryJob) -> Html:
    return html(' data-live="{}" data-now="{}"', job.id, job.state) if job.is_open else Html()


PLACEHOLDER = """<svg class="blank" viewBox="0 0 48 48" aria-hidden="true">
<path d="M17 6 5 12l4 10 5-2v22h20V20l5 2 4-10-12-6c-1 3-4 5-7 5s-6-2-7-5Z"/></svg>"""

CARD = """<li class="family" data-job="{job}" data-name="{name}"><label class="pick"><input type="checkbox" data-pick>
<span class="hushed">Select {name}</span></label>
<a class="figure" href="{url}" tabindex="-1" aria-hidden="true">{picture}</a>
<div class="words"><h2><a href="{url}">{name}</a></h2>
<p class="soft">{what} · {created}</p>{state}{error}{garments}<p class="tags">{tags}</p>{others}</div></li>"""

GARMENT = """<li{live}><a href="{url}"><span class="picture">{picture}</span>
<span class="name">{icon} {name}</span></a></li>"""

PROGRESS = """<p class="state-line"{root}>{icon} {live}</p>
<progress max="1" value="{progress}" data-progress="{jobs}" aria-label="Progress of {name}"></progress>"""
