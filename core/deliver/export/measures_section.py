"""The sections of a report on measures: of the finished garment, with its figure, and of its wearer."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape

from ...body.body_tape import WEARER_METRICS
from ...body.measure_names import HOW_MEASURED
from ...garment.pattern import Pattern
from ...garment.pieces.finished_points import FinishedMeasure
from .measure_figures import garment_figure_svg


def finished_html(pattern: Pattern, measures: Sequence[FinishedMeasure]) -> str:
    """Return the section on a garment's finished measures and where they are taken, or nothing where it has none."""
    if not measures:
        return ""
    figure = base64.b64encode(garment_figure_svg(pattern, measures, is_listed=False).encode()).decode("ascii")
    rows = [(f"{n} {one.point}", f"{1e2 * one.value:.1f} cm", one.how) for n, one in enumerate(measures, 1)]
    picture = f'<p><img style="width:100%" alt="Where they are taken" src="data:image/svg+xml;base64,{figure}"></p>'
    return f"<section><h2>Finished measures</h2>{_table(rows)}{picture}</section>"


def wearer_html(metrics: Mapping[str, float | None]) -> str:
    """Return the section on a wearer's measures by the metrics of a result, or nothing where these have none."""
    rows = []
    for name, how in HOW_MEASURED.items():
        length, angle = (metrics.get(f"{WEARER_METRICS}{name}_{unit}") for unit in ("mm", "deg"))
        if length is not None or angle is not None:
            value = f"{angle:.0f}°" if length is None else f"{0.1 * length:.1f} cm"
            rows.append((name.replace("_", " "), value, how))
    return f"<section><h2>Measures of the wearer</h2>{_table(rows)}</section>" if rows else ""


def _table(rows: Sequence[tuple[str, str, str]]) -> str:
    cells = "".join(
        f"<tr><td>{escape(name)}</td><td class=num>{value}</td><td>{escape(how)}</td></tr>" for name, value, how in rows
    )
    head = "<tr><th>Measure</th><th class=num>Value</th><th>How it is taken</th></tr>"
    return f"<table>{head}{cells}</table>"
