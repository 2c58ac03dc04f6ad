"""The frame of every report: one HTML file with its style inside, without scripts or network access."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from importlib.resources import files


def page_html(name: str, sections: Sequence[str]) -> str:
    """Return a report as the text of one HTML file.

    Args:
        name: Its subject; escaped here.
        sections: Its parts as HTML, every name that comes from a file escaped.
    """
    style = files(__package__).joinpath("report.css").read_text(encoding="utf-8")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(name)} – garmentq report</title><style>{style}</style></head>\n"
        f"<body><main>{''.join(sections)}</main></body></html>\n"
    )
