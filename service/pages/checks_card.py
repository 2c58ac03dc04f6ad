"""The checks of a result: those that did not pass first, each with its limits in words; the others folded."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ..records import Gate
from .control_words import speak_of_controls
from .garment_words import title_check
from .help_note import draw_heading
from .markup import Html, html, join
from .words import draw_verdict

PASS, FAIL = "pass", "fail"

UNIT = re.compile(r"\{value[^}]*\} (mm|cm2|%|degrees)")
"""The unit of a check's value in the sentence of its rule."""


def draw_checks(gates: Sequence[Gate], warnings: Sequence[str] = ()) -> Html:
    """Return the card with checks and remarks; empty if there are none."""
    if not (gates or warnings):
        return Html()
    open_ones = sorted((gate for gate in gates if gate.verdict != PASS), key=lambda gate: gate.verdict != FAIL)
    passed = [gate for gate in gates if gate.verdict == PASS]
    rows = html('<ul class="checks">{}</ul>', join(map(_draw_open, open_ones))) if open_ones else Html()
    remarks = [html("<li>{}</li>", speak_of_controls(text)) for text in warnings]
    if not gates:
        return html('<section class="card" id="checks"><h2>Remarks</h2><ul>{}</ul></section>', join(remarks))
    return html(
        CARD,
        heading=draw_heading("Checks", ABOUT),
        rows=rows,
        passed=html(PASSED, count=len(passed), total=len(gates), rows=join(map(_draw_passed, passed))),
        remarks=html(REMARKS, count=len(remarks), rows=join(remarks)) if remarks else Html(),
    )


def describe_limit(gate: Gate) -> str:
    """Return the value of a check with its limits: `4.2 mm; passes up to 2.5 mm, fails above 10 mm`.

    The first limit is that of this version's rule, so it is left out where the stored limit is another version's.
    """
    from ...core.judge.gates import GATE_RULES  # imports numpy: not at every start

    rule = next((rule for rule in GATE_RULES if rule.name == gate.name.rpartition(".")[2]), None)
    found = UNIT.search(rule.what) if rule else None
    unit = {"degrees": "°", "cm2": " cm²", "%": " %", "mm": " mm"}[found[1]] if found else ""
    said = [] if gate.value is None else [f"{gate.value:.3g}{unit}"]
    if gate.limit is None:
        return "".join(said)
    if rule is not None and rule.fail == gate.limit:
        return "; ".join([*said, f"passes up to {rule.doubtful:.3g}{unit}, fails above {gate.limit:.3g}{unit}"])
    return "; ".join([*said, f"limit {gate.limit:.3g}{unit}"])


def _draw_open(gate: Gate) -> Html:
    row = '<li>{} <b>{}</b><br>{}<br><span class="soft">{}</span></li>'
    message = speak_of_controls(gate.message)
    return html(row, draw_verdict(gate.verdict), title_check(gate.name), message, describe_limit(gate))


def _draw_passed(gate: Gate) -> Html:
    return html('<li>{}<br><span class="soft">{}</span></li>', title_check(gate.name), describe_limit(gate))


ABOUT = (
    "Each check compares one number of the result with two limits. Up to the first it passes; above it look before you "
    "cut; above the second do not cut before you have found the reason."
)

CARD = """<section class="card" id="checks">{heading}{rows}{passed}{remarks}</section>"""

PASSED = """<details><summary>{count} of {total} checks passed</summary>
<ul class="checks passed">{rows}</ul></details>"""

REMARKS = """<details><summary>Remarks ({count})</summary><ul class="doubt">{rows}</ul></details>"""
