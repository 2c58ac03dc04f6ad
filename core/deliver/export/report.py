"""The report of a recovery: one HTML file with pictures, pattern, numbers and verdicts, without network access."""

from __future__ import annotations

import json
from collections.abc import Iterator
from html import escape
from typing import Any

import numpy as np

from ...cloth.fabric import FabricEstimate
from ...garment.curves import edge_length, panel_area, panel_outline
from ...judge.gates import Product, product_of
from ...judge.line_intervals import describe_margins
from ...recover.recovery import Recovery
from ...run.verdict import worst_verdict
from .drawing import DRAWING_SCALE_DENOMINATOR, pattern_drawing
from .measures_section import wearer_html
from .page import page_html
from .pieces_section import pieces_html
from .views import ERROR_COLOUR_STOPS, INFERRED_COLOUR, render_views

VERDICTS = {
    "detail": {
        "pass": "Detail mesh: lies on the scan",
        "doubtful": "Detail mesh: usable, with remarks",
        "fail": "Detail mesh: look before you use it",
    },
    "pattern": {
        "pass": "Pattern: fair, and its seams match",
        "doubtful": "Pattern: usable, with remarks",
        "fail": "Pattern: look before you cut it",
    },
    "drape": {
        "pass": "Drape: at rest",
        "doubtful": "Drape: usable, with remarks",
        "fail": "Drape: settle it before simulating on",
    },
}
"""Headline of each product by its verdict; a drape that is not at rest does not affect the detail mesh."""

TITLES = {
    "surface_rms_mm.s2t": "Distance, result to scan, RMS [mm]",
    "surface_rms_mm.t2s": "Distance, scan to result, RMS [mm]",
    "surface_p95_mm.s2t": "Distance, result to scan, 95 % [mm]",
    "surface_p95_mm.t2s": "Distance, scan to result, 95 % [mm]",
    "hausdorff_mm": "Largest distance either way [mm]",
    "chamfer_vertex_m2e3": "Vertex Chamfer [m² × 10⁻³]",
    "chamfer_vertex_floor_m2e3": "its floor: two meshings of the scan",
    "normal_cosine": "Normal similarity, 1 − cos, both ways",
    "normal_cosine_floor": "its floor: two meshings of the scan",
    "stretch_p001": "Stretch, smallest (0.1 %)",
    "stretch_p999": "Stretch, largest (99.9 %)",
    "flipped_faces": "Faces against the scan",
    "self_intersecting_faces": "Faces that intersect others",
    "min_angle_deg": "Smallest angle (1 %) [°]",
    "body_penetration_mm": "Deepest inside the body [mm]",
    "pinched_mm": "Deepest between parts of the body that run into each other [mm]",
    "seam_mismatch_mm": "Largest seam mismatch [mm]",
    "vertices": "Vertices",
    "faces": "Faces",
    "body.fit_rms_mm": "Body model to the given body, RMS [mm]",
    "body.undeclared_mm": "Clothes taken for skin, to the body below them, RMS [mm]",
    "at_rest": "At rest (1: yes)",
    "residual": "Largest force left on a node [a node's weight]",
    "residual_rms": "Force left on a node, RMS [a node's weight]",
    "iterations": "Newton iterations to rest",
    "drape.at_rest": "Graded drape: at rest (1: yes)",
    "drape.residual": "Graded drape: largest force left on a node [a node's weight]",
    "drape.residual_rms": "Graded drape: force left on a node, RMS [a node's weight]",
    "drape.iterations": "Graded drape: Newton iterations",
}
"""Titles of metrics, in the order of the table; others follow under their own names."""

COLUMNS = (("", "Detail mesh"), ("sim.", "Simulation mesh"), ("redrape.", "Re-draped"), ("graded.", "Graded drape"))


MESHES = (
    ("", "Detail mesh", "the scan's own folds, on the pattern: to look at, and to texture"),
    ("sim.", "Simulation mesh", "the pattern at rest, started from the scan's folds: to simulate on from here"),
    ("redrape.", "Re-draped", "the pattern dressed anew from its rest placement: what the pattern alone gives"),
    ("graded.", "Graded drape", "the first pattern, draped before it met the scan's folds"),
)
"""Prefix of the metrics, name and purpose of each mesh; all have one topology."""

UNITS = {"H00": "N/m", "H01": "N/m", "H11": "N/m", "H22": "N/m", "k": "N m", "density": "kg/m²"}
"""Units of the fabric's parameters."""


