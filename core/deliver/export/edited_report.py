"""The report of a version: the garment before and after, verdicts, and the difference from the recovered pattern."""

from __future__ import annotations

import base64
from html import escape

import numpy as np

from ...reuse.edit.redraping import EditedGarment
from .dressed_report import draw_wearer, ease_html
from .judged_page import Heading, gates_html, head_html, manifest_html, numbers_html
from .page import page_html
from .picture import png_base64
from .views import CLOTH_COLOUR, DRAPE_COLOUR

MIN_SHOWN_CHANGE_MM = 0.05
"""Smallest change of a length that is shown [mm]: a tenth of the width of a chalk line."""


def draw_versions(edited: EditedGarment) -> bytes:
    """Return a PNG: above the garment that was edited, below the edited one; front, side and back."""
    rows = [draw_wearer(edited.before, CLOTH_COLOUR), draw_wearer(edited.worn, DRAPE_COLOUR)]
    return base64.b64decode(png_base64(np.concatenate(rows, axis=0)))


def report_edited(edited: EditedGarment, picture: bytes) -> str:
    """Return the whole report as the text of one HTML file; every name that comes from a file is escaped.

    Args:
        edited: The version.
        picture: PNG of both garments from `draw_versions`.
    """
    worn = edited.worn
    facts = {
        "Category": worn.category,
        "Template": worn.template,
        "Fabric": worn.fabric.title or worn.fabric.name,
        "Wearer": worn.body.source,
        "Draped from": "where the garment hung" if edited.is_warm else "the panels' placement",
        "CPU time": f"{edited.report.cpu_seconds:.0f} s",
    }
    heading = Heading("edited", worn.pattern.name or worn.category, facts)
    return page_html(
        f"{worn.category}, edited",
        [
            head_html(heading, edited.report.gates, edited.report.warnings),
            _pictures(picture),
            gates_html(edited.report.gates),
            _panels(edited),
            _seams(edited),
            ease_html(edited.ease),
            numbers_html(edited.report.metrics),
            manifest_html(edited.report.manifest),
        ],
    )


def _pictures(picture: bytes) -> str:
    data = base64.b64encode(picture).decode("ascii")
    return (
        "<section><h2>Before and after</h2><p class='hint'>Above the garment that was edited, below the edited one.</p>"
        f'<img alt="the garment before and after, front, side and back" src="data:image/png;base64,{data}"></section>'
    )


def _panels(edited: EditedGarment) -> str:
    """Return the table of panels with their differences from the recovered ones."""
    found = edited.difference.panels
    rows = "".join(
        f"<tr><td>{escape(pair.first)}</td><td class=num>{pair.area_percent:+.2f}</td>"
        f"<td class=num>{pair.outline_mm:.2f}</td></tr>"
        for pair in found.pairs
    )
    rows += "".join(f"<tr><td>{escape(name)}</td><td colspan=2>new</td></tr>" for name in found.only_first)
    rows += "".join(f"<tr><td>{escape(name)}</td><td colspan=2>gone</td></tr>" for name in found.only_second)
    head = "<tr><th>Panel</th><th class=num>Area, %</th><th class=num>Outline, RMS mm</th></tr>"
    return f"<section><h2>Difference to the recovered pattern</h2><table>{head}{rows}</table></section>"


def _seams(edited: EditedGarment) -> str:
    """Return the table of changed and new seams; empty where there are none."""
    found = edited.difference
    rows = "".join(
        f"<tr><td>{escape(one.a[0])} {one.a[1]}, {escape(one.b[0])} {one.b[1]}</td>"
        f"<td class=num>{one.change_mm[0]:+.1f}</td><td class=num>{one.change_mm[1]:+.1f}</td></tr>"
        for one in found.seams
        if max(abs(change) for change in one.change_mm) >= MIN_SHOWN_CHANGE_MM
    )
    for number in found.seams_added:
        seam = edited.worn.pattern.seams[number]
        sides = f"{escape(seam.a.panel)} {seam.a.edge}, {escape(seam.b.panel)} {seam.b.edge}"
        rows += f"<tr><td>{sides}</td><td colspan=2>new</td></tr>"
    if not rows:
        return ""
    head = "<tr><th>Seam (panel, edge)</th><th class=num>First side, mm</th><th class=num>Second side, mm</th></tr>"
    return f"<section><h2>Seams that changed</h2><table>{head}{rows}</table></section>"
