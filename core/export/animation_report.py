"""The report of a garment in motion: preview, contact sheet, verdicts and numbers, in one HTML file."""

from __future__ import annotations

import base64
import json
from html import escape

from ..animate import Moved
from .page import page_html
from .report import number

WORST = 8
"""Frames that are listed as the worst."""


def report_animation(moved: Moved, preview: bytes, sheet: bytes) -> str:
    """Return the whole report as the text of one HTML file; every name that comes from a file is escaped.

    Args:
        moved: The garment in motion.
        preview: GIF that loops.
        sheet: PNG of the contact sheet.
    """
    worn = moved.animation.worn
    return page_html(
        f"{worn.category} in motion",
        [_header(moved), _pictures(preview, sheet), _gates(moved), _worst(moved), _numbers(moved), _manifest(moved)],
    )


def _header(moved: Moved) -> str:
    worn, animation = moved.animation.worn, moved.animation
    verdicts = "".join(
        f'<span class="verdict {escape(gate.verdict)}">{escape(gate.name)}</span>' for gate in moved.gates
    )
    facts = (
        ("Motion", moved.motion),
        ("Frames", f"{len(animation.frames)} at {animation.fps:g} a second"),
        ("Fabric", worn.fabric.title or worn.fabric.name),
        ("Wearer", worn.body.source),
        ("CPU time", f"{moved.cpu_seconds:.0f} s"),
    )
    cells = "".join(f"<div><dt>{title}</dt><dd>{escape(value)}</dd></div>" for title, value in facts)
    notes = "".join(f"<li>{escape(text)}</li>" for text in moved.warnings)
    return (
        f'<header><p class="brand">garmentq · in motion</p><h1>{escape(worn.pattern.name or worn.category)}</h1>'
        f'<p class="verdicts">{verdicts}</p><dl class="facts">{cells}</dl></header>'
        + (f'<section class="notes"><h2>Remarks</h2><ul>{notes}</ul></section>' if notes else "")
    )


def _pictures(preview: bytes, sheet: bytes) -> str:
    moving, still = (base64.b64encode(content).decode("ascii") for content in (preview, sheet))
    return (
        f'<section><h2>Motion</h2><img alt="preview that loops" src="data:image/gif;base64,{moving}">'
        "<p class='hint'>Evenly spaced frames, row by row; the camera goes with the pelvis.</p>"
        f'<img alt="contact sheet" src="data:image/png;base64,{still}"></section>'
    )


def _gates(moved: Moved) -> str:
    rows = "".join(
        f'<tr><td><span class="badge {escape(gate.verdict)}">{escape(gate.verdict)}</span></td>'
        f"<td class=check>{escape(gate.name)}</td><td class=num>{number(gate.value)}</td>"
        f"<td class=num>{number(gate.limit)}</td><td>{escape(gate.message)}</td></tr>"
        for gate in moved.gates
    )
    head = "<tr><th></th><th>Check</th><th class=num>Value</th><th class=num>Passes to</th><th>What it means</th></tr>"
    return f"<section><h2>Checks</h2><table>{head}{rows}</table></section>"


def _worst(moved: Moved) -> str:
    """List the frames that are worst: not converged, then crossed, then deep."""
    verdicts = moved.animation.verdicts
    ranks = [(verdict.converged, -verdict.crossings, -verdict.depth) for verdict in verdicts]
    order = sorted(range(len(ranks)), key=ranks.__getitem__)
    rows = "".join(
        f"<tr><td class=num>{n + 1}</td><td>{'yes' if verdicts[n].converged else 'no'}</td>"
        f"<td class=num>{verdicts[n].crossings}</td><td class=num>{number(1e3 * verdicts[n].depth)}</td></tr>"
        for n in order[:WORST]
    )
    titles = ("Frame", "Converged", "Faces crossed", "Depth, mm")
    head = f"<tr>{''.join(f'<th>{title}</th>' for title in titles)}</tr>"
    return f"<section><h2>Worst frames</h2><table>{head}{rows}</table></section>"


def _numbers(moved: Moved) -> str:
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td class=num>{number(value)}</td></tr>"
        for name, value in sorted(moved.metrics.items())
    )
    head = "<tr><th>Metric</th><th class=num>Value</th></tr>"
    return f'<section class="page"><h2>Numbers</h2><table>{head}{rows}</table></section>'


def _manifest(moved: Moved) -> str:
    text = escape(json.dumps(moved.manifest, indent=1, ensure_ascii=False, default=str))
    return f"<section><h2>Settings and versions</h2><pre>{text}</pre></section>"