MEANINGS = {
    "H00": "stretch along the weft",
    "H01": "coupling of weft and warp",
    "H11": "stretch along the warp",
    "H22": "shear",
    "k": "bending",
    "density": "weight",
}
"""Quantity that each parameter describes."""


def report_html(recovery: Recovery) -> str:
    """Return the whole report as the text of one HTML file; every name that comes from a file is escaped."""
    sections = [
        _header(recovery),
        _pictures(recovery),
        _gates(recovery),
        _pattern(recovery),
        pieces_html(recovery.pattern),
        wearer_html(recovery.report.metrics),
        _fabric(recovery),
        _numbers(recovery),
        _settings(recovery),
    ]
    return page_html(recovery.scan.name, sections)


def format_number(value: Any) -> str:
    """Format a number as HTML: whole where it is whole, a dash where there is none."""
    if value is None or not np.isfinite(value):
        return "–"
    if value == 0.0 or abs(value) >= 100.0 or (value == round(value) and abs(value) >= 1.0):
        return f"{value:.0f}"
    return f"{value:.2f}" if abs(value) >= 1.0 else f"{value:.3f}" if abs(value) >= 1e-3 else "&lt; 0.001"


def _header(recovery: Recovery) -> str:
    of_product = {product: [g for g in recovery.report.gates if product_of(g.name) is product] for product in Product}
    verdicts = "".join(
        f'<span class="verdict {verdict}">{VERDICTS[product][verdict]}</span>'
        for product, gates in of_product.items()
        if gates and (verdict := worst_verdict(gate.verdict for gate in gates))
    )
    facts = (
        ("Category", recovery.target.category),
        ("Template", recovery.template),
        *_describe_candidates(recovery.report.manifest.get("candidates", [])),
        *_describe_openings(recovery.report.manifest.get("openings", [])),
        ("Fabric", recovery.fabric.title or recovery.fabric.name),
        ("Body", recovery.body.source),
        ("CPU time", f"{recovery.report.cpu_seconds:.0f} s"),
        ("Memory", f"{recovery.report.peak_mb:.0f} MB"),
    )
    cells = "".join(f"<div><dt>{title}</dt><dd>{escape(value)}</dd></div>" for title, value in facts)
    notes = "".join(f"<li>{escape(text)}</li>" for text in recovery.report.warnings)
    return (
        f'<header><p class="brand">garmentq · recovery report</p><h1>{escape(recovery.scan.name)}</h1>'
        f'<p class="verdicts">{verdicts}</p><dl class="facts">{cells}</dl></header>'
        + (f'<section class="notes"><h2>Remarks</h2><ul>{notes}</ul></section>' if notes else "")
    )


def _describe_candidates(candidates: list[dict[str, Any]]) -> Iterator[tuple[str, str]]:
    """Yield the cuts that were compared with the scan and their misfits, best first; nothing if the cut was given."""

    def describe(one: dict[str, Any]) -> str:
        parts = ", ".join(f"{part} {one[part]:.3f}" for part in ("girths", "neckline") if part in one)
        return f"{one['template']} {one['misfit']:.3f}" + (f" ({parts})" if parts else "")

    if candidates:
        yield "Cuts by misfit", "; ".join(describe(one) for one in candidates)


def _describe_openings(openings: list[dict[str, Any]]) -> Iterator[tuple[str, str]]:
    """Yield the openings beside the contours, with their lengths and probabilities; nothing if there are none."""

    def describe(one: dict[str, Any]) -> str:
        extent = f" {one['extent_mm']:.0f} mm" if "extent_mm" in one else ""
        return f"{one['name']}{extent}" + (f" ({one['probability']:.0%})" if "probability" in one else "")

    if openings:
        yield "Openings", "; ".join(describe(one) for one in openings)


