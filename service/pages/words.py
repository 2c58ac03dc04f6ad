"""Text of a job's state, age and verdict on the pages."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from ..gallery import GalleryJob
from ..kinds.redrape_request import REDRAPE
from ..outfit_readings import Reading, list_readings, name_category, name_end
from ..records import JobReport, RedrapeState
from ..states import ENDED, State
from .control_words import speak_of_controls
from .markup import Html, html, join

STATE_CLASSES = {State.SUCCEEDED: "good", State.FAILED: "bad", State.DEAD: "bad", State.CANCELLED: "soft"}
"""CSS class of a state."""

VERDICTS = {"pass": "good", "doubtful": "doubt", "fail": "bad"}
"""CSS class of a verdict."""


def draw_state(job: JobReport | GalleryJob) -> Html:
    """Return a job's state, with its stage if it runs."""
    text = f"{job.state}: {job.stage} {job.progress:.0%}" if job.state == State.RUNNING and job.stage else job.state
    shown = html('<span class="state {}" data-state="{}">{}</span>', STATE_CLASSES.get(job.state, ""), job.state, text)
    return shown if job.place is None else html('{} <span class="soft">{}</span>', shown, describe_place(job))


def describe_place(job: JobReport | GalleryJob) -> str:
    """Return a queued job's place and when it should start, as text for users."""
    if job.expected_start is None:
        return f"place {job.place}"
    minutes = round(max(0.0, job.expected_start - time.time()) / 60.0)
    return f"place {job.place}, starts {f'in about {minutes} min' if minutes else 'within a minute'}"


def draw_verdict(verdict: str | None) -> Html:
    """Return a verdict; empty if there is none."""
    return html('<span class="tag {}">{}</span>', VERDICTS.get(verdict, ""), verdict) if verdict else Html()


def draw_redrape(job: JobReport) -> Html:
    """Return the state of a re-drape that is not done; empty if it is, or if there is none."""
    if job.redrape is None or job.redrape.state is RedrapeState.DONE:
        return Html()
    text = f"re-drape: {job.redrape.state}" + (f", {job.redrape.code}" if job.redrape.code else "")
    return html('<span class="tag doubt">{}</span>', text)


def draw_time(seconds: float | None) -> Html:
    """Return a time [s since 1970]; the page's script converts it to the reader's time zone."""
    if seconds is None:
        return Html()
    when = datetime.fromtimestamp(seconds, UTC)
    shown = when.strftime("%Y-%m-%d %H:%M UTC")
    return html('<time datetime="{}">{}</time>', when.isoformat(timespec="seconds"), shown)


def draw_family(job: JobReport) -> Html:
    """Return links to a job's parent, inputs and children; empty if it has none."""
    links: Sequence[Html] = [
        html('<li><a href="{}">{}</a> <span class="soft">{}</span> <span data-child="{}">{}</span></li>',
             f"/{'results' if child.state == State.SUCCEEDED and child.kind != REDRAPE else 'jobs'}/{child.job}",
             child.name, child.kind, child.job, child.state)
        for child in job.children
    ]  # fmt: skip
    maker = "its recovery" if job.kind == REDRAPE else "its person"
    items = [html('<li>made by <a href="/jobs/{}">{}</a></li>', job.parent, maker)] if job.parent else []
    read = [html('<li>reads <a href="/results/{}">{}</a></li>', one, name) for name, one in job.inputs.items()]
    if not (links or items or read):
        return Html()
    return html('<section class="card"><h2>Family</h2><ul>{}</ul></section>', join([*items, *read, *links]))


def is_ended(job: JobReport) -> bool:
    """Return whether a job has ended."""
    return job.state in ENDED


MIN_READING_SHARE = 0.02
"""Probability of a reading of the outfit from which on the page offers it [1]."""

MAX_READINGS = 3
"""Number of readings that the page names."""


def list_offered(outfits: Sequence[Mapping[str, Any]]) -> list[Reading]:
    """Return the likely readings of an outfit that the page names, the best first."""
    first, *others = list_readings(outfits)[:MAX_READINGS]
    return [first, *(one for one in others if one.share >= MIN_READING_SHARE)]


def describe_worn(garments: Sequence[Mapping[str, Any]]) -> list[tuple[str, str]]:
    """Return what each garment was found to be, which of its ends the scan shows, and why it is not recovered."""
    rows = []
    for garment in garments:
        what = f"{name_category(garment) or 'of no known cut'}, confidence {garment['confidence']:.2f}"
        for word, hidden in (("ends seen", False), ("ends inferred", True)):
            ends = [name_end(contour) for contour in garment["contours"] if contour["is_inferred"] is hidden]
            what += f"; {word}: {', '.join(ends)}" if ends else ""
        problem = garment.get("problem")
        what += f". Not recovered: {speak_of_controls(problem['message'])}" if problem else ""
        rows.append((garment["part"], what))
    return rows
