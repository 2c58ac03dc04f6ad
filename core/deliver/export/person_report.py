"""The report of a labelled person: scan, body, parts and their confidence, in one HTML file."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape

from ...people.colours import COLOURS
from ...people.outfit import outfit_probabilities
from ...people.part import Part
from ...people.separation import LabelledPerson
from ...scan.raw import RawScan
from .page import page_html

NEXT_STEP_TEXTS = {
    True: "Nothing is recovered from this by itself. Correct labels.npz (segmented.ply shows it) and hand it in with "
    "--labels, or say what is worn with --wearing, or what is at a place with --mark.",
    False: "Each garment is recovered by a job of its own, with a report of its own. Where a part is wrong, correct "
    "labels.npz and hand it in with --labels.",
}
"""The next step, if something is wrong and if nothing is."""


def report_person(raw: RawScan, separation: LabelledPerson, warnings: Sequence[str], picture: bytes) -> str:
    """Return the whole report as the text of one HTML file; every name that comes from a file is escaped.

    Args:
        raw: The scan.
        separation: The labelled person.
        warnings: Warnings for the user, one sentence each.
        picture: PNG of scan, body, parts and confidence from `draw_person`.
    """
    sections = [
        _header(raw, separation, warnings),
        _pictures(separation, picture),
        _garments(separation),
        _openings(separation),
        _parts(raw, separation),
    ]
    return page_html(raw.name, sections)


def _header(raw: RawScan, separation: LabelledPerson, warnings: Sequence[str]) -> str:
    problem, body = separation.problem, separation.body
    verdict = ("fail", problem.message) if problem is not None else ("pass", "Segmented")
    kind = f"cloud of {len(raw.points)} points" if raw.is_cloud else f"{len(raw.points)} points, {len(raw.faces)} faces"
    facts = (
        ("Scan", kind),
        ("Unit, up", f"{raw.units}, {raw.up_axis}"),
        ("Colours", "none" if raw.colours is None else "yes"),
        ("Body", body.source),
        ("Body to the skin seen", f"{1e3 * body.fit_rms:.1f} mm RMS"),
    )
    cells = "".join(f"<div><dt>{title}</dt><dd>{escape(value)}</dd></div>" for title, value in facts)
    notes = "".join(f"<li>{escape(text)}</li>" for text in warnings)
    return (
        f'<header><p class="brand">garmentq · person report</p><h1>{escape(raw.name)}</h1>'
        f'<p class="verdicts"><span class="verdict {verdict[0]}">{escape(verdict[1])}</span></p>'
        f'<dl class="facts">{cells}</dl></header>'
        f'<section class="notes"><h2>Next</h2><p>{NEXT_STEP_TEXTS[problem is not None]}</p></section>'
        + (f'<section class="notes"><h2>Remarks</h2><ul>{notes}</ul></section>' if notes else "")
    )


def _pictures(separation: LabelledPerson, picture: bytes) -> str:
    data = base64.b64encode(picture).decode("ascii")
    keys = "".join(
        f'<span style="white-space:nowrap"><span style="display:inline-block;width:1em;height:1em;background:'
        f'rgb({r * 255:.0f} {g * 255:.0f} {b * 255:.0f})"></span> {part.word} </span> '
        for part, (r, g, b) in COLOURS.items()
        if (separation.label == part).any()
    )
    return (
        "<section><h2>Scan, body, parts, confidence</h2>"
        f'<img style="width:100%" alt="scan, body, parts and confidence from three sides" '
        f'src="data:image/png;base64,{data}"><p class="hint">{keys}In the last column grey is sure and red is one half '
        "or less.</p></section>"
    )


def _garments(separation: LabelledPerson) -> str:
    rows = "".join(
        f"<tr><td>{garment.part.word}</td><td>{escape(garment.category)}</td>"
        f"<td class=num>{garment.confidence:.2f}</td></tr>"
        for garment in separation.garments
    )
    readings = "".join(
        f"<tr><td>{' and '.join(part.word for part in outfit.parts) or 'nothing'}</td>"
        f"<td class=num>{weight:.2f}</td></tr>"
        for outfit, weight in list(zip(separation.outfits, outfit_probabilities(separation.outfits), strict=True))[:3]
    )
    return (
        "<section><h2>Garments</h2><table><tr><th>Garment</th><th>Category</th><th class=num>Confidence</th></tr>"
        f"{rows}</table><table><tr><th>Reading of what is worn</th><th class=num>Probability</th></tr>{readings}"
        "</table></section>"
    )


def _openings(separation: LabelledPerson) -> str:
    rows = "".join(
        f"<tr><td>{garment.part.word}</td><td>{escape(contour.name)}</td>"
        f"<td class=num>{'–' if contour.is_inferred else f'{contour.confidence:.2f}'}</td>"
        f"<td>{'nothing shows it: neither fitted nor measured' if contour.is_inferred else 'seen'}</td></tr>"
        for garment in separation.garments
        for contour in garment.contours
    )
    head = "<tr><th>Garment</th><th>Opening</th><th class=num>Confidence</th><th></th></tr>"
    return f"<section><h2>Openings</h2><table>{head}{rows}</table></section>" if rows else ""


def _parts(raw: RawScan, separation: LabelledPerson) -> str:
    seen = raw.place >= 0
    label, sure = separation.label[seen], separation.confidence[seen]
    rows = "".join(
        f"<tr><td>{part.word}</td><td class=num>{100.0 * (label == part).mean():.1f}</td>"
        f"<td class=num>{sure[label == part].mean():.2f}</td>"
        f"<td class=num>{100.0 * (sure[label == part] >= 0.9).mean():.0f}</td></tr>"
        for part in Part
        if (label == part).any()
    )
    head = (
        "<tr><th>Part</th><th class=num>Points [%]</th><th class=num>Mean confidence</th>"
        "<th class=num>Of its points 0.9 or surer [%]</th></tr>"
    )
    return f"<section><h2>Parts</h2><table>{head}{rows}</table></section>"
