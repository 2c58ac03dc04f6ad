"""The measures of a result on its page: of the finished garment and of its wearer."""

from __future__ import annotations

from collections.abc import Mapping

from ..records import JobReport
from .markup import Html, html, join

CENTIMETRES_PER_MM = 0.1
"""Centimetres in a millimetre [cm/mm]: metrics are in millimetres, tailors read centimetres."""


def draw_measures(job: JobReport, is_shared: bool = False) -> Html:
    """Return the card with the measures of a result; empty if it has none.

    Args:
        job: The job.
        is_shared: Leave out those of the wearer, which are personal data, and what only who works with it can do.
    """
    from ...core.body.measure_names import HOW_MEASURED
    from ...core.garment.pieces.finished_points import HOW_TAKEN

    tables = [
        _table("Finished garment", job, "finished.", {str(point): how for point, how in HOW_TAKEN.items()}),
        _table("Wearer", job, "wearer.", HOW_MEASURED),
    ]
    if is_shared:
        return html('<section class="card"><h2>Measures</h2>{}</section>', tables[0]) if tables[0] else Html()
    if not any(tables):
        return Html()
    return html(
        '<section class="card" id="measures"><h2>Measures</h2><div class="pair">{}</div><p class="soft">'
        "<code>garmentq measure {} --out FOLDER</code> draws where they are taken.</p></section>",
        join(tables), job.id,
    )  # fmt: skip


def _table(title: str, job: JobReport, before: str, how: Mapping[str, str]) -> Html:
    """Return the table of the measures whose metrics begin with a word; empty if there are none."""
    rows = []
    for name, text in how.items():
        length, angle = (job.metrics.get(f"{before}{name}_{unit}") for unit in ("mm", "deg"))
        value = "" if length is None else f"{CENTIMETRES_PER_MM * length:.1f}\u00a0cm"
        value = value if angle is None else f"{angle:.0f}°"
        if value:
            row = '<tr><th scope="row">{}</th><td class="number">{}</td><td class="soft">{}</td></tr>'
            rows.append(html(row, name.replace("_", " "), value, text))
    if not rows:
        return Html()
    return html(
        '<div class="wide" tabindex="0" role="region" aria-label="{}"><h3>{}</h3><table>{}</table></div>',
        title, title, join(rows),
    )  # fmt: skip
