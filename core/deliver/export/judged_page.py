"""Common parts of the reports of a garment on another body and in motion: head, checks, numbers, manifest."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from ...run.verdict import Gate
from .report import format_number


@dataclass(frozen=True)
class Heading:
    """Describe the top of a report: its kind in a word or two, the garment's name, and values by their titles."""

    kind: str
    title: str
    facts: Mapping[str, str]


def head_html(heading: Heading, gates: Sequence[Gate], warnings: Sequence[str]) -> str:
    """Return the head of a report: title, a word for each verdict, facts, and remarks; all values are escaped."""
    verdicts = "".join(f'<span class="verdict {escape(gate.verdict)}">{escape(_title(gate))}</span>' for gate in gates)
    cells = "".join(f"<div><dt>{title}</dt><dd>{escape(value)}</dd></div>" for title, value in heading.facts.items())
    notes = "".join(f"<li>{escape(text)}</li>" for text in warnings)
    return (
        f'<header><p class="brand">garmentq · {heading.kind}</p><h1>{escape(heading.title)}</h1>'
        f'<p class="verdicts">{verdicts}</p><dl class="facts">{cells}</dl></header>'
        + (f'<section class="notes"><h2>Remarks</h2><ul>{notes}</ul></section>' if notes else "")
    )


def gates_html(gates: Sequence[Gate]) -> str:
    """Return the table of verdicts, each with its value, the limit up to which it passes, and its meaning."""
    rows = "".join(
        f'<tr><td><span class="badge {escape(gate.verdict)}">{escape(gate.verdict)}</span></td>'
        f"<td class=check>{escape(_title(gate))}</td><td class=num>{format_number(gate.value)}</td>"
        f"<td class=num>{format_number(gate.limit)}</td><td>{escape(gate.message)}</td></tr>"
        for gate in gates
    )
    head = "<tr><th></th><th>Check</th><th class=num>Value</th><th class=num>Passes to</th><th>What it means</th></tr>"
    return f"<section><h2>Checks</h2><table>{head}{rows}</table></section>"


def numbers_html(metrics: Mapping[str, float | None]) -> str:
    """Return the table of all metrics by name."""
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td class=num>{format_number(value)}</td></tr>"
        for name, value in sorted(metrics.items())
    )
    head = "<tr><th>Metric</th><th class=num>Value</th></tr>"
    return f'<section class="page"><h2>Numbers</h2><table>{head}{rows}</table></section>'


def manifest_html(manifest: Mapping[str, Any]) -> str:
    """Return what reproduces the result, as text."""
    text = escape(json.dumps(manifest, indent=1, ensure_ascii=False, default=str))
    return f"<section><h2>Settings and versions</h2><pre>{text}</pre></section>"


def _title(gate: Gate) -> str:
    return gate.name.replace("_", " ")