def _pictures(recovery: Recovery) -> str:
    views, end = render_views(recovery)
    heads = list(views[0].pictures)
    rows = ['<div class="head"></div>' + "".join(f'<div class="head">{head}</div>' for head in heads)]
    for view in views:
        rows.append(f'<div class="side">{view.title}</div>')
        rows += [
            f'<img alt="{head}, {view.title.lower()}" src="data:image/png;base64,{data}">'
            for head, data in view.pictures.items()
        ]
    stops = ", ".join(
        f"rgb({r * 255:.0f} {g * 255:.0f} {b * 255:.0f}) {at:.0%}" for at, (r, g, b) in ERROR_COLOUR_STOPS
    )
    ticks = "".join(f"<span>{format_number(end * part / 4)}{' mm' if part == 4 else ''}</span>" for part in range(5))
    slate = " ".join(f"{part * 255:.0f}" for part in INFERRED_COLOUR)
    bar = (
        f'<div class="colours"><div class="bar" style="background:linear-gradient(90deg, {stops})"></div>'
        f'<div class="ticks">{ticks}</div><p class="hint"><span style="color:rgb({slate})">&#9632;</span> not shown by '
        "the scan: inferred</p></div>"
    )
    grid = f'<div class="pictures">{"".join(rows)}</div>'
    return f'<section style="--columns:{len(heads)}"><h2>Fit</h2>{grid}{bar}{_meshes(recovery)}</section>'


def _meshes(recovery: Recovery) -> str:
    """Return the table of the meshes with their purpose and distance from the scan."""
    rows = []
    for prefix, name, use in MESHES:
        ways = [recovery.report.metrics.get(f"{prefix}surface_rms_mm.{direction}") for direction in ("s2t", "t2s")]
        if any(direction is not None for direction in ways):
            there, back = (format_number(direction) for direction in ways)
            rows.append(f"<tr><td>{name}</td><td class=num>{there} / {back}</td><td>{use}</td></tr>")
    head = "<tr><th>Mesh</th><th class=num>To the scan / back, RMS [mm]</th><th>What it is</th></tr>"
    return f'<table class="meshes">{head}{"".join(rows)}</table>' if rows else ""


def _gates(recovery: Recovery) -> str:
    rows = "".join(
        f'<tr><td><span class="badge {escape(gate.verdict)}">{escape(gate.verdict)}</span></td>'
        f"<td class=check>{product_of(gate.name)}: {escape(gate.name.replace('_', ' '))}</td>"
        f"<td class=num>{format_number(gate.value)}</td>"
        f"<td class=num>{format_number(gate.limit)}</td><td>{escape(gate.message)}</td></tr>"
        for product in Product
        for gate in recovery.report.gates
        if product_of(gate.name) is product
    )
    head = (
        "<tr><th></th><th>Check</th><th class=num>Value</th><th class=num>Fails above</th><th>What it means</th></tr>"
    )
    return f"<section><h2>Checks</h2><table>{head}{rows}</table></section>" if rows else ""


def _pattern(recovery: Recovery) -> str:
    rows = []
    inferred = recovery.report.manifest.get("inferred", {})
    for panel in recovery.pattern.panels:
        outline = panel_outline(panel)
        width, height = outline.max(axis=0) - outline.min(axis=0)
        around = sum(edge_length(panel, index) for index in range(len(panel.edges)))
        rows.append(
            f"<tr><td>{escape(panel.name)}</td><td class=num>{width * 100:.1f} × {height * 100:.1f}</td>"
            f"<td class=num>{around * 100:.1f}</td><td class=num>{panel_area(panel) * 1e4:.0f}</td>"
            f"<td class=num>{100.0 * inferred.get(panel.name, 0.0):.0f}</td></tr>"
        )
    head = (
        "<tr><th>Panel</th><th class=num>Width × height [cm]</th><th class=num>Perimeter [cm]</th>"
        "<th class=num>Area [cm²]</th><th class=num>Inferred [%]</th></tr>"
    )
    lines = "".join(
        f"<tr><td>{escape(name)}</td><td class=num>{escape(length)}</td><td>{escape(place)}</td></tr>"
        for name, length, place in map(describe_margins, recovery.report.manifest.get("lines", []))
    )
    heads = "<tr><th>Seam or edge</th><th class=num>Length</th><th>Place on the cloth</th></tr>"
    known = f"<table>{heads}{lines}</table>" if lines else ""
    return (
        f'<section class="page"><h2>Pattern</h2><p class="hint">Drawn 1:{DRAWING_SCALE_DENOMINATOR} when printed at '
        "full size, net lines without seam allowance. "
        "Edges of one colour and number are sewn together; dark edges stay open. Lengths: cm. "
        f'pattern.svg holds the same at true scale.</p><div class="sheet">{pattern_drawing(recovery.pattern)}</div>'
        f"<table>{head}{''.join(rows)}</table>{known}</section>"
    )


