"""The ten lines that a user sees of a result."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from garmentq.cli.summary import print_result, summarise
from garmentq.service.records import Child, Gate, JobReport
from garmentq.service.states import State

GATES = [
    Gate("a", "pass", 1.0, 2.0, "fine."),
    Gate("b", "doubtful", 1.0, 2.0, "nearly."),
    Gate("c", "fail", 3.0, 2.0, "too far."),
]
METRICS = {
    "vertices": 3905.0, "fabric.k": 1.6e-6, "fabric.k.std": 0.3, "fabric.k.identifiable": 1.0,
    "surface_rms_mm.s2t": 0.94, "surface_rms_mm.t2s": 1.26, "sim.surface_rms_mm.s2t": 2.0,
    "sim.surface_rms_mm.t2s": 2.1, "body_penetration_mm": 0.31, "self_intersecting_faces": 4.0,
}  # fmt: skip


def make_job(**changes) -> JobReport:
    """Return an ended job with everything that a summary reads."""
    job = JobReport(
        "3685ecfd4f81", "person", State.SUCCEEDED, "measure", 1.0, 1, 0.0, 1.0, 2.0, None, False, "cpu", 0,
        "recover", "3685ecfd4f81", None, "fail",
        settings={}, version="", children=[], inputs={}, waits=[], tags=[], details={},
        garment="skirt", template="four_panel_skirt", fabric="cotton_poplin", body="scan:person", metrics=METRICS,
        gates=GATES, warnings=["frayed hem.", "other."], cpu_seconds=71.2, peak_mb=640.0,
    )  # fmt: skip
    return replace(job, **changes)


def test_what_it_says() -> None:
    """Breaks where a mesh is left out, the worst check is not the one shown, or a value gets a wrong name."""
    lines = dict(summarise(make_job(), [Path("/out/pattern.svg"), Path("/out/report.html"), Path("/out/fit.json")]))
    assert "back: detail mesh 0.9 / 1.3 mm;" in lines["surface"]
    assert "simulation mesh 2.0 / 2.1 mm" in lines["surface"]
    assert "re-draped" not in lines["surface"] and "at rest" not in lines["surface"]  # an older result does not say
    known = (
        METRICS
        | {"sim.at_rest": 0.0, "redrape.at_rest": 1.0}
        | {f"redrape.surface_rms_mm.{way}": 9.0 for way in ("s2t", "t2s")}
    )
    shown = dict(summarise(make_job(metrics=known), []))["surface"]
    assert shown.endswith("simulation mesh 2.0 / 2.1 mm, not at rest; re-draped pattern 9.0 / 9.0 mm, at rest")
    assert lines["body"] == "depth inside it / crossing faces: detail mesh 0.3 mm / 4"
    assert lines["checks"] == "1 of 3 passed; fail: too far."
    assert "1.6e-06 N m, within a factor of 1.3" in lines["fabric"]
    assert lines["warnings"] == "frayed hem. (and 1 more, see --verbose)"
    assert lines["open"] == "/out/report.html, /out/pattern.svg"


@pytest.mark.parametrize(
    ("metrics", "text"),
    [
        ({}, "was not fitted"),
        ({"fabric.k": None, "fabric.k.std": 1.2, "fabric.k.identifiable": 0.0}, "not identifiable"),
    ],
)
def test_a_fabric_that_is_not_known_gets_no_digits(metrics, text) -> None:
    """Breaks where a stiffness is printed that the scan does not determine."""
    assert text in dict(summarise(make_job(metrics=metrics), []))["fabric"]


@pytest.mark.parametrize("job", [make_job(), make_job(metrics={}, gates=[], warnings=[], cpu_seconds=None)])
def test_it_has_ten_lines(job, capsys) -> None:
    """Breaks where a text brings line breaks along, or a result without numbers is a traceback."""
    print_result(replace(job, warnings=["two\nlines"]), [])
    assert len(capsys.readouterr().out.splitlines()) == 10


def test_a_job_of_another_kind_shows_its_own(capsys) -> None:
    """Breaks where a job that recovers nothing is told in a garment's words, or its children are left out."""
    children = [Child("aaaabbbbcccc", "\u00c4rmel", "standin", State.QUEUED)]
    other = {"kind": "standin", "garment": None, "details": {"pieces": 3}, "children": children}
    print_result(make_job(**other, metrics={}, gates=[]), [])
    shown = capsys.readouterr().out
    assert shown.startswith("standin (job 3685ecfd4f81)") and "pieces     3" in shown
    assert "\u00c4rmel (aaaabbbbcccc, queued)" in shown and "base pattern" not in shown


def test_a_person_is_told_in_ten_lines(capsys) -> None:
    """Breaks where the second reading is left out, or an opening that nothing shows counts as seen."""
    neck = {"name": "neck", "confidence": 0.4, "is_inferred": True}
    contours = [neck, {"name": "hem", "confidence": 0.9, "is_inferred": False, "interval_mm": 17.4}]
    garments = [{"part": "one-piece", "category": "dress", "confidence": 0.912, "contours": contours}]
    outfits = [{"parts": ["one-piece"], "score": 0.0}, {"parts": ["upper", "lower"], "score": -1.0}]
    scan = {"vertex_count": 9, "is_cloud": True, "has_colours": False, "units": "cm", "up": "-z"}
    details = {"checked": {"scan": scan}, "garments": garments, "outfits": outfits, "parts": {}}
    children = [Child("aaaabbbbcccc", "one-piece", "recover", State.FAILED)]
    person = {"kind": "person", "garment": None, "details": details, "children": children, "gates": []}
    print_result(make_job(**person, metrics={"body.fit_rms_mm": 7.25}), [])
    shown = capsys.readouterr().out
    assert len(shown.splitlines()) == 10
    for text in (
        "person; cloud of 9 points without colours, cm, -z up", "7.2 mm RMS",
        "one-piece (73 %); or upper and lower (27 %)",
        "one-piece (dress), confidence 0.91",
        "1 shown, least confidence: one-piece hem \u00b117 mm 0.90; inferred: one-piece neck",
        "one-piece (aaaabbbbcccc, failed)",
    ):  # fmt: skip
        assert text in shown, text
    print_result(make_job(**person | {"details": {}}, metrics={}), [])
    assert len(capsys.readouterr().out.splitlines()) == 10
