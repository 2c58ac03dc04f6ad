"""The measures of a result on its page: of the finished garment and of its wearer."""

from __future__ import annotations

from collections.abc import Mapping

from ..records import JobReport
from .help_note import draw_heading
from .markup import Html, html, join

CENTIMETRES_PER_MM = 0.1
"""Centimetres in a millimetre [cm/mm]: metrics are in millimetres, tailors read centimetres."""


def draw_measures(job: JobReport, is_shared: bool = False) -> Html:
    """Return the card with the measures of a result; empty if it has none.

    Args:
        job: The job.
        is_shared: Leave out those of the wearer, which are personal data.
    """
    from ...core.body.measure_names import HOW_MEASURED
    from ...core.garment.pieces.finished_points import HOW_TAKEN

    finished = _table("Finished garment", job, "finished.", {str(point): how for point, how in HOW_TAKEN.items()})
    wearer = Html() if is_shared else _table("Wearer", job, "wearer.", HOW_MEASURED)
    if not (finished or wearer):
        return Html()
    if finished and wearer:
        wearer = html("<details><summary>Measures of the wearer</summary>{}</details>", wearer)
    return html(CARD, heading=draw_heading("Measures", ABOUT), tables=join([finished, wearer]))


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


ABOUT = (
    "The finished garment is measured on the flat pattern, without seam allowance; the wearer on the body. The "
    "difference of two girths is the ease."
)

CARD = """<section class="card" id="measures">{heading}{tables}</section>"""
