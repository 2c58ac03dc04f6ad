"""Tables that set two results side by side: measures, checks and metrics, with their differences."""

from __future__ import annotations

from collections.abc import Sequence

from ..records import Gate, JobReport
from .checks_card import describe_limit
from .garment_words import title_check
from .help_note import draw_heading
from .markup import Html, html, join
from .measures_card import CENTIMETRES_PER_MM
from .words import draw_verdict

FINISHED, WEARER = "finished.", "wearer."
"""Beginnings of the names of metrics that are measures."""


def draw_comparison(first: JobReport, second: JobReport) -> Html:
    """Return the cards with measures, checks and metrics of two results; those without content are left out."""
    cards = [_draw_measures(first, second), _draw_checks(first, second), _draw_metrics(first, second)]
    return html('<div class="cards">{}</div>', join(card for card in cards if card))


def format_difference(first: float | None, second: float | None, pattern: str) -> str:
    """Return the second number less the first with its sign; empty if one is missing, `=` if they read the same.

    Args:
        first: The first number.
        second: The second number.
        pattern: How the numbers are shown beside it, such as `.1f`.
    """
    if first is None or second is None:
        return ""
    if format(first, pattern) == format(second, pattern):
        return "="
    shown = format(second - first, f"+{pattern}")
    return shown.replace("-", "\u2212")


def _draw_measures(first: JobReport, second: JobReport) -> Html:
    """Return the card with the measures, the finished garment's first."""
    from ...core.body.measure_names import HOW_MEASURED
    from ...core.garment.pieces.finished_points import HOW_TAKEN

    finished = _draw_lengths(first, second, FINISHED, [str(point) for point in HOW_TAKEN])
    wearer = _draw_lengths(first, second, WEARER, list(HOW_MEASURED))
    if not (finished or wearer):
        return Html()
    if wearer:
        wearer = html("<details><summary>Measures of the wearers</summary>{}</details>", wearer)
    return html(MEASURES, heading=draw_heading("Measures", ABOUT), tables=join([finished, wearer]))


def _draw_lengths(first: JobReport, second: JobReport, before: str, names: Sequence[str]) -> Html:
    rows = []
    for name in names:
        a, b = (one.metrics.get(f"{before}{name}_mm") for one in (first, second))
        if a is None and b is None:
            continue
        a, b = (None if value is None else CENTIMETRES_PER_MM * value for value in (a, b))
        rows.append(_draw_row(name.replace("_", " "), (a, b), ".1f"))
    return html(TABLE, label=f"Measures, {before.rstrip('.')}", unit=" [cm]", rows=join(rows)) if rows else Html()


def _draw_row(name: str, values: tuple[float | None, float | None], pattern: str) -> Html:
    texts = ["" if value is None else format(value, pattern) for value in values]
    return html(ROW, name, *texts, format_difference(*values, pattern))


def _draw_checks(first: JobReport, second: JobReport) -> Html:
    """Return the card with the checks: those whose verdicts differ, or did not pass, first; the others folded."""
    pairs = _pair(first.gates, second.gates)
    open_rows: list[Html] = []
    passed: list[Html] = []
    for name, (a, b) in pairs.items():
        verdicts = {gate.verdict for gate in (a, b) if gate is not None}
        row = html(CHECK, title_check(name), _draw_gate(a), _draw_gate(b))
        (passed if verdicts == {"pass"} else open_rows).append(row)
    if not pairs:
        return Html()
    folded = html("<details><summary>{} passed</summary>{}</details>", len(passed), _draw_table(passed))
    return html(CHECKED_BOTH, rows=_draw_table(open_rows), passed=folded if passed else Html())


def _draw_table(rows: Sequence[Html]) -> Html:
    return html(CHECK_TABLE, join(rows)) if rows else Html()


def _draw_gate(gate: Gate | None) -> Html:
    if gate is None:
        return html('<span class="soft">not checked</span>')
    return html('{} <span class="soft">{}</span>', draw_verdict(gate.verdict), describe_limit(gate).partition(";")[0])


def _pair(first: Sequence[Gate], second: Sequence[Gate]) -> dict[str, tuple[Gate | None, Gate | None]]:
    """Return the checks of two results by name, in the order of the first, then of the second."""
    a, b = ({gate.name: gate for gate in gates} for gates in (first, second))
    return {name: (a.get(name), b.get(name)) for name in [*a, *(name for name in b if name not in a)]}


def _draw_metrics(first: JobReport, second: JobReport) -> Html:
    """Return the card with all other metrics, folded."""
    names = [name for name in sorted({*first.metrics, *second.metrics}) if not name.startswith((FINISHED, WEARER))]
    rows = [_draw_row(name, (first.metrics.get(name), second.metrics.get(name)), ".4g") for name in names]
    table = html(TABLE, label="Metrics", unit="", rows=join(rows))
    return html(METRICS, count=len(rows), table=table) if rows else Html()


ABOUT = "The difference is the second garment less the first: +1.0 means that the second is 1 cm longer or wider."

ROW = """<tr><th scope="row">{}</th><td class="number">{}</td><td class="number">{}</td>
<td class="number">{}</td></tr>"""

TABLE = """<div class="wide" tabindex="0" role="region" aria-label="{label}"><table class="compared"><thead><tr>
<th scope="col"><span class="hushed">Name</span></th><th scope="col" class="number">First{unit}</th>
<th scope="col" class="number">Second{unit}</th><th scope="col" class="number">Difference</th></tr></thead>
<tbody>{rows}</tbody></table></div>"""

MEASURES = """<section class="card" id="compared-measures">{heading}{tables}</section>"""

CHECK = """<tr><th scope="row">{}</th><td>{}</td><td>{}</td></tr>"""

CHECK_TABLE = """<table class="compared"><thead><tr><th scope="col">Check</th><th scope="col">First</th>
<th scope="col">Second</th></tr></thead><tbody>{}</tbody></table>"""

CHECKED_BOTH = """<section class="card" id="compared-checks"><h2>Checks</h2>{rows}{passed}</section>"""

METRICS = """<section class="card" id="compared-metrics"><h2>Metrics</h2><details><summary>{count} metrics</summary>
{table}</details></section>"""
