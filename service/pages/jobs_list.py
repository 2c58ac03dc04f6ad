"""The list of jobs: a row for each, those below a job indented under it."""

from __future__ import annotations

from collections.abc import Sequence

from ..gallery import GARMENT_KIND
from ..kinds.redrape_request import REDRAPE
from ..records import JobReport
from ..states import State
from ..submission import PERSON_KIND
from .control_words import speak_of_controls
from .icons import draw_icon
from .markup import Html, html, join
from .words import draw_state, draw_time, draw_verdict

WITHOUT_FIGURE = ("export", REDRAPE)
"""Kinds of jobs whose results have no picture of their own."""


def draw_list(families: Sequence[Sequence[JobReport]]) -> Html:
    """Return the table of some families, each its first job and those below it."""
    return html(LIST, rows=join(_draw_row(job, family[0]) for family in families for job in family))


def _draw_row(job: JobReport, root: JobReport) -> Html:
    is_below = job is not root
    is_alone = job.kind != REDRAPE and all(child.kind == REDRAPE for child in job.children)
    url = f"/results/{job.id}" if job.state == State.SUCCEEDED and is_alone else f"/jobs/{job.id}"
    thumbnail = Html()
    is_dressed = job.kind != PERSON_KIND or any(child.kind == GARMENT_KIND for child in job.children)
    if job.state == State.SUCCEEDED and is_dressed and job.kind not in WITHOUT_FIGURE:
        thumbnail = html('<img src="/jobs/{}/thumbnail" alt="" width="56" height="75" loading="lazy">', job.id)
    what = " · ".join([job.kind, ", ".join(one for one in (job.garment, job.fabric) if one)]).removesuffix(" · ")
    error = html('<span class="bad">{}</span>', speak_of_controls(job.error.message)) if job.error else Html()
    tags = join((html('<span class="tag">{}</span>', tag) for tag in job.tags), " ") if not is_below else Html()
    name = f"{root.name}: {job.name}" if is_below else job.name
    live = Html() if job.finished else html(' data-live="{}" data-now="{}"', job.id, job.state)
    return html(
        ROW, look=" below" if is_below else "", job=job.id, picture=thumbnail, url=url, name=name, what=what, live=live,
        icon=draw_icon(job), state=draw_state(job), verdict=draw_verdict(job.verdict), created=draw_time(job.created),
        error=error, tags=tags, pick=Html() if is_below else html(PICK, name=job.name),
        root=Html() if is_below else html(' data-name="{}"', job.name),
    )  # fmt: skip


PICK = """<label><input type="checkbox" data-pick><span class="hushed">Select {name}</span></label>"""

LIST = """<div class="wide"><table class="jobs"><thead><tr><th scope="col"><span class="hushed">Selection</span></th>
<th scope="col"><span class="hushed">Picture</span></th>
<th scope="col">Job</th><th scope="col">State</th><th scope="col">Verdict</th><th scope="col">Created</th></tr></thead>
<tbody id="jobs">{rows}</tbody></table></div>"""

ROW = """<tr class="job{look}" data-job="{job}"{root}{live}><td class="choice">{pick}</td>
<td class="picture">{picture}</td>
<td><a href="{url}">{name}</a> {tags}<br><span class="soft">{what}</span> {error}</td>
<td><a class="plain" href="/jobs/{job}">{icon} {state}</a></td><td>{verdict}</td><td class="soft">{created}</td></tr>"""
