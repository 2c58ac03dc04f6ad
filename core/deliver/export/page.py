"""The frame of every report: one HTML file with its style inside, without scripts or network access."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape, unescape
from importlib.resources import files

TABLE = re.compile(r"<table.*?</table>", re.DOTALL)
ROW = re.compile(r"<tr>.*?</tr>", re.DOTALL)
HEAD = re.compile(r"<th[^>]*>(.*?)</th>", re.DOTALL)
CELL = re.compile(r"<td(?=[ >])")
MARKUP = re.compile(r"<[^>]*>")


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
        f"<body><main>{_name_cells(''.join(sections))}</main></body></html>\n"
    )


def _name_cells(content: str) -> str:
    """Return HTML whose cells carry the heads of their columns, which a narrow screen shows beside them."""
    return TABLE.sub(lambda table: _name_rows(table[0]), content)


def _name_rows(table: str) -> str:
    heads = [escape(unescape(MARKUP.sub("", head)), quote=True) for head in HEAD.findall(table)]

    def name(row: re.Match[str]) -> str:
        left = iter(heads)
        return CELL.sub(lambda _: f'<td data-head="{next(left, "")}"', row[0])

    return ROW.sub(name, table)