def _fabric(recovery: Recovery) -> str:
    """Return the table of fabric parameters; without numbers where they are not identifiable."""
    if not recovery.estimates:
        return ""
    rows = []
    for each in recovery.estimates:
        text, certainty = "–", "not identifiable"
        if each.identifiable:
            low, high = each.value * np.exp(-each.std), each.value * np.exp(each.std)
            text = f"{each.value:.1e} {UNITS[each.name]}<br><small>{low:.1e} to {high:.1e}</small>"
            certainty = "identified"
        rows.append(
            f"<tr><td><b>{escape(each.name)}</b><br><small>{MEANINGS.get(each.name, '')}</small></td>"
            f"<td><span class='badge {'pass' if each.identifiable else 'open'}'>{certainty}</span></td>"
            f"<td class=num>{text}</td><td>{_draw_posterior(each)}</td><td>{escape(each.note)}</td></tr>"
        )
    head = "<tr><th>Parameter</th><th></th><th class=num>Value</th><th>Known from the drape</th><th>How</th></tr>"
    return (
        "<section><h2>Fabric</h2><p class='hint'>A drape at rest fixes only ratios to the cloth's weight; values hold "
        f"for {1e3 * recovery.fabric.density:.0f} g/m². Nearest named fabrics: "
        f"{escape(', '.join(recovery.nearest_fabrics))}."
        f"</p><table>{head}{''.join(rows)}</table></section>"
    )


def _draw_posterior(estimate: FabricEstimate) -> str:
    """Draw the width of the posterior relative to the prior: the uncertainty that a drape leaves."""
    left = 100.0 * min(1.0, estimate.std / max(estimate.prior_std, 1e-12))
    factor = f"within a factor {np.exp(estimate.std):.1f}" if estimate.identifiable else "open"
    if not estimate.identifiable and left < 50.0:
        factor = "narrowed, not fitted"
    return (
        f'<span class="prior" title="bar: the prior; filled: what the drape leaves of it">'
        f'<i style="width:{left:.0f}%"></i></span><small>{factor}</small>'
    )


def _numbers(recovery: Recovery) -> str:
    metrics = recovery.report.metrics
    prefixes = [prefix for prefix, _ in COLUMNS if prefix]
    bases: dict[str, None] = dict.fromkeys(TITLES)
    for name in sorted(metrics):
        if name.startswith(("fabric.", "pattern.point_std_mm")):
            continue  # shown in the section on the fabric
        prefix = next((prefix for prefix in prefixes if name.startswith(prefix)), "")
        bases[name.removeprefix(prefix)] = None
    shown = [(p, t) for p, t in COLUMNS if not p or any(name.startswith(p) for name in metrics)]
    rows = []
    for base in bases:
        if not any(prefix + base in metrics for prefix, _ in shown):
            continue
        title = TITLES.get(base) or _contour_title(base)
        cells = "".join(f"<td class=num>{format_number(metrics.get(prefix + base))}</td>" for prefix, _ in shown)
        rows.append(f"<tr><td title='{escape(base, quote=True)}'>{escape(title)}</td>{cells}</tr>")
    head = "<tr><th>Metric</th>" + "".join(f"<th class=num>{title}</th>" for _, title in shown) + "</tr>"
    return f'<section class="page"><h2>Numbers</h2><table>{head}{"".join(rows)}</table></section>'


def _contour_title(name: str) -> str:
    contour = name.removeprefix("contour_rms_mm.")
    return name if contour == name else f"Contour {contour.replace('.', ', ')}, RMS [mm]"


def _settings(recovery: Recovery) -> str:
    total = max(sum(recovery.report.stage_seconds.values()), 1e-9)
    stages = "".join(
        f'<tr><td>{escape(name)}</td><td class=num>{seconds:.1f}</td><td class="share">'
        f'<i style="width:{100.0 * seconds / total:.1f}%"></i></td></tr>'
        for name, seconds in recovery.report.stage_seconds.items()
    )
    manifest = escape(json.dumps(recovery.report.manifest, indent=1, ensure_ascii=False, default=str))
    head = '<tr><th>Stage</th><th class=num>CPU [s]</th><th class="share"></th></tr>'
    return (
        f'<section><h2>Time</h2><table class="stages">{head}{stages}</table></section>'
        f"<section><h2>Settings and versions</h2><pre>{manifest}</pre></section>"
    )
