"""A heading with a short explanation behind a `?`."""

from __future__ import annotations

from .markup import Html, html


def draw_heading(title: str, explanation: str) -> Html:
    """Return a heading of a section, and its explanation, which a click or Enter on the `?` opens."""
    return html(HEADING, title=title, explanation=explanation)


HEADING = """<div class="titled"><h2>{title}</h2><details class="help"><summary><span aria-hidden="true">?</span>
<span class="hushed">About: {title}</span></summary><p>{explanation}</p></details></div>"""
