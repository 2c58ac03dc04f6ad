"""The report of a garment that is worn again: both wearers, verdicts and numbers, in one HTML file."""

from __future__ import annotations

import base64
import json
from html import escape

import numpy as np

from ..wear import Dressed, Worn
from .page import page_html
from .person import on_white
from .picture import Camera, ColouredMesh, aim, draw, png_base64
from .report import number
from .views import CLOTH, DRAPED, SKIN, colour_of

WIDTH, HEIGHT = 300, 480
"""Size of one of the pictures [pixel]: three views of two wearers are a page wide."""

MOST_STRAIN, MOST_PRESSURE = 0.1, 1000.0
"""Ends of both scales of colour: cloth stretched by a tenth is tight, and a tight waistband presses by 1 kPa."""

TURNS = (0.0, 0.5 * np.pi, np.pi)
"""Angles about the vertical from which a wearer is drawn: front, right side, back."""


def draw_wearers(dressed: Dressed) -> bytes:
    """Return a PNG: above the first wearer, then the new one, the strain and the pressure; front, side and back."""
    strain, pressure = dressed.strain / MOST_STRAIN, dressed.pressure / MOST_PRESSURE
    rows = [_row(dressed.before, CLOTH), _row(dressed.worn, DRAPED)]
    rows += [_row(dressed.worn, colour_of(np.clip(share, 0.0, 1.0))) for share in (strain, pressure)]
    return base64.b64decode(png_base64(np.concatenate(rows, axis=0)))


def _row(worn: Worn, colour: np.ndarray) -> np.ndarray:
    """Draw a wearer in a garment from all sides, uint8, shape [height, 3 width, 4 or 3]."""
    body = worn.body
    surfaces = [
        ColouredMesh(body.vertices, body.faces, SKIN),
        ColouredMesh(worn.garment.nodes, worn.garment.faces, colour),
    ]
    return np.concatenate([on_white(draw(surfaces, aim_at(worn, turn))) for turn in TURNS], axis=1)


def aim_at(worn: Worn, turn: float) -> Camera:
    """Return the camera that shows a wearer whole, turned by an angle about the vertical [rad]."""
    around = np.array([[np.cos(turn), 0.0, np.sin(turn)], [0.0, 1.0, 0.0], [-np.sin(turn), 0.0, np.cos(turn)]])
    points = np.concatenate([worn.body.vertices, worn.garment.nodes])
    return aim(points, around @ worn.body.heading, WIDTH, HEIGHT)


def report_dressed(dressed: Dressed, picture: bytes) -> str:
    """Return the whole report as the text of one HTML file; every name that comes from a file is escaped.

    Args:
        dressed: The garment on the other body.
        picture: PNG of both wearers, as `draw_wearers` makes it.
    """
    return page_html(
        f"{dressed.worn.category} on {dressed.worn.body.source}",
        [_header(dressed), _pictures(picture), _gates(dressed), _ease(dressed), _numbers(dressed), _manifest(dressed)],
    )


def _header(dressed: Dressed) -> str:
    worn = dressed.worn
    verdicts = "".join(
        f'<span class="verdict {escape(gate.verdict)}">{escape(gate.name.replace("_", " "))}</span>'
        for gate in dressed.gates
    )
    facts = (
        ("Category", worn.category),
        ("Template", worn.template),
        ("Fabric", worn.fabric.title or worn.fabric.name),
        ("First wearer", dressed.before.body.source),
        ("Wearer", worn.body.source),
        ("CPU time", f"{dressed.cpu_seconds:.0f} s"),
    )
    cells = "".join(f"<div><dt>{title}</dt><dd>{escape(value)}</dd></div>" for title, value in facts)
    notes = "".join(f"<li>{escape(text)}</li>" for text in dressed.warnings)
    return (
        f'<header><p class="brand">garmentq · worn again</p><h1>{escape(worn.pattern.name or worn.category)}</h1>'
        f'<p class="verdicts">{verdicts}</p><dl class="facts">{cells}</dl></header>'
        + (f'<section class="notes"><h2>Remarks</h2><ul>{notes}</ul></section>' if notes else "")
    )


def _pictures(picture: bytes) -> str:
    data = base64.b64encode(picture).decode("ascii")
    return (
        "<section><h2>Wearers</h2><p class='hint'>From above: the wearer that the garment was recovered from; the new "
        "one; the cloth's strain, dark from 10 %; its pressure on the body, dark from 1 kPa.</p>"
        f'<img alt="both wearers, front, side and back" src="data:image/png;base64,{data}"></section>'
    )


def _gates(dressed: Dressed) -> str:
    rows = "".join(
        f'<tr><td><span class="badge {escape(gate.verdict)}">{escape(gate.verdict)}</span></td>'
        f"<td class=check>{escape(gate.name.replace('_', ' '))}</td><td class=num>{number(gate.value)}</td>"
        f"<td class=num>{number(gate.limit)}</td><td>{escape(gate.message)}</td></tr>"
        for gate in dressed.gates
    )
    head = (
        "<tr><th></th><th>Check</th><th class=num>Value</th><th class=num>Fails above</th><th>What it means</th></tr>"
    )
    return f"<section><h2>Checks</h2><table>{head}{rows}</table></section>"


def _ease(dressed: Dressed) -> str:
    rows = "".join(
        f"<tr><td>{escape(one.place.replace('_', ' '))}</td><td class=num>{1e3 * one.garment:.0f}</td>"
        f"<td class=num>{1e3 * one.body:.0f}</td><td class=num>{1e3 * one.value:+.0f}</td></tr>"
        for one in dressed.ease
    )
    head = "<tr><th>Girth [mm]</th><th class=num>Garment</th><th class=num>Body</th><th class=num>Ease</th></tr>"
    return f"<section><h2>Ease</h2><table>{head}{rows}</table></section>" if rows else ""


def _numbers(dressed: Dressed) -> str:
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td class=num>{number(value)}</td></tr>"
        for name, value in sorted(dressed.metrics.items())
    )
    head = "<tr><th>Metric</th><th class=num>Value</th></tr>"
    return f'<section class="page"><h2>Numbers</h2><table>{head}{rows}</table></section>'


def _manifest(dressed: Dressed) -> str:
    text = escape(json.dumps(dressed.manifest, indent=1, ensure_ascii=False, default=str))
    return f"<section><h2>Settings and versions</h2><pre>{text}</pre></section>"
