"""The report of a garment in motion: preview, contact sheet, verdicts and numbers, in one HTML file."""

from __future__ import annotations

import base64

from ...reuse.animate.animate_garment import AnimatedGarment
from .judged_page import Heading, gates_html, head_html, manifest_html, numbers_html
from .page import page_html
from .report import format_number

WORST_FRAME_COUNT = 8
"""Number of worst frames in the report."""


def report_animation(moved: AnimatedGarment, preview: bytes, sheet: bytes) -> str:
    """Return the whole report as the text of one HTML file; every name that comes from a file is escaped.

    Args:
        moved: The garment in motion.
        preview: GIF that loops.
        sheet: PNG of the contact sheet.
    """
    worn = moved.animation.worn
    return page_html(
        f"{worn.category} in motion",
        [
            _header(moved),
            _pictures(preview, sheet),
            gates_html(moved.report.gates),
            _worst(moved),
            numbers_html(moved.report.metrics),
            manifest_html(moved.report.manifest),
        ],
    )


def _header(moved: AnimatedGarment) -> str:
    worn, animation = moved.animation.worn, moved.animation
    facts = {
        "Motion": moved.motion,
        "Frames": f"{len(animation.frames)} at {animation.fps:g} a second",
        "Fabric": worn.fabric.title or worn.fabric.name,
        "Wearer": worn.body.source,
        "CPU time": f"{moved.report.cpu_seconds:.0f} s",
    }
    heading = Heading("in motion", worn.pattern.name or worn.category, facts)
    return head_html(heading, moved.report.gates, moved.report.warnings)


def _pictures(preview: bytes, sheet: bytes) -> str:
    moving, still = (base64.b64encode(content).decode("ascii") for content in (preview, sheet))
    return (
        f'<section><h2>Motion</h2><img alt="preview that loops" src="data:image/gif;base64,{moving}">'
        "<p class='hint'>Evenly spaced frames, row by row; the camera goes with the pelvis.</p>"
        f'<img alt="contact sheet" src="data:image/png;base64,{still}"></section>'
    )


def _worst(moved: AnimatedGarment) -> str:
    """List the worst frames: not converged, then crossed, then deep."""
    verdicts = moved.animation.verdicts
    ranks = [(verdict.converged, -verdict.crossings, -max(verdict.depth, verdict.pinched)) for verdict in verdicts]
    order = sorted(range(len(ranks)), key=ranks.__getitem__)
    rows = "".join(
        f"<tr><td class=num>{n + 1}</td><td>{'yes' if verdicts[n].converged else 'no'}</td>"
        f"<td class=num>{verdicts[n].crossings}</td><td class=num>{format_number(1e3 * verdicts[n].depth)}</td>"
        f"<td class=num>{format_number(1e3 * verdicts[n].pinched)}</td></tr>"
        for n in order[:WORST_FRAME_COUNT]
    )
    titles = ("Frame", "Converged", "Faces crossed", "Depth, mm", "Between parts of the body, mm")
    head = f"<tr>{''.join(f'<th>{title}</th>' for title in titles)}</tr>"
    return f"<section><h2>Worst frames</h2><table>{head}{rows}</table></section>"
